// Followed: lobes that light follows as it follows a mirror, but that have a width: for light samples, which may lie in them [E46].
// no_followed_light.wgsl is in place of this and of lights/followed.wgsl where there is none. Twin: src/optics/shading/bsdf.rs.
// import: shading/bsdf.wgsl

// Light of a direction in such a lobe.
struct Followed {
    lobe: u32,
    // f |cosθ|, 1/sr, of radiance on the way to the eye.
    f_cos: Bands,
    // pdf_solid_angle of the lobe; 0 where there is none.
    pdf: f32,
}

// True where light leaves by the lobe in more than one direction.
fn has_width(m: PackedMaterial, lobe: u32) -> bool {
    if is_rough_interface(m) {
        return lobe == LOBE_REFLECTION || lobe == LOBE_TRANSMISSION;
    }
    if is_layered(m) && lobe == LOBE_REFLECTION {
        return follows_clear_coat(m) && m.clear_coat_alpha > 0.0;
    }
    if lobe != LOBE_MIRROR || (m.flag_bits & SPECULAR) == 0u {
        return false;
    }
    return select(m.specular_exponent > 0.0, m.alpha > 0.0, has_facets(m));
}

// pdf_solid_angle with which sample_delta leaves in the direction w; 0 of a lobe without a width.
fn pdf_delta_at(b: Bsdf, lobe: u32, w: vec3<f32>) -> f32 {
    let m = b.material;
    if !has_width(m, lobe) {
        return 0.0;
    }
    if is_rough_interface(m) {
        return rough_pdf(m, lobe == LOBE_TRANSMISSION, b.direction, b.shading, b.from_front, w);
    }
    if has_facets(m) {
        if is_layered(m) && lobe == LOBE_REFLECTION {
            return microfacet_pdf(coat_facets(m), b.shading, w, -b.direction);
        }
        return microfacet_pdf(m, b.shading, w, -b.direction);
    }
    return phong_pdf_about(m.specular_exponent, mirror_direction(b.direction, b.geometric, b.shading), w);
}

// What a lobe of these sends back along the ray from the direction w.
fn followed_from(b: Bsdf, w: vec3<f32>) -> Followed {
    let m = b.material;
    let is_across = dot(w, b.geometric) < 0.0;
    if is_rough_interface(m) {
        let lobe = select(LOBE_REFLECTION, LOBE_TRANSMISSION, is_across);
        let pdf = pdf_delta_at(b, lobe, w);
        let eta_it = select(1.0, relative_index(m, b.from_front), is_across);
        let weight = rough_weight(m, is_across, b.direction, b.shading, b.from_front, w);
        return Followed(lobe, albedo_at(b, lobe) * weight * (pdf * eta_it * eta_it), pdf);
    }
    let pdf = pdf_delta_at(b, LOBE_MIRROR, w);
    if is_across || pdf <= 0.0 {
        return Followed(LOBE_NONE, Bands(0.0), 0.0);
    }
    if has_facets(m) {
        var f = microfacet_eval(m, m.specular, b.shading, w, -b.direction);
        if is_layered(m) {
            f *= base_under_layers(m, dot(w, b.shading), -dot(b.direction, b.shading));
        }
        return Followed(LOBE_MIRROR, f * dot(w, b.shading), pdf);
    }
    return Followed(LOBE_MIRROR, m.specular * pdf, pdf);
}

// The same of a clear coat, which may be followed beside its base.
fn clear_coat_from(b: Bsdf, w: vec3<f32>) -> Followed {
    let pdf = pdf_delta_at(b, LOBE_REFLECTION, w);
    if dot(w, b.geometric) < 0.0 || pdf <= 0.0 {
        return Followed(LOBE_NONE, Bands(0.0), 0.0);
    }
    let f = clear_coat_eval(b.material, b.shading, w, -b.direction);
    return Followed(LOBE_REFLECTION, Bands(f * dot(w, b.shading)), pdf);
}
