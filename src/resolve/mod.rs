//! Resolve: from what passes summed up to the picture. What single pixels find of light on surfaces is white noise about something
//! smooth: it is shared with neighbours on the same surface \[E29\].
//!
//! The sums stay as they are: a picture is resolved when it is looked at, from the means of two halves of the passes.

mod apart;
mod bandwidth;
mod looks;
mod mixed;
mod noise;
mod patch;
mod pyramid;
mod regression;
mod sources;
mod surfaces;
mod told;

use crate::film::neighbours::around;
use crate::film::{Film, Halves, Layer, RELATIVE_OFFSET};
use crate::packed::PackedScene;
use crate::spectrum::{BANDS, BLACK, Bands, add, is_black, mul, scale};
use bandwidth::{Bandwidths, ChoiceError, Errors};
use mixed::{Mixed, weighed};
use pyramid::middle;
use rayon::prelude::*;
use sources::{CHOICES, LAYERS, LEVELS, Lit, Sources};
use std::sync::{Arc, OnceLock};
use surfaces::Surfaces;

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
#[derive(Debug, Clone)]
pub struct Resolved {
    /// Radiance of each pixel, W/(m² sr).
    pub radiance: Vec<Bands>,
    /// What is known of its error.
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

    /// See what the image shows: [`Resolver::resolve`] needs it, and this is the part of its time that depends on no pass.
    pub fn look(&self) {
        self.surfaces();
    }

    fn surfaces(&self) -> &Surfaces {
        self.surfaces.get_or_init(|| Surfaces::look(&self.scene, self.seed))
    }

    /// Share light among neighbours, each layer by itself; what is black is left out. The film keeps the halves of these layers.
    pub fn resolve(&self, film: &Film) -> Vec<(Layer, Resolved)> {
        let has_light = |halves: &Halves| halves.means.iter().flatten().any(|l| !is_black(l));
        let of = |layer: &Layer| Some((*layer, film.halves(*layer).filter(has_light)?));
        let halves: Vec<(Layer, Halves)> = self.layers.iter().filter_map(of).collect();
        let Some((_, Halves { parts, .. })) = halves.first() else { return Vec::new() };
        let lit: Vec<Lit<'_>> = halves
            .iter()
            .map(|(layer, of)| Lit { layer: *layer, halves: of.means.each_ref().map(|half| &half[..]) })
            .collect();
        let resolved = share(film.size(), self.surfaces(), &lit, *parts, &weights(film));
        lit.iter().map(|lit| lit.layer).zip(resolved).collect()
    }
}

/// What squared errors of each pixel weigh: one over the squared radiance of light on surfaces about it. A lamp beside a dark pixel
/// makes no error of it small.
fn weights(film: &Film) -> Vec<f32> {
    let passes = film.passes().max(1) as f64;
    let lit = |pixel: usize| -> Bands {
        let sums = Layer::ON_SURFACES.map(|layer| film.sum(layer as usize, pixel));
        std::array::from_fn(|b| (sums.iter().map(|sum| sum[b]).sum::<f64>() / passes) as f32)
    };
    let pixels = film.size().iter().product::<u32>();
    let radiance: Vec<Bands> = (0..pixels as usize).map(lit).collect();
    let of = |pixel: u32| {
        let near = || around(pixel, film.size()).map(|i| radiance[i]);
        let count = near().count() as f32;
        let sum = near().fold(BLACK, |sum, l| add(&sum, &l));
        let square = sum.iter().map(|x| (x / count).powi(2)).sum::<f32>() / BANDS as f32;
        1.0 / (square + RELATIVE_OFFSET as f32).min(LARGEST_SQUARE)
    };
    (0..pixels).into_par_iter().map(of).collect()
}

/// Share what the halves of the passes found among pixels that show these surfaces.
fn share(
    size: [u32; 2],
    surfaces: &Surfaces,
    layers: &[Lit<'_>],
    parts: [f32; 2],
    weights: &[f32],
) -> Vec<Resolved> {
    let halves: Vec<_> = layers.iter().map(|lit| lit.halves).collect();
    let mut levels = apart::told(size, surfaces, &halves);
    while levels.len() < LEVELS {
        levels.push(levels[levels.len() - 1].coarser());
    }
    let sources = Sources { size, surfaces, layers, levels: &levels, parts, weights };
    let bandwidths = Bandwidths::look(&sources);
    let pixels = 0..size[0] * size[1];
    let shared: Vec<[Estimate; LAYERS]> =
        pixels.clone().into_par_iter().map(|pixel| of_pixel(&sources, &bandwidths, pixel)).collect();
    let resolved = |layer: usize| {
        let mixed = weighed(&sources, layer, &shared);
        let squared_error = pixels.clone().into_par_iter().map(|pixel| SquaredError {
            variance: mixed[pixel as usize].variance,
            bias: bias(&mixed, pixel, size),
        });
        Resolved {
            squared_error: squared_error.collect(),
            radiance: mixed.iter().map(|mixed| mixed.radiance).collect(),
        }
    };
    (0..layers.len()).map(resolved).collect()
}

/// Squared bias of a pixel and the eight about it: the product of what sharing changes in them in each half of the passes. Their mean is a
/// third as noisy as single pixels, and light seldom changes so finely that it is less.
fn bias(mixed: &[Mixed], pixel: u32, size: [u32; 2]) -> f32 {
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
