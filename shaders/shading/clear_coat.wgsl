// A clear coat of index 1.5 over all else: GGX's microfacets, which reflect by Schlick's formula [E50]. Twin:
// src/optics/shading/clear_coat.rs.
// import: shading/fresnel.wgsl
// import: shading/microfacet.wgsl

// True where the coat is followed as a mirror is.
fn follows_clear_coat(m: PackedMaterial) -> bool {
    return (m.flag_bits & CLEAR_COAT_FOLLOWED) != 0u;
}

// The material with the facets of its coat in place of its own: as rough each way.
fn coat_facets(m: PackedMaterial) -> PackedMaterial {
    var coat = m;
    coat.alpha = m.clear_coat_alpha;
    coat.flag_bits &= ~ANISOTROPIC;
    return coat;
}

// Of a smooth coat.
fn clear_coat_reflectance(m: PackedMaterial, cosine: f32) -> f32 {
    return m.clear_coat * mix(CLEAR_COAT_HEAD_ON, 1.0, schlick_rise(clamp(cosine, 0.0, 1.0)));
}

// BRDF, 1/sr, the same in all bands.
fn clear_coat_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let cos_i = dot(n, wi);
    let cos_o = dot(n, wo);
    if cos_i <= 0.0 || cos_o <= 0.0 {
        return 0.0;
    }
    let alpha = m.clear_coat_alpha;
    let h = normalize(wi + wo);
    let visible = 0.5 / (cos_i * ggx_slope(alpha, cos_o) + cos_o * ggx_slope(alpha, cos_i));
    return clear_coat_reflectance(m, dot(wo, h)) * (ggx_density(alpha, n, h) * visible);
}

// f cosθ / pdf of a direction that microfacet_sample gave for its α.
fn clear_coat_carried(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let cos_i = dot(n, wi);
    let cos_o = dot(n, wo);
    if cos_i <= 0.0 || cos_o <= 0.0 {
        return 0.0;
    }
    return clear_coat_reflectance(m, dot(wo, normalize(wi + wo))) * facet_seen_again(coat_facets(m), n, wi, wo);
}
