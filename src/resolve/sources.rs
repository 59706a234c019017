//! Sources: everything that the light of a patch is chosen from.

use super::lit::Lit;
use super::noise::Noise;
use super::pyramid::{Level, middle};
use super::regression::Kernel;
use super::surfaces::Surfaces;
use super::window::Window;
use crate::film::Layer;
use crate::spectrum::{BANDS, Bands};
use std::cell::OnceCell;

/// Levels of blocks: up to 32 × 32 pixels, kernels up to 80 pixels wide on each side.
pub(super) const LEVELS: usize = 6;
/// What is chosen among: a pixel's own, and the fits of each level.
pub(super) const CHOICES: usize = LEVELS + 1;
/// Layers that are resolved at once, at most.
pub(super) const LAYERS: usize = Layer::ON_SURFACES.len();

/// All layers, and what the image shows.
pub(super) struct Sources<'a> {
    pub(super) size: [u32; 2],
    pub(super) surfaces: &'a Surfaces,
    pub(super) layers: &'a [Lit<'a>],
    pub(super) levels: &'a [Level],
    /// Part of the passes that each half has.
    pub(super) parts: [f32; 2],
    /// What squared errors of each pixel weigh: they count relative to its light.
    pub(super) weights: &'a Window<f32>,
}

impl Sources<'_> {
    /// Of both halves together.
    pub(super) fn mean(&self, halves: &[Bands; 2]) -> Bands {
        std::array::from_fn(|b| self.parts[0] * halves[0][b] + self.parts[1] * halves[1][b])
    }

    /// Variance of that mean, as the halves of a layer differ, in the mean over the bands.
    pub(super) fn variance(&self, layer: usize, halves: &[Bands; 2]) -> f32 {
        let [a, b] = self.parts;
        let squares = halves[0].iter().zip(&halves[1]).map(|(x, y)| (x - y) * (x - y));
        self.noise(layer).together() * a * b * squares.sum::<f32>() / BANDS as f32
    }

    /// Mean radiance of a layer that each half found in a pixel.
    pub(super) fn own(&self, layer: usize, pixel: u32) -> [Bands; 2] {
        self.layers[layer].halves(pixel as usize)
    }

    /// How a layer's noise behaves.
    pub(super) fn noise(&self, layer: usize) -> Noise {
        Noise::of(self.layers[layer].layer)
    }

    /// What is to choose from at a patch of a pixel.
    pub(super) fn choices(&self, pixel: u32, id: usize) -> Choices<'_> {
        Choices { sources: self, pixel, id, kernels: Default::default() }
    }
}

/// What is to choose from at a patch.
pub(super) struct Choices<'a> {
    sources: &'a Sources<'a>,
    pixel: u32,
    id: usize,
    /// Of each level, as they are needed; all layers share them.
    kernels: [OnceCell<Option<Kernel>>; LEVELS],
}

impl Choices<'_> {
    /// Irradiance of a layer by one choice, as each half of the passes tells it.
    pub(super) fn of(&self, layer: usize, choice: usize) -> Option<[Bands; 2]> {
        let s = self.sources;
        let Some(level) = choice.checked_sub(1) else { return Some(s.levels[0].of(layer, self.id)) };
        let at = || {
            Kernel::at(&s.levels[level], s.surfaces, s.surfaces.patch(self.id), middle(self.pixel, s.size))
        };
        self.kernels[level].get_or_init(at).as_ref().map(|kernel| kernel.of(s.levels[level].values(layer)))
    }
}
