//! Glint: emission that is small in the image (E S* L): a lamp in a water surface, the rim of a lamp. A few camera trees,
//! which take both ways at a dielectric interface, find it; a pixel's one eye path would alias it for hundreds of passes.
//! In pixels that a pilot marked; in those that see specular surfaces and no light, in some passes only; in the others the eye path
//! alone. Where there are both, each weighs what the other would not find [E25].

use super::eye::{survival, wants_emission};
use super::followed_light::FollowedLight;
use super::splits::Splits;
use super::streams::{DIMENSION_GLINT, EVENTS_MAX, STREAM_GLINT_BAND, STREAM_GLINT_JITTER};
use crate::backend::Tally;
use crate::estimators::split_paths::{Light, Look, SplitPaths, is_mixed};
use crate::optics::lights::{le_seen, on_miss};
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::constants::{PILOT_TREES, WAITING_MAX};
use crate::packed::{CameraRay, PackedScene};
use crate::plan::Plan;
use crate::sampling::rng::{golden, random4, seed_at, sequence_seed};
use crate::spectrum::{BANDS, BLACK, Bands, add, is_black, mul, scale};
use rayon::prelude::*;

/// Of the trees of a pixel in the pilot the ones that tell whether there is anything to see but D surfaces: most pixels need no more.
const PILOT_FIRST: u32 = 2;
/// What one tree saw.
struct TreeView {
    /// Radiance of the emitters on it.
    emission: Bands,
    /// It ended on an emitter, with nothing specular before.
    direct: bool,
    /// It took both ways somewhere.
    branched: bool,
}

/// A way that is still to be followed.
#[derive(Clone, Copy)]
struct Way {
    ray: Ray,
    throughput: Bands,
    splits: Splits,
    /// Events so far.
    events: u32,
    /// From the eye, internal units.
    length: f32,
}

/// Follow tree `number` of a pixel through specular events only, and weigh the emission met after so many. Nothing is
/// scattered or absorbed by chance: what D events would take is in the reflectance.
fn tree(
    scene: &PackedScene,
    seed: u32,
    pixel: u32,
    number: u64,
    weight: impl Fn(u32, &Splits, Option<&SurfaceInteraction>) -> f32,
    tally: &mut Tally,
) -> TreeView {
    let CameraRay { origin, direction, travelled: length } =
        scene.sample_camera(pixel, number, seed, STREAM_GLINT_JITTER);
    let (seed, number) = (seed_at(seed, (number >> 32) as u32), number as u32);
    let ray = Ray::new(origin, direction).within(scene.media.camera);
    let mut waiting = [Way { ray, throughput: [1.0; BANDS], splits: Splits::start(), events: 0, length };
        WAITING_MAX as usize];
    let mut count = 1;
    let mut seen = TreeView { emission: BLACK, direct: false, branched: false };
    let mut node = 0;
    while count > 0 {
        count -= 1;
        let Way { mut ray, mut throughput, mut splits, mut events, mut length } = waiting[count];
        loop {
            tally.rays += 1;
            let Some(s) = SurfaceInteraction::hit(scene, &ray) else {
                let light = ray.brings_from_afar(scene, &on_miss(ray.direction));
                seen.emission =
                    add(&seen.emission, &scale(&mul(&throughput, &light), weight(events, &splits, None)));
                break;
            };
            length += s.distance;
            throughput = s.through(&throughput);
            if let Some(le) = le_seen(scene, &s, length) {
                let weight = weight(events, &splits, Some(&s));
                seen.emission = add(&seen.emission, &scale(&mul(&throughput, &le), weight));
                seen.direct = events == 0;
            }
            let mut bsdf = Bsdf::seen(scene, &s, length);
            let shares = bsdf.shares(&throughput);
            if shares.followed() <= 0.0 {
                break;
            }
            seen.direct = false;
            bsdf.part_bands(s.between(), &throughput, || {
                golden(number, sequence_seed(seed, pixel, STREAM_GLINT_BAND))
            });
            let [u_way, u0, u1, u_survive] = random4(seed, number, pixel, DIMENSION_GLINT + node);
            node += 1;
            let both = splits.takes_both(&shares);
            let (lobe, kept) = if both {
                seen.branched = true;
                // the lesser first: so many are never waiting
                let lesser = usize::from(shares.delta[1] < shares.delta[0]);
                if let Some(direction) = bsdf.sample_delta(1 - lesser, [u0, u1]) {
                    waiting[count] = Way {
                        ray: s.leave(direction),
                        throughput: bsdf.through_delta(1 - lesser, direction, &throughput),
                        splits: splits.after(&shares, 1 - lesser, bsdf.pdf_delta(1 - lesser, direction)),
                        events: events + 1,
                        length,
                    };
                    count += 1;
                }
                (lesser, shares.delta[lesser])
            } else {
                (shares.pick_delta(u_way * shares.followed()), shares.followed())
            };
            let survival = survival(events, kept);
            let Some(direction) = bsdf.sample_delta(lobe, [u0, u1]) else { break };
            splits = splits.after(&shares, lobe, bsdf.pdf_delta(lobe, direction));
            if u_survive >= survival {
                break;
            }
            events += 1;
            if events == EVENTS_MAX {
                tally.truncated += 1;
                break;
            }
            let chance = survival * shares.delta[lobe] / kept;
            throughput = scale(&bsdf.through_delta(lobe, direction, &throughput), 1.0 / chance);
            ray = s.leave(direction);
        }
    }
    seen
}

/// Emission of a pixel in one pass, beside what its eye path has seen of it.
pub(super) fn emission(
    scene: &PackedScene,
    plan: &Plan,
    glints: &SplitPaths,
    pixel: u32,
    pass: u32,
    tally: &mut Tally,
) -> Bands {
    let seed = plan.settings.seed;
    let trees = glints.trees_a_pass(pixel as usize);
    let lights = FollowedLight::new(scene, plan);
    let weight = |events, splits: &Splits, lit: Option<&SurfaceInteraction>| {
        let pdf_light = lit.map_or(0.0, |s| lights.pdf(s));
        if wants_emission(plan, events) { splits.weight_of_tree(trees, pdf_light) } else { 0.0 }
    };
    glints.numbers(pixel, pass, seed).fold(BLACK, |sum, number| {
        let seen = tree(scene, seed, pixel, number, weight, tally);
        add(&sum, &seen.emission)
    })
}

/// What the trees of a pixel have seen so far, in the pilot.
#[derive(Clone, Copy)]
struct Survey {
    trees: u32,
    lit: u32,
    direct: u32,
    branched: bool,
    sum: Bands,
    square: f32,
}

impl Survey {
    /// After trees up to this one, too. No pass uses them, so a choice by them costs no bias. It knows no --paths: the parts of an image add up.
    fn up_to(mut self, trees: u32, scene: &PackedScene, seed: u32, [pixel, pilot]: [u32; 2]) -> Self {
        for i in self.trees..trees {
            // no pass has so high a number
            let number = u64::from(pilot) << 32 | u64::from(i);
            let seen = tree(scene, seed, pixel, number, |_, _, _| 1.0, &mut Tally::default());
            self.trees += 1;
            self.lit += u32::from(!is_black(&seen.emission));
            self.direct += u32::from(seen.direct);
            self.branched |= seen.branched;
            self.sum = add(&self.sum, &seen.emission);
            self.square += seen.emission.iter().map(|x| x * x).sum::<f32>();
        }
        self
    }

    fn told(&self) -> Look {
        let light = match (self.lit, self.direct) {
            (0, _) => Light::Nowhere,
            _ if self.direct == self.trees => Light::Everywhere,
            _ => Light::InPart,
        };
        let each = 1.0 / self.trees as f32;
        let squared_mean = self.sum.iter().map(|x| (x * each).powi(2)).sum();
        Look { light, branched: self.branched, square: self.square * each, squared_mean }
    }
}

/// What the pilot's trees see.
pub(super) fn look(scene: &PackedScene, seed: u32, pilot: u32) -> Vec<Look> {
    let nothing = Survey { trees: 0, lit: 0, direct: 0, branched: false, sum: BLACK, square: 0.0 };
    let pixels = || (0..scene.pixels() as u32).into_par_iter();
    let few: Vec<Survey> = pixels().map(|i| nothing.up_to(PILOT_FIRST, scene, seed, [i, pilot])).collect();
    let first: Vec<Look> = few.iter().map(Survey::told).collect();
    let all = |i: u32| {
        let (survey, look) = (&few[i as usize], first[i as usize]);
        // few trees are too few to say that glass shows no light
        let is_open = look.branched || is_mixed(&first, i as usize, scene.size);
        if is_open { survey.up_to(PILOT_TREES, scene, seed, [i, pilot]).told() } else { look }
    };
    pixels().map(all).collect()
}
