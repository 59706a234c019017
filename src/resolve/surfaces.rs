//! Surfaces: what each pixel shows, as patches: parts of a pixel that lie on one surface, each with where it is and how much of the
//! irradiance there the pixel takes.

use super::looks::look;
use super::patch::{CLEARANCE_MOST, Patch};
use super::window::Window;
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
/// Looks at a pixel that shows one surface with a texture: its passes see all of the pixel, and its albedo is their mean.
const LOOKS_TEXTURED: u32 = 8;
/// What rises at less than this sine over a surface is taken for the surface itself.
const RISE: f32 = 0.15;
/// Pixels away at which one looks what rises there.
const STEPS: [i32; 8] = [1, 2, 3, 4, 6, 10, 16, 26];
/// Part of a pixel from which on it is all of it.
const WHOLE: f32 = 0.999;

/// The patches of the pixels of some rows.
#[derive(Debug)]
pub(super) struct Surfaces {
    size: [u32; 2],
    /// First patch of each pixel, and the end.
    first: Window<u32>,
    patches: Window<Patch>,
    /// What the middle of each pixel shows, one row farther.
    middles: Window<Vec<Patch>>,
    /// Rows up to here have their clearances.
    cleared: u32,
}

impl Surfaces {
    /// Nothing seen yet of an image.
    pub(super) fn new(size: [u32; 2]) -> Self {
        let first = Window::from_iter([0]);
        Self { size, first, patches: Window::default(), middles: Window::default(), cleared: 0 }
    }

    /// Of the patches of each pixel.
    #[cfg(test)]
    pub(super) fn of(size: [u32; 2], pixels: impl Iterator<Item = Vec<Patch>>) -> Self {
        let mut surfaces = Self::new(size);
        surfaces.take(pixels.collect());
        surfaces.cleared = size[1];
        surfaces
    }

    /// Pixels across and down in the image.
    #[cfg(test)]
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Rows of which all is known.
    pub(super) fn rows(&self) -> u32 {
        self.cleared
    }

    /// Look at so many rows more of a scene through its camera.
    pub(super) fn look(&mut self, scene: &PackedScene, seed: u32, rows: u32) {
        let [_, height] = self.size;
        let end = self.see(scene, seed, rows);
        let cleared = if end == height { height } else { end.saturating_sub(STEPS[STEPS.len() - 1] as u32) };
        self.find_clearances(cleared);
    }

    /// Look at so many rows from one on, and forget them. How many there were.
    pub(super) fn glance(scene: &PackedScene, seed: u32, row: u32, rows: u32) -> u32 {
        let (size, pixel) = (scene.size, (row * scene.size[0]) as usize);
        let middles = Window::at(pixel.saturating_sub(size[0] as usize));
        let mut first = Window::at(pixel);
        first.extend(vec![0]);
        Self { middles, first, ..Self::new(size) }.see(scene, seed, rows) - row
    }

    /// Take the patches of so many rows more; up to which row they are known then.
    fn see(&mut self, scene: &PackedScene, seed: u32, rows: u32) -> u32 {
        let [width, height] = self.size;
        let before = (self.first.end() - 1) as u32 / width;
        let end = (before + rows).min(height);
        let middles = self.middles.end() as u32..(end + 1).min(height) * width;
        let middles = middles.into_par_iter().map(|pixel| {
            // most pixels show one, and there are many
            let mut seen = Vec::with_capacity(1);
            look(scene, seed, pixel, 0, |patch| seen.push(patch));
            seen
        });
        self.middles.extend(middles.collect());
        let seen = &*self;
        let patches =
            (before * width..end * width).into_par_iter().map(|pixel| seen.of_pixel(scene, seed, pixel));
        self.take(patches.collect());
        self.middles.drop_before((end.saturating_sub(1) * width) as usize);
        end
    }

    /// What a pixel shows, from what it and those around it show in their middles.
    fn of_pixel(&self, scene: &PackedScene, seed: u32, pixel: u32) -> Vec<Patch> {
        let mine = &self.middles[pixel as usize];
        let is_like = |other: &Vec<Patch>| {
            mine.len() == other.len() && mine.iter().zip(other).all(|(a, b)| a.goes_with(b, 2.0))
        };
        let alone = around(pixel, self.size).all(|i| is_like(&self.middles[i]));
        let is_through = mine.iter().any(|patch| patch.is_through);
        let is_textured = mine.iter().any(|patch| patch.is_textured);
        let looks = match (alone, is_through) {
            (true, _) if is_textured => LOOKS_TEXTURED,
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
    }

    /// Take the patches of the pixels that follow.
    fn take(&mut self, pixels: Vec<Vec<Patch>>) {
        let mut end = self.patches.end() as u32;
        let ends = pixels.iter().map(|patches| {
            end += patches.len() as u32;
            end
        });
        self.first.extend(ends.collect());
        self.patches.extend(pixels.into_iter().flatten().collect());
    }

    /// Let go of all rows before this one.
    pub(super) fn drop_before(&mut self, row: u32) {
        let pixel = (row * self.size[0]) as usize;
        self.patches.drop_before(self.first[pixel] as usize);
        self.first.drop_before(pixel);
    }

    /// Look around each pixel of the rows up to this one for what rises over its surfaces.
    fn find_clearances(&mut self, rows: u32) {
        let ([width, height], looks) = (self.size, &*self);
        let found: Vec<f32> = (self.cleared * width..rows * width)
            .into_par_iter()
            .flat_map_iter(|pixel| {
                let (x, y) = ((pixel % width) as i32, (pixel / width) as i32);
                looks.at(pixel as usize).map(move |patch| {
                    let mut nearest = f32::INFINITY;
                    for step in STEPS {
                        // what lies farther off in the image may still be nearer, but not by much
                        for (i, j) in [(1, 0), (1, 1), (0, 1), (-1, 1), (-1, 0), (-1, -1), (0, -1), (1, -1)] {
                            let (x, y) = (x + i * step, y + j * step);
                            if x < 0 || y < 0 || x >= width as i32 || y >= height as i32 {
                                continue;
                            }
                            for id in looks.ids((y as u32 * width + x as u32) as usize) {
                                let other = looks.patch(id);
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
        let [begin, end] = [self.cleared, rows].map(|row| self.first[(row * width) as usize] as usize);
        let patches = self.patches.range_mut(begin..end);
        patches.zip(found).for_each(|(patch, clearance)| patch.place.clearance = clearance);
        self.cleared = rows;
    }

    /// True for a pixel that shows more than one surface, or one in a part of it.
    pub(super) fn is_mixed(&self, pixel: usize) -> bool {
        let ids = self.ids(pixel);
        ids.len() != 1 || self.patches[ids.start].share <= WHOLE
    }

    /// Those of a pixel.
    pub(super) fn at(&self, pixel: usize) -> impl Iterator<Item = &Patch> + Clone {
        self.patches.range(self.ids(pixel))
    }

    /// Number of the first patch of each pixel of some, and the end.
    pub(super) fn firsts(&self, pixels: Range<usize>) -> impl Iterator<Item = u32> {
        self.first.range(pixels.start..pixels.end + 1).copied()
    }

    /// One by its number.
    #[inline]
    pub(super) fn patch(&self, id: usize) -> &Patch {
        &self.patches[id]
    }

    /// Their numbers.
    #[inline]
    pub(super) fn ids(&self, pixel: usize) -> Range<usize> {
        self.first[pixel] as usize..self.first[pixel + 1] as usize
    }
}
