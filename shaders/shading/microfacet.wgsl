// A lobe of microfacets: f = F D V, D the density of GGX's normals, V = G₂/(4 cosθi cosθo) with Smith's masking of correlated heights [E41].
// Walter et al. 2007, Heitz 2014. Twin: src/optics/shading/microfacet.rs.
// import: sampling/sampling.wgsl
// import: shading/fresnel.wgsl
// import: shading/anisotropy.wgsl

// Density of normals, 1/sr.
fn ggx_density(alpha: f32, n: vec3<f32>, h: vec3<f32>) -> f32 {
    // the sine of the angle by a cross product: near the normal a cosine has no digits
    let across = cross(n, h);
    let cos_h = dot(n, h);
    let a2 = alpha * alpha;
    let s = dot(across, across) + a2 * cos_h * cos_h;
    return a2 / (PI * s * s);
}

// √(α² + (1 − α²) cos²θ).
fn ggx_slope(alpha: f32, cosine: f32) -> f32 {
    return sqrt(cosine * cosine + alpha * alpha * (1.0 - cosine * cosine));
}

// The normal of one of the facets that wo sees, each by the area that it shows (Dupuy & Benyoub 2023): the cap of a sphere, stretched by α
// along the first two axes of a frame about the surface normal.
fn visible_normal(frame: mat3x3<f32>, alphas: vec2<f32>, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    let local = wo * frame;
    let o = normalize(vec3(alphas * local.xy, local.z));
    let z = fma(1.0 - u.y, 1.0 + o.z, -o.z);
    let r = sqrt(clamp(1.0 - z * z, 0.0, 1.0));
    let h = vec3(r * unit_circle(u.x), z) + o;
    return normalize(frame * vec3(alphas * h.xy, max(0.0, h.z)));
}

// These of a material that has been met, brushed or not.
fn facet_density(m: PackedMaterial, n: vec3<f32>, h: vec3<f32>) -> f32 {
    if is_anisotropic(m) {
        return brushed_density(m, n, h);
    }
    return ggx_density(m.alpha, n, h);
}

fn facet_slope(m: PackedMaterial, n: vec3<f32>, w: vec3<f32>) -> f32 {
    if is_anisotropic(m) {
        return brushed_slope(m, n, w);
    }
    return ggx_slope(m.alpha, dot(n, w));
}

fn facet_normal(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    if is_anisotropic(m) {
        return visible_normal(brushed_frame(m, n), brushed_alphas(m), wo, u);
    }
    return visible_normal(basis(n), vec2(m.alpha), wo, u);
}

// G₁: part of the facets toward a direction that it sees; on whichever side that is.
fn facet_seen(m: PackedMaterial, n: vec3<f32>, w: vec3<f32>) -> f32 {
    let cosine = abs(dot(n, w));
    return 2.0 * cosine / (cosine + facet_slope(m, n, w));
}

// G₂/G₁(o): part of the facets that o sees which i sees as well.
fn facet_seen_again(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let cos_i = max(0.0, dot(n, wi));
    let cos_o = dot(n, wo);
    let slope_o = facet_slope(m, n, wo);
    return cos_i * (cos_o + slope_o) / (cos_i * slope_o + cos_o * facet_slope(m, n, wi));
}

// Part of the light at this cosine that facets mask from each other: it is scattered again and again [E41].
fn ggx_lost(alpha: f32, cosine: f32) -> f32 {
    let x = sqrt(alpha);
    let p = vec4(1.0, x, alpha, alpha * x);
    let y = sqrt(max(0.0, cosine));
    let series = dot(GGX_LOST_0, p)
        + y * (dot(GGX_LOST_1, p) + y * (dot(GGX_LOST_2, p) + y * (dot(GGX_LOST_3, p) + y * dot(GGX_LOST_4, p))));
    return max(0.0, series);
}

// Of even light: ∫ 2c lost(c) dc. The fit says too little of smooth surfaces.
fn ggx_lost_average(alpha: f32) -> f32 {
    let x = sqrt(alpha);
    let p = vec4(1.0, x, alpha, alpha * x);
    let sum = dot(GGX_LOST_0 + 0.8 * GGX_LOST_1 + (2.0 / 3.0) * GGX_LOST_2 + (4.0 / 7.0) * GGX_LOST_3 + 0.5 * GGX_LOST_4, p);
    return max(sum, min(0.9 * alpha * alpha, 0.0152));
}

// What is scattered more than once, as a diffuse lobe that light finds and leaves as facets mask it (Kulla & Conty 2017) [E41].
fn microfacet_again(m: PackedMaterial, tint: Bands, cos_i: f32, cos_o: f32) -> Bands {
    if (m.flag_bits & (CONDUCTOR | SCHLICK)) == 0u {
        return Bands(0.0);
    }
    let alpha = masking_alpha(m);
    let lost = ggx_lost_average(alpha);
    // of even light, as Schlick's formula has it
    var even = (20.0 * tint + facet_grazing(m)) / 21.0;
    if (m.flag_bits & CONDUCTOR) != 0u {
        even = tint * (20.0 * fresnel_conductor(1.0, m.iors, m.extinction) + 1.0) / 21.0;
    }
    let kept = even * even * (1.0 - lost) / (1.0 - even * lost);
    // none where the fit does not reach
    let rough = clamp((alpha - 0.02) / 0.03, 0.0, 1.0);
    return kept * (rough * ggx_lost(alpha, cos_i) * ggx_lost(alpha, cos_o) / (PI * lost));
}

fn microfacet_eval(m: PackedMaterial, tint: Bands, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    let cos_i = dot(n, wi);
    let cos_o = dot(n, wo);
    if cos_i <= 0.0 || cos_o <= 0.0 {
        return Bands(0.0);
    }
    let h = normalize(wi + wo);
    let visible = 0.5 / (cos_i * facet_slope(m, n, wo) + cos_o * facet_slope(m, n, wi));
    return facet_reflectance(m, tint, dot(wo, h)) * (facet_density(m, n, h) * visible)
        + microfacet_again(m, tint, cos_i, cos_o);
}

// pdf_solid_angle of microfacet_sample: G₁ D / (4 cosθo).
fn microfacet_pdf(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let cos_o = dot(n, wo);
    if dot(n, wi) <= 0.0 || cos_o <= 0.0 {
        return 0.0;
    }
    return facet_density(m, n, normalize(wi + wo)) / (2.0 * (cos_o + facet_slope(m, n, wo)));
}

// It may lie below the surface.
fn microfacet_sample(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec2<f32>) -> vec3<f32> {
    return normalize(reflect(-wo, facet_normal(m, n, wo, u)));
}

// f cosθ / (albedo pdf) of a direction that was sampled so.
fn microfacet_weight(m: PackedMaterial, tint: Bands, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>, albedo: Bands) -> Bands {
    let cos_i = dot(n, wi);
    let cos_o = dot(n, wo);
    if cos_i <= 0.0 || cos_o <= 0.0 {
        return Bands(0.0);
    }
    let reflected = facet_reflectance(m, tint, dot(wo, normalize(wi + wo))) * facet_seen_again(m, n, wi, wo);
    let again = microfacet_again(m, tint, cos_i, cos_o) * (cos_i / max(microfacet_pdf(m, n, wi, wo), 1e-20));
    return (reflected + again) / max(albedo, Bands(1e-20));
}
