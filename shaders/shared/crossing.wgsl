// Crossing: which of two faces a ray meets first where they are so near each other that rounded distances do not tell [E26].
// import: shared/triangles.wgsl
// reads  triangles

// Where a ray crosses a triangle's plane.
struct Crossing {
    t: f32,
    // How far rounding may move it.
    error: f32,
    // Of faces in one place the one of the highest rank is met. Twin: PackedTriangle::rank.
    rank: u32,
}

// From an origin near to the triangle, where few digits are lost.
fn crossing(index: u32, origin: vec3<f32>, direction: vec3<f32>) -> Crossing {
    let t = triangle_at(index);
    let n = cross(t.e1, t.e2);
    let across = dot(direction, n);
    let error = ONE_PLACE * dot(abs(n), abs(t.v0) + abs(t.e1) + abs(t.e2));
    let opaque = select(RANK_BACK, select(RANK_LAMP, RANK_FRONT, t.emitter == NO_EMITTER), across < 0.0);
    let rank = select(opaque, select(RANK_CLEAR_BACK, RANK_CLEAR_FRONT, across < 0.0), (t.flags & CLEAR) != 0u);
    return Crossing(dot(t.v0 - origin, n) / across, error / abs(across), rank);
}

// Whether a ray meets triangle `index` before another one, both near to `origin`.
fn is_met_first(index: u32, other: u32, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    let a = crossing(index, origin, direction);
    let b = crossing(other, origin, direction);
    if abs(a.t - b.t) > a.error + b.error {
        return a.t < b.t;
    }
    return a.rank > b.rank || (a.rank == b.rank && index < other);
}
