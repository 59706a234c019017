// Lights: the kinds, and what each is asked for. A new kind is a file and a line in each of these functions; what none of them
// names is a point or a spot. Aimed jotons: emit.wgsl and sun_aimed.wgsl. Twin: src/optics/lights/mod.rs.
// import: lights/triangle.wgsl
// import: lights/point.wgsl
// import: lights/sun.wgsl

// Where a joton's ray begins and about which axis; a place of an emissive triangle by u.
fn light_beam(e: PackedEmitter, u: vec2<f32>) -> Beam {
    var beam = point_beam(e);
    if is_triangle(e.kind) {
        beam = triangle_beam(e, u);
    }
    return beam;
}

// Solid angle, sr, that its own law starts jotons into: where it is narrower than the cones of the targets it serves better.
fn own_cone(e: PackedEmitter) -> f32 {
    return select(e.area, 1e30, is_triangle(e.kind));
}

// A joton by the light's own law, from its beam; v uniform; `share` of its flux [E2].
fn sample_le(e: PackedEmitter, beam: Beam, v: vec2<f32>, share: f32) -> Start {
    if HAS_DELTA_LIGHTS && e.kind == EMITTER_SUN {
        return sun_by_law(e, v, share);
    }
    if is_triangle(e.kind) {
        return triangle_by_law(e, beam, v, share);
    }
    return point_by_law(e, beam, v, share);
}

// A joton along a ray that was drawn otherwise; `weight` in sr [E13].
fn le_along(e: PackedEmitter, beam: Beam, ray: ConeRay, weight: f32) -> Start {
    if is_triangle(e.kind) {
        return triangle_along(e, beam, ray.direction, weight);
    }
    return point_along(e, beam, ray, weight);
}

// A place on an emitter, seen from p, with the probability of the pick. (On the host pick.rs multiplies by it.)
fn sample_li(e: PackedEmitter, p: vec3<f32>, u: vec2<f32>) -> LightSample {
    if is_triangle(e.kind) {
        return triangle_li(e, p, u);
    }
    if e.kind == EMITTER_SUN {
        return sun_li(e);
    }
    return point_li(e, p);
}

// pdf_solid_angle, with the pick, by which sample_li finds the front of an emissive triangle at this distance. No ray meets
// the other lights.
fn pdf_li(e: PackedEmitter, distance: f32, cos_light: f32) -> f32 {
    return triangle_pdf_li(e, distance, cos_light);
}

// True where p may lie so near to the light that shadow rays alone have fireflies.
fn is_near(e: PackedEmitter, p: vec3<f32>) -> bool {
    return is_triangle(e.kind) && is_near_triangle(e, p);
}
