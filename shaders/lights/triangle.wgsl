// An emissive triangle, which shines from its front: `strength` is radiance. Twin: src/optics/lights/triangle.rs.
// import: sampling/sampling.wgsl
// import: scene/features.wgsl
// import: lights/samples.wgsl
// import: lights/cone.wgsl
// import: lights/glow.wgsl
// import: accel/lift.wgsl

// True for an emissive triangle; where there are no other lights, nothing else is compiled.
fn is_triangle(kind: u32) -> bool {
    return !HAS_DELTA_LIGHTS || kind == EMITTER_TRIANGLE;
}

// A place on it, and its normal.
fn triangle_beam(e: PackedEmitter, u: vec2<f32>) -> Beam {
    let b = sample_triangle(u);
    return Beam(e.origin + b.x * e.e1 + b.y * e.e2, normalize(cross(e.e1, e.e2)), 0.0);
}

// A place of it, lifted off its front.
fn off_triangle(e: PackedEmitter, beam: Beam) -> vec3<f32> {
    return beam.through + beam.axis * lift_of(beam.axis, abs(e.origin) + abs(e.e1) + abs(e.e2));
}

// By its own law: by the cosine.
fn triangle_by_law(e: PackedEmitter, beam: Beam, v: vec2<f32>, share: f32) -> Start {
    let d = normalize(basis(beam.axis) * sample_cosine_hemisphere(v));
    var flux = e.flux;
    if has_glow(e) {
        // each place has a radiance of its own
        flux = e.strength * (PI * e.area);
    }
    return Start(off_triangle(e, beam), d, flux * share);
}

// Into a direction that was drawn otherwise; `weight` in sr.
fn triangle_along(e: PackedEmitter, beam: Beam, direction: vec3<f32>, weight: f32) -> Start {
    let radiant = e.area * max(0.0, dot(direction, beam.axis));
    return Start(off_triangle(e, beam), direction, e.strength * (radiant * weight));
}

// A place as seen from p.
fn triangle_li(e: PackedEmitter, p: vec3<f32>, u: vec2<f32>) -> LightSample {
    let beam = triangle_beam(e, u);
    let end = off_triangle(e, beam);
    let d = end - p;
    let distance2 = dot(d, d);
    let wi = d * inverseSqrt(max(distance2, 1e-30));
    let cos_light = max(0.0, -dot(wi, beam.axis));
    let inverse_pdf = cos_light * e.area / (max(distance2, 1e-30) * e.pick);
    var radiance = e.strength;
    if has_glow(e) {
        radiance *= glow_at(e, u);
    }
    return LightSample(wi, sqrt(distance2), end, radiance * inverse_pdf, 1.0 / max(inverse_pdf, 1e-30));
}

// pdf_solid_angle of triangle_li, with the pick, for a place at this distance that is seen under this cosine.
fn triangle_pdf_li(e: PackedEmitter, distance: f32, cos_light: f32) -> f32 {
    return e.pick * distance * distance / (e.area * cos_light);
}

// True where p may lie so near that shadow rays alone have fireflies.
fn is_near_triangle(e: PackedEmitter, p: vec3<f32>) -> bool {
    let center = (e.e1 + e.e2) / 3.0;
    let d = e.origin + center - p;
    let largest = max(length(center), length(e.e1 - center)) + NEAR_WIDTH * sqrt(e.area / e.pick);
    return dot(d, d) < largest * largest;
}
