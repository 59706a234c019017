// What happens at a surface. Twin: src/optics/shading/bsdf.rs.
// import: sampling/sampling.wgsl

// Reflectance of a smooth dielectric for unpolarised light [E8]; eta = n_transmitted / n_incident; 1 at total reflection.
fn fresnel(cos_i: f32, eta: f32) -> f32 {
    let sin2_t = (1.0 - cos_i * cos_i) / (eta * eta);
    if sin2_t >= 1.0 {
        return 1.0;
    }
    let cos_t = sqrt(1.0 - sin2_t);
    let parallel = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
    let perpendicular = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
    return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

// Snell: direction d on to a surface with unit normal n toward d's side; eta_it = n_incident / n_transmitted.
// Zero at total reflection.
fn refract_direction(d: vec3<f32>, n: vec3<f32>, eta_it: f32) -> vec3<f32> {
    let cos_i = -dot(d, n);
    let k = 1.0 - eta_it * eta_it * (1.0 - cos_i * cos_i);
    if k <= 0.0 {
        return vec3(0.0);
    }
    return normalize(eta_it * d + (eta_it * cos_i - sqrt(k)) * n);
}

fn max_band(b: Bands) -> f32 {
    return max(b.x, max(b.y, b.z));
}

// BRDF of the D lobes, 1/sr: Lambert plus normalised Phong about the mirror direction [E6].
fn eval_brdf(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    var f = m.diffuse / PI;
    if HAS_GLOSSY && (m.flag_bits & GLOSSY) != 0u {
        f += m.glossy * ((m.glossy_exponent + 2.0) / TAU * phong(m.glossy_exponent, n, wi, wo));
    }
    return f;
}

// BRDF of a lobe that is followed, 1/sr, for lights without area: following it never meets them [E6].
fn eval_narrow(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    if !is_narrow(m) {
        return Bands(0.0);
    }
    return m.specular * ((m.specular_exponent + 2.0) / TAU * phong(m.specular_exponent, n, wi, wo));
}

// A lobe of finite width that is followed as a mirror is, where there are lights that are not met so.
fn is_narrow(m: PackedMaterial) -> bool {
    return HAS_SPECULAR && HAS_DELTA_LIGHTS && m.specular_exponent > 0.0;
}

// cosᵉα of a Phong lobe, from 1 − cosα: near one a cosine has no digits for a large exponent.
fn phong(exponent: f32, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let off = reflect(-wi, n) - wo;
    let below = 0.5 * dot(off, off);
    return select(0.0, exp(exponent * log_one_minus(min(below, 1.0))), below < 1.0);
}

const EVENT_ABSORB: u32 = 0u;
const EVENT_DIFFUSE: u32 = 1u;
const EVENT_GLOSSY: u32 = 2u;
const EVENT_MIRROR: u32 = 3u;
const EVENT_REFLECT: u32 = 4u;
const EVENT_TRANSMIT: u32 = 5u;

// Part of the flux that each event takes, as max over bands of (reflectance × carried) / max of carried.
struct EventProbabilities {
    diffuse: f32,
    glossy: f32,
    mirror: f32,
    reflect: f32,
    transmit: f32,
}

fn event_probabilities(m: PackedMaterial, carried: Bands, reflectance: f32) -> EventProbabilities {
    let scale = 1.0 / max(max_band(carried), 1e-37);
    var c = EventProbabilities(0.0, 0.0, 0.0, 0.0, 0.0);
    if HAS_DIELECTRIC && (m.flag_bits & DIELECTRIC) != 0u {
        c.reflect = reflectance * max_band(m.specular * carried) * scale;
        c.transmit = (1.0 - reflectance) * max_band(m.transmission * carried) * scale;
        return c;
    }
    c.diffuse = max_band(m.diffuse * carried) * scale;
    if HAS_GLOSSY {
        c.glossy = max_band(m.glossy * carried) * scale;
    }
    if HAS_SPECULAR {
        c.mirror = max_band(m.specular * carried) * scale;
    }
    return c;
}

// The same for Russian roulette: where the bands' maxima add up to more than one, scaled down to one, and late in a
// path to less [E3].
fn roulette_probabilities(m: PackedMaterial, carried: Bands, reflectance: f32, events: u32) -> EventProbabilities {
    let c = event_probabilities(m, carried, reflectance);
    let limit = select(SURVIVAL_MAX, 1.0, events < SURE_EVENTS);
    let scale = limit / max(limit, c.diffuse + c.glossy + c.mirror + c.reflect + c.transmit);
    return EventProbabilities(c.diffuse * scale, c.glossy * scale, c.mirror * scale, c.reflect * scale, c.transmit * scale);
}

// The event that u in [0, 1) falls on; absorption past all of them.
fn chosen_event(c: EventProbabilities, u: f32) -> u32 {
    var edge = c.diffuse;
    if u < edge {
        return EVENT_DIFFUSE;
    }
    edge += c.glossy;
    if u < edge {
        return EVENT_GLOSSY;
    }
    edge += c.mirror;
    if u < edge {
        return EVENT_MIRROR;
    }
    edge += c.reflect;
    if u < edge {
        return EVENT_REFLECT;
    }
    return select(EVENT_ABSORB, EVENT_TRANSMIT, u < edge + c.transmit);
}

// Probability that a sample of the D lobes takes the Lambert lobe.
fn matte_share(m: PackedMaterial) -> f32 {
    let glossy = max_band(m.glossy);
    if !HAS_GLOSSY || glossy <= 0.0 {
        return 1.0;
    }
    let diffuse = max_band(m.diffuse);
    return diffuse / (diffuse + glossy);
}

// pdf_solid_angle of sample_brdf.
fn pdf_brdf(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let matte = matte_share(m);
    var pdf = matte * max(0.0, dot(wi, n)) / PI;
    if matte < 1.0 {
        pdf += (1.0 - matte) * (m.glossy_exponent + 1.0) / TAU * phong(m.glossy_exponent, n, wi, wo);
    }
    return pdf;
}

// A direction from the D lobes; it may lie below the surface.
fn sample_brdf(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    if u.z < matte_share(m) {
        return normalize(basis(n) * sample_cosine_hemisphere(u.xy));
    }
    return normalize(basis(normalize(reflect(-wo, n))) * sample_phong_lobe(u.xy, m.glossy_exponent));
}
