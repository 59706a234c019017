// Splits: where a camera tree takes both ways, and how likely an eye path is to go where a tree goes anyway [E25].
// Twin: src/backend/cpu/splits.rs.
// import: shading/lobes.wgsl

struct Splits {
    // Flux kept so far of all that set out.
    share: f32,
    // Chance that an eye path, which picks one way by its flux, took these where a tree takes both.
    chance: f32,
}

// The lobes of an interface by what they keep.
struct InterfaceLobes {
    lesser: u32,
    greater: u32,
}

fn interface_lobes(w: LobeWeights) -> InterfaceLobes {
    let reflects_less = w.reflection <= w.transmission;
    return InterfaceLobes(
        select(LOBE_TRANSMISSION, LOBE_REFLECTION, reflects_less), select(LOBE_REFLECTION, LOBE_TRANSMISSION, reflects_less),
    );
}

// Whether a tree takes both ways at an interface.
fn takes_both(s: Splits, w: LobeWeights) -> bool {
    return min(w.reflection, w.transmission) * s.share >= SPLIT_MIN;
}

// Weight of the emission that an eye path meets, beside so many trees a pass: the balance heuristic.
fn weight_of_eye(s: Splits, trees: f32) -> f32 {
    return s.chance / (s.chance + trees);
}

// Weight of the emission that each of so many trees a pass meets.
fn weight_of_tree(s: Splits, trees: f32) -> f32 {
    return 1.0 / (s.chance + trees);
}

// After a delta lobe that was taken where all have these weights. Where a tree takes one way only, it picks among the delta lobes as
// an eye path does.
fn splits_after(s: Splits, w: LobeWeights, lobe: u32) -> Splits {
    let followed = delta_weight(w);
    let taken = select(followed, weight_of(w, lobe), takes_both(s, w));
    return Splits(s.share * taken, s.chance * taken / (scatter_weight(w) + followed));
}
