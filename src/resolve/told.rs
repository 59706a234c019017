//! Told: what pixels say of the irradiance of the patches that they show, where nothing else is known of it.

use super::lit::Lit;
use super::surfaces::Surfaces;
use crate::spectrum::{BANDS, BLACK, Bands, add};
use rayon::prelude::*;
use std::ops::Range;

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

/// Of each patch of some pixels, all of a pixel alike, from the mean radiance of each half of the passes; 0 in bands that the pixel takes
/// nothing of.
pub(super) fn alike(surfaces: &Surfaces, lit: &Lit<'_>, pixels: Range<usize>) -> Vec<Values> {
    let over = |x: f32, weight: f32| if weight > 0.0 { x / weight } else { 0.0 };
    let of = |pixel: usize| {
        let weights = surfaces.at(pixel).map(|patch| patch.weight);
        let weight = weights.reduce(|sum, weight| add(&sum, &weight)).unwrap_or(BLACK);
        let mean = lit.halves(pixel).map(|half| std::array::from_fn(|b| over(half[b], weight[b])));
        std::iter::repeat_n(values(&mean), surfaces.ids(pixel).len())
    };
    pixels.into_par_iter().flat_map_iter(of).collect()
}

/// Pixels that what a pixel tells of a part of it, for a part of one, counts as.
pub(super) fn count(surfaces: &Surfaces, pixel: usize) -> f32 {
    if surfaces.is_mixed(pixel) { MIXED } else { 1.0 }
}
