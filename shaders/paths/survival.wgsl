// How long a camera path goes on [E3].
// import: accel/intersect.wgsl
// reads  steps

// Loop iterations of a pixel's camera paths, at most.
override CAMERA_STEPS: u32 = STEP_BUDGET;
// Part of them over which they run out: a path then ends by chance, not by a cut, which would lose its light.
override STEP_RAMP: u32 = CAMERA_STEPS / 8u;

// Most that the probability may be that a path goes on after `events` events: one, but late in a path, and where `steps` comes
// near to `budget`.
fn survival_limit(events: u32, budget: u32) -> f32 {
    // never zero: what it divides stays finite
    let ramp = f32(budget - min(steps + 1u, budget) + 1u) / f32(STEP_RAMP);
    return min(select(SURVIVAL_MAX, 1.0, events < SURE_EVENTS), ramp);
}

// Probability that a path goes on after `events` events and one more that keeps the share `kept` of what it carries.
// Nothing is left to chance where nothing limits it.
fn survival(events: u32, kept: f32, budget: u32) -> f32 {
    let limit = survival_limit(events, budget);
    return select(min(kept, limit), 1.0, limit >= 1.0);
}
