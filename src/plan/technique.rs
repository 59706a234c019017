//! Technique: by which way indirect light is found with less error. A few thousand paths from what the camera sees tell how noisy paths
//! are; where a lamp is hidden from them, jotons find its light.

use super::Indirect;
use super::guiding::visible_points::{VisiblePoint, VisiblePoints, step};
use crate::optics::lights::le;
use crate::optics::lights::pick::{pdf_light, sample_light};
use crate::optics::ray::{Ray, SurfaceInteraction, lift, visible};
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::PackedScene;
use crate::sampling::distributions::{cosine_hemisphere, to_world};
use crate::sampling::rng::purpose::{DIMENSION_TECHNIQUE, STREAM_TECHNIQUE};
use crate::sampling::rng::{random4, sequence_seed, sobol2};
use crate::spectrum::{BANDS, Bands, mul, scale, sum};
use glam::Vec3;
use rayon::prelude::*;
use std::f32::consts::FRAC_1_PI;

/// Places that are looked at, at most, and paths from each.
const PLACES: usize = 512;
const PATHS: u32 = 16;
/// Shadow rays from each.
const SHADOW_RAYS: u32 = 4;
/// Places near each other whose irradiance is taken for one.
const GROUP: usize = 16;
/// Longest path that is followed.
const EVENTS: u32 = 24;
/// Relative variance of one path from which on the map serves better: a joton's is about 2, and paths cost half as much and are shared
/// among ten times as many pixels as lie in a disc.
const NOISY: f64 = 40.0;
/// Part of the paths that are not over after so many events from which on the map serves better: it goes on from dispatch to dispatch,
/// while what a long path of a device has not found in one is left to the chances of a few.
const UNFINISHED: f64 = 0.05;

/// The better way for a scene. Where it has caustics, what is dark here may be lit by them.
pub(super) fn choose(scene: &PackedScene, seed: u32, seen: &VisiblePoints, has_caustics: bool) -> Indirect {
    let [variance, unfinished] = look(scene, seed, seen, has_caustics);
    if variance < NOISY && unfinished < UNFINISHED { Indirect::Paths } else { Indirect::Map }
}

/// Variance of the irradiance that one path finds, over the square of all that comes there, in the mean over what the camera sees in any
/// light; and the part of the paths that are not over.
fn look(scene: &PackedScene, seed: u32, seen: &VisiblePoints, has_caustics: bool) -> [f64; 2] {
    let every = seen.points().len().div_ceil(PLACES).max(1);
    let mut places: Vec<&VisiblePoint> = seen.points().iter().step_by(every).collect();
    let [low, high] = scene.bounds;
    places.sort_by_cached_key(|place| along_curve((place.near.origin - low) / (high - low).max_element()));
    let paths: Vec<[(f64, bool); PATHS as usize]> = places
        .par_iter()
        .enumerate()
        .map(|(i, place)| std::array::from_fn(|k| irradiance(scene, seed, place, i as u32, k as u32)))
        .collect();
    let unfinished = paths.iter().flatten().filter(|path| !path.1).count() as f64;
    let found: Vec<[f64; PATHS as usize]> = paths.iter().map(|of| of.map(|path| path.0)).collect();
    let shown: Vec<f64> = places
        .par_iter()
        .enumerate()
        .map(|(i, place)| shown_directly(scene, seed, place, i as u32))
        .collect();
    let groups = found.chunks(GROUP).zip(shown.chunks(GROUP)).filter_map(|(group, shown)| {
        let count = group.len() as f64;
        let mean = group.iter().flatten().sum::<f64>() / (count * f64::from(PATHS));
        // what differs from place to place is no noise
        let of_place = |paths: &[f64; PATHS as usize]| {
            let mean = paths.iter().sum::<f64>() / f64::from(PATHS);
            paths.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / f64::from(PATHS - 1)
        };
        let variance = group.iter().map(of_place).sum::<f64>() / count;
        let all = mean + shown.iter().sum::<f64>() / count;
        if all > 0.0 { Some(variance / (all * all)) } else { has_caustics.then_some(0.0) }
    });
    let all: Vec<f64> = groups.collect();
    let by_groups = all.iter().sum::<f64>() / all.len().max(1) as f64;
    [by_groups, unfinished / paths.as_flattened().len().max(1) as f64]
}

/// Where a place of the unit cube comes along Morton's curve, which keeps near places near each other.
fn along_curve(place: Vec3) -> u32 {
    let cells = (place.clamp(Vec3::ZERO, Vec3::ONE) * 255.0).as_uvec3();
    (0..8).fold(0, |code, bit| {
        let of = |x: u32, axis: u32| (x >> bit & 1) << (3 * bit + axis);
        code | of(cells.x, 0) | of(cells.y, 1) | of(cells.z, 2)
    })
}

/// Irradiance over π by path `number` from a place, all bands together: what comes from surfaces that a light shines on; and whether
/// the path was over.
fn irradiance(scene: &PackedScene, seed: u32, place: &VisiblePoint, index: u32, number: u32) -> (f64, bool) {
    let u = sobol2(number, sequence_seed(seed, index, STREAM_TECHNIQUE));
    let side = place.side(number);
    let mut ray = Ray::new(side.origin, to_world(cosine_hemisphere(u), side.normal));
    let mut throughput = [1.0; BANDS];
    let mut found = 0.0;
    // pdf_solid_angle of the last D event where a shadow ray competes: not of the first, whose light is direct
    let mut pdf_last: Option<f32> = None;
    let mut is_over = false;
    for event in 0..EVENTS {
        let Some(s) = SurfaceInteraction::hit(scene, &ray) else {
            is_over = true;
            break;
        };
        let draw = |k: u32| random4(seed, number, index, DIMENSION_TECHNIQUE + 2 * event + k);
        if let (Some(pdf), Some(le)) = (pdf_last, le(&s)) {
            let weight = pdf / (pdf + pdf_light(&scene.emitters, &s));
            found += sum(&scale(&mul(&throughput, &le), weight));
        }
        let bsdf = Bsdf::at(&s);
        if s.flags().has_diffuse() {
            found += direct(scene, &s, &bsdf, &throughput, draw(1));
        }
        let Some((is_d, (next, carried))) = step(&s, &throughput, event, draw(0)) else {
            is_over = true;
            break;
        };
        pdf_last = is_d.then(|| bsdf.pdf_scatter(next.direction));
        (ray, throughput) = (next, carried);
    }
    (found / BANDS as f64, is_over)
}

/// Irradiance over π that lights give a place themselves, all bands together, by a few shadow rays.
fn shown_directly(scene: &PackedScene, seed: u32, place: &VisiblePoint, index: u32) -> f64 {
    let one = |k: u32| {
        let [x, y, ..] = random4(seed, PATHS + k, index, DIMENSION_TECHNIQUE);
        let side = place.side(k);
        let Some(l) = sample_light(scene, &scene.emitters, side.origin, [x, y]) else { return 0.0 };
        let cos_s = l.wi.dot(side.normal);
        if cos_s <= 0.0 || !visible(scene, side.origin, l.target) {
            return 0.0;
        }
        sum(&l.irradiance) * f64::from(cos_s * FRAC_1_PI)
    };
    (0..SHADOW_RAYS).map(one).sum::<f64>() / f64::from(SHADOW_RAYS) / BANDS as f64
}

/// Direct light at a surface, by one shadow ray that shares its weight with the path's next direction.
fn direct(scene: &PackedScene, s: &SurfaceInteraction, bsdf: &Bsdf, throughput: &Bands, u: [f32; 4]) -> f64 {
    let origin = lift(s.position, s.ng, s.triangle);
    let Some(l) = sample_light(scene, &scene.emitters, origin, [u[0], u[1]]) else { return 0.0 };
    let cos_s = bsdf.cosine(l.wi);
    if cos_s <= 0.0 || !visible(scene, s.origin_toward(l.wi), l.target) {
        return 0.0;
    }
    let weight = if l.pdf > 0.0 { l.pdf / (l.pdf + bsdf.pdf_scatter(l.wi)) } else { 1.0 };
    let radiance = mul(&mul(throughput, &bsdf.eval_scatter(l.wi)), &l.irradiance);
    sum(&scale(&radiance, cos_s * weight))
}
