// Where no microfacets are rougher one way than the other: in place of anisotropy.wgsl. See no_facets.wgsl.

fn is_anisotropic(m: PackedMaterial) -> bool {
    return false;
}

fn mean_alpha(m: PackedMaterial) -> f32 {
    return m.alpha;
}

fn masking_alpha(m: PackedMaterial) -> f32 {
    return m.alpha;
}

fn brushed_density(m: PackedMaterial, n: vec3<f32>, h: vec3<f32>) -> f32 {
    return 0.0;
}

fn brushed_slope(m: PackedMaterial, n: vec3<f32>, w: vec3<f32>) -> f32 {
    return 1.0;
}

fn brushed_frame(m: PackedMaterial, n: vec3<f32>) -> mat3x3<f32> {
    return mat3x3(n, n, n);
}

fn brushed_alphas(m: PackedMaterial) -> vec2<f32> {
    return vec2(0.0);
}

fn kept_brush(m: PackedMaterial) -> u32 {
    return 0u;
}

fn kept_numbers(kept: u32) -> vec2<f32> {
    return vec2(0.0);
}

fn with_kept_way(m: PackedMaterial, kept: u32) -> PackedMaterial {
    return m;
}
