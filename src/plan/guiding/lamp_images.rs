//! Lamp images: the pixels in which curved mirrors and glass may show a lamp smaller than camera rays would find it.
//!
//! A surface that shows a lamp small sends its light into all directions. Some of the jotons that leave it pass by the eye
//! not far off, and close to where they do so there may be a place whose light meets the eye. It is looked for by small
//! changes of the direction in which such a joton sets out, each of which is kept where the joton then passes nearer.

use super::lamp::{Lamp, lamps};
use crate::optics::lights::sample_le_aimed;
use crate::optics::lights::samples::Start;
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::packed::PackedScene;
use crate::plan::guiding::visible_points::{CHAIN, step};
use crate::sampling::rng::purpose::{
    DIMENSION_LAMP_CHANGES, DIMENSION_LAMP_IMAGES, STREAM_LAMP_IMAGES_DIRECTION, STREAM_LAMP_IMAGES_PLACE,
};
use crate::sampling::rng::{random4, sequence_seed, sobol2};
use glam::Vec3;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Jotons that are traced first.
const JOTONS: u32 = 1 << 13;
/// A joton passes near the eye where its direction differs from the one to the eye by less than this.
const NEAR: f32 = 0.3;
/// It meets the eye where they differ by less than this.
const MET: f32 = 0.01;
/// Of the jotons that pass it from one pixel the nearest is changed; in so many pixels, at most.
const PIXELS: usize = 256;
/// Changes that are tried of each.
const CHANGES: u32 = 192;
/// The first change moves each random number of the start by this, at most.
const FIRST_CHANGE: f32 = 0.05;
/// After a change that brings the joton no nearer the next is smaller by this factor.
const SMALLER: f32 = 0.97;

/// A joton that passes by the eye.
#[derive(Clone, Copy)]
struct Pass {
    lamp: u32,
    number: u32,
    /// Random numbers of the place that it starts from, and of its direction.
    place: [f32; 2],
    towards: [f32; 2],
    /// The pixel that sees the place from which it passes the eye.
    pixel: u32,
    /// Difference of its unit direction to the one toward the eye.
    off: f32,
}

/// Pixels that show such images, in ascending order, as far as they are found.
pub(in crate::plan) fn lamp_images(scene: &PackedScene, seed: u32) -> Vec<u32> {
    // camera rays never meet a light without area
    let has_area = |lamp: &Lamp| lamp.emitters(scene)[0].has_area();
    let lamps: Vec<Lamp> = lamps(&scene.emitters).into_iter().filter(has_area).collect();
    let total: f64 = lamps.iter().map(Lamp::flux).sum();
    if scene.targets.is_empty() || total <= 0.0 {
        return Vec::new();
    }
    let search = Search { scene, seed, lamps };
    let first: Vec<Pass> = (0..search.lamps.len())
        .into_par_iter()
        .flat_map(|lamp| {
            let share = search.lamps[lamp].flux() / total;
            let count = (f64::from(JOTONS) * share).ceil() as u32;
            let search = &search;
            (0..count).into_par_iter().filter_map(move |number| search.start(lamp as u32, number))
        })
        .collect();
    let mut nearest: BTreeMap<u32, Pass> = BTreeMap::new();
    for pass in first {
        let held = nearest.entry(pass.pixel).or_insert(pass);
        if pass.off < held.off {
            *held = pass;
        }
    }
    let starts: Vec<Pass> = nearest.into_values().collect();
    let every = starts.len().div_ceil(PIXELS).max(1);
    let mut pixels: Vec<u32> =
        starts.par_iter().step_by(every).filter_map(|pass| search.approach(*pass)).collect();
    pixels.sort_unstable();
    pixels.dedup();
    pixels
}

struct Search<'a> {
    scene: &'a PackedScene,
    seed: u32,
    lamps: Vec<Lamp>,
}

impl Search<'_> {
    /// Joton `number` of a lamp, where it passes near the eye.
    fn start(&self, lamp: u32, number: u32) -> Option<Pass> {
        let draw = |stream: u32| sobol2(number, sequence_seed(self.seed, lamp, stream));
        let (place, towards) = (draw(STREAM_LAMP_IMAGES_PLACE), draw(STREAM_LAMP_IMAGES_DIRECTION));
        let pass = Pass { lamp, number, place, towards, pixel: 0, off: NEAR };
        self.nearest(pass)
    }

    /// The pixel in which small changes make a joton meet the eye, if they do.
    fn approach(&self, mut best: Pass) -> Option<u32> {
        let mut change = FIRST_CHANGE;
        for i in 0..CHANGES {
            let u = random4(self.seed, best.lamp, best.number, DIMENSION_LAMP_CHANGES + i);
            let moved = |x: f32, u: f32| (x + change * (2.0 * u - 1.0)).clamp(0.0, 1.0 - f32::EPSILON);
            let changed = Pass {
                place: [moved(best.place[0], u[0]), moved(best.place[1], u[1])],
                towards: [moved(best.towards[0], u[2]), moved(best.towards[1], u[3])],
                ..best
            };
            match self.nearest(changed) {
                Some(nearer) => best = nearer,
                None => change *= SMALLER,
            }
        }
        (best.off < MET).then_some(best.pixel)
    }

    /// The same joton where it now passes nearer to the eye than `pass.off`; none where it does not. It takes the same events,
    /// as long as their probabilities change little.
    fn nearest(&self, mut pass: Pass) -> Option<Pass> {
        let scene = self.scene;
        let (number, rest, pick) = self.lamps[pass.lamp as usize].pick(pass.place[0]);
        let emitter = &scene.emitters[number];
        let Start { origin, direction, mut flux, .. } =
            sample_le_aimed(scene, emitter, [rest, pass.place[1]], pass.towards, 1.0 / pick)?;
        let mut ray = Ray::new(origin, direction).within(scene.media.of_emitter(number));
        let mut is_near = false;
        for event in 0..CHAIN {
            let hit = SurfaceInteraction::hit(scene, &ray);
            if event > 0 {
                let free = hit.as_ref().map_or(f32::INFINITY, |s| s.distance);
                if let Some((pixel, off)) = seen_from(scene, ray.origin, ray.direction, free)
                    && off < pass.off
                {
                    is_near = true;
                    (pass.pixel, pass.off) = (pixel, off);
                }
            }
            let Some(s) = hit.filter(|s| s.flags().has_delta()) else { break };
            let u = random4(self.seed, pass.lamp, pass.number, DIMENSION_LAMP_IMAGES + event);
            let Some((false, next)) = step(&s, &flux, event, u) else { break };
            (ray, flux) = next;
        }
        is_near.then_some(pass)
    }
}

/// The pixel that sees `place`, and the difference between `direction` and the one from there to the eye; none where nothing
/// is seen of it, or where the ray ends, after the length `free`, before it passes the eye.
fn seen_from(scene: &PackedScene, place: Vec3, direction: Vec3, free: f32) -> Option<(u32, f32)> {
    let [x, y] = scene.camera.image_of(place)?;
    let ray = scene.camera.ray([x, y]);
    let off = (direction + ray.direction).length();
    let distance = (place - ray.origin).length();
    let [width, height] = scene.size;
    let pixel = (y * height as f32) as u32 * width + (x * width as f32) as u32;
    (free > distance * (1.0 - NEAR)).then_some((pixel, off))
}
