// Picking one of the emitters, by the probabilities of the list that the kernel sees.
// Twin: src/optics/lights/pick.rs.
// import: scene/scene.wgsl
// reads  scene

struct Pick {
    emitter: u32,
    // The random number again, uniform within the emitter's share: stratification survives the choice.
    rest: f32,
}

fn pick_emitter(u: f32, count: u32) -> Pick {
    var low = 0u;
    var high = count - 1u;
    while low < high {
        let middle = (low + high) / 2u;
        if u < emitter_at(middle).cumulative {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let e = emitter_at(low);
    let before = e.cumulative - e.pick;
    return Pick(low, clamp((u - before) / max(e.pick, 1e-30), 0.0, 0.99999994));
}
