// Mixtures: surfaces that are glass in part and opaque in part [E57]. Which of the two a ray meets is chance: a number that the place and
// the ray's direction make, so that the same ray always meets the same. Twin: src/optics/shading/mixture.rs.
// import: scene/features.wgsl
// import: scene/scene.wgsl
// import: sampling/rng.wgsl
// import: shading/texture.wgsl
// import: shading/surface.wgsl
// import: shading/media.wgsl

// Which part of a surface was met.
struct Met {
    // Its material.
    material: u32,
    // How much of the surface is glass, where that is its rest; else 0.
    glass: f32,
}

// How much of what is glass in part is glass.
fn glass_part(m: PackedMaterial, uv: vec2<f32>) -> f32 {
    var transmission = m.clear_coat;
    var metallic = m.metallic;
    if HAS_TEXTURES && m.transmission_texture != 0u {
        transmission = min(1.0, texture_number(m.transmission_texture - 1u, uv, 0.0));
    }
    let of_metal = m.facet_textures >> 16u;
    if HAS_TEXTURES && of_metal != 0u {
        metallic = min(1.0, texture_number(of_metal - 1u, uv, 0.0));
    }
    return transmission * (1.0 - metallic);
}

// Where a surface is met in a direction by light in these bodies.
fn met_at(s: Surface, direction: vec3<f32>, from_front: bool, inside: u32) -> Met {
    let whole = Met(s.material, 0.0);
    if !HAS_MIXTURES {
        return whole;
    }
    let m = material_at(s.material);
    if m.rest == 0u {
        return whole;
    }
    // where light stays in the body that it is in there is no surface
    let before = inside_before(inside, m, from_front);
    if is_no_boundary(m, before, inside_beyond(before, m, from_front)) {
        return whole;
    }
    let glass = glass_part(m, s.texture.uv);
    let start = pcg4d(vec4(bitcast<vec3<u32>>(s.position), s.material));
    let mixed = pcg4d(start ^ vec4(bitcast<vec3<u32>>(direction), 0u));
    if unit(mixed.x) < glass {
        return whole;
    }
    return Met(m.rest, glass);
}
