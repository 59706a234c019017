//! Bandwidth: over how many pixels irradiance may be shared, by what that costs: variance from how the halves of the passes differ,
//! squared bias from what changes, in both halves alike, from one bandwidth to the next [E29].

use super::pyramid::{Level, Told, middle};
use super::regression::{REACH, fit};
use super::surfaces::{Patch, Place, Surfaces};
use crate::spectrum::{BANDS, Bands};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Levels of blocks: up to 32 × 32 pixels, kernels up to 80 pixels wide on each side.
pub(super) const LEVELS: usize = 6;
/// What is chosen among: a pixel's own, and the fits of each level.
pub(super) const CHOICES: usize = LEVELS + 1;
/// Width of a cell, pixels: statistics are kept for each.
const CELL: u32 = 8;
/// Every second pixel across and down is a sample of them.
const STEP: u32 = 2;
/// Statistics are means within so many radii of a kernel, and at least so many pixels.
const POOL: f32 = 1.5;
/// See [`POOL`].
const POOL_LEAST: f32 = 20.0;
/// Squared bias of a fit over the squared difference to the next finer one: bias goes with the squared radius.
const BIAS_OF_STEP: f32 = 16.0 / 9.0;
/// Where a step stands out, within so many pixels …
const POOL_NEAR: f32 = 9.0;
/// … by the square root of this in standard errors, it counts there, whatever lies around.
const DOUBT_NEAR: f32 = 4.0;
/// How noisy single passes are changes slowly over the image. Were it not pooled widely, places where something rare was found would be
/// shared among many, and those around, where it was not, among few: light would be lost.
const POOL_VARIANCE: f32 = 40.0;
/// A step of less than the square root of this in standard errors is no bias.
const DOUBT: f32 = 2.0;
/// Kernel pixels over blocks: the equivalent number of equal weights.
const KERNEL_BLOCKS: f32 = 10.9;

/// Squared error of a choice of which nothing is known.
const UNKNOWN: f32 = 1e30;

/// Likeness of the places in a cell that are taken for one surface.
const LIKES: f32 = 0.3;

/// What is known in a cell of one surface: sums over its samples, then means over the surroundings.
#[derive(Debug, Clone, Copy)]
struct Cell {
    place: Place,
    at: Vec2,
    count: f32,
    moments: [Moments; CHOICES],
}

/// Of one choice.
#[derive(Debug, Clone, Copy, Default)]
struct Moments {
    samples: f32,
    /// Variance of the mean of both halves.
    variance: f32,
    /// Product of what both halves change from the choice before, and its square.
    step: f32,
    step_squared: f32,
    /// What of it both halves agree on.
    least_step: f32,
}

/// Variance of each choice at one place, and its squared bias: sums of steps, of which those that two choices have in common say nothing
/// about which is better.
pub(super) type Errors = [[f32; 2]; CHOICES];

/// Squared errors all over the image.
#[derive(Debug)]
pub(super) struct Bandwidths {
    size: [u32; 2],
    first: Vec<u32>,
    cells: Vec<(Cell, Errors)>,
}

/// Everything that is chosen from.
pub(super) struct Sources<'a> {
    pub(super) size: [u32; 2],
    pub(super) surfaces: &'a Surfaces,
    pub(super) levels: &'a [Level],
    /// Mean radiance of each half.
    pub(super) halves: [&'a [Bands]; 2],
    /// Part of the passes that each half has.
    pub(super) parts: [f32; 2],
}

impl Sources<'_> {
    /// Of both halves together.
    pub(super) fn mean(&self, halves: &[Bands; 2]) -> Bands {
        std::array::from_fn(|b| self.parts[0] * halves[0][b] + self.parts[1] * halves[1][b])
    }

    /// Variance of that mean, as the halves differ, in the mean over the bands.
    pub(super) fn variance(&self, halves: &[Bands; 2]) -> f32 {
        let [a, b] = self.parts;
        let squares = halves[0].iter().zip(&halves[1]).map(|(x, y)| (x - y) * (x - y));
        a * b * squares.sum::<f32>() / BANDS as f32
    }

    /// Irradiance by one choice at a patch of a pixel that tells this.
    pub(super) fn choose(&self, choice: usize, patch: &Patch, pixel: u32, told: &Told) -> Option<[Bands; 2]> {
        match choice.checked_sub(1) {
            None => Some(told.halves),
            Some(level) => fit(&self.levels[level], patch, middle(pixel, self.size)),
        }
    }

    /// Mean radiance that each half found in a pixel.
    pub(super) fn own(&self, pixel: u32) -> [Bands; 2] {
        self.halves.map(|half| half[pixel as usize])
    }

    /// What a pixel tells.
    pub(super) fn told(&self, pixel: u32) -> Told {
        let is_mixed = self.surfaces.is_mixed(pixel as usize);
        Told::new(self.surfaces.at(pixel as usize), is_mixed, self.own(pixel))
    }
}

/// The square of the lesser of what both halves say, negative where they differ in sign: what one alone has found is nothing.
pub(super) fn agreed(x: f32, y: f32) -> f32 {
    let least = x.abs().min(y.abs());
    (least * least).copysign(x * y)
}

/// A mean square as far as it is more than chance, of this squared standard error: 0 below the square root of `doubt` of these.
pub(super) fn credible(mean: f32, uncertain: f32, doubt: f32) -> f32 {
    if mean > 0.0 { mean * (1.0 - doubt * uncertain / (mean * mean)).max(0.0) } else { 0.0 }
}

/// Radius of a choice's kernel, pixels.
fn radius(choice: usize) -> f32 {
    if choice == 0 { 0.5 } else { REACH * (1u32 << (choice - 1)) as f32 }
}

/// Independent samples that a kernel's own width leaves one of.
fn together(choice: usize) -> f32 {
    if choice == 0 {
        return 1.0;
    }
    (KERNEL_BLOCKS * (1u32 << (2 * (choice - 1))) as f32 / (STEP * STEP) as f32).max(1.0)
}

impl Bandwidths {
    /// Look what each choice would give.
    pub(super) fn look(sources: &Sources<'_>) -> Self {
        let size = sources.size.map(|n| n.div_ceil(CELL));
        let cells: Vec<Vec<Cell>> =
            (0..size[0] * size[1]).into_par_iter().map(|cell| sampled(sources, cell, size[0])).collect();
        let (mut first, mut all) = (vec![0], Vec::new());
        for cell in cells {
            all.extend(cell);
            first.push(all.len() as u32);
        }
        let errors: Vec<Errors> = all.par_iter().map(|cell| pooled(cell, &all, &first, size)).collect();
        Self { size, first, cells: all.into_iter().zip(errors).collect() }
    }

    /// Squared error of each choice at a patch; none where nothing is known of its surface.
    pub(super) fn at(&self, patch: &Patch, at: Vec2) -> Option<Errors> {
        let reach = 1.5 * CELL as f32;
        let (mut sum, mut errors) = (0.0, [[0.0; 2]; CHOICES]);
        for row in rows(at, reach, self.size) {
            let ids = self.first[row.start] as usize..self.first[row.end] as usize;
            for (cell, mine) in &self.cells[ids] {
                let away = cell.at.distance_squared(at);
                let near = 1.0 - away / (reach * reach);
                if near <= 0.0 {
                    continue;
                }
                let like = patch.place.likeness(&cell.place, away.sqrt());
                let w = near * near * like * cell.count;
                sum += w;
                for (e, m) in errors.as_flattened_mut().iter_mut().zip(mine.as_flattened()) {
                    *e += w * m;
                }
            }
        }
        (sum > 0.0).then(|| errors.map(|e| e.map(|x| x / sum)))
    }
}

/// Ranges of cells, a row each, within `reach` pixels.
fn rows(at: Vec2, reach: f32, size: [u32; 2]) -> impl Iterator<Item = Range<usize>> {
    let range = |at: f32, n: u32| {
        let of = |x: f32| (x.max(0.0) as u32 / CELL).min(n - 1);
        of(at - reach)..of(at + reach) + 1
    };
    let columns = range(at.x, size[0]);
    range(at.y, size[1]).map(move |y| {
        let row = y * size[0];
        (row + columns.start) as usize..(row + columns.end) as usize
    })
}

/// The surfaces of a cell, with sums over samples.
fn sampled(sources: &Sources<'_>, cell: u32, across: u32) -> Vec<Cell> {
    let [x, y] = [cell % across * CELL, cell / across * CELL];
    let [width, height] = sources.size;
    let mut cells: Vec<Cell> = Vec::new();
    for y in (y..(y + CELL).min(height)).step_by(STEP as usize) {
        for x in (x..(x + CELL).min(width)).step_by(STEP as usize) {
            let pixel = y * width + x;
            let told = sources.told(pixel);
            for patch in sources.surfaces.at(pixel as usize) {
                let all = std::array::from_fn(|choice| sources.choose(choice, patch, pixel, &told));
                let found = Cell {
                    place: patch.place,
                    at: middle(pixel, sources.size),
                    count: told.count * patch.share,
                    moments: moments(sources, &all),
                };
                let likes = |c: &Cell| {
                    let normal = c.place.normal.normalize_or(Vec3::Z);
                    Place { normal, ..c.place }.likeness(&patch.place, CELL as f32) > LIKES
                };
                match cells.iter_mut().find(|c| likes(c)) {
                    Some(cell) => cell.add(&found),
                    None => {
                        let mut cell = Cell { count: 0.0, moments: Default::default(), ..found };
                        cell.add(&found);
                        cells.push(cell);
                    }
                }
            }
        }
    }
    for cell in &mut cells {
        cell.place.normal = cell.place.normal.normalize_or(Vec3::Z);
    }
    cells
}

/// Of the estimates of one pixel.
fn moments(sources: &Sources<'_>, all: &[Option<[Bands; 2]>; CHOICES]) -> [Moments; CHOICES] {
    let over = 1.0 / BANDS as f32;
    let mut before: Option<[Bands; 2]> = None;
    std::array::from_fn(|choice| {
        let Some(halves) = all[choice] else { return Moments::default() };
        let variance = sources.variance(&halves);
        let mut m = Moments { samples: 1.0, variance, ..Moments::default() };
        if let Some(finer) = before {
            for band in 0..BANDS {
                let [x, y] = [0, 1].map(|h: usize| halves[h][band] - finer[h][band]);
                m.step += over * x * y;
                m.least_step += over * agreed(x, y);
            }
        }
        m.step_squared = m.step * m.step;
        before = Some(halves);
        m
    })
}

impl Cell {
    /// Take a sample, or a first one: moments are sums.
    fn add(&mut self, sample: &Cell) {
        let all = self.count + sample.count;
        self.place.join(self.count, &sample.place, sample.count);
        self.at = (self.at * self.count + sample.at * sample.count) / all;
        for (mine, m) in self.moments.iter_mut().zip(&sample.moments) {
            mine.samples += sample.count * m.samples;
            mine.variance += sample.count * m.variance;
            mine.step += sample.count * m.step;
            mine.least_step += sample.count * m.least_step;
            mine.step_squared += sample.count * sample.count * m.step_squared;
        }
        self.count = all;
    }
}

/// Squared error of each choice about a cell.
fn pooled(cell: &Cell, all: &[Cell], first: &[u32], size: [u32; 2]) -> Errors {
    let mut bias = 0.0f32;
    let mut finer = f32::INFINITY;
    std::array::from_fn(|choice| {
        let reach = POOL * radius(choice);
        let widely = reach.max(POOL_VARIANCE);
        let (mut variance, mut samples) = (0.0f32, 0.0f32);
        let mut wide = Steps::within(reach.max(POOL_LEAST));
        let mut near = Steps::within(POOL_NEAR);
        for row in rows(cell.at, widely, size) {
            for other in &all[first[row.start] as usize..first[row.end] as usize] {
                let away = other.at.distance_squared(cell.at);
                let inside = 1.0 - away / (widely * widely);
                if inside <= 0.0 {
                    continue;
                }
                let like = cell.place.likeness(&other.place, away.sqrt() + CELL as f32);
                let m = &other.moments[choice];
                let w = inside * inside * like;
                samples += w * m.samples;
                variance += w * m.variance;
                wide.add(away, like, m.samples, m.step, m.step_squared);
                near.add(away, like, m.samples, m.least_step, 0.0);
            }
        }
        if wide.n <= 0.0 || samples <= 0.0 {
            return [UNKNOWN; 2];
        }
        let variance = (variance / samples).min(finer);
        let before = std::mem::replace(&mut finer, variance);
        let together = together(choice.saturating_sub(1));
        let step = wide.credible(before, together, DOUBT).max(near.credible(before, together, DOUBT_NEAR));
        bias += BIAS_OF_STEP * step;
        [variance, bias]
    })
}

/// A mean of steps.
struct Steps {
    reach_squared: f32,
    n: f32,
    nn: f32,
    sum: f32,
    squares: f32,
}

impl Steps {
    fn within(reach: f32) -> Self {
        Self { reach_squared: reach * reach, n: 0.0, nn: 0.0, sum: 0.0, squares: 0.0 }
    }

    /// Sums over some samples, so far away and of this likeness.
    fn add(&mut self, away: f32, like: f32, samples: f32, sum: f32, squares: f32) {
        let inside = (1.0 - away / self.reach_squared).max(0.0);
        let w = inside * inside * like;
        self.n += w * samples;
        self.nn += w * w * samples;
        self.sum += w * sum;
        self.squares += w * w * squares;
    }

    /// The mean, as far as it is more than chance, where the finer choice has a variance of `before`.
    fn credible(&self, before: f32, together: f32, doubt: f32) -> f32 {
        if self.n <= 0.0 || self.sum <= 0.0 {
            return 0.0;
        }
        let mean = self.sum / self.n;
        // without bias a product is as large as the finer choice's halves differ, 2 var each; samples within its kernel hang together
        let independent = (self.n * self.n / self.nn / together).max(1.0);
        let by_chance = (2.0 * before).powi(2) / independent;
        let uncertain = by_chance.max(self.squares / (self.n * self.n));
        credible(mean, uncertain, doubt)
    }
}
