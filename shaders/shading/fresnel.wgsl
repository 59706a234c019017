// How much a microfacet reflects, by the angle at which light meets it [E40]. Twin: src/optics/shading/fresnel.rs.
// import: shading/dielectric.wgsl
// import: shading/layered.wgsl

// True where what reflects, or the interface, is of microfacets, smooth or rough.
fn has_facets(m: PackedMaterial) -> bool {
    return HAS_FACETS && (m.flag_bits & FACETS) != 0u;
}

// Of smooth metal, index η + ik in air, in each band: |r|² of both polarisations, by the root w of (η + ik)² − sin²θ.
fn fresnel_conductor(cos_i: f32, eta: Bands, k: Bands) -> Bands {
    let sin2 = Bands(max(0.0, 1.0 - cos_i * cos_i));
    let real = eta * eta - k * k - sin2;
    let imaginary = 2.0 * eta * k;
    let modulus = sqrt(real * real + imaginary * imaginary);
    let w_real = sqrt(max(Bands(0.0), 0.5 * (modulus + real)));
    let w_imaginary2 = max(Bands(0.0), 0.5 * (modulus - real));
    // r_s = (cosθ − w)/(cosθ + w)
    let minus = w_real - cos_i;
    let plus = w_real + cos_i;
    let rs = (minus * minus + w_imaginary2) / (plus * plus + w_imaginary2);
    // r_p/r_s = (w cosθ − sin²θ)/(w cosθ + sin²θ)
    let p_minus = w_real * cos_i - sin2;
    let p_plus = w_real * cos_i + sin2;
    let w_cos2 = w_imaginary2 * (cos_i * cos_i);
    let ratio = (p_minus * p_minus + w_cos2) / max(p_plus * p_plus + w_cos2, Bands(1e-30));
    return 0.5 * rs * (1.0 + ratio);
}

// (1 − cosθ)⁵, by which Schlick's formula goes from what is reflected head on to all.
fn schlick_rise(cosine: f32) -> f32 {
    let rest = 1.0 - cosine;
    let square = rest * rest;
    return square * square * rest;
}

// Of an opaque material's microfacets; `tint` is what it says of the lobe.
fn facet_reflectance(m: PackedMaterial, tint: Bands, cosine: f32) -> Bands {
    let c = clamp(cosine, 0.0, 1.0);
    if (m.flag_bits & CONDUCTOR) != 0u {
        return tint * fresnel_conductor(c, m.iors, m.extinction);
    }
    if (m.flag_bits & SCHLICK) != 0u {
        return tint + (facet_grazing(m) - tint) * schlick_rise(c);
    }
    return tint * fresnel(c, m.ior);
}
