// What is scattered through a surface: f = albedo/π toward the other side, pdf_solid_angle = |cosθ|/π [E55].
// Twin: src/optics/shading/translucent.rs.
// import: scene/features.wgsl
// import: sampling/sampling.wgsl

fn is_translucent(m: PackedMaterial) -> bool {
    return HAS_TRANSLUCENT && (m.flag_bits & TRANSLUCENT) != 0u;
}

// f, 1/sr, of light from the other side.
fn translucent_eval(m: PackedMaterial) -> Bands {
    return m.transmission / PI;
}

// n is on this side, as of all of these.
fn translucent_pdf(n: vec3<f32>, wi: vec3<f32>) -> f32 {
    return max(0.0, -dot(wi, n)) / PI;
}

fn translucent_sample(n: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return normalize(basis(-n) * sample_cosine_hemisphere(u));
}

// Cosine of light from a direction to the shading normal n, or of light that leaves; 0 on a side of the surface where none does.
fn scatter_cosine(m: PackedMaterial, geometric: vec3<f32>, n: vec3<f32>, w: vec3<f32>) -> f32 {
    let cosine = dot(w, n);
    let above = dot(w, geometric);
    if is_translucent(m) && cosine < 0.0 && above < 0.0 {
        return -cosine;
    }
    return select(0.0, cosine, cosine > 0.0 && above > 0.0);
}
