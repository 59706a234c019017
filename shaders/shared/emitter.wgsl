// Emitters: picking, places on them, and what they send along a direction.
// import: shared/sampling.wgsl
// import: shared/features.wgsl
// reads  emitters

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
        if u < emitters[middle].cumulative {
            high = middle;
        } else {
            low = middle + 1u;
        }
    }
    let e_pick = emitters[low].pick;
    let before = emitters[low].cumulative - e_pick;
    return Pick(low, clamp((u - before) / max(e_pick, 1e-30), 0.0, 0.99999994));
}

// True for an emissive triangle; where there are no other lights, nothing else is compiled.
fn is_triangle(kind: u32) -> bool {
    return !HAS_DELTA_LIGHTS || kind == EMITTER_TRIANGLE;
}

// Part of the axial intensity that a spot sends at this cosine from its axis: a cubic smoothstep in the cosine.
fn spot_falloff(cosine: f32, cos_inner: f32, cos_outer: f32) -> f32 {
    let x = clamp((cosine - cos_outer) / max(cos_inner - cos_outer, 1e-7), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}
