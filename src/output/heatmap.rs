//! Heat map: relative error per pixel as false colour on a logarithmic scale, with the scale as a bar below.

use super::png::write_srgb;
use crate::error::Result;
use std::path::Path;

/// Powers of ten at the two ends of the scale: below, an error is invisible; above, all is equally wrong.
const DECADES: std::ops::RangeInclusive<i32> = -4..=1;
/// Height of the bar, pixels, and of the gap above it.
const BAR: u32 = 8;
const GAP: u32 = 2;
/// sRGB of the scale, evenly spaced: seven points of the "inferno" map (Smith and van der Walt 2015), whose
/// lightness grows evenly, and so also reads in grey.
const COLOURS: [[f64; 3]; 7] = [
    [0.0, 0.0, 4.0],
    [51.0, 10.0, 95.0],
    [120.0, 28.0, 109.0],
    [187.0, 55.0, 84.0],
    [237.0, 105.0, 37.0],
    [252.0, 180.0, 26.0],
    [252.0, 255.0, 164.0],
];
/// An error that is not a number, or infinite.
const NOT_FINITE: [u8; 3] = [0, 255, 255];
/// The gap, and the marks of the whole powers of ten in the bar.
const MARK: [u8; 3] = [255, 255, 255];

/// Write the map of `errors`, rows of `width`.
pub(super) fn write(path: &Path, width: u32, errors: &[f64]) -> Result<()> {
    let rows = errors.len() as u32 / width.max(1);
    let mut pixels: Vec<[u8; 3]> = errors.iter().map(|&e| colour(e)).collect();
    pixels.extend(std::iter::repeat_n(MARK, (GAP * width) as usize));
    for _ in 0..BAR {
        pixels.extend((0..width).map(|x| bar(x, width)));
    }
    write_srgb(path, width, rows + GAP + BAR, &pixels)
}

/// The bar at column `x`: the scale, with a mark at each power of ten inside.
fn bar(x: u32, width: u32) -> [u8; 3] {
    let span = f64::from(DECADES.end() - DECADES.start());
    let decade = |x: u32| f64::from(x) / f64::from(width) * span;
    if x > 0 && decade(x).floor() > decade(x - 1).floor() {
        return MARK;
    }
    colour(10f64.powf(f64::from(*DECADES.start()) + decade(x)))
}

fn colour(error: f64) -> [u8; 3] {
    if !error.is_finite() {
        return NOT_FINITE;
    }
    let (low, high) = (f64::from(*DECADES.start()), f64::from(*DECADES.end()));
    let at = ((error.log10() - low) / (high - low)).clamp(0.0, 1.0) * (COLOURS.len() - 1) as f64;
    let left = (at as usize).min(COLOURS.len() - 2);
    let mix = at - left as f64;
    std::array::from_fn(|c| (COLOURS[left][c] * (1.0 - mix) + COLOURS[left + 1][c] * mix).round() as u8)
}
