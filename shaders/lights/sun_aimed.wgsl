// A sun's light aimed at the specular bodies [E13]. See sun.wgsl.
// import: sampling/sampling.wgsl
// import: lights/samples.wgsl
// reads  targets

// Through the discs of the first `count` targets along the beam.
fn sun_aimed(e: PackedEmitter, v: vec2<f32>, share: f32, count: u32) -> Start {
    let frame = basis(e.e1);
    var total = 0.0;
    for (var i = 0u; i < count; i += 1u) {
        total += targets[i].radius * targets[i].radius;
    }
    var rest = v.x * total;
    var chosen = 0u;
    while chosen + 1u < count && rest >= targets[chosen].radius * targets[chosen].radius {
        rest -= targets[chosen].radius * targets[chosen].radius;
        chosen += 1u;
    }
    let t = targets[chosen];
    let d = sample_disc(vec2(min(rest / (t.radius * t.radius), 0.99999994), v.y)) * t.radius;
    let through = t.center + frame[0] * d.x + frame[1] * d.y;
    var hits = 0u;
    for (var i = 0u; i < count; i += 1u) {
        let off = through - targets[i].center;
        let across = off - e.e1 * dot(off, e.e1);
        hits += select(0u, 1u, i == chosen || dot(across, across) <= targets[i].radius * targets[i].radius);
    }
    let origin = through - e.e1 * dot(through - e.origin, e.e1);
    return Start(origin, e.e1, e.strength * (share * PI * total / f32(hits)));
}
