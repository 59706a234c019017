// A rough interface of two dielectrics: it reflects and transmits at microfacets [E43] (Walter et al. 2007). Both lobes are followed.
// Twin: src/optics/shading/rough_interface.rs.
// import: shading/microfacet.wgsl

fn is_rough_interface(m: PackedMaterial) -> bool {
    return HAS_DIELECTRIC && has_facets(m) && is_dielectric(m);
}

// Index of the ray's side over the other's, by one index of the body.
fn eta_across(ior: f32, from_front: bool) -> f32 {
    return select(ior, 1.0 / ior, from_front);
}

// About what is reflected: by a facet that lies flat, per band; neither way is ever without a share.
fn rough_reflectance(m: PackedMaterial, n: vec3<f32>, direction: vec3<f32>, from_front: bool) -> Bands {
    let flat = dielectric_reflectance(m, n, direction, from_front);
    return clamp(flat, Bands(ROUGH_SHARE_MIN), Bands(1.0 - ROUGH_SHARE_MIN));
}

// Reflectance of a facet, per band.
fn rough_facet(m: PackedMaterial, cos_h: f32, from_front: bool) -> Bands {
    if is_dispersive(m) {
        var reflectance = Bands(0.0);
        for (var band = 0u; band < BANDS; band += 1u) {
            reflectance[band] = fresnel(cos_h, 1.0 / eta_across(m.iors[band], from_front));
        }
        return reflectance;
    }
    return Bands(fresnel(cos_h, 1.0 / eta_across(m.ior, from_front)));
}

struct RoughSample {
    direction: vec3<f32>,
    // f cosθ / (share pdf), the share that of rough_reflectance.
    weight: Bands,
}

// `direction` arrives; n is on its side.
fn rough_sample(
    m: PackedMaterial, transmits: bool, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> RoughSample {
    let wo = -direction;
    let h = ggx_normal(m.alpha, n, wo, u);
    let cos_o = dot(wo, n);
    let reflected = rough_facet(m, clamp(dot(wo, h), 0.0, 1.0), from_front);
    let share = rough_reflectance(m, n, direction, from_front);
    if transmits {
        let d = refract_direction(direction, h, eta_across(m.ior, from_front));
        let is_across = dot(d, geometric) < 0.0 && dot(d, n) < 0.0;
        let weight = (1.0 - reflected) / (1.0 - share) * ggx_seen(m.alpha, -dot(d, n));
        return RoughSample(d, select(Bands(0.0), weight, is_across));
    }
    let d = normalize(reflect(direction, h));
    let is_above = dot(d, geometric) > 0.0 && dot(d, n) > 0.0;
    let weight = reflected / share * ggx_seen_again(m.alpha, max(0.0, dot(d, n)), cos_o);
    return RoughSample(d, select(Bands(0.0), weight, is_above));
}
