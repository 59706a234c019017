// The Phong lobe: f = albedo (e+2)/2π cosᵉα, α between wo and the mirror direction of wi, pdf_solid_angle = (e+1)/2π cosᵉα [E6].
// Twin: src/optics/shading/phong.rs.
// import: sampling/sampling.wgsl

// cosᵉα, α between two directions, from 1 − cosα: near one a cosine has no digits for a large exponent.
fn phong_power(exponent: f32, a: vec3<f32>, b: vec3<f32>) -> f32 {
    let off = a - b;
    let below = 0.5 * dot(off, off);
    return select(0.0, exp(exponent * log_one_minus(min(below, 1.0))), below < 1.0);
}

fn phong_eval(albedo: Bands, exponent: f32, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    return albedo * ((exponent + 2.0) / TAU * phong_power(exponent, reflect(-wi, n), wo));
}

fn phong_pdf(exponent: f32, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    return phong_pdf_about(exponent, reflect(-wi, n), wo);
}

// The same of a direction about an axis.
fn phong_pdf_about(exponent: f32, axis: vec3<f32>, w: vec3<f32>) -> f32 {
    return (exponent + 1.0) / TAU * phong_power(exponent, axis, w);
}

// `direction` arrives. It may lie below the surface.
fn phong_sample(exponent: f32, n: vec3<f32>, direction: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return normalize(basis(normalize(reflect(direction, n))) * sample_phong_lobe(u, exponent));
}

// f cosθ / (albedo pdf) of a direction that was sampled so.
fn phong_weight(exponent: f32, cos_out: f32) -> f32 {
    return (exponent + 2.0) / (exponent + 1.0) * max(0.0, cos_out);
}
