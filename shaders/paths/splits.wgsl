// Splits: where a camera tree takes both ways, and how likely an eye path is to go where a tree goes anyway [E25].
// Twin: src/backend/cpu/splits.rs.
// import: shading/bsdf.wgsl

struct Splits {
    // Flux kept so far of all that set out.
    share: f32,
    // Chance that an eye path, which picks one way by its flux, took these where a tree takes both.
    chance: f32,
}

// Whether a tree takes both ways at a boundary.
fn takes_both(s: Splits, c: EventProbabilities) -> bool {
    return min(c.reflect, c.transmit) * s.share >= SPLIT_MIN;
}

// Weight of the emission that an eye path meets, beside so many trees a pass: the balance heuristic.
fn weight_of_eye(s: Splits, trees: f32) -> f32 {
    return s.chance / (s.chance + trees);
}

// Weight of the emission that each of so many trees a pass meets.
fn weight_of_tree(s: Splits, trees: f32) -> f32 {
    return 1.0 / (s.chance + trees);
}

// After an event with these chances.
fn splits_after(s: Splits, c: EventProbabilities, event: u32) -> Splits {
    let kept = c.diffuse + c.glossy + c.mirror + c.reflect + c.transmit;
    if event == EVENT_MIRROR || takes_both(s, c) {
        let taken = event_chance(c, event);
        return Splits(s.share * taken, s.chance * taken / kept);
    }
    return Splits(s.share * kept, s.chance);
}
