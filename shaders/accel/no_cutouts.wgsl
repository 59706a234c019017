// Where no surface is cut: in place of cutout.wgsl. See shading/no_facets.wgsl.
// import: scene/scene.wgsl

fn opacity_of(m: PackedMaterial, uv: vec2<f32>) -> f32 {
    return 1.0;
}

fn goes_through(triangle: u32, t: PackedTriangle, weights: vec2<f32>, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    return false;
}
