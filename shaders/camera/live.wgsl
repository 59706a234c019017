// Live: the tiles that take part in a pass [E21]. A workgroup is a tile of 8 × 8 pixels.
// import: dispatch/index.wgsl
// reads  tiles, pass_info

// Number of a tile in the low 24 bits, k above: it takes part in one of 2^k passes. Small k come first, so that the tiles
// that are live in a pass are the first ones. A dispatch sees a part of them.
@group(2) @binding(0) var<uniform> tiles: array<vec4<u32>, TILES_VECTORS>;

fn tile_word(index: u32) -> u32 {
    let at = index / WORKGROUP;
    return tiles[at / 4u][at % 4u];
}

// The pixel of an invocation, counted over the whole image; NO_PIXEL beyond the strip.
fn live_pixel(index: u32) -> u32 {
    let tile = tile_word(index) & TILE_MASK;
    let pixel = tiled_pixel(tile * WORKGROUP + index % WORKGROUP, pass_info.width, pass_info.rows);
    return select(NO_PIXEL, pass_info.first_row * pass_info.width + pixel, pixel != NO_PIXEL);
}

// The index that an invocation uses in its pixel's sequences: those from one power of two of passes to the next follow
// each other, and none is used twice.
fn sequence_index(index: u32) -> u32 {
    let k = tile_word(index) >> TILE_BITS;
    if k == 0u || pass_info.pass_index == 0u {
        return pass_info.pass_index;
    }
    let octave = 1u << firstLeadingBit(pass_info.pass_index);
    return octave + ((pass_info.pass_index - octave) >> k);
}
