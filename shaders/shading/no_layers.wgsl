// Where no material has layers: in place of layers.wgsl; clear_coat.wgsl, sheen.wgsl and layered_lobes.wgsl are left out. See no_facets.wgsl.
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

fn sheen_colour(m: PackedMaterial) -> Bands {
    return Bands(0.0);
}

fn sheen_albedo(m: PackedMaterial, cosine: f32) -> f32 {
    return 0.0;
}

fn sheen_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return 0.0;
}

fn under_layers_weight(m: PackedMaterial, cos_i: f32, cos_o: f32) -> f32 {
    return 1.0;
}

fn pdf_layered(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return 0.0;
}

fn sample_layered(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    return n;
}

fn clear_coat_sample(
    m: PackedMaterial, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, u: vec2<f32>,
) -> LobeSample {
    return weighed(n, 0.0, 1.0);
}

fn sheen_sample_at(
    m: PackedMaterial, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, u: vec2<f32>,
) -> LobeSample {
    return weighed(n, 0.0, 1.0);
}
