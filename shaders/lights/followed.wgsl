// Followed light: light samples in lobes that are followed but have a width, narrow metal, coats and rough glass (E S* L), beside the eye
// paths and trees that follow the lobe: the balance heuristic of all of them [E46]. Twin: src/backend/cpu/followed_light.rs.
// import: shading/followed.wgsl
// import: lights/direct.wgsl
// import: paths/splits.wgsl

// pdf_solid_angle with which all the light samples of a vertex find the lit surface that a ray from there has met, after `distance`.
fn pdf_of_lights(s: Surface, b: Bsdf, distance: f32) -> f32 {
    if s.emitter == NO_EMITTER || !b.from_front {
        return 0.0;
    }
    return f32(pass_info.light_candidates) * pdf_li(emitter_at(s.emitter), distance, -dot(b.direction, s.front));
}

// What a lobe sends on of a light sample if nothing shades it, with its share of the weight.
fn light_by_lobe(b: Bsdf, w: LobeWeights, splits: Splits, trees: f32, light: LightSample, followed: Followed) -> Bands {
    if followed.pdf <= 0.0 {
        return Bands(0.0);
    }
    var gives = followed.f_cos * light.weight;
    if HAS_MEDIA {
        // a shadow ray crosses no boundary
        gives *= transmittance(inside_after(b, followed.lobe), light.distance);
    }
    if light.pdf > 0.0 {
        let after = splits_after(splits, w, followed.lobe, followed.pdf);
        gives *= weight_of_light(after, trees, f32(pass_info.light_candidates) * light.pdf);
    }
    return gives;
}

// What a vertex of an eye path sends on from the lights; `splits` are up to the vertex.
fn light_in_lobes(s: Surface, b: Bsdf, w: LobeWeights, splits: Splits, trees: f32, draws: LightDraws, u: f32) -> FollowedLight {
    var result = FollowedLight(Bands(0.0), 0u, 0u);
    let has_coat = is_layered(b.material) && has_width(b.material, LOBE_REFLECTION);
    if !has_coat && !has_width(b.material, select(LOBE_MIRROR, LOBE_REFLECTION, is_dielectric(b.material))) {
        return result;
    }
    let candidates = f32(pass_info.light_candidates);
    var picked = LightSample(vec3(0.0), 0.0, vec3(0.0), Bands(0.0), 0.0);
    var given = Bands(0.0);
    var reservoir = Reservoir(0.0, u);
    var found = 0u;
    for (var k = 0u; k < own(pass_info.light_candidates); k += 1u) {
        let light = light_candidate(s.position, draws, k);
        var gives = light_by_lobe(b, w, splits, trees, light, followed_from(b, light.wi));
        if has_coat {
            gives += light_by_lobe(b, w, splits, trees, light, clear_coat_from(b, light.wi));
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
    if found == 0u {
        return result;
    }
    result.rays = 1u;
    result.saved = found - 1u;
    // it starts as a path does that follows the lobe, so that both meet the same
    let start = departure(s, picked.wi, b.from_front);
    let way = picked.end - start.origin;
    // a sun is as far from anywhere
    let is_sun = picked.distance >= 1e30;
    let distance = select(length(way), picked.distance, is_sun);
    let direction = select(way / max(length(way), 1e-30), picked.wi, is_sun);
    if trace_ray(start.origin, direction, distance, start.t_back, true, picked.end).triangle == MISS {
        result.light = given * (reservoir.total / (candidates * max_band(given)));
    }
    return result;
}
