// Lift: how far off a surface rays start and end [E27].

// How far off a plane f32 may put a point that lies in it, by the extent along each axis of what spans the plane.
fn lift_of(normal: vec3<f32>, extent: vec3<f32>) -> f32 {
    return max(LIFT * dot(abs(normal), extent), LIFT_LEAST);
}
