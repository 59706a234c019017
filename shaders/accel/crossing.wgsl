// Crossing: which of two faces a ray meets first where they are so near each other that rounded distances do not tell [E27].
// Twin: Crossing in src/packed/accel/mod.rs.
// import: scene/scene.wgsl
// import: scene/features.wgsl

// What it takes to tell.
struct Face {
    v0: vec3<f32>,
    // How far off its plane rounding may put it, times the length of the normal.
    error: f32,
    normal: vec3<f32>,
    flags: u32,
}

fn face_of(c: PackedTriangle) -> Face {
    let n = cross(c.e1, c.e2);
    return Face(c.v0, ONE_PLACE * dot(abs(n), abs(c.v0) + abs(c.e1) + abs(c.e2)), n, c.flags);
}

// Of faces in one place the one of the highest rank is met. Twin: PackedTriangle::rank.
fn face_rank(flags: u32, is_front: bool) -> u32 {
    let opaque = select(RANK_BACK, select(RANK_FRONT, RANK_LAMP, (flags & LAMP) != 0u), is_front);
    // where bodies have priorities each is left when the next has been entered [E45]
    let is_later = select(is_front, !is_front, HAS_MEDIA && (flags & NESTED) != 0u);
    return select(opaque, select(RANK_CLEAR_BACK, RANK_CLEAR_FRONT, is_later), (flags & CLEAR) != 0u);
}

// Whether a ray meets face a before b; its origin is near to both, so that few digits are lost.
fn is_met_first(a: Face, b: Face, a_is_lower: bool, origin: vec3<f32>, direction: vec3<f32>) -> bool {
    let across = vec2(dot(direction, a.normal), dot(direction, b.normal));
    let t = vec2(dot(a.v0 - origin, a.normal), dot(b.v0 - origin, b.normal)) / across;
    let error = vec2(a.error, b.error) / abs(across);
    let rank = vec2(face_rank(a.flags, across.x < 0.0), face_rank(b.flags, across.y < 0.0));
    let by_rank = rank.x > rank.y || (rank.x == rank.y && a_is_lower);
    let is_apart = abs(t.x - t.y) > error.x + error.y;
    return select(by_rank, (t.x < t.y), is_apart);
}
