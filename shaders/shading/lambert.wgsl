// The Lambert lobe: f = albedo/π, pdf_solid_angle = cosθ/π. Twin: src/optics/shading/lambert.rs.
// import: sampling/sampling.wgsl

fn lambert_eval(m: PackedMaterial) -> Bands {
    return m.diffuse / PI;
}

fn lambert_pdf(n: vec3<f32>, wi: vec3<f32>) -> f32 {
    return max(0.0, dot(wi, n)) / PI;
}

fn lambert_sample(n: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return normalize(basis(n) * sample_cosine_hemisphere(u));
}
