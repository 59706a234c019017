// What a gather point says in one word: material, specular events on the way from the eye, side; and how wide its pixel is.
// import: sampling/sampling.wgsl

fn gather_surface(material: u32, chain: u32, from_front: bool, both_sides: bool) -> u32 {
    return material | (min(chain, CHAIN_MAX) << CHAIN_SHIFT) | select(BACK_SIDE, 0u, from_front) | select(0u, BOTH_SIDES, both_sides);
}

// Specular events between the eye and the point, saturated.
fn chain_of(point: GatherPoint) -> u32 {
    return (point.surface >> CHAIN_SHIFT) & CHAIN_MAX;
}

// Width of the pixel on the surface, where it is longest.
fn pixel_footprint(point: GatherPoint, pixel_angle: f32) -> f32 {
    let cosine = abs(dot(decode_direction(point.normal), decode_direction(point.wo)));
    return point.path_length * pixel_angle / max(cosine, CLIP_GRAZING);
}
