// Lobes: the list of what a surface can do with light. Who follows light knows a lobe by its number, and whether it is delta: light
// leaves by it in one direction, or so nearly that it is followed (event S); by the others it scatters (event D). A new
// lobe is a file of its own and a line in each of the functions below.
// Twin: src/optics/shading/mod.rs.
// import: shading/lambert.wgsl
// import: shading/phong.wgsl
// import: shading/mirror.wgsl
// import: shading/dielectric.wgsl

const LOBE_NONE: u32 = 0u;
const LOBE_LAMBERT: u32 = 1u;
const LOBE_PHONG: u32 = 2u;
// Delta lobes from here on.
const LOBE_MIRROR: u32 = 3u;
const LOBE_REFLECTION: u32 = 4u;
const LOBE_TRANSMISSION: u32 = 5u;

fn is_delta(lobe: u32) -> bool {
    return lobe >= LOBE_MIRROR;
}

// True where some lobe scatters: a gather point, a place for jotons.
fn does_scatter(m: PackedMaterial) -> bool {
    return (m.flag_bits & (DIFFUSE | GLOSSY)) != 0u;
}

// True where the BRDF depends on directions.
fn does_vary(m: PackedMaterial) -> bool {
    return HAS_GLOSSY && (m.flag_bits & GLOSSY) != 0u;
}

// True for a lobe of finite width that is followed as a mirror is, where there are lights that are not met so.
fn is_narrow(m: PackedMaterial) -> bool {
    return HAS_SPECULAR && HAS_DELTA_LIGHTS && m.specular_exponent > 0.0;
}

// Reflectance or transmittance of a lobe, per band; `reflectance` is the interface's, by Fresnel.
fn lobe_albedo(m: PackedMaterial, lobe: u32, reflectance: Bands) -> Bands {
    switch lobe {
        case LOBE_LAMBERT: { return m.diffuse; }
        case LOBE_PHONG: { return m.glossy; }
        case LOBE_MIRROR: { return m.specular; }
        case LOBE_REFLECTION: { return m.specular * reflectance; }
        default: { return m.transmission * (1.0 - reflectance); }
    }
}

// Of all lobes together.
fn total_albedo(m: PackedMaterial, reflectance: Bands) -> Bands {
    let delta = select(m.specular, m.specular * reflectance + m.transmission * (1.0 - reflectance), is_dielectric(m));
    return m.diffuse + m.glossy + delta;
}

// A number for each lobe.
struct LobeWeights {
    lambert: f32,
    phong: f32,
    mirror: f32,
    reflection: f32,
    transmission: f32,
}

// Part of the flux that takes each lobe, as max over bands of (albedo × carried) / max of carried.
fn lobe_weights(m: PackedMaterial, carried: Bands, reflectance: Bands) -> LobeWeights {
    let scale = 1.0 / max(max_band(carried), 1e-37);
    var w = LobeWeights(0.0, 0.0, 0.0, 0.0, 0.0);
    if is_dielectric(m) {
        w.reflection = max_band(reflectance * (m.specular * carried)) * scale;
        w.transmission = max_band((1.0 - reflectance) * (m.transmission * carried)) * scale;
        return w;
    }
    w.lambert = max_band(m.diffuse * carried) * scale;
    if HAS_GLOSSY {
        w.phong = max_band(m.glossy * carried) * scale;
    }
    if HAS_SPECULAR {
        w.mirror = max_band(m.specular * carried) * scale;
    }
    return w;
}

fn scaled_weights(w: LobeWeights, factor: f32) -> LobeWeights {
    return LobeWeights(
        w.lambert * factor, w.phong * factor, w.mirror * factor, w.reflection * factor, w.transmission * factor,
    );
}

fn weight_of(w: LobeWeights, lobe: u32) -> f32 {
    switch lobe {
        case LOBE_LAMBERT: { return w.lambert; }
        case LOBE_PHONG: { return w.phong; }
        case LOBE_MIRROR: { return w.mirror; }
        case LOBE_REFLECTION: { return w.reflection; }
        default: { return w.transmission; }
    }
}

// Sum over the lobes that scatter.
fn scatter_weight(w: LobeWeights) -> f32 {
    return w.lambert + w.phong;
}

// Sum over the delta lobes.
fn delta_weight(w: LobeWeights) -> f32 {
    return w.mirror + w.reflection + w.transmission;
}

// How much weight an eye path gives to stopping here: lights without area are seen in a narrow lobe only from a path that stops.
fn stop_weight(m: PackedMaterial, w: LobeWeights) -> f32 {
    let scatter = scatter_weight(w);
    return select(scatter, max(scatter, NARROW_STOPS * w.mirror), is_narrow(m));
}

// Weights as probabilities of Russian roulette: where the bands' maxima add up to more than one, scaled down to one, and late in a
// path to less [E3].
fn roulette(w: LobeWeights, events: u32) -> LobeWeights {
    let limit = select(SURVIVAL_MAX, 1.0, events < SURE_EVENTS);
    return scaled_weights(w, limit / max(limit, scatter_weight(w) + delta_weight(w)));
}

// The lobe that u in [0, 1) falls on; LOBE_NONE past all of them.
fn chosen_lobe(w: LobeWeights, u: f32) -> u32 {
    var edge = w.lambert;
    if u < edge {
        return LOBE_LAMBERT;
    }
    edge += w.phong;
    if u < edge {
        return LOBE_PHONG;
    }
    edge += w.mirror;
    if u < edge {
        return LOBE_MIRROR;
    }
    edge += w.reflection;
    if u < edge {
        return LOBE_REFLECTION;
    }
    return select(LOBE_NONE, LOBE_TRANSMISSION, u < edge + w.transmission);
}

// The delta lobe that u in [0, their sum) falls on; never one without weight, whatever rounding says.
fn chosen_delta(w: LobeWeights, u: f32) -> u32 {
    if HAS_DIELECTRIC && w.transmission > 0.0 && u >= w.mirror + w.reflection {
        return LOBE_TRANSMISSION;
    }
    return select(LOBE_MIRROR, LOBE_REFLECTION, HAS_DIELECTRIC && w.reflection > 0.0 && u >= w.mirror);
}

// BRDF of the lobes that scatter, 1/sr.
fn eval_scatter(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    var f = lambert_eval(m);
    if does_vary(m) {
        f += phong_eval(m.glossy, m.glossy_exponent, n, wi, wo);
    }
    return f;
}

// BRDF of a narrow lobe, 1/sr, for lights without area: following it never meets them [E6].
fn eval_narrow(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    if !is_narrow(m) {
        return Bands(0.0);
    }
    return phong_eval(m.specular, m.specular_exponent, n, wi, wo);
}

// Probability that a sample of the lobes that scatter takes the Lambert lobe.
fn lambert_share(m: PackedMaterial) -> f32 {
    let glossy = max_band(m.glossy);
    if !HAS_GLOSSY || glossy <= 0.0 {
        return 1.0;
    }
    let diffuse = max_band(m.diffuse);
    return diffuse / (diffuse + glossy);
}

// pdf_solid_angle of sample_scatter.
fn pdf_scatter(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let lambert = lambert_share(m);
    var pdf = lambert * lambert_pdf(n, wi);
    if lambert < 1.0 {
        pdf += (1.0 - lambert) * phong_pdf(m.glossy_exponent, n, wi, wo);
    }
    return pdf;
}

// A direction from the lobes that scatter; it may lie below the surface.
fn sample_scatter(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    if u.z < lambert_share(m) {
        return lambert_sample(n, u.xy);
    }
    return phong_sample(m.glossy_exponent, n, -wo, u.xy);
}

// Where light goes by a lobe.
struct LobeSample {
    // Unit.
    direction: vec3<f32>,
    // f cosθ / (albedo pdf_solid_angle); 0 where the direction is on the wrong side of the surface.
    weight: f32,
    // Radiance scales by this on the way to the eye, (η_i/η_t)²; flux does not [E9].
    radiance_scale: f32,
}

// Both normals are on the side of `direction`, which arrives. Where a shading normal would send a reflection below the surface,
// or a transmission above it, the geometric one decides.
fn sample_delta(
    m: PackedMaterial, lobe: u32, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> LobeSample {
    if HAS_DIELECTRIC && lobe == LOBE_TRANSMISSION {
        let eta_it = relative_index(m, from_front);
        let d = transmitted_direction(m, direction, geometric, n, eta_it);
        return LobeSample(d, select(0.0, 1.0, any(d != vec3(0.0))), eta_it * eta_it);
    }
    // an interface's reflection has no width
    let d = mirror_sample(select(0.0, m.specular_exponent, lobe == LOBE_MIRROR), direction, geometric, n, u);
    return LobeSample(d, select(0.0, 1.0, dot(d, geometric) > 0.0), 1.0);
}

fn sample_lobe(
    m: PackedMaterial, lobe: u32, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> LobeSample {
    if is_delta(lobe) {
        return sample_delta(m, lobe, direction, geometric, n, from_front, u);
    }
    var d: vec3<f32>;
    var weight = 1.0;
    if lobe == LOBE_LAMBERT {
        d = lambert_sample(n, u);
    } else {
        d = phong_sample(m.glossy_exponent, n, direction, u);
        weight = phong_weight(m.glossy_exponent, dot(d, n));
    }
    return LobeSample(d, select(0.0, weight, dot(d, geometric) > 0.0), 1.0);
}
