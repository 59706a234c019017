//! Sweep: light is shared from the first row of an image to the last. Each stage goes as far as those before it allow, and what no later
//! row asks for is let go: some hundreds of rows are held, of an image of any height.

use super::apart::Told;
use super::bandwidth::Bandwidths;
use super::lit::Lit;
use super::mixed::{self, Mixed, Word, weighed, words};
use super::sources::{LAYERS, Sources};
use super::surfaces::Surfaces;
use super::window::Window;
use super::{Estimate, Resolved, SquaredError, bias, of_pixel};
use crate::packed::PackedScene;
use rayon::prelude::*;
use std::ops::Range;

/// What an image shows.
pub(super) enum Shown<'a> {
    /// It is known.
    Kept(&'a Surfaces),
    /// It is looked at on the way.
    Looked { scene: &'a PackedScene, seed: u32, surfaces: Surfaces },
}

impl Shown<'_> {
    fn surfaces(&self) -> &Surfaces {
        match self {
            Self::Kept(surfaces) => surfaces,
            Self::Looked { surfaces, .. } => surfaces,
        }
    }

    fn look(&mut self, rows: u32) {
        if let Self::Looked { scene, seed, surfaces } = self {
            surfaces.look(scene, *seed, rows);
        }
    }

    fn drop_before(&mut self, row: u32) {
        if let Self::Looked { surfaces, .. } = self {
            surfaces.drop_before(row);
        }
    }
}

/// What the halves of the passes found.
pub(super) struct Found<'a> {
    pub(super) size: [u32; 2],
    pub(super) layers: &'a [Lit<'a>],
    /// Part of the passes that each half has.
    pub(super) parts: [f32; 2],
    /// Pixels across and down from one whose errors are told to the next.
    pub(super) step: u32,
    /// What squared errors weigh in each pixel of some rows.
    pub(super) weights: &'a (dyn Fn(Range<u32>) -> Vec<f32> + Sync),
}

/// A layer on its way.
struct Shared {
    words: Window<Option<Word>>,
    mixed: Window<Mixed>,
    done: Resolved,
}

/// Share what was found among pixels that show these surfaces, so many rows at a time.
pub(super) fn share(found: &Found<'_>, mut shown: Shown<'_>, strip: u32) -> Vec<Resolved> {
    let Found { size, layers, parts, step, .. } = *found;
    let [width, height] = size;
    let rows_of = |pixels: usize| (pixels / width as usize) as u32;
    // where stages that look so many rows ahead can go, and at the end of the image no farther at a time than elsewhere
    let behind = |row: u32, ahead: u32| if row == height { height } else { row.saturating_sub(ahead) };
    let next = |before: u32, ready: u32| ready.min(before.saturating_add(strip));
    let mut told = Told::new(size, layers.len());
    let mut bandwidths = Bandwidths::new(size);
    let mut weights: Window<f32> = Window::default();
    let mut estimates: Window<[Estimate; LAYERS]> = Window::default();
    let mut shared: Vec<Shared> = layers.iter().map(|_| Shared::of(size, step)).collect();
    let mut done = 0;
    while done < height {
        shown.look(strip);
        let surfaces = shown.surfaces();
        told.go_on(surfaces, layers, strip);
        let sampled = rows_of(weights.end());
        let rows = next(sampled, bandwidths.rows_to_sample(told.rows(), height));
        weights.extend((found.weights)(sampled..rows));
        let sources = Sources { size, surfaces, layers, levels: &told.levels, parts, weights: &weights };
        bandwidths.look(&sources, rows);

        let rows = rows_of(estimates.end());
        let pixels = rows * width..next(rows, bandwidths.rows(height)) * width;
        let more = pixels.clone().into_par_iter().map(|pixel| of_pixel(&sources, &bandwidths, pixel));
        estimates.extend(more.collect());
        let to_mix = behind(rows_of(estimates.end()), mixed::REACH);
        let to_end = behind(to_mix, 1);
        for (layer, shared) in shared.iter_mut().enumerate() {
            shared.words.extend(words(&sources, layer, &estimates, pixels.clone()));
            let pixels = shared.mixed.end() as u32..to_mix * width;
            let more = weighed(&sources, layer, &estimates, &shared.words, pixels);
            shared.done.radiance.extend(more.iter().map(|mixed| mixed.radiance));
            shared.mixed.extend(more);
            let samples: Vec<u32> = (done.next_multiple_of(step)..to_end)
                .step_by(step as usize)
                .flat_map(|y| (0..width).step_by(step as usize).map(move |x| y * width + x))
                .collect();
            let more = samples.into_par_iter().map(|pixel| SquaredError {
                variance: shared.mixed[pixel as usize].variance,
                bias: bias(&shared.mixed, pixel, size),
            });
            shared.done.squared_error.par_extend(more);
            shared.mixed.drop_before((to_end.saturating_sub(1) * width) as usize);
            shared.words.drop_before((to_mix.saturating_sub(mixed::REACH) * width) as usize);
        }
        done = to_end;
        let mixed = (to_mix * width) as usize;
        weights.drop_before(mixed);
        bandwidths.drop_before(rows_of(estimates.end()));
        let reached = told.drop_before(rows_of(estimates.end()));
        estimates.drop_before(mixed);
        shown.drop_before(to_mix.min(reached));
    }
    shared.into_iter().map(|shared| shared.done).collect()
}

impl Shared {
    fn of(size: [u32; 2], step: u32) -> Self {
        let pixels = |step: u32| size.map(|n| n.div_ceil(step) as usize).iter().product();
        let done = Resolved {
            radiance: Vec::with_capacity(pixels(1)),
            squared_error: Vec::with_capacity(pixels(step)),
        };
        Self { words: Window::default(), mixed: Window::default(), done }
    }
}
