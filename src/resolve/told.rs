//! Told: what pixels say of the irradiance of the patches that they show, where nothing else is known of it.

use super::surfaces::Surfaces;
use crate::spectrum::{BANDS, Bands};
use rayon::prelude::*;

/// What a pixel of several surfaces tells counts as so many pixels: where surfaces are seen whole anywhere near, these alone tell of
/// them.
const MIXED: f32 = 0.02;

/// Mean irradiance that each half of the passes found, one after the other: the bands, and zeros up to whole vectors of four.
pub(super) type Values = [f32; (2 * BANDS).next_multiple_of(4)];

/// Both halves in one array.
pub(super) fn values(halves: &[Bands; 2]) -> Values {
    let mut values = Values::default();
    for (value, band) in values.iter_mut().zip(halves.as_flattened()) {
        *value = *band;
    }
    values
}

/// Each half of what stands in one array.
pub(super) fn halves(values: &Values) -> [Bands; 2] {
    std::array::from_fn(|half| std::array::from_fn(|band| values[half * BANDS + band]))
}

/// Of each patch, all of a pixel alike, from the mean radiance of each half of the passes; 0 in bands that the pixel takes nothing of.
pub(super) fn alike(surfaces: &Surfaces, halves: [&[Bands]; 2]) -> Vec<Values> {
    let over = |x: f32, weight: f32| if weight > 0.0 { x / weight } else { 0.0 };
    let of = |pixel: usize| {
        let patches = surfaces.at(pixel);
        let weight: Bands = std::array::from_fn(|b| patches.iter().map(|patch| patch.weight[b]).sum());
        let mean = halves.map(|half| std::array::from_fn(|b| over(half[pixel][b], weight[b])));
        std::iter::repeat_n(values(&mean), patches.len())
    };
    (0..halves[0].len()).into_par_iter().flat_map_iter(of).collect()
}

/// Pixels that what a pixel tells of a part of it, for a part of one, counts as.
pub(super) fn count(surfaces: &Surfaces, pixel: usize) -> f32 {
    if surfaces.is_mixed(pixel) { MIXED } else { 1.0 }
}
