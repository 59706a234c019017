// Trees: how many look for emission through a pixel, besides its eye path [E25]. Twin: src/estimators/split_paths.rs.
// reads  pass_info

// An entry of the list: the pixel, its level above.
fn glint_pixel(entry: u32) -> u32 {
    return entry & ((1u << GLINT_PIXEL_BITS) - 1u);
}

fn glint_level(entry: u32) -> u32 {
    return entry >> GLINT_PIXEL_BITS;
}

// Trees of a pixel in a pass that has some, by its level.
fn trees_of(level: u32) -> u32 {
    return select(level, GLINT_TREES << (level - GLINT_TURNS - 1u), level > GLINT_TURNS);
}

// Trees of a pixel in a pass, on average.
fn trees_a_pass(level: u32) -> f32 {
    return select(f32(trees_of(level)), 1.0 / f32(pass_info.glint_turns), level == GLINT_TURNS);
}
