// Emission: where joton `number` starts, which way, and with what flux.
// Φ = flux of the emitter / (pick N) by the emitter's own law [E2]; aimed: Le cosθ A / (pick N pdf_solid_angle) [E13]. Each
// map has its emitters, with pick probabilities, and some a warp, that were learned [E20].
// import: shared/index.wgsl
// import: shared/rng.wgsl
// import: shared/emitter.wgsl
// import: shared/warp.wgsl
// reads  emitters, targets, warps, map_info, pass_info

struct Start {
    origin: vec3<f32>,
    direction: vec3<f32>,
    flux: Bands,
}

fn emit(number: u32) -> Start {
    let at = wide_sum(vec2(map_info.first_joton, map_info.first_joton_high), number);
    let seed = seed_at(pass_info.seed, at.y);
    let place_stream = select(STREAM_DIFFUSE_PLACE, STREAM_CAUSTIC_PLACE, CAUSTIC);
    let direction_stream = select(STREAM_DIFFUSE_DIRECTION, STREAM_CAUSTIC_DIRECTION, CAUSTIC);
    let u = sobol2(at.x, sequence_seed(seed, 0u, place_stream));
    var v = sobol2(at.x, sequence_seed(seed, 0u, direction_stream));
    let pick = pick_emitter(u.x, pass_info.emitters);
    let e = emitters[pick.emitter];
    var share = 1.0 / (e.pick * f32(map_info.emitted));
    if HAS_WARPS && e.warp > 0u {
        let steered = warped(e.warp - 1u, v);
        v = steered.place;
        share /= steered.density;
    }
    if HAS_DELTA_LIGHTS && e.kind == EMITTER_SUN {
        return emit_sun(e, v, share);
    }
    var position = e.origin;
    var normal = e.e1;
    if is_triangle(e.kind) {
        let b = sample_triangle(vec2(pick.rest, u.y));
        position = e.origin + b.x * e.e1 + b.y * e.e2;
        normal = normalize(cross(e.e1, e.e2));
    }
    var aim = Aim(vec3(0.0), 0u, 0.0, vec3(0.0));
    if CAUSTIC {
        aim = aim_at_targets(position, v, pick.rest);
    }
    if aim.hits > 0u {
        let cosine = dot(aim.direction, normal);
        let weight = share * aim.total / f32(aim.hits);
        var radiant = e.strength;
        if is_triangle(e.kind) {
            radiant *= e.area * max(0.0, cosine);
        } else if e.kind == EMITTER_SPOT {
            radiant *= spot_falloff(cosine, e.e2.x, e.e2.y);
        }
        return Start(start_origin(e, position, normal), aim.direction, radiant * weight);
    }
    if is_triangle(e.kind) {
        let d = normalize(basis(normal) * sample_cosine_hemisphere(v));
        return Start(start_origin(e, position, normal), d, e.flux * share);
    }
    if e.kind == EMITTER_SPOT {
        let one_minus_outer = 1.0 - e.e2.y;
        let local = sample_cone(v, one_minus_outer);
        let fall = spot_falloff(local.z, e.e2.x, e.e2.y);
        return Start(position, normalize(basis(normal) * local), e.strength * (fall * TAU * one_minus_outer * share));
    }
    let local = sample_cone(v, 2.0);
    return Start(position, local, e.flux * share);
}

fn start_origin(e: PackedEmitter, position: vec3<f32>, normal: vec3<f32>) -> vec3<f32> {
    if is_triangle(e.kind) {
        return offset_origin(position, normal);
    }
    return position;
}

struct Aim {
    direction: vec3<f32>,
    // Cones that contain the direction; 0 where aiming is impossible.
    hits: u32,
    // Sum of the measures: solid angles of the cones, or areas of the discs.
    total: f32,
    // Place on the sun's disc, from its centre.
    place: vec3<f32>,
}

// One minus the cosine of the cone from p that holds a target; 2 where p is inside.
fn cone_size(p: vec3<f32>, t: Target) -> f32 {
    let d = t.center - p;
    let sine2 = t.radius * t.radius / dot(d, d);
    return select(2.0, sine2 / (1.0 + sqrt(max(0.0, 1.0 - sine2))), sine2 < 1.0);
}

// A direction into the cones of the targets, uniform in a cone picked by its solid angle.
// pdf_solid_angle = hits / total.
fn aim_at_targets(p: vec3<f32>, v: vec2<f32>, choice: f32) -> Aim {
    var aim = Aim(vec3(0.0), 0u, 0.0, vec3(0.0));
    var inside = false;
    let count = own(pass_info.targets);
    for (var i = 0u; i < count; i += 1u) {
        let size = cone_size(p, targets[i]);
        inside = inside || size >= 2.0;
        aim.total += size;
    }
    if inside || aim.total <= 0.0 {
        return aim;
    }
    // v.x both picks the cone and, rescaled, places the direction in it
    var rest = v.x * aim.total;
    var chosen = 0u;
    var size = cone_size(p, targets[0]);
    while chosen + 1u < count && rest >= size {
        rest -= size;
        chosen += 1u;
        size = cone_size(p, targets[chosen]);
    }
    let axis = normalize(targets[chosen].center - p);
    aim.direction = normalize(basis(axis) * sample_cone(vec2(min(rest / size, 0.99999994), v.y), size));
    for (var i = 0u; i < count; i += 1u) {
        let d = normalize(targets[i].center - p);
        // the chosen cone counts whatever its rounding says
        aim.hits += select(0u, 1u, i == chosen || 1.0 - dot(aim.direction, d) <= cone_size(p, targets[i]));
    }
    aim.total *= TAU;
    return aim;
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
