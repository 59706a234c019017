//! Apart: a pixel of several surfaces knows the sum of their light alone. What neighbours tell of each takes it apart [E29].

use super::patch::Patch;
use super::pyramid::{Level, middle};
use super::regression::Kernel;
use super::surfaces::Surfaces;
use crate::spectrum::{BANDS, BLACK, Bands};
use rayon::prelude::*;

/// A patch that is so large a part of its pixel is all that the pixel tells of.
const DOMINANT: f32 = 0.9;
/// Times that what neighbours tell is taken off.
const TURNS: u32 = 4;
/// Level of blocks by which neighbours tell: kernels of 10 pixels.
const LEVEL: usize = 2;

/// The finest levels of what pixels tell of each of their patches, from the mean radiance of each half of some layers.
pub(super) fn told(size: [u32; 2], surfaces: &Surfaces, layers: &[[&[Bands]; 2]]) -> Vec<Level> {
    let mut levels = vec![Level::of_pixels(size, surfaces, layers)];
    (0..LEVEL).for_each(|finer| levels.push(levels[finer].coarser()));
    let is_shared = |pixel: &usize| {
        let patches = surfaces.at(*pixel);
        patches.len() > 1 && patches.iter().all(|patch| patch.share < DOMINANT)
    };
    let shared: Vec<usize> = (0..(size[0] * size[1]) as usize).filter(is_shared).collect();
    if shared.is_empty() {
        return levels;
    }
    let mut changed = vec![vec![false; *surfaces.firsts().last().unwrap_or(&0) as usize]];
    shared.iter().flat_map(|pixel| surfaces.ids(*pixel)).for_each(|id| changed[0][id] = true);
    (0..LEVEL).for_each(|finer| changed.push(levels[finer + 1].holders(&changed[finer])));
    for _ in 0..TURNS {
        let (level, pixels) = (&levels[LEVEL], &levels[0]);
        let apart = |pixel: &usize| {
            let kernel = |patch| Kernel::at(level, patch, middle(*pixel as u32, size));
            let kernels: Vec<Option<Kernel>> = surfaces.at(*pixel).iter().map(kernel).collect();
            let of = |(layer, halves): (usize, &[&[Bands]; 2])| {
                let near = |(kernel, id): (&Option<Kernel>, usize)| {
                    kernel.as_ref().map_or_else(|| pixels.of(layer, id), |k| k.of(level.values(layer)))
                };
                let near = kernels.iter().zip(surfaces.ids(*pixel)).map(near).collect();
                apart(surfaces.at(*pixel), halves.map(|half| half[*pixel]), near)
            };
            layers.iter().enumerate().map(of).collect::<Vec<_>>()
        };
        let found: Vec<Vec<Vec<[Bands; 2]>>> = shared.par_iter().map(apart).collect();
        for (pixel, found) in shared.iter().zip(found) {
            for (layer, found) in found.iter().enumerate() {
                surfaces.ids(*pixel).zip(found).for_each(|(id, halves)| levels[0].set(layer, id, halves));
            }
        }
        for coarse in 1..=LEVEL {
            let (finer, coarser) = levels.split_at_mut(coarse);
            coarser[0].take_from(&finer[coarse - 1], Some(&changed[coarse]));
        }
    }
    levels
}

/// What a pixel of this radiance tells of its patches, where `near` is what neighbours tell of them: the nearest to that, by least
/// squares, that adds up to the pixel's own.
fn apart(patches: &[Patch], radiance: [Bands; 2], near: Vec<[Bands; 2]>) -> Vec<[Bands; 2]> {
    let mut told = near;
    for (h, mut rest) in radiance.into_iter().enumerate() {
        let mut squares = BLACK;
        for (patch, told) in patches.iter().zip(&told) {
            for b in 0..BANDS {
                rest[b] -= patch.weight[b] * told[h][b];
                squares[b] += patch.weight[b] * patch.weight[b];
            }
        }
        for (patch, told) in patches.iter().zip(&mut told) {
            for b in (0..BANDS).filter(|b| squares[*b] > 0.0) {
                told[h][b] += rest[b] * patch.weight[b] / squares[b];
            }
        }
    }
    told
}
