//! Trace: jotons from their emitters through the scene, stored where a map needs them.
//!
//! Caustic jotons follow a pure S chain; each D-capable surface on it gets one (class L S+ D). Diffuse jotons play
//! full Russian roulette and are stored after their first D event. Flux is stored as it arrives, before the surface's
//! reflectance, times |wi·Ns|/|wi·Ng|: the gather needs no cosine.

use super::maps::Joton;
use super::streams::*;
use crate::backend::{Cause, Tally};
use crate::film::paths::{DEAD, Event, LightPaths};
use crate::optics::lights::pick::{aimed, by_law};
use crate::optics::lights::samples::Start;
use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::Bsdf;
use crate::optics::shading::cutout;
use crate::optics::shading::roulette::{EventProbabilities, SCATTERED};
use crate::packed::PackedScene;
use crate::packed::constants::{ADJOINT_MAX, OPACITY_LEAST, UNSEEN_STORED};
use crate::plan::Plan;
use crate::sampling::rng::{golden, random4, sequence_seed, sequence2};
use crate::spectrum::{BANDS, Bands, max, mul, scale};
use rayon::prelude::*;

/// Jotons that one task traces: enough to hide the scheduling, few enough to balance it.
const BLOCK: u32 = 2048;

/// Jotons of one map of one pass, in the order of their numbers, whatever the threads did.
pub(super) fn jotons(
    scene: &PackedScene,
    plan: &Plan,
    pass: u32,
    caustic: bool,
    tally: &mut Tally,
) -> Vec<Joton> {
    let count = if caustic { plan.caustic_jotons } else { plan.diffuse_jotons };
    let blocks: Vec<(Vec<Joton>, Tally)> = (0..count.div_ceil(BLOCK))
        .into_par_iter()
        .map(|block| {
            let mut tracer = Tracer { scene, plan, pass, stored: Vec::new(), tally: Tally::default() };
            for i in block * BLOCK..((block + 1) * BLOCK).min(count) {
                if caustic { tracer.caustic(i, count) } else { tracer.diffuse(i, count) }
            }
            (tracer.stored, tracer.tally)
        })
        .collect();
    let mut all = Vec::with_capacity(blocks.iter().map(|b| b.0.len()).sum());
    for (stored, counts) in blocks {
        all.extend_from_slice(&stored);
        *tally += counts;
    }
    tally.jotons_emitted += u64::from(count);
    tally.jotons_stored += all.len() as u64;
    all
}

struct Tracer<'a> {
    scene: &'a PackedScene,
    plan: &'a Plan,
    pass: u32,
    stored: Vec<Joton>,
    tally: Tally,
}

impl Tracer<'_> {
    fn sobol(&self, i: u32, count: u32, stream: u32) -> [f32; 2] {
        let index = u64::from(self.pass) * u64::from(count) + u64::from(i);
        sequence2(index, self.plan.settings.seed, 0, stream)
    }

    /// A joton of class L S+ D.
    fn caustic(&mut self, i: u32, count: u32) {
        let place = self.sobol(i, count, STREAM_CAUSTIC_PLACE);
        let towards = self.sobol(i, count, STREAM_CAUSTIC_DIRECTION);
        let Some(start) = aimed(self.scene, &self.plan.guides.caustic, place, towards, count as f32) else {
            return;
        };
        self.follow::<true>(i, start, DIMENSION_CAUSTIC);
    }

    /// A joton of class L S* D (D|S)* D.
    fn diffuse(&mut self, i: u32, count: u32) {
        let place = self.sobol(i, count, STREAM_DIFFUSE_PLACE);
        let towards = self.sobol(i, count, STREAM_DIFFUSE_DIRECTION);
        let start = by_law(self.scene, &self.plan.guides.diffuse, place, towards, count as f32);
        add_flux(&mut self.tally.emitted, &start.flux, 1.0);
        self.follow::<false>(i, start, DIMENSION_DIFFUSE);
    }

    /// The number that tells in which band a joton is transmitted where they part.
    fn band(&self, i: u32, is_caustic: bool) -> f32 {
        let (count, stream) = if is_caustic {
            (self.plan.caustic_jotons, STREAM_CAUSTIC_BAND)
        } else {
            (self.plan.diffuse_jotons, STREAM_DIFFUSE_BAND)
        };
        let index = self.pass.wrapping_mul(count).wrapping_add(i);
        golden(index, sequence_seed(self.plan.settings.seed, 0, stream))
    }

    fn follow<const CAUSTIC: bool>(&mut self, i: u32, start: Start, dimension: u32) {
        let paths = &self.plan.settings.paths;
        let (mut ray, mut flux) = (start.ray(), start.flux);
        let mut state = LightPaths::START;
        let (mut specular, mut diffuse) = (0u32, 0u32);
        for event in 0..EVENTS_MAX {
            if max(&flux) <= 0.0 {
                return;
            }
            self.tally.rays += 1;
            let Some(s) = SurfaceInteraction::hit(self.scene, &ray) else {
                if !CAUSTIC {
                    let escapes = ray.brings_from_afar(self.scene, &flux);
                    add_flux(&mut self.tally.escaped, &escapes, 1.0);
                    self.absorbed(&flux, &escapes);
                }
                return;
            };
            let arrives = s.through(&flux);
            if !CAUSTIC {
                self.absorbed(&flux, &arrives);
            }
            flux = arrives;
            let wi_ng = s.back.dot(s.ng);
            let adjoint_in = if s.smooth { limited(s.back.dot(s.ns).abs() / wi_ng) } else { 1.0 };
            if s.flags().stores() && (if CAUSTIC { specular > 0 } else { diffuse > 0 }) {
                // fewer jotons meet what is there in part, but discs have all of its area
                let there = cutout::opacity(s.textures, s.material, s.texture.uv).max(OPACITY_LEAST);
                let counts_as = if CAUSTIC { 1.0 } else { self.counts_as(&s, i, event) } / there;
                if counts_as > 0.0 {
                    self.store(&s, &scale(&flux, adjoint_in * counts_as), paths.step(state, Event::D));
                }
            }
            let [u_way, u0, u1, u_lobe] = random4(self.plan.settings.seed, self.pass, i, dimension + event);
            let mut probabilities = EventProbabilities::new(&s, &flux, event);
            if !CAUSTIC {
                let lost = probabilities.total_albedo().map(|kept| 1.0 - kept);
                add_flux(&mut self.tally.absorbed, &mul(&lost, &flux), 1.0);
            }
            probabilities.bsdf.part_bands(s.between(), &flux, || self.band(i, CAUSTIC));
            let Some(way) = probabilities.choose(u_way) else { return };
            if CAUSTIC && way == SCATTERED {
                return;
            }
            let kept = probabilities.carried(way, &flux);
            let has_relief = way == SCATTERED && s.flags().has_relief();
            let off_relief =
                if has_relief { probabilities.bsdf.scatter_off_relief(u_lobe, [u0, u1]) } else { None };
            let leaving = match off_relief {
                Some((w, _)) => Some(w),
                None if has_relief => None,
                None => probabilities.direction(way, u_lobe, [u0, u1]),
            };
            flux = match leaving {
                Some(w) if way == SCATTERED => {
                    let arrives = scale(&flux, adjoint_in / probabilities.ways[way]);
                    let leaves = off_relief
                        .map_or_else(|| scattered(&s, &probabilities.bsdf, w), |(_, weight)| weight);
                    mul(&arrives, &leaves)
                }
                Some(w) => {
                    let through = probabilities.bsdf.flux_through_delta(way - 1, w, &flux);
                    let goes_on = scale(&through, 1.0 / probabilities.ways[way]);
                    if s.smooth { scale(&goes_on, specular_adjoint(&s, w)) } else { goes_on }
                }
                None => [0.0; BANDS],
            };
            if !CAUSTIC {
                // what the sampled direction did not carry on was absorbed: keeps the balance exact in expectation
                self.absorbed(&kept, &flux);
            }
            let Some(w) = leaving else { return };
            if way == SCATTERED {
                diffuse += 1;
                state = paths.step(state, Event::D);
            } else {
                specular += 1;
                state = paths.step(state, Event::S);
            }
            if state == DEAD && CAUSTIC {
                return;
            }
            ray = s.leave(w);
        }
        self.tally.truncated += 1;
    }

    /// What of `before` is no more there.
    fn absorbed(&mut self, before: &Bands, after: &Bands) {
        if before != after {
            add_flux(&mut self.tally.absorbed, before, 1.0);
            add_flux(&mut self.tally.absorbed, after, -1.0);
        }
    }

    /// How many jotons this one of the diffuse map stands for; 0 where another stands for it. Where the camera does not look one
    /// of a few is stored [E23].
    fn counts_as(&mut self, s: &SurfaceInteraction, i: u32, event: u32) -> f32 {
        if self.plan.visible_cells.as_ref().is_none_or(|cells| cells.holds(s.position)) {
            return 1.0;
        }
        let [u, ..] = random4(self.plan.settings.seed, self.pass, i, DIMENSION_UNSEEN + event);
        if u * (UNSEEN_STORED as f32) < 1.0 {
            return UNSEEN_STORED as f32;
        }
        self.tally.jotons_not_stored += 1;
        0.0
    }

    fn store(&mut self, s: &SurfaceInteraction, flux: &Bands, state: u32) {
        if state == DEAD {
            return;
        }
        if flux.iter().any(|x| !x.is_finite()) {
            self.tally.non_finite.count(Cause::Joton);
            return;
        }
        self.stored.push(Joton { position: s.position, wi: s.back, flux: *flux, normal: s.ng, state });
    }
}

/// What a D event toward `w` leaves of the flux: f |w·Ng| / pdf (Veach 1997, 5.3) [E11]; the flux is already times
/// |wi·Ns|/|wi·Ng|.
fn scattered(s: &SurfaceInteraction, bsdf: &Bsdf, w: glam::Vec3) -> Bands {
    if bsdf.cosine(w) <= 0.0 {
        return [0.0; BANDS];
    }
    let adjoint_out = if s.smooth { limited(w.dot(s.ng) / w.dot(s.ns)) } else { 1.0 };
    scale(&bsdf.weight_scatter(w), adjoint_out)
}

/// Veach's factor for an S event [E11]: the same as for a D event, so that jotons see the surface that the eye sees.
fn specular_adjoint(s: &SurfaceInteraction, w: glam::Vec3) -> f32 {
    let n = s.frame().specular_normal();
    limited((s.back.dot(n) * w.dot(s.ng) / (s.back.dot(s.ng) * w.dot(n))).abs())
}

fn limited(factor: f32) -> f32 {
    if factor.is_finite() { factor.min(ADJOINT_MAX) } else { 1.0 }
}

fn add_flux(sum: &mut [f64; BANDS], flux: &Bands, sign: f64) {
    for b in 0..BANDS {
        sum[b] += sign * f64::from(flux[b]);
    }
}
