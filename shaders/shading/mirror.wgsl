// The mirror, or a narrow lobe about its direction that is followed as one. Twin: src/optics/shading/mirror.rs.
// import: sampling/sampling.wgsl
// import: scene/features.wgsl

// The mirror direction about the shading normal; about the geometric one where that would lead below the surface.
fn mirror_direction(direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let d = normalize(reflect(direction, n));
    if HAS_SMOOTH && dot(d, geometric) <= 0.0 {
        return normalize(reflect(direction, geometric));
    }
    return d;
}

// It may lie below the surface where the lobe is narrow.
fn mirror_sample(
    exponent: f32, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, u: vec2<f32>,
) -> vec3<f32> {
    let d = mirror_direction(direction, geometric, n);
    if HAS_SPECULAR && exponent > 0.0 {
        return normalize(basis(d) * sample_phong_lobe(u, exponent));
    }
    return d;
}
