// Cut-outs: surfaces of which some is not there [E38]. A ray goes straight through where a number that it and the triangle make is no
// less than the opacity at the hit: the same ray always does the same. Twin: src/optics/shading/cutout.rs.
// import: scene/scene.wgsl
// import: scene/features.wgsl
// import: sampling/rng.wgsl
// import: shading/texture.wgsl
// reads  scene

// Bits of a material's `textures` below the number of its opacity.
const OPACITY_SHIFT: u32 = 16u;

// How much of a surface is there.
fn opacity_of(m: PackedMaterial, uv: vec2<f32>) -> f32 {
    let number = m.textures >> OPACITY_SHIFT;
    if number == 0u {
        return 1.0;
    }
    return texture_number(number - 1u, uv, 0.0);
}

// True where a ray that would meet a triangle at these weights goes through it.
fn goes_through(triangle: u32, t: PackedTriangle, weights: vec2<f32>, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    if (t.flags & CUT) == 0u {
        return false;
    }
    let opacity = opacity_of(material_at(t.material), texture_place(triangle, t, weights).uv);
    let start = pcg4d(vec4(bitcast<vec3<u32>>(origin), triangle));
    let mixed = pcg4d(start ^ vec4(bitcast<vec3<u32>>(direction), 0u));
    return unit(mixed.x) >= opacity;
}
