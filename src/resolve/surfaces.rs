//! Surfaces: what each pixel shows, as patches: parts of a pixel that lie on one surface, each with where it is and how much of the
//! irradiance there the pixel takes. Found by camera paths that are no part of the picture.

use crate::film::neighbours::around;
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::{CameraRay, PackedScene};
use crate::sampling::rng::purpose::{DIMENSION_PATCH, STREAM_PATCH};
use crate::sampling::rng::{pcg4d, random4};
use crate::spectrum::{BANDS, Bands, add, mul, scale};
use glam::Vec3;
use rayon::prelude::*;

/// Camera paths of a pixel whose neighbours show the same surface, and of the others.
const LOOKS: [u32; 2] = [1, 16];
/// Cosine between normals at which likeness ends.
const LEAST_COS: f32 = 0.8;
/// Difference between clearances at which it ends.
const CLEARANCE_RANGE: f32 = 1.6;
/// Heights over the place's plane at which it ends, in widths of a pixel: at the place, and more per pixel of distance.
const HEIGHT: [f32; 2] = [0.5, 0.15];
/// Clearances from here on are alike.
const CLEARANCE_MOST: f32 = 5.0;
/// What rises at less than this sine over a surface is taken for the surface itself.
const RISE: f32 = 0.15;
/// Pixels away at which one looks what rises there.
const STEPS: [i32; 8] = [1, 2, 3, 4, 6, 10, 16, 26];
/// Longest specular chain that is followed.
const CHAIN: u32 = 24;
/// Part of a pixel from which on it is all of it.
const WHOLE: f32 = 0.999;
/// Cosine between the normals of points that may be of one patch.
const PATCH_COS: f32 = 0.95;
/// Their distance from each other's plane, in widths of a pixel.
const PATCH_HEIGHT: f32 = 1.0;

/// A place on a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Internal units.
    pub(super) position: Vec3,
    /// Unit shading normal toward the eye.
    pub(super) normal: Vec3,
    /// Width of a pixel there.
    pub(super) footprint: f32,
    /// Places of other kinds have nothing in common: other ways through mirrors and glass, other lobes that depend on directions.
    pub(super) kind: u32,
    /// Distance to the nearest surface in view that rises over this one, log2 of widths of a pixel.
    pub(super) clearance: f32,
}

/// A part of a pixel that shows one surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// Its middle.
    pub(super) place: Place,
    /// The pixel's radiance per irradiance: throughput times albedo, in the mean over all of the pixel.
    pub(super) weight: Bands,
    /// Part of the pixel.
    pub(super) share: f32,
}

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
        let first: Vec<Option<Patch>> =
            (0..pixels).into_par_iter().map(|pixel| seen(scene, seed, pixel, 0)).collect();
        let all: Vec<Vec<Patch>> = (0..pixels)
            .into_par_iter()
            .map(|pixel| {
                let mine = first[pixel as usize];
                let alone = around(pixel, scene.size).all(|i| match (&mine, &first[i]) {
                    (None, None) => true,
                    (Some(a), Some(b)) => a.goes_with(b, 2.0),
                    _ => false,
                });
                let looks = LOOKS[usize::from(!alone)];
                let mut patches: Vec<Patch> = Vec::new();
                for number in 0..looks {
                    let Some(seen) = (if number == 0 { mine } else { seen(scene, seed, pixel, number) })
                    else {
                        continue;
                    };
                    match patches.iter_mut().find(|p| p.goes_with(&seen, 1.0)) {
                        Some(patch) => patch.take(&seen),
                        None => patches.push(seen),
                    }
                }
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
        &self.patches[self.first[pixel] as usize..self.first[pixel + 1] as usize]
    }
}

impl Place {
    /// The mean of `count` places and one more; the normal is their sum.
    pub(super) fn join(&mut self, count: f32, other: &Place, others: f32) {
        let all = count + others;
        let (mine, theirs) = (count / all, others / all);
        self.position = self.position * mine + other.position * theirs;
        self.normal = self.normal * mine + other.normal * theirs;
        self.footprint = self.footprint * mine + other.footprint * theirs;
        self.clearance = self.clearance * mine + other.clearance * theirs;
    }

    /// Weight of what lies at another place, so many pixels away in the image, for this one: 1 on the same plane, 0 on another surface.
    #[inline]
    pub(super) fn likeness(&self, other: &Place, pixels: f32) -> f32 {
        if self.kind != other.kind {
            return 0.0;
        }
        let clear = 1.0 - (self.clearance - other.clearance).abs() * (1.0 / CLEARANCE_RANGE);
        let facing = (self.normal.dot(other.normal) - LEAST_COS) * (1.0 / (1.0 - LEAST_COS));
        if clear <= 0.0 || facing <= 0.0 {
            return 0.0;
        }
        let height = (other.position - self.position).dot(self.normal).abs();
        let relative = height / (self.footprint * (HEIGHT[0] + HEIGHT[1] * pixels));
        clear * facing * (1.0 - relative).max(0.0)
    }
}

impl Patch {
    /// True for patches of one surface, so many pixels apart.
    fn goes_with(&self, other: &Patch, pixels: f32) -> bool {
        let (mine, theirs) = (&self.place, &other.place);
        let d = theirs.position - mine.position;
        mine.kind == theirs.kind
            && mine.normal.normalize().dot(theirs.normal) > PATCH_COS
            && d.dot(theirs.normal).abs() < PATCH_HEIGHT * pixels * theirs.footprint
    }

    /// One place more.
    fn take(&mut self, other: &Patch) {
        self.place.join(self.share, &other.place, 1.0);
        self.weight = add(&self.weight, &other.weight);
        self.share += 1.0;
    }
}

/// Where a camera path of a pixel ends; the first goes through its middle.
fn seen(scene: &PackedScene, seed: u32, pixel: u32, number: u32) -> Option<Patch> {
    let CameraRay { origin, direction, travelled: mut length } = if number == 0 {
        let [width, height] = scene.size;
        let at = |i: u32, n: u32| (i as f32 + 0.5) / n as f32;
        scene.camera.ray([at(pixel % width, width), at(pixel / width, height)])
    } else {
        scene.sample_camera(pixel, number.into(), seed, STREAM_PATCH)
    };
    let mut ray = Ray::new(origin, direction);
    let mut throughput = [1.0; BANDS];
    let mut kind = [0; 4];
    for event in 0..CHAIN {
        let s = SurfaceInteraction::hit(scene, &ray)?;
        length += s.distance;
        let bsdf = Bsdf::at(&s);
        let shares = bsdf.shares(&throughput);
        let kept = shares.kept();
        if kept <= 0.0 {
            return None;
        }
        let [u_way, u0, u1, _] = random4(seed, number, pixel, DIMENSION_PATCH + event);
        let choice = u_way * kept;
        if choice < shares.scatter {
            if bsdf.scatter.varies() {
                kind = pcg4d([kind[0], s.triangle.material + 1, 1, 0]);
            }
            let weight = scale(&mul(&throughput, &bsdf.scatter.albedo()), kept / shares.scatter);
            let place = Place {
                position: s.position,
                normal: s.ns,
                footprint: length * scene.pixel_angle(),
                kind: kind[0],
                clearance: CLEARANCE_MOST,
            };
            return Some(Patch { place, weight, share: 1.0 });
        }
        let lobe = shares.pick_delta(choice - shares.scatter);
        let direction = bsdf.sample_delta(lobe, [u0, u1])?;
        throughput = scale(&bsdf.through_delta(lobe, &throughput), kept / shares.delta[lobe]);
        kind = pcg4d([kind[0], lobe as u32, s.triangle.material, 2]);
        ray = s.leave(direction);
    }
    None
}
