// Glow: what a texture leaves of an emissive triangle's radiance [E49]. Twin: src/optics/lights/glow.rs.
// import: scene/features.wgsl
// import: scene/scene.wgsl
// import: sampling/sampling.wgsl
// import: shading/texture.wgsl
// import: shading/material.wgsl

fn has_glow(e: PackedEmitter) -> bool {
    return HAS_GLOW && e.texture != 0u;
}

// At these weights of the triangle's second and third corner, of one that has it.
fn glow_on(e: PackedEmitter, weights: vec2<f32>) -> Bands {
    let place = texture_place(e.triangle, triangle_at(e.triangle), weights);
    return texel_bands(texture_lookup(e.texture - 1u, place.uv, 0.0));
}

// Where u lies on it.
fn glow_at(e: PackedEmitter, u: vec2<f32>) -> Bands {
    return glow_on(e, sample_triangle(u));
}
