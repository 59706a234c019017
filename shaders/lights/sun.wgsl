// A sun: parallel light along `e1` from a disc of radius `e2.x` outside the scene; `strength` is irradiance across the beam.
// Twin: src/optics/lights/sun.rs.
// import: sampling/sampling.wgsl
// import: lights/samples.wgsl

// By its own law: one direction, from any place of the disc: it is the place that can be steered.
fn sun_by_law(e: PackedEmitter, v: vec2<f32>, share: f32) -> Start {
    let frame = basis(e.e1);
    let d = sample_disc(v) * e.e2.x;
    return Start(e.origin + frame[0] * d.x + frame[1] * d.y, e.e1, e.flux * share);
}

// Light sample; it does not depend on the place.
fn sun_li(e: PackedEmitter) -> LightSample {
    return LightSample(-e.e1, 1e30, vec3(0.0), e.strength / e.pick, 0.0);
}
