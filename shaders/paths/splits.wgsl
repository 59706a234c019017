// Splits: where a camera tree takes both ways, and how likely an eye path is to go where a tree goes anyway [E25].
// Twin: src/backend/cpu/splits.rs.
// import: scene/features.wgsl
// import: shading/lobes.wgsl

struct Splits {
    // Flux kept so far of all that set out.
    share: f32,
    // Chance that an eye path, which picks one way by its flux, took these where a tree takes both.
    chance: f32,
    // pdf_solid_angle of an eye path's last direction, and lobe; 0 where no light sample may have found what it meets.
    pdf: f32,
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

// Eye paths and the light samples of their last vertex, which have this pdf_solid_angle, in the measure of `chance`.
fn without_trees(s: Splits, pdf_light: f32) -> f32 {
    if HAS_FOLLOWED_LIGHT && s.pdf > 0.0 {
        return s.chance * (1.0 + pdf_light / s.pdf);
    }
    return s.chance;
}

// Weight of the emission that an eye path meets, beside so many trees a pass, and light samples: the balance heuristic.
fn weight_of_eye(s: Splits, trees: f32, pdf_light: f32) -> f32 {
    return s.chance / (without_trees(s, pdf_light) + trees);
}

// Weight of the emission that each of so many trees a pass meets.
fn weight_of_tree(s: Splits, trees: f32, pdf_light: f32) -> f32 {
    return 1.0 / (without_trees(s, pdf_light) + trees);
}

// Weight of what light samples find in the lobe that these splits are after.
fn weight_of_light(s: Splits, trees: f32, pdf_light: f32) -> f32 {
    let by_light = s.chance * pdf_light;
    return by_light / (by_light + (s.chance + trees) * s.pdf);
}

// After a delta lobe that was taken where all have these weights, in a direction with this pdf_solid_angle of the lobe, 0 where it has no
// width. Where a tree takes one way only, it picks among the delta lobes as an eye path does.
fn splits_after(s: Splits, w: LobeWeights, lobe: u32, pdf: f32) -> Splits {
    let followed = delta_weight(w);
    let kept = scatter_weight(w) + followed;
    let taken = select(followed, weight_of(w, lobe), takes_both(s, w));
    var after = Splits(s.share * taken, s.chance * taken / kept, 0.0);
    if HAS_FOLLOWED_LIGHT {
        after.pdf = pdf * weight_of(w, lobe) / kept;
    }
    return after;
}
