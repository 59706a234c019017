// Direct: light that reaches a gather point straight from an emitter, by shadow rays (E S* D L).
// L = f_r Le V G / (pick pdf_area), averaged over the shadow rays [E5]; where the surface is glossy or touches an emitter,
// each shadow ray shares its weight with one BSDF sample by the balance heuristic (Veach & Guibas 1995).
// reads  scene, tiles, gather_points, path_filter      writes  film_direct, status
// import: scene/features.wgsl
// import: camera/strip.wgsl
// import: camera/live.wgsl
// import: dispatch/count.wgsl
// import: sampling/rng.wgsl
// import: scene/scene.wgsl
// import: accel/intersect.wgsl
// import: shading/material.wgsl
// import: shading/lobes.wgsl
// import: lights/pick.wgsl
// import: lights/light.wgsl
// import: lights/le.wgsl
// import: lights/reservoir.wgsl
// import: paths/gather_point.wgsl
// import: paths/paths.wgsl

@group(1) @binding(0) var<uniform> path_filter: PathFilter;
@group(1) @binding(1) var<storage, read> gather_points: array<GatherPoint>;
@group(1) @binding(2) var<storage, read_write> film_direct: array<vec4<f32>>;
@group(1) @binding(3) var<storage, read_write> status: array<atomic<u32>>;

fn sample_light(p: vec3<f32>, u: vec2<f32>) -> LightSample {
    let pick = pick_emitter(u.x, pass_info.emitters);
    return sample_li(emitter_at(pick.emitter), p, vec2(pick.rest, u.y));
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
fn by_brdf(m: PackedMaterial, origin: vec3<f32>, geometric: vec3<f32>, n: vec3<f32>, wo: vec3<f32>, u: vec3<f32>) -> Bands {
    let wi = sample_scatter(m, n, wo, u);
    let cos_receiver = dot(wi, n);
    if cos_receiver <= 0.0 || dot(wi, geometric) <= 0.0 {
        return Bands(0.0);
    }
    let hit = traverse(origin, wi, 1e30, false);
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
            pdf_light = f32(pass_info.light_candidates) * pdf_li(e, hit.t, -dot(wi, front));
        }
    }
    if max_band(found) <= 0.0 {
        return Bands(0.0);
    }
    // f Le cos / pdf · pdf / (pdf + pdf_light)
    return eval_scatter(m, n, wi, wo) * found * (cos_receiver / (pdf_scatter(m, n, wi, wo) + pdf_light));
}

@compute @workgroup_size(64)
fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
    let index = linear_index(id, groups);
    let pixel = live_pixel(index);
    if pixel == NO_PIXEL {
        return;
    }
    let point = gather_points[held(pixel)];
    let chain = chain_of(point);
    if max_band(point.throughput) <= 0.0
        || (HAS_PATH_FILTER && !path_wanted(path_step(PATH_START, EVENT_D), chain)) {
        return;
    }
    let m = material_of_point(point);
    let geometric = decode_direction(point.normal);
    let shading = decode_direction(point.shading_normal);
    let wo = decode_direction(point.wo);
    let origin = point.position;
    let shared_weight = does_vary(m) || near_emitter(point.position);
    let sample = sequence_index(index);
    var sum = Bands(0.0);
    var rays = 0u;
    var saved = 0u;
    let candidates = f32(pass_info.light_candidates);
    for (var ray = 0u; ray < own(pass_info.shadow_rays); ray += 1u) {
        let u = random4(pass_info.seed, sample, pixel, DIMENSION_DIRECT + ray);
        // one of the candidates gets the shadow ray, by what each would give if nothing shaded it, for all of them [E24]
        var picked = LightSample(vec3(0.0), 0.0, vec3(0.0), Bands(0.0), 0.0);
        var given = Bands(0.0);
        var reservoir = Reservoir(0.0, u.w);
        var found = 0u;
        let first = wide_sum(wide_product(sample, pass_info.shadow_rays * pass_info.light_candidates),
            ray * pass_info.light_candidates);
        for (var k = 0u; k < own(pass_info.light_candidates); k += 1u) {
            let at = wide_sum(first, k);
            let seed = sequence_seed(seed_at(pass_info.seed, at.y), pixel, STREAM_LIGHT);
            let light = sample_light(origin, sobol2(at.x, seed));
            let cos_receiver = dot(light.wi, shading);
            if cos_receiver > 0.0 && dot(light.wi, geometric) > 0.0 && max_band(light.weight) > 0.0 {
                var weight = cos_receiver;
                if shared_weight && light.pdf > 0.0 {
                    let pdf = candidates * light.pdf;
                    weight *= pdf / (pdf + pdf_scatter(m, shading, light.wi, wo));
                }
                var f = eval_scatter(m, shading, light.wi, wo);
                if light.pdf <= 0.0 {
                    // what has an area is met where the lobe is followed
                    f += eval_narrow(m, shading, light.wi, wo);
                }
                let gives = f * light.weight * weight;
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
            rays += 1u;
            saved += found - 1u;
            if !is_occluded(origin, picked.wi, picked.distance, picked.end) {
                sum += given * (reservoir.total / (candidates * max_band(given)));
            }
        }
        if shared_weight {
            rays += 1u;
            sum += by_brdf(m, origin, geometric, shading, wo, u.xyz);
        }
    }
    count(STATUS_RAYS, STATUS_RAYS_HIGH, rays);
    if saved > 0u {
        count(STATUS_SHADOW_RAYS_SAVED, STATUS_SHADOW_RAYS_SAVED_HIGH, saved);
    }
    if traversal_cut {
        atomicAdd(&status[STATUS_TRAVERSAL_CUT], 1u);
    }
    film_direct[held(pixel)] += four_of_bands(point.throughput * sum / f32(pass_info.shadow_rays));
}
