// What is diffuse under a clear coat: f = albedo/π T(θi) T(θo), T = 1 − R of the coat [E42]. Directions by their cosine, as of Lambert's
// lobe. Twin: src/optics/shading/undercoat.rs.
// import: shading/fresnel.wgsl

fn is_coated(m: PackedMaterial) -> bool {
    return HAS_FACETS && (m.flag_bits & COATED) != 0u;
}

// Part of light at this cosine that the coat lets through.
fn coat_passes(m: PackedMaterial, cosine: f32) -> f32 {
    let c = clamp(cosine, 0.0, 1.0);
    if (m.flag_bits & SCHLICK) != 0u {
        let root = (m.ior - 1.0) / (m.ior + 1.0);
        if is_layered(m) {
            return 1.0 - mix(root * root, m.grazing, schlick_rise(c));
        }
        return (1.0 - root * root) * (1.0 - schlick_rise(c));
    }
    return 1.0 - fresnel(c, m.ior);
}

fn undercoat_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    return m.diffuse * (coat_passes(m, dot(wi, n)) * coat_passes(m, dot(wo, n)) / PI);
}

// Of what leaves at this cosine, or arrives at it: factor on `diffuse`.
fn undercoat_albedo(m: PackedMaterial, cosine: f32) -> f32 {
    return coat_passes(m, cosine) * m.coat_transmittance;
}

// f cosθ / (albedo pdf) of a direction by its cosine.
fn undercoat_weight(m: PackedMaterial, cos_out: f32) -> f32 {
    return coat_passes(m, cos_out) / m.coat_transmittance;
}
