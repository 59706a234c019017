//! Learn: which lights, and which ways from them, are of use where the camera looks, by tracing some tens of thousands of
//! jotons and shadow rays on the host [E20].
//!
//! Whatever is learned, nothing is left out: every light keeps a part of its flux's share, every bin of a warp a part of its
//! area's, and what is found is divided by the probability that is really used.

mod density;
mod direct;
mod lamp;
mod lamp_images;
pub(super) mod visible_points;

pub(super) use direct::direct;
pub(super) use lamp_images::lamp_images;

use crate::estimators::maps::MapKind;
use crate::optics::lights::samples::Start;
use crate::optics::lights::{sample_le, sample_le_aimed};
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::packed::{Guide, MAX_WARPS, PackedScene, Warp};
use crate::plan::guiding::visible_points::{CHAIN, Cells, VisiblePoints, step};
use crate::sampling::rng::purpose::{DIMENSION_LEARN, STREAM_LEARN_DIRECTION, STREAM_LEARN_PLACE};
use crate::sampling::rng::{random4, sequence_seed, sobol2};
use crate::spectrum::sum;
use density::{guessed, warp};
use glam::Vec3;
use lamp::{Lamp, lamps};
use rayon::prelude::*;

/// What was learned of a map.
pub(super) struct Learned {
    pub(super) guide: Guide,
    /// Part of the jotons that are stored where the camera looks; 1 where nothing is known.
    pub(super) in_view: f64,
}

/// Jotons of the two rounds: the second goes where the first found something.
const ROUNDS: [u32; 2] = [1 << 13, 3 << 13];
/// Part of the jotons, and of shadow rays, that are picked by flux alone, whatever was learned.
const BY_FLUX: f64 = 0.1;
/// Part of the second round that follows the first round's shares.
const AGAIN: f64 = 0.25;
/// What is learned must lower the second moment to this part of what it is. Of the diffuse map further: its noise is a part
/// of the image's only, and more jotons in view are more to gather.
const WORTH: [f64; 2] = [0.9, 0.6];
/// Useful jotons that a warp is learned from, at least; and fewer where they had to be sought: what half of them tells is held against
/// the other half.
const HITS: usize = 64;
const HITS_SOUGHT: usize = 8;
/// Times that the way to where the camera looks is sought, at most.
const APPROACHES: u32 = 8;
/// Doublings of where the camera looks up to which jotons tell the way there.
const DOUBLINGS_MOST: u32 = 12;
/// Events after which a diffuse joton is not followed any further.
const EVENTS: u32 = 8;

/// A joton that some gather point can use.
struct Hit {
    /// Its number among its lamp's.
    number: u32,
    /// Where on the square of directions it started.
    towards: [f32; 2],
    /// How much its noise counts in the image, all bands, as if its lamp had no other joton. Cells are as large as pixels
    /// make them: of a caustic the square of the irradiance of a cell; of the diffuse map, whose radius does not follow
    /// the pixels, of flux over the width of a cell.
    moment: f64,
}

/// A joton that a map would store, whether the camera looks there or not.
struct Stored {
    /// Where on the square of directions it started, and one over the density of starting there.
    towards: [f32; 2],
    weight: f64,
    position: Vec3,
    /// Geometric normal.
    normal: Vec3,
}

/// A lamp and what its jotons have found.
struct Traced {
    lamp: Lamp,
    /// By which its directions are drawn, where even ones have found too little.
    guess: Option<Warp>,
    /// Jotons traced.
    count: u32,
    stored: Vec<Stored>,
    hits: Vec<Hit>,
}

impl Traced {
    /// Enough were useful to learn from.
    fn is_known(&self) -> bool {
        self.hits.len() >= if self.guess.is_some() { HITS_SOUGHT } else { HITS }
    }

    /// Mean over its jotons of what their noise counts.
    fn moment(&self) -> f64 {
        self.hits.iter().map(|h| h.moment).sum::<f64>() / f64::from(self.count.max(1))
    }
}

/// Learn how to emit the jotons of a map.
pub(super) fn jotons(scene: &PackedScene, seed: u32, seen: &VisiblePoints, kind: MapKind) -> Learned {
    if seen.is_empty() || scene.emitters.is_empty() || kind == MapKind::Caustic && scene.targets.is_empty() {
        return Learned { guide: Guide::default(), in_view: 1.0 };
    }
    let worth = WORTH[kind as usize];
    let mut traced: Vec<Traced> = lamps(&scene.emitters)
        .into_iter()
        .map(|lamp| Traced { lamp, guess: None, count: 0, stored: Vec::new(), hits: Vec::new() })
        .collect();
    let total: f64 = traced.iter().map(|t| t.lamp.flux()).sum();
    let even = 1.0 / traced.len() as f64;
    let first: Vec<f64> = traced.iter().map(|t| 0.5 * even + 0.5 * t.lamp.flux() / total).collect();
    let round = |traced: &mut Vec<Traced>, shares: &[f64], count| {
        trace(scene, [seed, kind as u32], seen, traced, shares, count);
    };
    round(&mut traced, &first, ROUNDS[0]);
    approach(seen, &mut traced, |traced| round(traced, &first, ROUNDS[0]));
    let found: f64 = traced.iter().map(|t| t.moment().sqrt()).sum();
    // one light that serves well already needs no more
    let settled = |t: &Traced| t.hits.len() >= HITS && warp(&t.hits, worth).is_none();
    if found <= 0.0 || traced.len() == 1 && settled(&traced[0]) {
        let in_view = in_view(&traced, |i| traced[i].lamp.flux());
        return Learned { guide: Guide::default(), in_view };
    }
    let second: Vec<f64> = traced
        .iter()
        .zip(&first)
        .map(|(t, f)| AGAIN * f + (1.0 - AGAIN) * t.moment().sqrt() / found)
        .collect();
    round(&mut traced, &second, ROUNDS[1]);
    let (guide, in_view) = steer(scene, &traced, total, worth);
    Learned { guide, in_view }
}

fn hits_of(traced: &[Traced]) -> usize {
    traced.iter().map(|t| t.hits.len()).sum()
}

/// Where next to no joton comes where the camera looks, a close-up in a large scene: draw directions by the jotons that came nearest to
/// it, ever nearer, until enough are there. `round` traces anew.
fn approach(seen: &VisiblePoints, traced: &mut Vec<Traced>, mut round: impl FnMut(&mut Vec<Traced>)) {
    if hits_of(traced) >= HITS {
        return;
    }
    let surroundings: Vec<Cells> = (0..=DOUBLINGS_MOST).map(|d| seen.widened(d)).collect();
    let mut doublings = surroundings.len();
    for _ in 0..APPROACHES {
        let found = hits_of(traced);
        if found >= HITS {
            return;
        }
        // the narrowest surroundings in which enough jotons were stored; where no narrower ones hold as many, the few that are there
        let narrower = surroundings[..doublings].iter().position(|cells| {
            let is_near = |s: &&Stored| cells.width(s.position, s.normal).is_some();
            traced.iter().flat_map(|t| &t.stored).filter(is_near).take(HITS).count() == HITS
        });
        if narrower.is_none() && found == 0 {
            return;
        }
        doublings = narrower.unwrap_or(0);
        let cells = &surroundings[doublings];
        for t in traced.iter_mut() {
            let near = t.stored.iter().filter(|s| cells.width(s.position, s.normal).is_some());
            t.guess = guessed(near.map(|s| (s.towards, s.weight)));
            (t.count, t.stored, t.hits) = (0, Vec::new(), Vec::new());
        }
        round(traced);
    }
}

/// Trace about `count` jotons more, shared out among the lamps.
fn trace(
    scene: &PackedScene,
    seed: [u32; 2],
    seen: &VisiblePoints,
    traced: &mut [Traced],
    shares: &[f64],
    count: u32,
) {
    traced.par_iter_mut().zip(shares).enumerate().for_each(|(i, (t, share))| {
        let more = (share * f64::from(count)).ceil() as u32;
        let numbers = (t.count..t.count + more).into_par_iter();
        let found: Vec<(Vec<Stored>, Vec<Hit>)> =
            numbers.map(|n| hits(scene, seed, seen, t, [i as u32, n])).collect();
        for (stored, hits) in found {
            t.stored.extend(stored);
            t.hits.extend(hits);
        }
        t.count += more;
    });
}

/// Where joton `number` of lamp number `index` is stored, and what it leaves where it is of use.
fn hits(
    scene: &PackedScene,
    [seed, kind]: [u32; 2],
    seen: &VisiblePoints,
    traced: &Traced,
    [index, number]: [u32; 2],
) -> (Vec<Stored>, Vec<Hit>) {
    let draw = |streams: [u32; 2]| sobol2(number, sequence_seed(seed, index, streams[kind as usize]));
    let (place, towards) = (draw(STREAM_LEARN_PLACE), draw(STREAM_LEARN_DIRECTION));
    let (towards, density) = traced.guess.as_ref().map_or((towards, 1.0), |guess| guess.place(towards));
    let weight = 1.0 / f64::from(density);
    let (emitter, rest, pick) = traced.lamp.pick(place[0]);
    let e = &scene.emitters[emitter];
    let is_caustic = kind == MapKind::Caustic as u32;
    let start = if is_caustic {
        sample_le_aimed(scene, e, [rest, place[1]], towards, 1.0 / pick)
    } else {
        Some(sample_le(scene, e, [rest, place[1]], towards, 1.0 / pick))
    };
    let (mut stored, mut hits) = (Vec::new(), Vec::new());
    let Some(Start { origin, direction, mut flux, .. }) = start else { return (stored, hits) };
    let mut ray = Ray::new(origin, direction).within(scene.media.of_emitter(emitter));
    let mut scattered = false;
    for event in 0..if is_caustic { CHAIN } else { EVENTS } {
        let Some(s) = SurfaceInteraction::hit(scene, &ray) else { break };
        let stores = (if is_caustic { event > 0 } else { scattered }) && s.flags().stores();
        if stores {
            stored.push(Stored { towards, weight, position: s.position, normal: s.ng });
        }
        if stores && let Some(width) = seen.width(s.position, s.ng) {
            let width = f64::from(width);
            let noise = sum(&flux) / if is_caustic { width * width } else { width };
            // what overflows teaches nothing
            let moment = Some(noise * noise * weight).filter(|m| m.is_finite());
            hits.extend(moment.map(|moment| Hit { number, towards, moment }));
        }
        if is_caustic && !s.flags().has_delta() {
            break;
        }
        let u = random4(seed, index, number, DIMENSION_LEARN[kind as usize] + event);
        let Some((is_d, next)) = step(&s, &flux, event, u) else { break };
        if is_caustic && is_d {
            break;
        }
        scattered |= is_d;
        (ray, flux) = next;
    }
    (stored, hits)
}

/// Part of the jotons that are stored in view where lamps are picked in proportion to `share`.
fn in_view(traced: &[Traced], share: impl Fn(usize) -> f64) -> f64 {
    let sum = |count: &dyn Fn(&Traced) -> usize| -> f64 {
        let each = traced.iter().enumerate();
        each.map(|(i, t)| share(i) * count(t) as f64 / f64::from(t.count.max(1))).sum()
    };
    let stored = sum(&|t| t.stored.len());
    if stored > 0.0 { sum(&|t| t.hits.len()) / stored } else { 1.0 }
}

/// Warps and pick probabilities from what was found, if these are worth it.
fn steer(scene: &PackedScene, traced: &[Traced], total: f64, wanted: f64) -> (Guide, f64) {
    let mut strongest: Vec<usize> = (0..traced.len()).filter(|&i| traced[i].is_known()).collect();
    strongest.sort_by(|&a, &b| traced[b].moment().total_cmp(&traced[a].moment()));
    strongest.truncate(MAX_WARPS);
    let learned: Vec<(usize, (Warp, f64))> =
        strongest.into_par_iter().filter_map(|i| Some((i, warp(&traced[i].hits, wanted)?))).collect();
    let number = |lamp: usize| learned.iter().position(|l| l.0 == lamp);
    // root of the second moment with its warp: what a lamp is worth
    let worth: Vec<f64> = (0..traced.len())
        .map(|i| (traced[i].moment() * number(i).map_or(1.0, |w| learned[w].1.1)).sqrt())
        .collect();
    let found: f64 = worth.iter().sum();
    let plain: f64 = traced.iter().map(|t| t.moment().sqrt()).sum();
    let by_flux: f64 = traced.iter().map(|t| t.moment() * total / t.lamp.flux()).sum();
    if found * found >= wanted * by_flux {
        return (Guide::default(), in_view(traced, |i| traced[i].lamp.flux()));
    }
    let share = |i: usize| (1.0 - BY_FLUX) * worth[i] / found + BY_FLUX * traced[i].lamp.flux() / total;
    let mut weights = Vec::with_capacity(scene.emitters.len());
    let mut warp_of = Vec::with_capacity(scene.emitters.len());
    for (i, t) in traced.iter().enumerate() {
        let per_flux = share(i) / t.lamp.flux();
        weights.extend(t.lamp.emitters(scene).iter().map(|e| sum(&e.flux) * per_flux));
        warp_of.resize(weights.len(), number(i));
    }
    let gain = (plain / found).powi(2);
    let warps = learned.into_iter().map(|l| l.1.0).collect();
    let guide = Guide::new(&scene.emitters, &weights, warps, |e| warp_of[e], gain);
    (guide, in_view(traced, share))
}
