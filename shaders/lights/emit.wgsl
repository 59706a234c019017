// Emission: where joton `number` starts, which way, and with what flux.
// Φ = flux of the emitter / (pick N) by the emitter's own law [E2]; aimed: Le cosθ A / (pick N pdf_solid_angle) [E13]. Each
// map has its emitters, with pick probabilities, and some a warp, that were learned [E20].
// Twin: src/optics/lights/pick.rs.
// import: dispatch/index.wgsl
// import: sampling/rng.wgsl
// import: lights/pick.wgsl
// import: lights/light.wgsl
// import: lights/sun_aimed.wgsl
// import: lights/warp.wgsl
// reads  scene, targets, warps, map_info, pass_info

// Seeds of the pairs that choose places and directions, for the indices of this pass …
var<private> place_seeds: vec3<u32>;
var<private> direction_seeds: vec3<u32>;
// … and for those of them past the next multiple of 2^32.
var<private> place_seeds_wrapped: vec3<u32>;
var<private> direction_seeds_wrapped: vec3<u32>;

// The emitter of the last joton that was emitted.
var<private> emitted_by: u32;

// Call this before `emit`, once: the seeds are the same for all jotons.
fn prepare_emission() {
    let place = select(STREAM_DIFFUSE_PLACE, STREAM_CAUSTIC_PLACE, CAUSTIC);
    let direction = select(STREAM_DIFFUSE_DIRECTION, STREAM_CAUSTIC_DIRECTION, CAUSTIC);
    place_seeds = sobol_seeds(sequence_seed(map_info.seed, 0u, place));
    direction_seeds = sobol_seeds(sequence_seed(map_info.seed, 0u, direction));
    place_seeds_wrapped = sobol_seeds(sequence_seed(map_info.seed_wrapped, 0u, place));
    direction_seeds_wrapped = sobol_seeds(sequence_seed(map_info.seed_wrapped, 0u, direction));
}

fn emit(number: u32) -> Start {
    // the low word of the index
    let at = map_info.first_joton + number;
    let is_wrapped = at < number;
    let u = sobol_point(at, select(place_seeds, place_seeds_wrapped, is_wrapped));
    var v = sobol_point(at, select(direction_seeds, direction_seeds_wrapped, is_wrapped));
    let pick = pick_emitter(u.x, pass_info.emitters);
    emitted_by = pick.emitter;
    let e = emitter_at(pick.emitter);
    var share = 1.0 / (e.pick * f32(map_info.emitted));
    if HAS_WARPS && e.warp > 0u {
        let steered = warped(e.warp - 1u, v);
        v = steered.place;
        share /= steered.density;
    }
    if HAS_DELTA_LIGHTS && e.kind == EMITTER_SUN && CAUSTIC && own(pass_info.targets) > 0u {
        return sun_aimed(e, v, share, own(pass_info.targets));
    }
    let beam = light_beam(e, vec2(pick.rest, u.y));
    if CAUSTIC {
        let aim = aim_at_targets(beam, v);
        // where its own cone is narrower than those of the targets, a light's own law serves better
        if aim.hits > 0u && aim.total < own_cone(e) {
            let start = le_along(e, beam, ConeRay(aim.direction, aim.foot), share * aim.total / f32(aim.hits));
            return with_glow(start, e, vec2(pick.rest, u.y));
        }
    }
    return with_glow(sample_le(e, beam, v, share), e, vec2(pick.rest, u.y));
}

// A start from where u lies on an emitter, with what a texture leaves of it.
fn with_glow(start: Start, e: PackedEmitter, u: vec2<f32>) -> Start {
    var glowing = start;
    if has_glow(e) {
        glowing.flux *= glow_at(e, u);
    }
    return glowing;
}

struct Aim {
    direction: vec3<f32>,
    // Cones that contain the direction; 0 where aiming is impossible.
    hits: u32,
    // See ConeRay.
    foot: vec3<f32>,
    // Sum of the solid angles of the cones.
    total: f32,
}

// A direction into the cones of the targets, uniform in a cone picked by its solid angle.
// pdf_solid_angle = hits / total.
fn aim_at_targets(beam: Beam, v: vec2<f32>) -> Aim {
    var aim = Aim(vec3(0.0), 0u, vec3(0.0), 0.0);
    var inside = false;
    let count = own(pass_info.targets);
    for (var i = 0u; i < count; i += 1u) {
        let size = cone_size(to_target(beam, targets[i]), targets[i]);
        inside = inside || size >= 2.0;
        aim.total += size;
    }
    if inside || aim.total <= 0.0 {
        return aim;
    }
    // v.x both picks the cone and, rescaled, places the direction in it
    var rest = v.x * aim.total;
    var chosen = 0u;
    var size = cone_size(to_target(beam, targets[0]), targets[0]);
    while chosen + 1u < count && rest >= size {
        rest -= size;
        chosen += 1u;
        size = cone_size(to_target(beam, targets[chosen]), targets[chosen]);
    }
    let d = to_target(beam, targets[chosen]);
    let distance = length(d);
    let place = vec2(min(rest / size, 0.99999994), v.y);
    let ray = into_cone(targets[chosen].center, d / distance, distance, size, place);
    for (var i = 0u; i < count; i += 1u) {
        let t = targets[i];
        // a cone holds what passes its sphere within the radius: told at the sphere, where angles have no digits
        let off = ray.foot - t.center;
        let across = off - ray.direction * dot(off, ray.direction);
        let holds = dot(across, across) <= t.radius * t.radius && dot(to_target(beam, t), ray.direction) > 0.0;
        // the chosen cone counts whatever its rounding says
        aim.hits += select(0u, 1u, i == chosen || holds);
    }
    return Aim(ray.direction, aim.hits, ray.foot, aim.total * TAU);
}
