//! Which lights shadow rays go to: those that light what the camera sees.

use super::BY_FLUX;
use super::lamp::{Lamp, lamps};
use crate::optics::lights::sample_li;
use crate::optics::ray::visible;
use crate::packed::{Guide, PackedScene};
use crate::plan::guiding::visible_points::{VisiblePoint, VisiblePoints};
use crate::sampling::rng::purpose::DIMENSION_PICKS;
use crate::sampling::rng::random4;
use crate::spectrum::sum;
use rayon::prelude::*;

/// Places that are looked at, at most.
const PLACES: usize = 1024;
/// Lamps that are tried at each place, at most.
const TRIES: usize = 32;
/// What is learned must lower the second moment to this part of what it is.
const WORTH: f64 = 0.8;

/// Light samples of which one gets a shadow ray, where that pays …
const CANDIDATES: u32 = 8;
/// … which it does where the second moment falls to this part.
const CANDIDATES_WORTH: f64 = 0.5;

/// How lights are picked for shadow rays.
pub(in crate::plan) struct Picks {
    pub(in crate::plan) guide: Guide,
    /// Light samples of which one gets a shadow ray.
    pub(in crate::plan) candidates: u32,
}

/// What a lamp gives to a place.
struct Given {
    lamp: usize,
    /// Irradiance if nothing shades it, and as it is: parts of what all lamps give.
    unshadowed: f64,
    lit: f64,
    /// Lamps that it stands for, itself and those that were not tried.
    stands_for: f64,
}

/// Learn how to pick lights for shadow rays: p ∝ √(mean over the image of (irradiance / that of all lamps)²), which makes
/// the relative noise least [E22]; nothing where that is not worth it. And whether candidates pay [E24].
pub(in crate::plan) fn direct(scene: &PackedScene, seed: u32, seen: &VisiblePoints) -> Picks {
    let lamps = lamps(&scene.emitters);
    if lamps.len() < 2 || seen.is_empty() {
        return Picks { guide: Guide::default(), candidates: 1 };
    }
    let step = seen.points().len().div_ceil(PLACES);
    let places: Vec<&VisiblePoint> = seen.points().iter().step_by(step).collect();
    let found: Vec<Vec<Given>> = places
        .par_iter()
        .enumerate()
        .map(|(i, p)| given(scene, &lamps, p, |k| random4(seed, i as u32, k, DIMENSION_PICKS)))
        .collect();
    let mut moments = vec![0.0; lamps.len()];
    found.iter().flatten().for_each(|g| moments[g.lamp] += g.lit.powi(2) * g.stands_for);
    let total: f64 = lamps.iter().map(Lamp::flux).sum();
    let worth: f64 = moments.iter().map(|m| m.sqrt()).sum();
    let by_flux: f64 = moments.iter().zip(&lamps).map(|(m, l)| m * total / l.flux()).sum();
    let is_worth_it = worth > 0.0 && worth * worth < WORTH * by_flux;
    let shares: Vec<f64> = moments
        .iter()
        .zip(&lamps)
        .map(|(m, l)| {
            let by_flux = l.flux() / total;
            if is_worth_it { (1.0 - BY_FLUX) * m.sqrt() / worth + BY_FLUX * by_flux } else { by_flux }
        })
        .collect();
    let guide = if is_worth_it {
        let weights: Vec<f64> = lamps
            .iter()
            .zip(&shares)
            .flat_map(|(l, s)| l.emitters(scene).iter().map(move |e| sum(&e.flux) * s / l.flux()))
            .collect();
        Guide::new(&scene.emitters, &weights, Vec::new(), |_| None, 1.0)
    } else {
        Guide::default()
    };
    // second moments of one sample, and of one that is picked by what it gives unshadowed
    let single: f64 = found.iter().flatten().map(|g| g.lit.powi(2) * g.stands_for / shares[g.lamp]).sum();
    let picked: f64 = found.iter().flatten().map(|g| g.unshadowed * g.stands_for).sum();
    let pays = picked + single / f64::from(CANDIDATES) < CANDIDATES_WORTH * single;
    Picks { guide, candidates: if pays { CANDIDATES } else { 1 } }
}

/// What some of the lamps give to a place.
fn given(
    scene: &PackedScene,
    lamps: &[Lamp],
    p: &VisiblePoint,
    random: impl Fn(u32) -> [f32; 4],
) -> Vec<Given> {
    let tries = lamps.len().min(TRIES);
    let stands_for = lamps.len() as f64 / tries as f64;
    let shift = f64::from(random(u32::MAX)[0]);
    let mut found: Vec<Given> = (0..tries)
        .filter_map(|k| {
            let lamp = (((k as f64 + shift) * stands_for) as usize).min(lamps.len() - 1);
            let [u, v, ..] = random(k as u32);
            let (emitter, rest, pick) = lamps[lamp].pick(u);
            let l = sample_li(scene, &scene.emitters[emitter], p.near.origin, [rest, v])?;
            let side = p.far.filter(|far| l.wi.dot(far.normal) > 0.0).unwrap_or(p.near);
            let cosine = l.wi.dot(side.normal);
            let unshadowed = sum(&l.irradiance) * f64::from(cosine / pick);
            if cosine <= 0.0 || !unshadowed.is_finite() {
                return None;
            }
            let lit = if visible(scene, side.origin, l.target) { unshadowed } else { 0.0 };
            Some(Given { lamp, unshadowed, lit, stands_for })
        })
        .collect();
    let all: f64 = found.iter().map(|g| g.lit * g.stands_for).sum();
    if all <= 0.0 {
        return Vec::new();
    }
    for g in &mut found {
        (g.unshadowed, g.lit) = (g.unshadowed / all, g.lit / all);
    }
    found
}
