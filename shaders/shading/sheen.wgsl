// Sheen: fibres that stand up from a surface. f = C D / (4 cosθi cosθo (1 + Λi + Λo)), D = (2 + 1/α) sin^(1/α)θh / 2π [E51], Estevez &
// Kulla 2017. Directions are drawn evenly. Twin: src/optics/shading/sheen.rs.
// import: sampling/sampling.wgsl
// import: shading/clear_coat.wgsl

fn sheen_colour(m: PackedMaterial) -> Bands {
    return m.extinction;
}

fn sheen_roughness(m: PackedMaterial) -> f32 {
    return unpack2x16unorm(m.sheen).x;
}

// The most that the colour has in any band or at any wavelength.
fn sheen_most(m: PackedMaterial) -> f32 {
    return unpack2x16unorm(m.sheen).y;
}

// Part of white light at this cosine that the lobe sends on, by a fit from above.
fn sheen_albedo(m: PackedMaterial, cosine: f32) -> f32 {
    let r = sheen_roughness(m);
    let p = vec4(1.0, r, r * r, r * r * r);
    let y = sqrt(max(0.0, cosine));
    let high = dot(SHEEN_ALBEDO_4, p) + y * (dot(SHEEN_ALBEDO_5, p) + y * dot(SHEEN_ALBEDO_6, p));
    let low = dot(SHEEN_ALBEDO_2, p) + y * (dot(SHEEN_ALBEDO_3, p) + y * high);
    return clamp(dot(SHEEN_ALBEDO_0, p) + y * (dot(SHEEN_ALBEDO_1, p) + y * low), 0.0, 1.0);
}

// Exponent of Λ, from the two ends of the fit: α = 0 and α = 1.
fn sheen_exponent(x: f32, alpha: f32) -> f32 {
    let t = (1.0 - alpha) * (1.0 - alpha);
    let a = mix(21.5473, 25.3245, t);
    let b = mix(3.82987, 3.32435, t);
    let c = mix(0.19823, 0.16801, t);
    let d = mix(-1.97760, -1.27393, t);
    let e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow(x, c)) + d * x + e;
}

fn sheen_lambda(cosine: f32, alpha: f32) -> f32 {
    if cosine < 0.5 {
        return exp(sheen_exponent(cosine, alpha));
    }
    return exp(2.0 * sheen_exponent(0.5, alpha) - sheen_exponent(max(0.0, 1.0 - cosine), alpha));
}

// BRDF of a white one, 1/sr, under what clear coat there is.
fn sheen_eval(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let cos_i = dot(n, wi);
    let cos_o = dot(n, wo);
    if cos_i <= 0.0 || cos_o <= 0.0 {
        return 0.0;
    }
    let alpha = sheen_roughness(m) * sheen_roughness(m);
    let across = cross(n, normalize(wi + wo));
    let density = (2.0 + 1.0 / alpha) / TAU * pow(min(dot(across, across), 1.0), 0.5 / alpha);
    let shadowed = 1.0 + sheen_lambda(cos_i, alpha) + sheen_lambda(cos_o, alpha);
    let passed = 1.0 - max(clear_coat_reflectance(m, cos_i), clear_coat_reflectance(m, cos_o));
    return density * passed / (4.0 * cos_i * cos_o * shadowed);
}

fn sheen_pdf(n: vec3<f32>, wi: vec3<f32>) -> f32 {
    return select(0.0, 1.0 / TAU, dot(n, wi) > 0.0);
}

fn sheen_sample(n: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return normalize(basis(n) * sample_cone(u, 1.0));
}
