//! Mixed: pixels that show several surfaces. What they found themselves counts as far as it contradicts what neighbours tell of each.

use super::Estimate;
use super::sources::{LAYERS, Sources};
use super::window::Window;
use crate::spectrum::{BANDS, BLACK, Bands, add, is_black, scale};
use rayon::prelude::*;
use std::ops::Range;

/// Pixels around one of several surfaces that tell how good its neighbours' word is.
pub(super) const REACH: u32 = 4;
/// What these agree on is chance below the square root of this in standard errors.
const DOUBT: f32 = 2.0;

/// What one pixel of several surfaces says of a layer, weighed: the squared bias of what neighbours tell of it, and the variance of its
/// own.
#[derive(Debug, Clone, Copy)]
pub(super) struct Word {
    bias: f32,
    variance: f32,
}

/// A pixel of a layer: of what neighbours tell and of its own findings.
#[derive(Debug, Clone, Copy)]
pub(super) struct Mixed {
    pub(super) radiance: Bands,
    /// In the mean over the bands.
    pub(super) variance: f32,
    /// What both halves of the passes have too much for what they found in the pixel itself.
    pub(super) changes: [Bands; 2],
}

impl Mixed {
    const BLACK: Self = Self { radiance: BLACK, variance: 0.0, changes: [BLACK; 2] };
}

/// What pixels of several surfaces say of a layer, of some that follow; none of the others.
pub(super) fn words(
    sources: &Sources<'_>,
    layer: usize,
    shared: &Window<[Estimate; LAYERS]>,
    pixels: Range<u32>,
) -> Vec<Option<Word>> {
    // one pass has no second half that could say so
    let is_mixed = |pixel: u32| sources.parts[1] > 0.0 && sources.surfaces.is_mixed(pixel as usize);
    pixels
        .into_par_iter()
        .map(|pixel| is_mixed(pixel).then(|| word(sources, layer, &shared[pixel as usize][layer], pixel)))
        .collect()
}

/// Some pixels of a layer that follow, where the words of all around them are known.
pub(super) fn weighed(
    sources: &Sources<'_>,
    layer: usize,
    shared: &Window<[Estimate; LAYERS]>,
    words: &Window<Option<Word>>,
    pixels: Range<u32>,
) -> Vec<Mixed> {
    let of = |pixel: u32| {
        let own = sources.own(layer, pixel);
        let all = &shared[pixel as usize][layer];
        if own.iter().all(is_black) && sources.surfaces.ids(pixel as usize).is_empty() {
            return Mixed::BLACK;
        }
        let is_mixed = words[pixel as usize].is_some();
        let (t, alone) = if is_mixed { doubt(sources, layer, words, pixel) } else { (0.0, 0.0) };
        let (fitted, seen) = (sources.mean(&all.halves), sources.mean(&own));
        // no fit is darker than nothing; only colours that no screen shows have less than that of a band
        let mean: Bands = std::array::from_fn(|b| fitted[b].max(seen[b].min(0.0)));
        let radiance = add(&scale(&mean, 1.0 - t), &scale(&seen, t));
        let kept = 1.0 - t;
        let variance = (kept * kept * all.variance + t * t * alone) / sources.weights[pixel as usize];
        let changes = [0, 1].map(|h| std::array::from_fn(|b| kept * (all.halves[h][b] - own[h][b])));
        Mixed { radiance, variance, changes }
    };
    pixels.into_par_iter().map(of).collect()
}

/// What a pixel says, where neighbours tell `told` of it.
fn word(sources: &Sources<'_>, layer: usize, told: &Estimate, pixel: u32) -> Word {
    let noise = sources.noise(layer);
    let (own, told) = (sources.own(layer, pixel), &told.halves);
    let weight = sources.weights[pixel as usize];
    let mut bias = 0.0;
    for b in 0..BANDS {
        bias += weight * noise.common(own[0][b] - told[0][b], own[1][b] - told[1][b]) / BANDS as f32;
    }
    Word { bias, variance: weight * sources.variance(layer, &own) }
}

/// The weight of a pixel's own findings where it shows several surfaces, and their weighed variance: from all such pixels around it.
fn doubt(sources: &Sources<'_>, layer: usize, words: &Window<Option<Word>>, pixel: u32) -> (f32, f32) {
    let [width, height] = sources.size;
    let [x, y] = [pixel % width, pixel / width];
    let near = |i: u32, n: u32| i.saturating_sub(REACH)..(i + REACH + 1).min(n);
    let (mut n, mut bias, mut variance) = (0.0f32, 0.0f32, 0.0f32);
    for y in near(y, height) {
        let columns = near(x, width);
        let row = (y * width + columns.start) as usize..(y * width + columns.end) as usize;
        for word in words.range(row).flatten() {
            bias += word.bias;
            variance += word.variance;
            n += 1.0;
        }
    }
    let (bias, variance) = (bias / n, variance / n);
    let by_chance = (2.0 * variance).powi(2) / n;
    let bias = sources.noise(layer).credible(bias, by_chance, 0.0, DOUBT);
    (bias / (bias + variance).max(f32::MIN_POSITIVE), variance)
}
