// Where no material has layers: in place of layers.wgsl; clear_coat.wgsl and sheen.wgsl are left out. See no_facets.wgsl.
// import: shading/layered.wgsl

fn layers_pass(m: PackedMaterial, cosine: f32) -> f32 {
    return 1.0;
}

fn base_under_layers(m: PackedMaterial, cos_i: f32, cos_o: f32) -> f32 {
    return 1.0;
}

fn follows_clear_coat(m: PackedMaterial) -> bool {
    return false;
}

fn coat_facets(m: PackedMaterial) -> PackedMaterial {
    return m;
}

fn clear_coat_reflectance(m: PackedMaterial, cosine: f32) -> f32 {
    return 0.0;
}

fn clear_coat_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return 0.0;
}

fn clear_coat_carried(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return 0.0;
}

fn sheen_colour(m: PackedMaterial) -> Bands {
    return Bands(0.0);
}

fn sheen_albedo(m: PackedMaterial, cosine: f32) -> f32 {
    return 0.0;
}

fn sheen_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return 0.0;
}

fn sheen_pdf(n: vec3<f32>, wi: vec3<f32>) -> f32 {
    return 0.0;
}

fn sheen_sample(n: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return n;
}
