// Lobes: the list of what a surface can do with light. Who follows light knows a lobe by its number, and whether it is delta: light
// leaves by it in one direction, or so nearly that it is followed (event S); by the others it scatters (event D). A new
// lobe is a file of its own and a line in each of the functions below.
// Twin: src/optics/shading/mod.rs.
// import: shading/lambert.wgsl
// import: shading/translucent.wgsl
// import: shading/phong.wgsl
// import: shading/mirror.wgsl
// import: shading/dielectric.wgsl
// import: shading/fresnel.wgsl
// import: shading/undercoat.wgsl
// import: shading/microfacet.wgsl
// import: shading/rough_interface.wgsl
// import: shading/layers.wgsl
// import: shading/layered_lobes.wgsl

const LOBE_NONE: u32 = 0u;
const LOBE_DIFFUSE: u32 = 1u;
const LOBE_GLOSSY: u32 = 2u;
const LOBE_TRANSLUCENT: u32 = 3u;
const LOBE_SHEEN: u32 = 4u;
const LOBE_CLEAR_COAT: u32 = 5u;
// Delta lobes from here on.
const LOBE_MIRROR: u32 = 6u;
// Of an interface, or of a clear coat that is followed.
const LOBE_REFLECTION: u32 = 7u;
const LOBE_TRANSMISSION: u32 = 8u;

fn is_delta(lobe: u32) -> bool {
    return lobe >= LOBE_MIRROR;
}

// True where some lobe may scatter: a place for jotons. Where roughness varies, all of the surface is.
fn does_scatter(m: PackedMaterial) -> bool {
    return (m.flag_bits & STORES) != 0u;
}

// True where the BRDF depends on directions.
fn does_vary(m: PackedMaterial) -> bool {
    return (HAS_GLOSSY && (m.flag_bits & GLOSSY) != 0u) || is_coated(m) || is_layered(m);
}

// What of a material depends on the angle at which light arrives.
struct AtAngle {
    // Of an interface; of microfacets that lie flat. Else 0.
    reflectance: Bands,
    // Part of a diffuse lobe's light that a coat lets in and out; 1 where there is none.
    under_coat: f32,
    // Of a clear coat, and of white sheen under it.
    clear_coat: f32,
    sheen: f32,
}

// The lobe of microfacets: what the material says of it. One of the two is black.
fn facet_tint(m: PackedMaterial) -> Bands {
    return select(m.specular, m.glossy, (m.flag_bits & GLOSSY) != 0u);
}

// n is a unit normal on the side of -direction.
fn at_angle(m: PackedMaterial, n: vec3<f32>, direction: vec3<f32>, from_front: bool) -> AtAngle {
    if has_facets(m) {
        if is_rough_interface(m) {
            return AtAngle(rough_reflectance(m, n, direction, from_front), 1.0, 0.0, 0.0);
        }
        let cosine = -dot(direction, n);
        let under_coat = select(1.0, undercoat_albedo(m, cosine), is_coated(m));
        // where the tint is black there is no lobe, whatever Schlick's formula says
        let has_lobe = (m.flag_bits & (GLOSSY | SPECULAR)) != 0u;
        let facets = select(Bands(0.0), facet_reflectance(m, facet_tint(m), cosine), has_lobe);
        if is_layered(m) {
            let passed = layers_pass(m, cosine);
            let coat = clear_coat_reflectance(m, cosine);
            return AtAngle(facets * passed, under_coat * passed, coat, sheen_albedo(m, cosine) * (1.0 - coat));
        }
        return AtAngle(facets, under_coat, 0.0, 0.0);
    }
    return AtAngle(dielectric_reflectance(m, n, direction, from_front), 1.0, 0.0, 0.0);
}

// Of what mirrors or is glossy and no interface; a material of microfacets states one of the two.
fn reflecting_albedo(m: PackedMaterial, lobe: u32, stated: Bands, at: AtAngle) -> Bands {
    return select(stated, at.reflectance, has_facets(m) && (m.flag_bits & lobe) != 0u);
}

// Reflectance or transmittance of a lobe, per band; of one with a width about that.
fn lobe_albedo(m: PackedMaterial, lobe: u32, at: AtAngle) -> Bands {
    switch lobe {
        case LOBE_DIFFUSE: { return diffuse_albedo(m, at); }
        case LOBE_GLOSSY: { return reflecting_albedo(m, GLOSSY, m.glossy, at); }
        case LOBE_TRANSLUCENT: { return m.transmission; }
        case LOBE_MIRROR: { return reflecting_albedo(m, SPECULAR, m.specular, at); }
        case LOBE_SHEEN: { return sheen_colour(m) * at.sheen; }
        case LOBE_CLEAR_COAT: { return Bands(at.clear_coat); }
        case LOBE_REFLECTION: { return interface_albedo(m, at); }
        default: { return m.transmission * (1.0 - at.reflectance); }
    }
}

fn interface_albedo(m: PackedMaterial, at: AtAngle) -> Bands {
    if is_layered(m) {
        return Bands(at.clear_coat);
    }
    return m.specular * at.reflectance;
}

fn diffuse_albedo(m: PackedMaterial, at: AtAngle) -> Bands {
    if HAS_FACETS {
        return m.diffuse * at.under_coat;
    }
    return m.diffuse;
}

// Of all lobes together.
fn total_albedo(m: PackedMaterial, at: AtAngle) -> Bands {
    if is_dielectric(m) {
        return m.diffuse + m.glossy + (m.specular * at.reflectance + m.transmission * (1.0 - at.reflectance));
    }
    if has_facets(m) {
        let base = diffuse_albedo(m, at) + at.reflectance;
        if is_layered(m) {
            return base + (sheen_colour(m) * at.sheen + at.clear_coat);
        }
        return base;
    }
    if is_translucent(m) {
        return m.diffuse + m.glossy + m.specular + m.transmission;
    }
    return m.diffuse + m.glossy + m.specular;
}

// A number for each lobe.
struct LobeWeights {
    diffuse: f32,
    glossy: f32,
    mirror: f32,
    reflection: f32,
    transmission: f32,
    translucent: f32,
    sheen: f32,
    clear_coat: f32,
}

// Part of the flux that takes each lobe, as max over bands of (albedo × carried) / max of carried.
fn lobe_weights(m: PackedMaterial, carried: Bands, at: AtAngle) -> LobeWeights {
    let scale = 1.0 / max(max_band(carried), 1e-37);
    var w = LobeWeights(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    if is_dielectric(m) {
        w.reflection = max_band(at.reflectance * (m.specular * carried)) * scale;
        w.transmission = max_band((1.0 - at.reflectance) * (m.transmission * carried)) * scale;
        return w;
    }
    w.diffuse = max_band(diffuse_albedo(m, at) * carried) * scale;
    if HAS_GLOSSY {
        w.glossy = max_band(reflecting_albedo(m, GLOSSY, m.glossy, at) * carried) * scale;
    }
    if is_translucent(m) {
        w.translucent = max_band(m.transmission * carried) * scale;
    }
    if HAS_SPECULAR {
        w.mirror = max_band(reflecting_albedo(m, SPECULAR, m.specular, at) * carried) * scale;
    }
    if is_layered(m) {
        let coat = at.clear_coat * max_band(carried) * scale;
        w.sheen = max_band(sheen_colour(m) * carried) * at.sheen * scale;
        w.clear_coat = select(coat, 0.0, follows_clear_coat(m));
        w.reflection = select(0.0, coat, follows_clear_coat(m));
    }
    return w;
}

fn scaled_weights(w: LobeWeights, factor: f32) -> LobeWeights {
    return LobeWeights(
        w.diffuse * factor, w.glossy * factor, w.mirror * factor, w.reflection * factor, w.transmission * factor,
        w.translucent * factor, w.sheen * factor, w.clear_coat * factor,
    );
}

fn weight_of(w: LobeWeights, lobe: u32) -> f32 {
    switch lobe {
        case LOBE_DIFFUSE: { return w.diffuse; }
        case LOBE_GLOSSY: { return w.glossy; }
        case LOBE_TRANSLUCENT: { return w.translucent; }
        case LOBE_MIRROR: { return w.mirror; }
        case LOBE_SHEEN: { return w.sheen; }
        case LOBE_CLEAR_COAT: { return w.clear_coat; }
        case LOBE_REFLECTION: { return w.reflection; }
        default: { return w.transmission; }
    }
}

// Sum over the lobes that scatter.
fn scatter_weight(w: LobeWeights) -> f32 {
    var weight = w.diffuse + w.glossy;
    if HAS_TRANSLUCENT {
        weight += w.translucent;
    }
    if HAS_LAYERS {
        weight += w.sheen + w.clear_coat;
    }
    return weight;
}

// Sum over the delta lobes.
fn delta_weight(w: LobeWeights) -> f32 {
    return w.mirror + w.reflection + w.transmission;
}

// Weights as probabilities of Russian roulette: where the bands' maxima add up to more than one, scaled down to one, and late in a
// path to less [E3].
fn roulette(w: LobeWeights, events: u32) -> LobeWeights {
    let limit = select(SURVIVAL_MAX, 1.0, events < SURE_EVENTS);
    return scaled_weights(w, limit / max(limit, scatter_weight(w) + delta_weight(w)));
}

// The lobe that u in [0, 1) falls on; LOBE_NONE past all of them.
fn chosen_lobe(w: LobeWeights, u: f32) -> u32 {
    var edge = w.diffuse;
    if u < edge {
        return LOBE_DIFFUSE;
    }
    edge += w.glossy;
    if u < edge {
        return LOBE_GLOSSY;
    }
    if HAS_TRANSLUCENT {
        edge += w.translucent;
        if u < edge {
            return LOBE_TRANSLUCENT;
        }
    }
    if HAS_LAYERS {
        edge += w.sheen;
        if u < edge {
            return LOBE_SHEEN;
        }
        edge += w.clear_coat;
        if u < edge {
            return LOBE_CLEAR_COAT;
        }
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
    return select(LOBE_MIRROR, LOBE_REFLECTION, (HAS_DIELECTRIC || HAS_LAYERS) && w.reflection > 0.0 && u >= w.mirror);
}

// BSDF of the lobes that scatter, 1/sr.
fn eval_scatter(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    if is_translucent(m) && dot(wi, n) < 0.0 {
        return translucent_eval(m);
    }
    return eval_reflected(m, n, wi, wo);
}

// Of those that leave light on its side.
fn eval_reflected(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> Bands {
    var f = lambert_eval(m);
    if is_coated(m) {
        f = undercoat_eval(m, n, wi, wo);
    }
    if HAS_GLOSSY && (m.flag_bits & GLOSSY) != 0u {
        if has_facets(m) {
            f += microfacet_eval(m, m.glossy, n, wi, wo);
        } else {
            f += phong_eval(m.glossy, m.glossy_exponent, n, wi, wo);
        }
    }
    if is_layered(m) {
        f = f * base_under_layers(m, dot(n, wi), dot(n, wo)) + sheen_colour(m) * sheen_eval(m, n, wi, wo);
        if !follows_clear_coat(m) {
            f += clear_coat_eval(m, n, wi, wo);
        }
    }
    return f;
}

// Probability that a sample of the lobes that scatter takes the diffuse one.
fn diffuse_share(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>) -> f32 {
    if HAS_GLOSSY && has_facets(m) && (m.flag_bits & GLOSSY) != 0u {
        let at = at_angle(m, n, -wo, true);
        let base = max_band(diffuse_albedo(m, at));
        return base / max(base + max_band(at.reflectance), 1e-30);
    }
    let glossy = max_band(m.glossy);
    if !HAS_GLOSSY || glossy <= 0.0 {
        return 1.0;
    }
    let diffuse = max_band(m.diffuse);
    return diffuse / (diffuse + glossy);
}

// Probability that a sample of the lobes that scatter goes to the other side.
fn translucent_share(m: PackedMaterial) -> f32 {
    if !is_translucent(m) {
        return 0.0;
    }
    let through = max_band(m.transmission);
    return through / max(through + max_band(m.diffuse) + max_band(m.glossy), 1e-30);
}

// pdf_solid_angle of sample_scatter.
fn pdf_scatter(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    if is_layered(m) {
        return pdf_layered(m, n, wi, wo);
    }
    if is_translucent(m) {
        let through = translucent_share(m);
        if dot(wi, n) < 0.0 {
            return through * translucent_pdf(n, wi);
        }
        return (1.0 - through) * pdf_reflected(m, n, wi, wo);
    }
    return pdf_reflected(m, n, wi, wo);
}

// That of the lobes that leave light on its side.
fn pdf_reflected(m: PackedMaterial, n: vec3<f32>, wi: vec3<f32>, wo: vec3<f32>) -> f32 {
    let diffuse = diffuse_share(m, n, wo);
    var pdf = diffuse * lambert_pdf(n, wi);
    if diffuse < 1.0 {
        if has_facets(m) {
            pdf += (1.0 - diffuse) * microfacet_pdf(m, n, wi, wo);
        } else {
            pdf += (1.0 - diffuse) * phong_pdf(m.glossy_exponent, n, wi, wo);
        }
    }
    return pdf;
}

// A direction from the lobes that scatter; it may lie below the surface. Where light goes there, too, f and pdf of it are those of that lobe.
fn sample_scatter(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    if is_layered(m) {
        return sample_layered(m, n, wo, u);
    }
    if is_translucent(m) {
        let through = translucent_share(m);
        if u.z < through {
            return translucent_sample(n, u.xy);
        }
        return sample_reflected(m, n, wo, vec3(u.xy, (u.z - through) / (1.0 - through)));
    }
    return sample_reflected(m, n, wo, u);
}

fn sample_reflected(m: PackedMaterial, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> vec3<f32> {
    if u.z < diffuse_share(m, n, wo) {
        return lambert_sample(n, u.xy);
    }
    if has_facets(m) {
        return microfacet_sample(m, n, wo, u.xy);
    }
    return phong_sample(m.glossy_exponent, n, -wo, u.xy);
}

// Where light goes by a lobe.
struct LobeSample {
    // Unit.
    direction: vec3<f32>,
    // f cosθ / (albedo pdf_solid_angle), per band; 0 where the direction is on the wrong side of the surface.
    weight: Bands,
    // Radiance scales by this on the way to the eye, (η_i/η_t)²; flux does not [E9].
    radiance_scale: f32,
}

fn weighed(direction: vec3<f32>, weight: f32, radiance_scale: f32) -> LobeSample {
    return LobeSample(direction, Bands(weight), radiance_scale);
}

// Both normals are on the side of `direction`, which arrives. Where a shading normal would send a reflection below the surface,
// or a transmission above it, the geometric one decides.
fn sample_delta(
    m: PackedMaterial, lobe: u32, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> LobeSample {
    if is_rough_interface(m) {
        let transmits = lobe == LOBE_TRANSMISSION;
        let sample = rough_sample(m, transmits, direction, geometric, n, from_front, u);
        let eta_it = relative_index(m, from_front);
        return LobeSample(sample.direction, sample.weight, select(1.0, eta_it * eta_it, transmits));
    }
    if HAS_DIELECTRIC && lobe == LOBE_TRANSMISSION {
        let eta_it = relative_index(m, from_front);
        let d = transmitted_direction(m, direction, geometric, n, eta_it);
        return weighed(d, select(0.0, 1.0, any(d != vec3(0.0))), eta_it * eta_it);
    }
    if is_layered(m) && lobe == LOBE_REFLECTION && m.clear_coat_alpha > 0.0 {
        return clear_coat_sample(m, direction, geometric, n, u);
    }
    if HAS_SPECULAR && has_facets(m) && m.alpha > 0.0 && !(is_layered(m) && lobe == LOBE_REFLECTION) {
        return facet_sample(m, m.specular, direction, geometric, n, u);
    }
    // an interface's reflection has no width
    let d = mirror_sample(select(0.0, m.specular_exponent, lobe == LOBE_MIRROR), direction, geometric, n, u);
    return weighed(d, select(0.0, 1.0, dot(d, geometric) > 0.0), 1.0);
}

fn facet_sample(
    m: PackedMaterial, tint: Bands, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, u: vec2<f32>,
) -> LobeSample {
    let d = microfacet_sample(m, n, -direction, u);
    let flat = facet_reflectance(m, tint, -dot(direction, n));
    var weight = microfacet_weight(m, tint, n, d, -direction, flat);
    if is_layered(m) {
        weight *= under_layers_weight(m, dot(d, n), -dot(direction, n));
    }
    return LobeSample(d, select(Bands(0.0), weight, dot(d, geometric) > 0.0), 1.0);
}

fn sample_lobe(
    m: PackedMaterial, lobe: u32, direction: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, from_front: bool, u: vec2<f32>,
) -> LobeSample {
    if is_delta(lobe) {
        return sample_delta(m, lobe, direction, geometric, n, from_front, u);
    }
    if HAS_LAYERS && lobe == LOBE_SHEEN {
        return sheen_sample_at(m, direction, geometric, n, u);
    }
    if HAS_LAYERS && lobe == LOBE_CLEAR_COAT {
        return clear_coat_sample(m, direction, geometric, n, u);
    }
    if lobe == LOBE_GLOSSY && has_facets(m) {
        return facet_sample(m, m.glossy, direction, geometric, n, u);
    }
    if HAS_TRANSLUCENT && lobe == LOBE_TRANSLUCENT {
        let through = translucent_sample(n, u);
        return weighed(through, select(0.0, 1.0, dot(through, geometric) < 0.0), 1.0);
    }
    var d: vec3<f32>;
    var weight = 1.0;
    if lobe == LOBE_DIFFUSE {
        d = lambert_sample(n, u);
        if is_coated(m) {
            weight = undercoat_weight(m, dot(d, n));
        }
        if is_layered(m) {
            weight *= under_layers_weight(m, dot(d, n), -dot(direction, n));
        }
    } else {
        d = phong_sample(m.glossy_exponent, n, direction, u);
        weight = phong_weight(m.glossy_exponent, dot(d, n));
    }
    return weighed(d, select(0.0, weight, dot(d, geometric) > 0.0), 1.0);
}
