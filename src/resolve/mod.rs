//! Resolve: from what passes summed up to the picture. What single pixels find of light on surfaces is white noise about something
//! smooth: it is shared with neighbours on the same surface \[E29\].
//!
//! The sums stay as they are: a picture is resolved when it is looked at, from the means of two halves of the passes.

mod apart;
mod bandwidth;
mod lit;
mod looks;
mod mixed;
mod noise;
mod patch;
mod pyramid;
mod regression;
mod sources;
mod surfaces;
mod sweep;
mod told;
mod window;

use crate::film::neighbours::around;
use crate::film::{Film, Halves, Layer, RELATIVE_OFFSET};
use crate::packed::PackedScene;
use crate::spectrum::{BANDS, BLACK, Bands, add, mul, scale};
use bandwidth::{Bandwidths, ChoiceError, Errors};
use lit::Lit;
use mixed::Mixed;
use pyramid::middle;
use rayon::prelude::*;
use sources::{CHOICES, LAYERS, LEVELS, Sources};
use std::ops::Range;
use std::sync::{Arc, OnceLock};
use std::time::Instant;
use surfaces::Surfaces;
use sweep::{Found, Shown, share};
use window::Window;

/// Rows that are taken at a time: blocks of the coarsest level.
const STRIP: u32 = 1 << (LEVELS - 1);
/// What an image of so many rows shows is kept: a sweep holds as much of a larger one.
const KEPT_ROWS: u32 = 512;
/// Seconds that it takes to resolve a picture, over those of a look at what it shows.
const OVER_LOOK: f64 = 2.5;
/// Of so many rows one is looked at to foresee the time of all.
const FORESEEN: u32 = 8;

/// What is taken where nothing is known: a kernel of 10 pixels.
const FIRST_CHOICE: usize = 3;
/// Its relative variance.
const UNSURE: f32 = 0.01;
/// Squared radiance that errors are compared with, at most: one over it is no zero.
const LARGEST_SQUARE: f32 = 1e30;
/// How fast the weight of a choice falls with its squared error.
const SHARPNESS: i32 = 4;
/// Choices of less than this part of the weight are left out.
const LEAST_WEIGHT: f32 = 0.15;
/// Of a patch that is so small a part of its pixel only the best counts.
const SMALL: f32 = 0.2;

/// Smooths light on the surfaces of a scene.
#[derive(Debug)]
pub struct Resolver {
    scene: Arc<PackedScene>,
    seed: u32,
    layers: Vec<Layer>,
    /// Of an image of at most [`KEPT_ROWS`]: others are looked at each time.
    surfaces: OnceLock<Surfaces>,
}

/// Squared error of a pixel, (W/(m² sr))², means over the bands.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct SquaredError {
    /// An estimate of the variance.
    pub variance: f32,
    /// Product of what sharing changes in each half of the passes, about the pixel: on average the squared bias, but noisy; by chance it is
    /// negative.
    pub bias: f32,
}

/// An image of a layer.
#[derive(Debug, Clone, Default)]
pub struct Resolved {
    /// Radiance of each pixel, W/(m² sr).
    pub radiance: Vec<Bands>,
    /// What is known of its error: of each pixel whose error was asked for, row by row.
    pub squared_error: Vec<SquaredError>,
}

impl Resolver {
    /// Of these layers of light on surfaces, of a scene as its camera sees it; none where there are no layers.
    pub fn of_layers(scene: Arc<PackedScene>, seed: u32, layers: Vec<Layer>) -> Option<Self> {
        (!layers.is_empty()).then(|| Self { scene, seed, layers, surfaces: OnceLock::new() })
    }

    /// Those that it smooths.
    pub fn layers(&self) -> &[Layer] {
        &self.layers
    }

    /// Seconds that [`Resolver::resolve`] is going to take. This sees what the image shows, or some rows of it: the part of that time that
    /// depends on no pass.
    pub fn foresee(&self) -> f64 {
        let begin = Instant::now();
        let height = self.scene.size[1];
        if height <= KEPT_ROWS {
            self.kept();
            return OVER_LOOK * begin.elapsed().as_secs_f64();
        }
        // evenly spaced rows
        let seen: u32 = (0..height / FORESEEN / STRIP)
            .map(|strip| Surfaces::glance(&self.scene, self.seed, strip * FORESEEN * STRIP, STRIP))
            .sum();
        (1.0 + OVER_LOOK) * begin.elapsed().as_secs_f64() * f64::from(height) / f64::from(seen.max(1))
    }

    /// What the image shows, once for all.
    fn kept(&self) -> &Surfaces {
        self.surfaces.get_or_init(|| {
            let mut surfaces = Surfaces::new(self.scene.size);
            while surfaces.rows() < self.scene.size[1] {
                surfaces.look(&self.scene, self.seed, STRIP);
            }
            surfaces
        })
    }

    /// Share light among neighbours, each layer by itself; what is black is left out. The film keeps the halves of these layers. Errors are
    /// told of every `step`th pixel across and down.
    pub fn resolve(&self, film: &Film, step: u32) -> Vec<(Layer, Resolved)> {
        let of = |layer: &Layer| Some((*layer, film.halves(*layer).filter(Halves::has_light)?));
        let halves: Vec<(Layer, Halves<'_>)> = self.layers.iter().filter_map(of).collect();
        let Some((_, Halves { parts, .. })) = halves.first() else { return Vec::new() };
        let means: Vec<_> = halves.iter().map(|(_, halves)| |pixel: usize| halves.means(pixel)).collect();
        let lit = halves.iter().zip(&means).map(|((layer, _), means)| Lit { layer: *layer, means });
        let lit: Vec<Lit<'_>> = lit.collect();
        let shown = if film.size()[1] <= KEPT_ROWS {
            Shown::Kept(self.kept())
        } else {
            Shown::Looked { scene: &self.scene, seed: self.seed, surfaces: Surfaces::new(film.size()) }
        };
        let weights = |rows: Range<u32>| weights(film, rows);
        let found = Found { size: film.size(), layers: &lit, parts: *parts, step, weights: &weights };
        let resolved = share(&found, shown, STRIP);
        lit.iter().map(|lit| lit.layer).zip(resolved).collect()
    }
}

/// What squared errors of each pixel of some rows weigh: one over the squared radiance of light on surfaces about it. A lamp beside a
/// dark pixel makes no error of it small.
fn weights(film: &Film, rows: Range<u32>) -> Vec<f32> {
    let [width, height] = film.size();
    let passes = film.passes().max(1) as f64;
    let lit = |pixel: u32| -> Bands {
        let sums = Layer::ON_SURFACES.map(|layer| film.sum(layer as usize, pixel as usize));
        std::array::from_fn(|b| (sums.iter().map(|sum| sum[b]).sum::<f64>() / passes) as f32)
    };
    let first = rows.start.saturating_sub(1) * width;
    let radiance: Vec<Bands> = (first..(rows.end + 1).min(height) * width).into_par_iter().map(lit).collect();
    let of = |pixel: u32| {
        let near = || around(pixel, film.size()).map(|i| radiance[i - first as usize]);
        let count = near().count() as f32;
        let sum = near().fold(BLACK, |sum, l| add(&sum, &l));
        let square = sum.iter().map(|x| (x / count).powi(2)).sum::<f32>() / BANDS as f32;
        1.0 / (square + RELATIVE_OFFSET as f32).min(LARGEST_SQUARE)
    };
    (rows.start * width..rows.end * width).into_par_iter().map(of).collect()
}

/// Squared bias of a pixel and the eight about it: the product of what sharing changes in them in each half of the passes. Their mean is a
/// third as noisy as single pixels, and light seldom changes so finely that it is less.
fn bias(mixed: &Window<Mixed>, pixel: u32, size: [u32; 2]) -> f32 {
    let (mut count, mut changes) = (0.0, [BLACK; 2]);
    for near in around(pixel, size) {
        let more = mixed[near].changes;
        changes = [0, 1].map(|h: usize| add(&changes[h], &more[h]));
        count += 1.0;
    }
    let [first, second] = changes;
    first.iter().zip(second).map(|(x, y)| x * y).sum::<f32>() / (BANDS as f32 * count * count)
}

/// Irradiance at a patch, or radiance of a pixel.
#[derive(Debug, Clone, Copy)]
struct Estimate {
    /// As each half of the passes tells it.
    halves: [Bands; 2],
    /// Weighed.
    variance: f32,
}

impl Estimate {
    const NOTHING: Self = Self { halves: [BLACK; 2], variance: 0.0 };
}

/// Radiance of each layer of a pixel by what is known of its surfaces.
fn of_pixel(sources: &Sources<'_>, bandwidths: &Bandwidths, pixel: u32) -> [Estimate; LAYERS] {
    let mut all = [Estimate::NOTHING; LAYERS];
    for id in sources.surfaces.ids(pixel as usize) {
        let patch = sources.surfaces.patch(id);
        let found = of_patch(sources, bandwidths, pixel, id);
        let weight = patch.weight.iter().sum::<f32>() / BANDS as f32;
        for (all, found) in all.iter_mut().zip(&found) {
            all.halves = [0, 1].map(|h| add(&all.halves[h], &mul(&patch.weight, &found.halves[h])));
            all.variance += found.variance * weight * weight;
        }
    }
    all
}

/// Irradiance of each layer at a patch.
fn of_patch(sources: &Sources<'_>, bandwidths: &Bandwidths, pixel: u32, id: usize) -> [Estimate; LAYERS] {
    let patch = sources.surfaces.patch(id);
    // one pass tells nothing of its noise
    let known = if sources.parts[1] > 0.0 { bandwidths.at(patch, middle(pixel, sources.size)) } else { None };
    let variance = |choice: usize| if choice == FIRST_CHOICE { UNSURE } else { 1.0 };
    let unknown =
        || std::array::from_fn(|choice| ChoiceError { variance: variance(choice), ..Default::default() });
    let errors = known.unwrap_or_else(|| [unknown(); LAYERS]);
    let choices = sources.choices(pixel, id);
    let mut found = [Estimate::NOTHING; LAYERS];
    for layer in 0..sources.layers.len() {
        let (all, mut errors) = (&mut found[layer], errors[layer]);
        let least = if patch.share < SMALL { 1.0 } else { LEAST_WEIGHT };
        let mut parts = parts_of(&errors, least);
        // what is good around here may not be there here; a pixel's own always is
        while let Some(missing) = (0..CHOICES).find(|c| parts[*c] > 0.0 && choices.of(layer, *c).is_none()) {
            errors[missing] = ChoiceError::UNKNOWN;
            parts = parts_of(&errors, least);
        }
        for (choice, part) in parts.into_iter().enumerate().filter(|(_, part)| *part > 0.0) {
            let Some(halves) = choices.of(layer, choice) else { continue };
            all.halves = [0, 1].map(|h| add(&all.halves[h], &scale(&halves[h], part)));
            all.variance += part * errors[choice].variance;
        }
    }
    found
}

/// Weights of the choices, which add up to 1: those whose squared errors differ from the least by little, compared with their variance,
/// share it; but for the best those of less than a part of it are left out.
fn parts_of(errors: &Errors, least: f32) -> [f32; CHOICES] {
    let squared = errors.map(|error| error.variance + error.bias);
    let best = (0..CHOICES).min_by(|a, b| squared[*a].total_cmp(&squared[*b])).unwrap_or(0);
    let weights: [f32; CHOICES] = std::array::from_fn(|choice| {
        let scale = errors[best].variance + errors[choice].variance + f32::MIN_POSITIVE;
        (1.0 + (squared[choice] - squared[best]) / scale).powi(-SHARPNESS)
    });
    let total: f32 = weights.iter().sum();
    let is_left_out = |choice: usize| choice != best && weights[choice] < least * total;
    let kept: [f32; CHOICES] =
        std::array::from_fn(|choice| if is_left_out(choice) { 0.0 } else { weights[choice] });
    let total: f32 = kept.iter().sum();
    if !total.is_finite() {
        // squares of such light are no f32: a pixel keeps its own
        return std::array::from_fn(|choice| if choice == 0 { 1.0 } else { 0.0 });
    }
    kept.map(|weight| weight / total)
}

#[cfg(test)]
mod tests;
