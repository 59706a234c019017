//! Surfaces: what each pixel shows, as patches: parts of a pixel that lie on one surface, each with where it is and how much of the
//! irradiance there the pixel takes.

use super::looks::look;
use super::patch::{CLEARANCE_MOST, Patch};
use crate::film::neighbours::around;
use crate::packed::PackedScene;
use crate::spectrum::scale;
use glam::Vec3;
use rayon::prelude::*;
use std::ops::Range;

/// Looks at a pixel whose neighbours show other surfaces …
const LOOKS: u32 = 32;
/// … and where these are seen through mirrors and glass, each look splits.
const LOOKS_THROUGH: u32 = 6;
/// What rises at less than this sine over a surface is taken for the surface itself.
const RISE: f32 = 0.15;
/// Pixels away at which one looks what rises there.
const STEPS: [i32; 8] = [1, 2, 3, 4, 6, 10, 16, 26];
/// Part of a pixel from which on it is all of it.
const WHOLE: f32 = 0.999;

/// The patches of all pixels.
#[derive(Debug)]
pub(super) struct Surfaces {
    /// First patch of each pixel, and the end.
    first: Vec<u32>,
    patches: Vec<Patch>,
}

impl Surfaces {
    /// Look at a scene through its camera.
    pub(super) fn look(scene: &PackedScene, seed: u32) -> Self {
        let pixels = scene.pixels() as u32;
        let first: Vec<Vec<Patch>> = (0..pixels)
            .into_par_iter()
            .map(|pixel| {
                // most pixels show one, and there are many
                let mut seen = Vec::with_capacity(1);
                look(scene, seed, pixel, 0, |patch| seen.push(patch));
                seen
            })
            .collect();
        let all: Vec<Vec<Patch>> = (0..pixels)
            .into_par_iter()
            .map(|pixel| {
                let mine = &first[pixel as usize];
                let is_like = |other: &Vec<Patch>| {
                    mine.len() == other.len() && mine.iter().zip(other).all(|(a, b)| a.goes_with(b, 2.0))
                };
                let alone = around(pixel, scene.size).all(|i| is_like(&first[i]));
                let is_through = mine.iter().any(|patch| patch.is_through);
                let looks = match (alone, is_through) {
                    (true, _) => 1,
                    (_, true) => LOOKS_THROUGH,
                    _ => LOOKS,
                };
                let mut patches: Vec<Patch> = Vec::with_capacity(mine.len());
                let mut take = |seen: Patch| match patches.iter_mut().find(|p| p.goes_with(&seen, 1.0)) {
                    Some(patch) => patch.take(&seen),
                    None => patches.push(seen),
                };
                mine.iter().for_each(|patch| take(*patch));
                (1..looks).for_each(|number| look(scene, seed, pixel, number, &mut take));
                for p in &mut patches {
                    p.weight = scale(&p.weight, 1.0 / looks as f32);
                    p.share /= looks as f32;
                    p.place.normal = p.place.normal.normalize_or(Vec3::Z);
                }
                patches
            })
            .collect();
        let mut surfaces = Self::of(all.into_iter());
        surfaces.find_clearances(scene.size);
        surfaces
    }

    /// Of the patches of each pixel.
    pub(super) fn of(pixels: impl Iterator<Item = Vec<Patch>>) -> Self {
        let mut surfaces = Self { first: vec![0], patches: Vec::new() };
        for patches in pixels {
            surfaces.patches.extend(patches);
            surfaces.first.push(surfaces.patches.len() as u32);
        }
        surfaces
    }

    /// Look around each pixel for what rises over its surfaces.
    fn find_clearances(&mut self, [width, height]: [u32; 2]) {
        let looks = &*self;
        let found: Vec<f32> = (0..width * height)
            .into_par_iter()
            .flat_map_iter(|pixel| {
                let (x, y) = ((pixel % width) as i32, (pixel / width) as i32);
                looks.at(pixel as usize).iter().map(move |patch| {
                    let mut nearest = f32::INFINITY;
                    for step in STEPS {
                        // what lies farther off in the image may still be nearer, but not by much
                        for (i, j) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
                            let (x, y) = (x + i * step, y + j * step);
                            if x < 0 || y < 0 || x >= width as i32 || y >= height as i32 {
                                continue;
                            }
                            for other in looks.at((y as u32 * width + x as u32) as usize) {
                                let d = other.place.position - patch.place.position;
                                let away = d.length();
                                if d.dot(patch.place.normal) > RISE * away {
                                    nearest = nearest.min(away);
                                }
                            }
                        }
                    }
                    (nearest / patch.place.footprint).max(2.0).log2().min(CLEARANCE_MOST)
                })
            })
            .collect();
        self.patches.iter_mut().zip(found).for_each(|(patch, clearance)| patch.place.clearance = clearance);
    }

    /// True for a pixel that shows more than one surface, or one in a part of it.
    pub(super) fn is_mixed(&self, pixel: usize) -> bool {
        !matches!(self.at(pixel), [patch] if patch.share > WHOLE)
    }

    /// Those of a pixel.
    pub(super) fn at(&self, pixel: usize) -> &[Patch] {
        &self.patches[self.ids(pixel)]
    }

    /// Number of the first patch of each pixel, and the end.
    pub(super) fn firsts(&self) -> &[u32] {
        &self.first
    }

    /// One by its number.
    pub(super) fn patch(&self, id: usize) -> &Patch {
        &self.patches[id]
    }

    /// Their numbers.
    pub(super) fn ids(&self, pixel: usize) -> Range<usize> {
        self.first[pixel] as usize..self.first[pixel + 1] as usize
    }
}
