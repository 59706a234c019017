// Cones: rays into them that keep their digits where they arrive, however narrow the cone and far away its apex.
// Twin: src/optics/lights/cone.rs.
// import: sampling/sampling.wgsl

// The axis about which directions are drawn.
struct Beam {
    // A place on it: the light itself, but where that is far away.
    through: vec3<f32>,
    axis: vec3<f32>,
    // From the light to that place.
    distance: f32,
}

struct ConeRay {
    direction: vec3<f32>,
    // The point of the ray nearest to the middle of what the cone holds: it keeps its digits however far away the light is.
    foot: vec3<f32>,
}

// A ray in a cone of this 1 − cos about the way, `distance` long, that leads along `axis` to `middle`.
fn into_cone(middle: vec3<f32>, axis: vec3<f32>, distance: f32, size: f32, u: vec2<f32>) -> ConeRay {
    let frame = basis(axis);
    let local = sample_cone(u, size);
    let across = frame[0] * local.x + frame[1] * local.y;
    let foot = middle + distance * (local.z * across - dot(local.xy, local.xy) * axis);
    return ConeRay(normalize(frame * local), foot);
}

// From the light to a target.
fn to_target(beam: Beam, t: Target) -> vec3<f32> {
    return t.center - beam.through + beam.axis * beam.distance;
}

// One minus the cosine of the cone that holds a target `d` away; 2 where d begins inside.
fn cone_size(d: vec3<f32>, t: Target) -> f32 {
    let sine2 = t.radius * t.radius / dot(d, d);
    return select(2.0, sine2 / (1.0 + sqrt(max(0.0, 1.0 - sine2))), sine2 < 1.0);
}
