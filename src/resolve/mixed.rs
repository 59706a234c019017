//! Mixed: pixels that show several surfaces. What they found themselves counts as far as it contradicts what neighbours tell of each.

use super::Estimate;
use super::sources::{LAYERS, Sources};
use crate::spectrum::{BANDS, Bands, add, scale};

/// Pixels around one of several surfaces that tell how good its neighbours' word is.
const REACH: u32 = 4;
/// What these agree on is chance below the square root of this in standard errors.
const DOUBT: f32 = 2.0;

/// Radiance of a layer of a pixel, of what neighbours tell and of its own findings, and its squared error.
pub(super) fn weighed(
    sources: &Sources<'_>,
    layer: usize,
    shared: &[[Estimate; LAYERS]],
    pixel: u32,
) -> (Bands, [f32; 2]) {
    let own = sources.own(layer, pixel);
    let all = &shared[pixel as usize][layer];
    // one pass has no second half that could say so
    let is_mixed = sources.parts[1] > 0.0 && sources.surfaces.is_mixed(pixel as usize);
    let (t, away, alone) = if is_mixed { doubt(sources, layer, shared, pixel) } else { (0.0, 0.0, 0.0) };
    let mean = sources.mean(&all.halves).map(|x| x.max(0.0));
    let value = add(&scale(&mean, 1.0 - t), &scale(&sources.mean(&own), t));
    let kept = (1.0 - t) * (1.0 - t);
    let weight = sources.weights[pixel as usize];
    (value, [kept * all.error[0] + t * t * alone, kept * (all.error[1] + away)].map(|e| e / weight))
}

/// The weight of a pixel's own findings where it shows several surfaces, the squared bias of what neighbours tell, and the variance of
/// its own, both weighed: from all such pixels around it.
fn doubt(sources: &Sources<'_>, layer: usize, shared: &[[Estimate; LAYERS]], pixel: u32) -> (f32, f32, f32) {
    let noise = sources.noise(layer);
    let [width, height] = sources.size;
    let [x, y] = [pixel % width, pixel / width];
    let near = |i: u32, n: u32| i.saturating_sub(REACH)..(i + REACH + 1).min(n);
    let (mut n, mut product, mut variance) = (0.0f32, 0.0f32, 0.0f32);
    for y in near(y, height) {
        for x in near(x, width) {
            let pixel = y * width + x;
            if !sources.surfaces.is_mixed(pixel as usize) {
                continue;
            }
            let (own, told) = (sources.own(layer, pixel), &shared[pixel as usize][layer].halves);
            let weight = sources.weights[pixel as usize];
            for b in 0..BANDS {
                let common = noise.common(own[0][b] - told[0][b], own[1][b] - told[1][b]);
                product += weight * common / BANDS as f32;
            }
            variance += weight * sources.variance(layer, &own);
            n += 1.0;
        }
    }
    let (product, variance) = (product / n, variance / n);
    let by_chance = (2.0 * variance).powi(2) / n;
    let bias = noise.credible(product, by_chance, 0.0, DOUBT);
    (bias / (bias + variance).max(f32::MIN_POSITIVE), bias, variance)
}
