//! Which lights shadow rays go to: those that light what the camera sees.

use super::BY_FLUX;
use super::lamp::{Lamp, lamps};
use crate::bands::sum;
use crate::optics::light::sample_emitter;
use crate::optics::ray::visible;
use crate::pack::{Guide, PackedScene};
use crate::plan::seen::{Seen, SeenPoint};
use crate::rng::random4;
use rayon::prelude::*;

/// Places that are looked at, at most.
const PLACES: usize = 1024;
/// Lamps that are tried at each place, at most.
const TRIES: usize = 32;
/// What is learned must lower the second moment to this part of what it is.
const WORTH: f64 = 0.8;
/// Purpose of random numbers; those of the backends lie below.
const DIMENSION_DIRECT: u32 = 0x13_0000;

/// Learn how to pick lights for shadow rays: p ∝ √(mean over the image of (irradiance / that of all lamps)²), which makes
/// the relative noise least [E22]. Nothing where that is not worth it.
pub(in crate::plan) fn direct(scene: &PackedScene, seed: u32, seen: &Seen) -> Guide {
    let lamps = lamps(&scene.emitters);
    if lamps.len() < 2 || seen.is_empty() {
        return Guide::default();
    }
    let step = seen.points().len().div_ceil(PLACES);
    let places: Vec<&SeenPoint> = seen.points().iter().step_by(step).collect();
    let found: Vec<Vec<(usize, f64)>> = places
        .par_iter()
        .enumerate()
        .map(|(i, p)| relative_moments(scene, &lamps, p, |k| random4(seed, i as u32, k, DIMENSION_DIRECT)))
        .collect();
    let mut moments = vec![0.0; lamps.len()];
    found.into_iter().flatten().for_each(|(lamp, moment)| moments[lamp] += moment);
    let total: f64 = lamps.iter().map(Lamp::flux).sum();
    let worth: f64 = moments.iter().map(|m| m.sqrt()).sum();
    let by_flux: f64 = moments.iter().zip(&lamps).map(|(m, l)| m * total / l.flux()).sum();
    if worth <= 0.0 || worth * worth >= WORTH * by_flux {
        return Guide::default();
    }
    let per_flux = |(m, l): (&f64, &Lamp)| (1.0 - BY_FLUX) * m.sqrt() / worth / l.flux() + BY_FLUX / total;
    let per_flux = moments.iter().zip(&lamps).map(per_flux);
    let weights: Vec<f64> = lamps
        .iter()
        .zip(per_flux)
        .flat_map(|(l, w)| l.emitters(scene).iter().map(move |e| sum(&e.flux) * w))
        .collect();
    Guide::new(&scene.emitters, &weights, Vec::new(), |_| None, 1.0)
}

/// The squares of the parts of a place's irradiance that some of the lamps give it, each as often as it stands for lamps that
/// were not tried.
fn relative_moments(
    scene: &PackedScene,
    lamps: &[Lamp],
    p: &SeenPoint,
    random: impl Fn(u32) -> [f32; 4],
) -> Vec<(usize, f64)> {
    let tries = lamps.len().min(TRIES);
    let stands_for = lamps.len() as f64 / tries as f64;
    let shift = f64::from(random(u32::MAX)[0]);
    let given: Vec<(usize, f64)> = (0..tries)
        .filter_map(|k| {
            let lamp = (((k as f64 + shift) * stands_for) as usize).min(lamps.len() - 1);
            let [u, v, ..] = random(k as u32);
            let (emitter, rest, pick) = lamps[lamp].pick(u);
            let l = sample_emitter(&scene.emitters[emitter], p.origin, [rest, v])?;
            let cosine = l.wi.dot(p.normal);
            let lit = cosine > 0.0 && visible(scene, p.origin, l.target);
            lit.then(|| (lamp, sum(&l.irradiance) * f64::from(cosine / pick)))
        })
        .filter(|(_, irradiance)| irradiance.is_finite())
        .collect();
    let all: f64 = given.iter().map(|g| g.1).sum::<f64>() * stands_for;
    given.into_iter().map(|(lamp, e)| (lamp, (e / all).powi(2) * stands_for)).filter(|g| g.1 > 0.0).collect()
}
