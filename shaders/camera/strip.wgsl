// The pixels of a dispatch: a strip of rows of the image. Buffers with an entry for each pixel hold these rows and the ones
// next to them; random numbers, camera and neighbours are those of the whole image, so strips leave no trace in it.
// import: dispatch/index.wgsl
// reads  pass_info

// The pixel of an invocation, counted over the whole image; NO_PIXEL beyond the strip.
fn strip_pixel(index: u32) -> u32 {
    let first = pass_info.first_row * pass_info.width;
    return select(NO_PIXEL, first + index, index < pass_info.rows * pass_info.width);
}

// Where the buffers hold what belongs to a pixel.
fn held(pixel: u32) -> u32 {
    return pixel - pass_info.held_first * pass_info.width;
}

// First and last row about a pixel, as far as they are held.
fn rows_about(pixel: u32) -> vec2<u32> {
    let y = pixel / pass_info.width;
    return vec2(max(y, pass_info.held_first + 1u) - 1u, min(y + 1u, pass_info.held_first + pass_info.held_rows - 1u));
}

// First and last column about a pixel.
fn columns_about(pixel: u32) -> vec2<u32> {
    let x = pixel % pass_info.width;
    return vec2(max(x, 1u) - 1u, min(x + 1u, pass_info.width - 1u));
}
