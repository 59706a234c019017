//! Bandwidth: over how many pixels irradiance may be shared, by what that costs: variance from how the halves of the passes differ,
//! squared bias from what changes, in both halves alike, from one bandwidth to the next [E29].

use super::noise::{Noise, agreed};
use super::patch::{Patch, Place};
use super::pyramid::middle;
use super::regression::REACH;
use super::sources::{CHOICES, Choices, LAYERS, LEVELS, Sources};
use super::told::count;
use super::window::Window;
use crate::spectrum::{BANDS, Bands};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::ops::Range;

/// Width of a cell, pixels: statistics are kept for each.
const CELL: u32 = 8;
/// One pixel in so many is a sample of them, in each row and each column.
const STEP: u32 = 4;
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
/// A step of less than the square root of this in standard errors is no bias.
const DOUBT: f32 = 2.0;
/// Kernel pixels over blocks: the equivalent number of equal weights.
const KERNEL_BLOCKS: f32 = 10.9;

/// Pixels from the middle of a pixel to the end of the coarsest block that its kernels reach.
const KERNEL_ROWS: u32 = ((REACH + 1.0) * (1u32 << (LEVELS - 1)) as f32) as u32;
/// Rows of cells from one that statistics of it are taken from.
const POOL_CELLS: u32 = (POOL * REACH * (1u32 << (LEVELS - 1)) as f32) as u32 / CELL + 2;
/// Cells from a pixel's own that tell its errors.
const AT_CELLS: u32 = 2;

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
    /// Of each layer.
    moments: [[Moments; CHOICES]; LAYERS],
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
    /// What of it both halves agree on, and its square.
    least_step: f32,
    least_step_squared: f32,
}

/// Weighed squared errors of a choice at one place.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ChoiceError {
    pub(super) variance: f32,
    /// Squared bias that choices are compared by: a sum of steps, of which those that two choices have in common decide nothing.
    pub(super) bias: f32,
}

impl ChoiceError {
    /// Of a choice of which nothing is known.
    pub(super) const UNKNOWN: Self = Self { variance: UNKNOWN, bias: UNKNOWN };

    fn add(&mut self, other: &Self, weight: f32) {
        self.variance += weight * other.variance;
        self.bias += weight * other.bias;
    }
}

/// Of each choice.
pub(super) type Errors = [ChoiceError; CHOICES];

/// Squared errors of some rows of the image.
#[derive(Debug)]
pub(super) struct Bandwidths {
    size: [u32; 2],
    /// First surface of each cell, and the end.
    first: Window<u32>,
    cells: Window<Cell>,
    errors: Window<[Errors; LAYERS]>,
    /// Rows of cells whose errors are known.
    pooled: u32,
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
    (KERNEL_BLOCKS * (1u32 << (2 * (choice - 1))) as f32 / STEP as f32).max(1.0)
}

/// Radii in which a choice's steps and its variance are pooled.
fn reaches(choice: usize, noise: Noise) -> [f32; 2] {
    let reach = POOL * radius(choice);
    [reach.max(POOL_LEAST), reach.max(noise.pool())]
}

impl Bandwidths {
    /// Nothing known yet of an image.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let size = size.map(|n| n.div_ceil(CELL));
        let first = Window::from_iter([0]);
        Self { size, first, cells: Window::default(), errors: Window::default(), pooled: 0 }
    }

    /// Rows of cells that have their samples.
    fn sampled(&self) -> u32 {
        (self.first.end() - 1) as u32 / self.size[0]
    }

    /// Rows of pixels that can be asked for, of so many.
    pub(super) fn rows(&self, height: u32) -> u32 {
        if self.pooled == self.size[1] {
            height
        } else {
            (self.pooled * CELL).saturating_sub(AT_CELLS * CELL)
        }
    }

    /// Rows of pixels whose weights [`Bandwidths::look`] needs.
    pub(super) fn rows_to_sample(&self, told: u32, height: u32) -> u32 {
        if told == height { height } else { told.saturating_sub(KERNEL_ROWS) / CELL * CELL }
    }

    /// Look what each choice would give in the rows of pixels up to this one.
    pub(super) fn look(&mut self, sources: &Sources<'_>, rows: u32) {
        let across = self.size[0];
        let rows = if rows == sources.size[1] { self.size[1] } else { rows / CELL };
        let cells: Vec<Vec<Cell>> = (self.sampled() * across..rows * across)
            .into_par_iter()
            .map(|cell| sampled(sources, cell, across))
            .collect();
        let mut end = self.cells.end() as u32;
        let ends = cells.iter().map(|cells| {
            end += cells.len() as u32;
            end
        });
        self.first.extend(ends.collect());
        self.cells.extend(cells.into_iter().flatten().collect());
        self.pool(sources);
    }

    /// Errors as far as all samples around are known.
    fn pool(&mut self, sources: &Sources<'_>) {
        let sampled = self.sampled();
        let rows = if sampled == self.size[1] { sampled } else { sampled.saturating_sub(POOL_CELLS) };
        let rows = rows.max(self.pooled);
        let ids = [self.pooled, rows].map(|row| self.first[(row * self.size[0]) as usize] as usize);
        let errors = (ids[0]..ids[1]).into_par_iter().map(|id| {
            let near = Near::of(&self.cells[id], self);
            let mut errors = [[ChoiceError::UNKNOWN; CHOICES]; LAYERS];
            for (layer, errors) in errors.iter_mut().enumerate().take(sources.layers.len()) {
                *errors = near.pooled(layer, sources.noise(layer));
            }
            errors
        });
        self.errors.extend(errors.collect());
        self.pooled = rows;
    }

    /// Let go of what no pixel of this row, or of one that follows, asks for.
    pub(super) fn drop_before(&mut self, row: u32) {
        let keep = |row: u32, cells: u32| (row.saturating_sub(cells) * self.size[0]) as usize;
        let asked = keep(row / CELL, AT_CELLS);
        self.errors.drop_before(self.first[asked] as usize);
        let block = asked.min(keep(self.pooled, POOL_CELLS));
        self.cells.drop_before(self.first[block] as usize);
        self.first.drop_before(block);
    }

    /// Squared error of each choice for each layer at a patch; none where nothing is known of its surface.
    pub(super) fn at(&self, patch: &Patch, at: Vec2) -> Option<[Errors; LAYERS]> {
        let reach = 1.5 * CELL as f32;
        let (mut sum, mut errors) = (0.0, [[ChoiceError::default(); CHOICES]; LAYERS]);
        for row in rows(at, reach, self.size) {
            let ids = self.first[row.start] as usize..self.first[row.end] as usize;
            for (cell, mine) in self.cells.range(ids.clone()).zip(self.errors.range(ids)) {
                let away = cell.at.distance_squared(at);
                let near = 1.0 - away / (reach * reach);
                if near <= 0.0 {
                    continue;
                }
                let like = patch.place.likeness(&cell.place, away.sqrt());
                let w = near * near * like * cell.count;
                if w <= 0.0 {
                    continue;
                }
                sum += w;
                let errors = errors.as_flattened_mut().iter_mut();
                errors.zip(mine.as_flattened()).for_each(|(error, mine)| error.add(mine, w));
            }
        }
        let mean = |of: ChoiceError| {
            let mut mean = ChoiceError::default();
            mean.add(&of, 1.0 / sum);
            mean
        };
        (sum > 0.0).then(|| errors.map(|of_layer| of_layer.map(mean)))
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
    for y in y..(y + CELL).min(height) {
        // 0 2 1 3: each column has as many as each row
        let first = x + 2 * y % STEP + y / 2 % 2;
        for x in (first..(x + CELL).min(width)).step_by(STEP as usize) {
            let pixel = y * width + x;
            let count = count(sources.surfaces, pixel as usize);
            for id in sources.surfaces.ids(pixel as usize) {
                let patch = sources.surfaces.patch(id);
                let choices = sources.choices(pixel, id);
                let mut moments = [[Moments::default(); CHOICES]; LAYERS];
                for (layer, moments) in moments.iter_mut().enumerate().take(sources.layers.len()) {
                    *moments = moments_of(sources, layer, &choices, sources.weights[pixel as usize]);
                }
                let found = Cell {
                    place: patch.place,
                    at: middle(pixel, sources.size),
                    count: count * patch.share,
                    moments,
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

/// Of what is to choose from for a layer at one patch, whose squared errors weigh so much.
fn moments_of(sources: &Sources<'_>, layer: usize, choices: &Choices<'_>, weight: f32) -> [Moments; CHOICES] {
    let over = weight / BANDS as f32;
    let mut before: Option<[Bands; 2]> = None;
    std::array::from_fn(|choice| {
        let Some(halves) = choices.of(layer, choice) else { return Moments::default() };
        let variance = weight * sources.variance(layer, &halves);
        let mut m = Moments { samples: 1.0, variance, ..Moments::default() };
        if let Some(finer) = before {
            for band in 0..BANDS {
                let [x, y] = [0, 1].map(|h: usize| halves[h][band] - finer[h][band]);
                m.step += over * x * y;
                m.least_step += over * agreed(x, y);
            }
        }
        m.step_squared = m.step * m.step;
        m.least_step_squared = m.least_step * m.least_step;
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
        let moments = self.moments.as_flattened_mut().iter_mut();
        for (mine, m) in moments.zip(sample.moments.as_flattened()) {
            mine.samples += sample.count * m.samples;
            mine.variance += sample.count * m.variance;
            mine.step += sample.count * m.step;
            mine.least_step += sample.count * m.least_step;
            mine.step_squared += sample.count * sample.count * m.step_squared;
            mine.least_step_squared += sample.count * sample.count * m.least_step_squared;
        }
        self.count = all;
    }
}

/// Cells of the same surface about one.
struct Near<'a> {
    /// For each choice those within its largest reach that are within no finer one's: their squared distance, likeness, and moments.
    by_choice: [Vec<(f32, f32, &'a Cell)>; CHOICES],
}

impl<'a> Near<'a> {
    fn of(cell: &Cell, all: &'a Bandwidths) -> Self {
        let mut by_choice: [Vec<_>; CHOICES] = Default::default();
        let largest: [f32; CHOICES] = std::array::from_fn(|choice| {
            reaches(choice, Noise::Rare).into_iter().fold(0.0, f32::max).powi(2)
        });
        for row in rows(cell.at, largest[CHOICES - 1].sqrt(), all.size) {
            for other in all.cells.range(all.first[row.start] as usize..all.first[row.end] as usize) {
                let away = other.at.distance_squared(cell.at);
                let Some(choice) = largest.iter().position(|reach| away < *reach) else { continue };
                let like = cell.place.likeness(&other.place, away.sqrt() + CELL as f32);
                if like > 0.0 {
                    by_choice[choice].push((away, like, other));
                }
            }
        }
        Self { by_choice }
    }

    /// Squared error of each choice for a layer whose noise is of this kind.
    fn pooled(&self, layer: usize, noise: Noise) -> Errors {
        let (mut bias, mut finer) = (0.0f32, f32::INFINITY);
        std::array::from_fn(|choice| {
            let [reach, widely] = reaches(choice, noise);
            let (mut variance, mut samples) = (0.0f32, 0.0f32);
            let mut wide = Steps::within(reach);
            let mut near = Steps::within(POOL_NEAR);
            for &(away, like, other) in self.by_choice[..=choice].iter().flatten() {
                let m = &other.moments[layer][choice];
                let inside = (1.0 - away / (widely * widely)).max(0.0);
                let w = inside * inside * like;
                samples += w * m.samples;
                variance += w * m.variance;
                wide.add(away, like, m.samples, m.step, m.step_squared);
                near.add(away, like, m.samples, m.least_step, m.least_step_squared);
            }
            if wide.n <= 0.0 || samples <= 0.0 {
                return ChoiceError::UNKNOWN;
            }
            let variance = (variance / samples).min(finer);
            let before = std::mem::replace(&mut finer, variance);
            let together = together(choice.saturating_sub(1));
            let wide = wide.credible(noise, before, together, DOUBT);
            bias += BIAS_OF_STEP * wide.max(near.credible(noise, before, together, DOUBT_NEAR));
            ChoiceError { variance, bias }
        })
    }
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
    #[inline]
    fn add(&mut self, away: f32, like: f32, samples: f32, sum: f32, squares: f32) {
        let inside = (1.0 - away / self.reach_squared).max(0.0);
        let w = inside * inside * like;
        self.n += w * samples;
        self.nn += w * w * samples;
        self.sum += w * sum;
        self.squares += w * w * squares;
    }

    /// The mean, as far as it is more than chance, whose noise is of this kind, where the finer choice has a variance of `before`.
    fn credible(&self, noise: Noise, before: f32, together: f32, doubt: f32) -> f32 {
        if self.n <= 0.0 || self.sum <= 0.0 {
            return 0.0;
        }
        // without bias a product is as large as the finer choice's halves differ, 2 var each; samples within its kernel hang together
        let independent = (self.n * self.n / self.nn / together).max(1.0);
        let by_chance = (2.0 * before).powi(2) / independent;
        noise.credible(self.sum / self.n, by_chance, self.squares / (self.n * self.n), doubt)
    }
}
