// A spot: a point whose intensity falls off from its axis; `e1` is the axis, `e2` = (1 − cos inner, 1 − cos outer, distance) [E12].
// Twin: src/optics/lights/spot.rs.

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

// Along a way from the light.
fn spot_share(e: PackedEmitter, way: vec3<f32>) -> f32 {
    return spot_falloff(one_minus_cos(way, e.e1), e.e2.x, e.e2.y);
}
