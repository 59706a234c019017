//! Apart: a pixel of several surfaces knows the sum of their light alone. What neighbours tell of each takes it apart [E29].

use super::lit::Lit;
use super::patch::Patch;
use super::pyramid::{Level, Part, middle};
use super::regression::{Kernel, REACH};
use super::sources::LEVELS;
use super::surfaces::Surfaces;
use super::told::Values;
use super::window::Window;
use crate::spectrum::{BANDS, BLACK, Bands};
use rayon::prelude::*;
use std::collections::VecDeque;
use std::ops::Range;

/// A patch that is so large a part of its pixel is all that the pixel tells of.
const DOMINANT: f32 = 0.9;
/// Times that what neighbours tell is taken off.
const TURNS: usize = 4;
/// Level of blocks by which neighbours tell: kernels of 10 pixels.
const LEVEL: usize = 2;

/// Rows of a block of that level …
const BLOCK: u32 = 1 << LEVEL;
/// … and rows on each side of it that its pixels' kernels reach.
const REACH_ROWS: u32 = ((REACH * BLOCK as f32) as u32).next_multiple_of(BLOCK);

/// Levels of what pixels tell of each of their patches, from the mean radiance of each half of some layers. Each turn follows the one
/// before it, from the first row to the last.
#[derive(Debug)]
pub(super) struct Told {
    size: [u32; 2],
    pub(super) levels: Vec<Level>,
    /// Rows after each turn; of none, those that are known at all.
    done: [u32; TURNS + 1],
    /// What the nodes of [`LEVEL`] found before each turn, of each layer.
    before: [Vec<Window<Values>>; TURNS],
    /// What the nodes of the levels up to that are joined from, but for single pixels.
    parts: [Window<Part>; LEVEL],
    /// Pixels that turns change …
    shared: VecDeque<usize>,
    /// … and the nodes that hold them.
    changed: [Window<bool>; LEVEL + 1],
}

impl Told {
    /// Nothing yet of so many layers.
    pub(super) fn new(size: [u32; 2], layers: usize) -> Self {
        Self {
            size,
            levels: (0..LEVELS).map(|level| Level::new(1 << level, size, layers)).collect(),
            done: [0; TURNS + 1],
            before: std::array::from_fn(|_| (0..layers).map(|_| Window::default()).collect()),
            parts: Default::default(),
            shared: VecDeque::new(),
            changed: Default::default(),
        }
    }

    /// Rows of pixels that all levels are known of.
    pub(super) fn rows(&self) -> u32 {
        let coarsest = &self.levels[LEVELS - 1];
        (coarsest.rows() * coarsest.width).min(self.size[1])
    }

    /// Go on by so many rows, as far as surfaces are known.
    pub(super) fn go_on(&mut self, surfaces: &Surfaces, layers: &[Lit<'_>], strip: u32) {
        let height = self.size[1];
        if self.done[TURNS] == height {
            return;
        }
        self.tell_alike(surfaces, layers, strip);
        for turn in 0..TURNS {
            let ready = if self.done[turn] == height {
                height
            } else {
                self.done[turn].saturating_sub(REACH_ROWS) / BLOCK * BLOCK
            };
            if ready > self.done[turn + 1] {
                self.turn(turn, ready, surfaces, layers);
                self.done[turn + 1] = ready;
            }
        }
        for coarse in LEVEL + 1..LEVELS {
            let (finer, coarser) = self.levels.split_at_mut(coarse);
            let rows =
                if coarse == LEVEL + 1 { self.done[TURNS] } else { finer[coarse - 1].pixel_rows(height) };
            let joined = coarser[0].join(&finer[coarse - 1], surfaces, rows, height);
            coarser[0].take_values(joined.values);
        }
        // what no turn asks for any more
        if self.done[TURNS] == height {
            (self.parts, self.changed, self.shared) = Default::default();
            self.before.iter_mut().flatten().for_each(|values| *values = Window::default());
            return;
        }
        let row = self.done[TURNS].saturating_sub(REACH_ROWS);
        let begins: [usize; LEVEL + 1] = std::array::from_fn(|level| {
            let level = &self.levels[level];
            level.ids_of_rows(row / level.width..level.rows()).start
        });
        let gone = self.shared.partition_point(|pixel| *pixel < (row * self.size[0]) as usize);
        self.shared.drain(..gone);
        self.parts.iter_mut().zip(begins).for_each(|(parts, begin)| parts.drop_before(begin));
        self.changed.iter_mut().zip(begins).for_each(|(changed, begin)| changed.drop_before(begin));
        self.before.iter_mut().flatten().for_each(|values| values.drop_before(begins[LEVEL]));
    }

    /// Let go of what no kernel about this row, or one that follows, reaches. The first row whose pixels are.
    pub(super) fn drop_before(&mut self, row: u32) -> u32 {
        let first = |level: &Level| row.saturating_sub((REACH * level.width as f32) as u32 + 1);
        self.levels.iter_mut().for_each(|level| level.drop_before(first(level)));
        first(&self.levels[0])
    }

    /// Take more rows, patches of a pixel alike.
    fn tell_alike(&mut self, surfaces: &Surfaces, layers: &[Lit<'_>], strip: u32) {
        let [width, height] = self.size;
        let known = surfaces.rows().min(self.done[0].saturating_add(strip));
        let rows = if known == height { height } else { known / BLOCK * BLOCK };
        let pixels = (self.done[0] * width) as usize..(rows * width) as usize;
        self.levels[0].take_pixels(surfaces, layers, rows);
        let shared: Vec<usize> = pixels.into_par_iter().filter(|pixel| is_shared(surfaces, *pixel)).collect();
        let begin = self.changed[0].end();
        let mut changed = vec![false; self.levels[0].ids_end() - begin];
        shared.iter().flat_map(|pixel| surfaces.ids(*pixel)).for_each(|id| changed[id - begin] = true);
        self.changed[0].extend(changed);
        self.shared.extend(shared);
        for coarse in 1..=LEVEL {
            let (finer, coarser) = self.levels.split_at_mut(coarse);
            let begin = self.changed[coarse].end();
            let joined = coarser[0].join(&finer[coarse - 1], surfaces, rows, height);
            let mut changed = vec![false; coarser[0].ids_end() - begin];
            for part in &joined.parts {
                changed[part.of as usize - begin] |= self.changed[coarse - 1][part.id as usize];
            }
            self.changed[coarse].extend(changed);
            self.parts[coarse - 1].extend(joined.parts);
            if coarse < LEVEL {
                coarser[0].take_values(joined.values);
            } else {
                self.before[0]
                    .iter_mut()
                    .zip(joined.values)
                    .for_each(|(before, values)| before.extend(values));
            }
        }
        self.done[0] = rows;
    }

    /// Take a turn's rows up to this one apart.
    fn turn(&mut self, turn: usize, end: u32, surfaces: &Surfaces, layers: &[Lit<'_>]) {
        let size = self.size;
        let rows = self.done[turn + 1]..end;
        let (level, pixels, before) = (&self.levels[LEVEL], &self.levels[0], &self.before[turn]);
        let shared: Vec<usize> = {
            let at = |row: u32| self.shared.partition_point(|pixel| *pixel < (row * size[0]) as usize);
            self.shared.range(at(rows.start)..at(rows.end)).copied().collect()
        };
        let apart = |pixel: &usize| {
            let kernel = |patch| Kernel::at(level, surfaces, patch, middle(*pixel as u32, size));
            let kernels: Vec<Option<Kernel>> = surfaces.at(*pixel).map(kernel).collect();
            let of = |(layer, lit): (usize, &Lit<'_>)| {
                let near = |(kernel, id): (&Option<Kernel>, usize)| {
                    kernel.as_ref().map_or_else(|| pixels.of(layer, id), |k| k.of(&before[layer]))
                };
                let near = kernels.iter().zip(surfaces.ids(*pixel)).map(near).collect();
                apart(surfaces.at(*pixel), lit.halves(*pixel), near)
            };
            layers.iter().enumerate().map(of).collect::<Vec<_>>()
        };
        let found: Vec<Vec<Vec<[Bands; 2]>>> = shared.par_iter().map(apart).collect();
        for (pixel, found) in shared.iter().zip(found) {
            for (layer, found) in found.iter().enumerate() {
                surfaces
                    .ids(*pixel)
                    .zip(found)
                    .for_each(|(id, halves)| self.levels[0].set(layer, id, halves));
            }
        }
        self.renew(turn, rows);
    }

    /// What coarser nodes of some rows found, after a turn.
    fn renew(&mut self, turn: usize, rows: Range<u32>) {
        for coarse in 1..=LEVEL {
            let (finer, coarser) = self.levels.split_at_mut(coarse);
            let (finer, coarser) = (&finer[coarse - 1], &mut coarser[0]);
            let of =
                |level: &Level| level.ids_of_rows(rows.start / level.width..rows.end.div_ceil(level.width));
            let (parts, ids) = (of(finer), of(coarser));
            let (all_parts, changed) = (&self.parts[coarse - 1], &self.changed[coarse]);
            let parts = || all_parts.range(parts.clone()).filter(|part| changed[part.of as usize]);
            for layer in 0..coarser.values.len() {
                if coarse < LEVEL {
                    let mut values = std::mem::take(&mut coarser.values[layer]);
                    ids.clone().filter(|id| changed[*id]).for_each(|id| values[id] = Values::default());
                    for part in parts() {
                        coarser.add_part(&mut values[part.of as usize], part, finer.values(layer));
                    }
                    coarser.values[layer] = values;
                    continue;
                }
                let old = self.before[turn][layer].range(ids.clone()).zip(ids.clone());
                let new = old.map(|(value, id)| if changed[id] { Values::default() } else { *value });
                let mut values: Vec<Values> = new.collect();
                for part in parts() {
                    coarser.add_part(&mut values[part.of as usize - ids.start], part, finer.values(layer));
                }
                match self.before.get_mut(turn + 1) {
                    Some(next) => next[layer].extend(values),
                    None => coarser.values[layer].extend(values),
                }
            }
        }
    }
}

/// True for a pixel that shows more than one surface, and none nearly alone.
fn is_shared(surfaces: &Surfaces, pixel: usize) -> bool {
    surfaces.ids(pixel).len() > 1 && surfaces.at(pixel).all(|patch| patch.share < DOMINANT)
}

/// What a pixel of this radiance tells of its patches, where `near` is what neighbours tell of them: the nearest to that, by least
/// squares, that adds up to the pixel's own.
fn apart<'a>(
    patches: impl Iterator<Item = &'a Patch> + Clone,
    radiance: [Bands; 2],
    near: Vec<[Bands; 2]>,
) -> Vec<[Bands; 2]> {
    let mut told = near;
    for (h, mut rest) in radiance.into_iter().enumerate() {
        let mut squares = BLACK;
        for (patch, told) in patches.clone().zip(&told) {
            for b in 0..BANDS {
                rest[b] -= patch.weight[b] * told[h][b];
                squares[b] += patch.weight[b] * patch.weight[b];
            }
        }
        for (patch, told) in patches.clone().zip(&mut told) {
            for b in (0..BANDS).filter(|b| squares[*b] > 0.0) {
                told[h][b] += rest[b] * patch.weight[b] / squares[b];
            }
        }
    }
    told
}
