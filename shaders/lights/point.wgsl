// A light at a place: a point or a spot; `strength` is radiant intensity, of a spot on its axis. Twin: src/optics/lights/point.rs.
// import: scene/features.wgsl
// import: lights/samples.wgsl
// import: lights/cone.wgsl
// import: lights/spot.wgsl

// The way from it to p.
fn from_light(e: PackedEmitter, p: vec3<f32>) -> vec3<f32> {
    return p - e.origin + e.e1 * e.e2.z;
}

// Its axis; where it is far away, of the cone that holds the scene.
fn point_beam(e: PackedEmitter) -> Beam {
    let far2 = dot(e.origin, e.origin);
    if HAS_DELTA_LIGHTS && e.e2.z == 0.0 && far2 > FAR * FAR {
        // a spot that is far away and wide: the cone that holds the scene has an axis of its own
        return Beam(vec3(0.0), -e.origin * inverseSqrt(far2), sqrt(far2));
    }
    return Beam(e.origin, e.e1, e.e2.z);
}

// Along a ray; `weight` in sr. It starts at the light or, where that is far away, before the scene.
fn point_along(e: PackedEmitter, beam: Beam, ray: ConeRay, weight: f32) -> Start {
    let is_far = beam.distance > 0.0;
    var radiant = e.strength;
    if e.kind == EMITTER_SPOT {
        radiant *= spot_share(e, select(ray.direction, from_light(e, ray.foot), is_far));
    }
    let back = (SCENE_RADIUS + dot(ray.foot, beam.axis)) / dot(ray.direction, beam.axis);
    return Start(select(beam.through, ray.foot - ray.direction * back, is_far), ray.direction, radiant * weight);
}

// By its own law: evenly over its cone.
fn point_by_law(e: PackedEmitter, beam: Beam, v: vec2<f32>, share: f32) -> Start {
    return point_along(e, beam, into_cone(beam.through, beam.axis, beam.distance, e.area / TAU, v), e.area * share);
}

// As seen from p.
fn point_li(e: PackedEmitter, p: vec3<f32>) -> LightSample {
    let d = from_light(e, p);
    let distance2 = max(dot(d, d), 1e-30);
    let fall = select(1.0, spot_share(e, d), e.kind == EMITTER_SPOT);
    let wi = -d * inverseSqrt(distance2);
    return LightSample(wi, sqrt(distance2), p - d, e.strength * (fall / (distance2 * e.pick)), 0.0);
}
