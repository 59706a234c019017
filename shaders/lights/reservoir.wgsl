// Reservoir: one of many, by weight, in one look at each [E24]. Twin: src/optics/lights/reservoir.rs.

struct Reservoir {
    // Sum of the weights so far.
    total: f32,
    // Uniform in [0, 1), whatever was kept so far.
    choice: f32,
}

// True where the next one, of this weight, takes the place of the one that was kept: with probability weight / total.
// One number serves all choices: what is left of it is uniform again.
fn takes(r: ptr<function, Reservoir>, weight: f32) -> bool {
    if weight <= 0.0 {
        return false;
    }
    (*r).total += weight;
    let part = weight / (*r).total;
    let taken = (*r).choice < part;
    let left = select(((*r).choice - part) / (1.0 - part), (*r).choice / part, taken);
    // below one, which rounding may reach
    (*r).choice = min(left, 0.99999994);
    return taken;
}
