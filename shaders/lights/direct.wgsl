// Direct light at a surface: by shadow rays, and by the surface's lobes where these share the weight.
// L = f_r Le V G / (pick pdf_area) [E5]; where the surface is glossy or touches an emitter, each shadow ray shares its weight
// with one BSDF sample by the balance heuristic (Veach & Guibas 1995).
// reads  scene, pass_info
// import: scene/features.wgsl
// import: dispatch/index.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: accel/intersect.wgsl
// import: shading/lobes.wgsl
// import: shading/media.wgsl
// import: lights/pick.wgsl
// import: lights/light.wgsl
// import: lights/le.wgsl
// import: lights/reservoir.wgsl

// Where light arrives.
struct Receiver {
    material: PackedMaterial,
    // Lifted off the surface: where rays start.
    origin: vec3<f32>,
    // Unit normals toward where the path came from, and the direction to there.
    geometric: vec3<f32>,
    shading: vec3<f32>,
    wo: vec3<f32>,
    // Shadow rays share their weight with BSDF samples.
    shares: bool,
    // The bodies that it is in.
    inside: u32,
    // How far it is lifted, where light comes from the other side, too.
    lift: f32,
}

// Where rays in a direction start: on the side of the surface that it is on.
fn origin_toward(r: Receiver, direction: vec3<f32>) -> vec3<f32> {
    if is_translucent(r.material) && dot(direction, r.geometric) < 0.0 {
        return r.origin - 2.0 * r.lift * r.geometric;
    }
    return r.origin;
}

// Light of one shadow ray, and of one BSDF sample where these share the weight; without the throughput.
struct DirectLight {
    by_light: Bands,
    by_lobe: Bands,
    rays: u32,
    // Shadow rays that other candidates did not need.
    saved: u32,
}

fn sample_light(p: vec3<f32>, u: vec2<f32>) -> LightSample {
    let pick = pick_emitter(u.x, pass_info.emitters);
    return sample_li(emitter_at(pick.emitter), p, vec2(pick.rest, u.y));
}

// Light sample k of some, as seen from p.
fn light_candidate(p: vec3<f32>, draws: LightDraws, k: u32) -> LightSample {
    let at = wide_sum(draws.first, k);
    let seed = sequence_seed(seed_at(pass_info.seed, at.y), draws.path, draws.stream);
    return sample_light(p, sobol2(at.x, seed));
}

// True where p may lie so near to a light that shadow rays alone have fireflies. It depends on the place
// only, so the choice of estimator costs no bias.
fn near_emitter(p: vec3<f32>) -> bool {
    let count = own(pass_info.emitters);
    if count > NEAR_EMITTERS_MAX {
        return true;
    }
    var near = false;
    for (var i = 0u; i < count; i += 1u) {
        near = near || is_near(emitter_at(i), p);
    }
    return near;
}

// Light that a direction of the D lobes finds, with its share of the weight.
fn by_brdf(r: Receiver, u: vec3<f32>) -> Bands {
    let m = r.material;
    let n = r.shading;
    let wi = sample_scatter(m, n, r.wo, u);
    let cos_receiver = scatter_cosine(m, r.geometric, n, wi);
    if cos_receiver <= 0.0 {
        return Bands(0.0);
    }
    let hit = traverse(origin_toward(r, wi), wi, 1e30, false);
    var found = Bands(0.0);
    var pdf_light = 0.0;
    if hit.triangle == MISS {
        found = on_miss(wi);
    } else {
        let t = triangle_at(hit.triangle);
        let front = normalize(cross(t.e1, t.e2));
        if t.emitter != NO_EMITTER && dot(wi, front) < 0.0 {
            let e = emitter_at(t.emitter);
            found = e.strength;
            if has_glow(e) {
                found *= glow_on(e, vec2(hit.u, hit.v));
            }
            pdf_light = f32(pass_info.light_candidates) * pdf_li(e, hit.t, -dot(wi, front));
        }
    }
    if HAS_MEDIA {
        found *= transmittance(r.inside, hit.t);
    }
    if max_band(found) <= 0.0 {
        return Bands(0.0);
    }
    // f Le cos / pdf · pdf / (pdf + pdf_light)
    return eval_scatter(m, n, wi, r.wo) * found * (cos_receiver / (pdf_scatter(m, n, wi, r.wo) + pdf_light));
}

// One sample; u: a direction, its lobe, and which candidate.
fn direct_light(r: Receiver, draws: LightDraws, u: vec4<f32>) -> DirectLight {
    var result = DirectLight(Bands(0.0), Bands(0.0), 0u, 0u);
    let candidates = f32(pass_info.light_candidates);
    // one of the candidates gets the shadow ray, by what each would give if nothing shaded it, for all of them [E24]
    var picked = LightSample(vec3(0.0), 0.0, vec3(0.0), Bands(0.0), 0.0);
    var given = Bands(0.0);
    var reservoir = Reservoir(0.0, u.w);
    var found = 0u;
    for (var k = 0u; k < own(pass_info.light_candidates); k += 1u) {
        let light = light_candidate(r.origin, draws, k);
        let cos_receiver = scatter_cosine(r.material, r.geometric, r.shading, light.wi);
        if cos_receiver > 0.0 && max_band(light.weight) > 0.0 {
            var weight = cos_receiver;
            if r.shares && light.pdf > 0.0 {
                let pdf = candidates * light.pdf;
                weight *= pdf / (pdf + pdf_scatter(r.material, r.shading, light.wi, r.wo));
            }
            var gives = eval_scatter(r.material, r.shading, light.wi, r.wo) * light.weight * weight;
            if HAS_MEDIA {
                // a shadow ray crosses no boundary
                gives *= transmittance(r.inside, light.distance);
            }
            let size = max_band(gives);
            if size > 0.0 {
                found += 1u;
                if takes(&reservoir, size) {
                    picked = light;
                    given = gives;
                }
            }
        }
    }
    if max_band(given) > 0.0 {
        result.rays += 1u;
        result.saved += found - 1u;
        let origin = origin_toward(r, picked.wi);
        if !is_occluded(origin, picked.wi, picked.distance, picked.end) {
            result.by_light = given * (reservoir.total / (candidates * max_band(given)));
        }
    }
    if r.shares {
        result.rays += 1u;
        result.by_lobe = by_brdf(r, u.xyz);
    }
    return result;
}
