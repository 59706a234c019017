// Lights as shadow rays and camera paths find them: the kinds, one line each. Emission of jotons: emit.wgsl.
// import: lights/triangle.wgsl
// import: lights/point.wgsl
// import: lights/sun.wgsl

// A place on an emitter, seen from p.
fn sample_li(e: PackedEmitter, p: vec3<f32>, u: vec2<f32>) -> LightSample {
    if is_triangle(e.kind) {
        return triangle_li(e, p, u);
    }
    if e.kind == EMITTER_SUN {
        return sun_li(e);
    }
    return point_li(e, p);
}

// pdf_solid_angle with which sample_li, after the pick, finds the front of an emissive triangle at this distance; no ray meets the others.
fn pdf_li(e: PackedEmitter, distance: f32, cos_light: f32) -> f32 {
    return triangle_pdf_li(e, distance, cos_light);
}

// True where p may lie so near to the light that shadow rays alone have fireflies.
fn is_near(e: PackedEmitter, p: vec3<f32>) -> bool {
    return is_triangle(e.kind) && is_near_triangle(e, p);
}
