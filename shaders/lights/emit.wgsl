// Emission: where joton `number` starts, which way, and with what flux.
// Φ = flux of the emitter / (pick N) by the emitter's own law [E2]; aimed: Le cosθ A / (pick N pdf_solid_angle) [E13]. Each
// map has its emitters, with pick probabilities, and some a warp, that were learned [E20].
// import: dispatch/index.wgsl
// import: sampling/rng.wgsl
// import: lights/emitter.wgsl
// import: lights/cone.wgsl
// import: lights/warp.wgsl
// reads  scene, targets, warps, map_info, pass_info

struct Start {
    origin: vec3<f32>,
    direction: vec3<f32>,
    flux: Bands,
}

// Seeds of the pairs that choose places and directions, for the indices of this pass …
var<private> place_seeds: vec3<u32>;
var<private> direction_seeds: vec3<u32>;
// … and for those of them past the next multiple of 2^32.
var<private> place_seeds_wrapped: vec3<u32>;
var<private> direction_seeds_wrapped: vec3<u32>;

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
    let e = emitter_at(pick.emitter);
    var share = 1.0 / (e.pick * f32(map_info.emitted));
    if HAS_WARPS && e.warp > 0u {
        let steered = warped(e.warp - 1u, v);
        v = steered.place;
        share /= steered.density;
    }
    if HAS_DELTA_LIGHTS && e.kind == EMITTER_SUN {
        return emit_sun(e, v, share);
    }
    var beam = beam_of(e);
    if is_triangle(e.kind) {
        let b = sample_triangle(vec2(pick.rest, u.y));
        beam = Beam(e.origin + b.x * e.e1 + b.y * e.e2, normalize(cross(e.e1, e.e2)), 0.0);
    }
    var aim = Aim(vec3(0.0), 0u, vec3(0.0), 0.0);
    if CAUSTIC {
        aim = aim_at_targets(beam, v);
    }
    // where its own cone is narrower than those of the targets, a light's own law serves better
    if aim.hits > 0u && (is_triangle(e.kind) || aim.total < e.area) {
        let weight = share * aim.total / f32(aim.hits);
        if is_triangle(e.kind) {
            let radiant = e.area * max(0.0, dot(aim.direction, beam.axis));
            return Start(on_lamp(e, beam), aim.direction, e.strength * (radiant * weight));
        }
        return start_in_cone(e, beam, ConeRay(aim.direction, aim.foot), weight);
    }
    if is_triangle(e.kind) {
        let d = normalize(basis(beam.axis) * sample_cosine_hemisphere(v));
        return Start(on_lamp(e, beam), d, e.flux * share);
    }
    return start_in_cone(e, beam, into_cone(beam.through, beam.axis, beam.distance, e.area / TAU, v), e.area * share);
}

// A place on an emissive triangle, lifted off its front.
fn on_lamp(e: PackedEmitter, beam: Beam) -> vec3<f32> {
    return beam.through + beam.axis * lift_of(beam.axis, abs(e.origin) + abs(e.e1) + abs(e.e2));
}

// Starts at the light or, where that is far away, before the scene; `weight` in sr.
fn start_in_cone(e: PackedEmitter, beam: Beam, ray: ConeRay, weight: f32) -> Start {
    let is_far = beam.distance > 0.0;
    var radiant = e.strength;
    if e.kind == EMITTER_SPOT {
        let at = select(ray.direction, from_light(e, ray.foot), is_far);
        radiant *= spot_falloff(one_minus_cos(at, e.e1), e.e2.x, e.e2.y);
    }
    let back = (SCENE_RADIUS + dot(ray.foot, beam.axis)) / dot(ray.direction, beam.axis);
    return Start(select(beam.through, ray.foot - ray.direction * back, is_far), ray.direction, radiant * weight);
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

// The sun's disc, or the discs of the targets along the beam.
fn emit_sun(e: PackedEmitter, v: vec2<f32>, share: f32) -> Start {
    let frame = basis(e.e1);
    let count = own(pass_info.targets);
    if CAUSTIC && count > 0u {
        var total = 0.0;
        for (var i = 0u; i < count; i += 1u) {
            total += targets[i].radius * targets[i].radius;
        }
        var rest = v.x * total;
        var chosen = 0u;
        while chosen + 1u < count && rest >= targets[chosen].radius * targets[chosen].radius {
            rest -= targets[chosen].radius * targets[chosen].radius;
            chosen += 1u;
        }
        let t = targets[chosen];
        let d = sample_disc(vec2(min(rest / (t.radius * t.radius), 0.99999994), v.y)) * t.radius;
        let through = t.center + frame[0] * d.x + frame[1] * d.y;
        var hits = 0u;
        for (var i = 0u; i < count; i += 1u) {
            let off = through - targets[i].center;
            let across = off - e.e1 * dot(off, e.e1);
            hits += select(0u, 1u, i == chosen || dot(across, across) <= targets[i].radius * targets[i].radius);
        }
        let origin = through - e.e1 * dot(through - e.origin, e.e1);
        return Start(origin, e.e1, e.strength * (share * PI * total / f32(hits)));
    }
    // one direction, from any place: it is the place that can be steered
    let d = sample_disc(v) * e.e2.x;
    return Start(e.origin + frame[0] * d.x + frame[1] * d.y, e.e1, e.flux * share);
}
