// Emitters: picking, places on them, and what they send along a direction.
// import: sampling/sampling.wgsl
// import: scene/features.wgsl
// import: scene/scene.wgsl
// reads  scene

struct Pick {
    emitter: u32,
    // The random number again, uniform within the emitter's share: stratification survives the choice.
    rest: f32,
}

fn pick_emitter(u: f32, count: u32) -> Pick {
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if u < emitter_at(middle).cumulative {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let e = emitter_at(low);
    let before = e.cumulative - e.pick;
    return Pick(low, clamp((u - before) / max(e.pick, 1e-30), 0.0, 0.99999994));
}

// True for an emissive triangle; where there are no other lights, nothing else is compiled.
fn is_triangle(kind: u32) -> bool {
    return !HAS_DELTA_LIGHTS || kind == EMITTER_TRIANGLE;
}

// The way from a point or a spot to p.
fn from_light(e: PackedEmitter, p: vec3<f32>) -> vec3<f32> {
    return p - e.origin + e.e1 * e.e2.z;
}

// 1 − cos of the angle between v and a unit axis: by its sine where it is small, since a cosine has no digits there.
fn one_minus_cos(v: vec3<f32>, axis: vec3<f32>) -> f32 {
    let along = dot(v, axis);
    let across = v - along * axis;
    let length2 = max(dot(v, v), 1e-30);
    let cosine = along * inverseSqrt(length2);
    return select(1.0 - cosine, dot(across, across) / (length2 * (1.0 + cosine)), cosine > 0.0);
}

// Part of the axial intensity that a spot sends, from 1 − cos of the angle to its axis, and of its angles: a cubic
// smoothstep in the cosine.
fn spot_falloff(at: f32, inner: f32, outer: f32) -> f32 {
    let x = clamp((outer - at) / max(outer - inner, 1e-30), 0.0, 1.0);
    return select(x * x * (3.0 - 2.0 * x), 1.0, at <= inner);
}
