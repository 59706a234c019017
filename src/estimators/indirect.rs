//! Indirect: which points of a sequence the paths of neighbouring pixels take \[E28\].

use crate::film::tile_schedule::TILE;

/// Pixels of a tile.
const TILE_PIXELS: u32 = TILE * TILE;

/// The tile of a pixel, and the index in its sequence of the pixel's path in a pass: the paths of a tile in one pass are
/// an aligned block, which covers the square evenly, and each pixel takes another part of it in each pass.
pub fn tile_point(pixel: u32, pass: u32, [width, _]: [u32; 2]) -> (u32, u64) {
    let (x, y) = (pixel % width, pixel / width);
    let tile = y / TILE * width.div_ceil(TILE) + x / TILE;
    let place = y % TILE * TILE + x % TILE;
    (tile, u64::from(pass) * u64::from(TILE_PIXELS) + u64::from(place ^ (pass % TILE_PIXELS)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::sequence2;

    /// In each pass the 64 pixels of a tile have one point in each 64th of the square; a pixel never has the same twice; tiles differ.
    #[test]
    fn tiles_cover_the_square_in_every_pass() {
        let size = [24, 16];
        let mut seen = std::collections::HashSet::new();
        for pass in 0..70 {
            for split in 0..=6 {
                let mut cells = [false; 64];
                for pixel in (0..8).flat_map(|y| (8..16).map(move |x| y * 24 + x)) {
                    let (tile, index) = tile_point(pixel, pass, size);
                    assert_eq!(tile, 1);
                    let [x, y] = sequence2(index, 3, tile, 9);
                    let of = |x: f32, bits: u32| (x * (1u32 << bits) as f32) as usize;
                    let cell = of(x, split) << (6 - split) | of(y, 6 - split);
                    assert!(!std::mem::replace(&mut cells[cell], true), "pass {pass} pixel {pixel}");
                    assert!(split > 0 || seen.insert(index), "index {index} comes twice");
                }
            }
        }
        assert_eq!(tile_point(9 * 24 + 20, 0, size).0, 5);
    }
}
