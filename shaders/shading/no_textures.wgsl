// Where no surface has a texture and none is cut: in place of texture.wgsl. See no_facets.wgsl.
// import: scene/scene.wgsl
// import: shading/texture_place.wgsl

fn texture_place(triangle: u32, t: PackedTriangle, b: vec2<f32>) -> TexturePlace {
    return TexturePlace(vec2(0.0), 0.0, vec3(0.0), vec3(0.0));
}

fn texture_lookup(number: u32, uv: vec2<f32>, width: f32) -> vec4<f32> {
    return vec4(1.0);
}

fn texture_number(number: u32, uv: vec2<f32>, width: f32) -> f32 {
    return 1.0;
}
