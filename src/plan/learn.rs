//! Learn: where the caustic jotons that the camera can see come from, by tracing some tens of thousands on the host [E20].
//!
//! Whatever is learned, nothing is left out: every light keeps a part of its flux's share, every bin of a warp a part of its
//! area's, and the flux of a joton is divided by the probability that is really used.

use super::seen::{CHAIN, Seen, specular_step};
use crate::bands::sum;
use crate::optics::emit::{Start, aimed_of};
use crate::optics::ray::{Ray, Surface};
use crate::pack::{Guide, MAX_WARPS, PackedEmitter, PackedScene, WARP_BINS, Warp};
use crate::rng::{random4, sequence_seed, sobol2};
use rayon::prelude::*;

/// Jotons of the two rounds: the second goes where the first found something.
const ROUNDS: [u32; 2] = [1 << 13, 3 << 13];
/// Most lamps that are told apart; beyond, neighbours in the list are taken together.
const LAMPS: usize = 512;
/// Emissive triangles in a row are one lamp where the cosine between their normals is at least this.
const ONE_LAMP: f32 = 0.999;
/// Part of the jotons that are picked by flux alone, whatever was learned.
const BY_FLUX: f64 = 0.1;
/// Part of the second round that follows the first round's shares.
const AGAIN: f64 = 0.25;
/// Parts of a warp that are spread evenly, and times that its bins are smoothed: the pair that serves best is taken.
const EVEN: [f64; 3] = [0.05, 0.1, 0.2];
const SMOOTHINGS: [u32; 3] = [0, 1, 3];
/// A warp must lower the second moment to this part of what it is.
const WORTH: f64 = 0.9;
/// Useful jotons that a warp is learned from, at least.
const HITS: usize = 64;
/// Purposes of random numbers; those of the backends lie below.
const STREAM_PLACE: u32 = 0x201;
const STREAM_DIRECTION: u32 = 0x202;
const DIMENSION_LEARN: u32 = 0x11_0000;

/// A joton that some gather point can use.
struct Hit {
    /// Its number among its lamp's.
    number: u32,
    /// Where on the square of directions it started.
    towards: [f32; 2],
    /// Square of the irradiance that it adds to its cell, all bands, as if its lamp had no other joton: cells are as
    /// large as pixels make them, so this is how much its noise counts in the image.
    moment: f64,
}

/// What is known of one lamp.
struct Lamp {
    /// Number of its first emitter.
    first: usize,
    /// Flux of its emitters up to and including each, internal W, all bands.
    flux_upto: Vec<f64>,
    /// Jotons traced.
    traced: u32,
    hits: Vec<Hit>,
}

impl Lamp {
    fn flux(&self) -> f64 {
        self.flux_upto.last().copied().unwrap_or(0.0)
    }

    /// The emitter that `u` picks by flux, what is left of `u`, and the probability of picking it.
    fn pick(&self, u: f32) -> (usize, f32, f32) {
        let wanted = f64::from(u) * self.flux();
        let i = self.flux_upto.partition_point(|&f| f <= wanted).min(self.flux_upto.len() - 1);
        let below = if i == 0 { 0.0 } else { self.flux_upto[i - 1] };
        let flux = self.flux_upto[i] - below;
        let rest = ((wanted - below) / flux.max(f64::MIN_POSITIVE)) as f32;
        (self.first + i, rest.clamp(0.0, 1.0 - f32::EPSILON), (flux / self.flux()) as f32)
    }

    /// Mean square of the useful flux of a joton.
    fn moment(&self) -> f64 {
        self.hits.iter().map(|h| h.moment).sum::<f64>() / f64::from(self.traced.max(1))
    }
}

/// Learn how to emit the caustic jotons of a scene.
pub(super) fn guide(scene: &PackedScene, seed: u32) -> Guide {
    let seen = Seen::look(scene, seed);
    if seen.is_empty() || scene.targets.is_empty() {
        return Guide::default();
    }
    let mut lamps = lamps(&scene.emitters);
    let total: f64 = lamps.iter().map(Lamp::flux).sum();
    let even = 1.0 / lamps.len() as f64;
    let first: Vec<f64> = lamps.iter().map(|l| 0.5 * even + 0.5 * l.flux() / total).collect();
    trace(scene, seed, &seen, &mut lamps, &first, ROUNDS[0]);
    let found: f64 = lamps.iter().map(|l| l.moment().sqrt()).sum();
    // one light that serves well already needs no more
    let settled = |l: &Lamp| l.hits.len() >= HITS && warp(&l.hits).is_none();
    if found <= 0.0 || lamps.len() == 1 && settled(&lamps[0]) {
        return Guide::default();
    }
    let second: Vec<f64> = lamps
        .iter()
        .zip(&first)
        .map(|(l, f)| AGAIN * f + (1.0 - AGAIN) * l.moment().sqrt() / found)
        .collect();
    trace(scene, seed, &seen, &mut lamps, &second, ROUNDS[1]);
    steer(scene, &lamps, total)
}

/// Emitters in runs: triangles of one lamp, and what must be taken together to be few enough.
fn lamps(emitters: &[PackedEmitter]) -> Vec<Lamp> {
    let normal = |e: &PackedEmitter| e.e1.cross(e.e2).normalize_or_zero();
    let continues = |a: &PackedEmitter, b: &PackedEmitter| {
        a.kind == 0 && b.kind == 0 && a.strength == b.strength && normal(a).dot(normal(b)) > ONE_LAMP
    };
    let mut starts: Vec<usize> =
        (0..emitters.len()).filter(|&i| i == 0 || !continues(&emitters[i - 1], &emitters[i])).collect();
    let together = starts.len().div_ceil(LAMPS);
    starts = starts.into_iter().step_by(together.max(1)).collect();
    let ends: Vec<usize> = starts.iter().skip(1).copied().chain([emitters.len()]).collect();
    starts
        .into_iter()
        .zip(ends)
        .map(|(first, end)| {
            let mut upto = 0.0;
            let add = |e: &PackedEmitter| {
                upto += sum(&e.flux);
                upto
            };
            let flux_upto = emitters[first..end].iter().map(add).collect();
            Lamp { first, flux_upto, traced: 0, hits: Vec::new() }
        })
        .collect()
}

/// Trace about `count` jotons more, shared out among the lamps.
fn trace(scene: &PackedScene, seed: u32, seen: &Seen, lamps: &mut [Lamp], shares: &[f64], count: u32) {
    lamps.par_iter_mut().zip(shares).enumerate().for_each(|(i, (lamp, share))| {
        let more = (share * f64::from(count)).ceil() as u32;
        let numbers = (lamp.traced..lamp.traced + more).into_par_iter();
        let found: Vec<Hit> =
            numbers.flat_map_iter(|n| hits(scene, seed, seen, lamp, [i as u32, n])).collect();
        lamp.hits.extend(found);
        lamp.traced += more;
    });
}

/// What joton `number` of lamp number `index` leaves where it is of use.
fn hits(scene: &PackedScene, seed: u32, seen: &Seen, lamp: &Lamp, [index, number]: [u32; 2]) -> Vec<Hit> {
    let draw = |stream| sobol2(number, sequence_seed(seed, index, stream));
    let (place, towards) = (draw(STREAM_PLACE), draw(STREAM_DIRECTION));
    let (emitter, rest, pick) = lamp.pick(place[0]);
    let start = aimed_of(scene, &scene.emitters[emitter], [rest, place[1]], towards, 1.0 / pick);
    let Some(Start { origin, direction, mut flux }) = start else { return Vec::new() };
    let mut ray = Ray { origin, direction };
    let mut hits = Vec::new();
    for event in 0..CHAIN {
        let Some(s) = Surface::hit(scene, &ray) else { break };
        if event > 0
            && s.flags().has_diffuse()
            && let Some(width) = seen.width(s.position, s.ng)
        {
            let irradiance = sum(&flux) / f64::from(width * width);
            // what overflows teaches nothing
            let moment = Some(irradiance * irradiance).filter(|m| m.is_finite());
            hits.extend(moment.map(|moment| Hit { number, towards, moment }));
        }
        if !s.flags().has_delta() {
            break;
        }
        let u = random4(seed, index, number, DIMENSION_LEARN + event);
        let Some(next) = specular_step(&s, &flux, event, u) else { break };
        (ray, flux) = next;
    }
    hits
}

/// Warps and pick probabilities from what was found.
fn steer(scene: &PackedScene, lamps: &[Lamp], total: f64) -> Guide {
    let mut strongest: Vec<usize> = (0..lamps.len()).filter(|&i| lamps[i].hits.len() >= HITS).collect();
    strongest.sort_by(|&a, &b| lamps[b].moment().total_cmp(&lamps[a].moment()));
    strongest.truncate(MAX_WARPS);
    let learned: Vec<(usize, (Warp, f64))> =
        strongest.into_par_iter().filter_map(|i| Some((i, warp(&lamps[i].hits)?))).collect();
    let number = |lamp: usize| learned.iter().position(|l| l.0 == lamp);
    if lamps.len() == 1 && learned.is_empty() {
        return Guide::default();
    }
    // root of the second moment with its warp: what a lamp is worth
    let worth: Vec<f64> = (0..lamps.len())
        .map(|i| (lamps[i].moment() * number(i).map_or(1.0, |w| learned[w].1.1)).sqrt())
        .collect();
    let found: f64 = worth.iter().sum();
    let plain: f64 = lamps.iter().map(|l| l.moment().sqrt()).sum();
    let mut weights = Vec::with_capacity(scene.emitters.len());
    let mut warp_of = Vec::with_capacity(scene.emitters.len());
    for (i, lamp) in lamps.iter().enumerate() {
        let per_flux = (1.0 - BY_FLUX) * worth[i] / found / lamp.flux() + BY_FLUX / total;
        for e in &scene.emitters[lamp.first..][..lamp.flux_upto.len()] {
            weights.push(sum(&e.flux) * per_flux);
            warp_of.push(number(i));
        }
    }
    let warps = learned.into_iter().map(|l| l.1.0).collect();
    Guide::new(&scene.emitters, &weights, warps, |e| warp_of[e], (plain / found).powi(2))
}

/// The warp that lowers the second moment most, and to what part; none where it is not worth it. Each half of the hits
/// judges what is learned from the other.
fn warp(hits: &[Hit]) -> Option<(Warp, f64)> {
    let half = |parity: u32| move |h: &&Hit| h.number % 2 == parity;
    let candidates = SMOOTHINGS.iter().flat_map(|&s| EVEN.map(|e| (s, e)));
    let judged = candidates.map(|(smoothings, even)| {
        let part: f64 = (0..2)
            .map(|parity| {
                let density =
                    density(&smoothed(&moments(hits.iter().filter(half(1 - parity))), smoothings), even);
                let judges = || hits.iter().filter(half(parity));
                let after: f64 = judges().map(|h| h.moment / density[bin(h.towards)]).sum();
                0.5 * after / judges().map(|h| h.moment).sum::<f64>()
            })
            .sum();
        (part, smoothings, even)
    });
    let (part, smoothings, even) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let density = density(&smoothed(&moments(hits.iter()), smoothings), even);
    (part < WORTH).then(|| (Warp::new(&density), part))
}

/// Bin of a place in the square.
fn bin(towards: [f32; 2]) -> usize {
    let [row, column] = towards.map(|x| (x * WARP_BINS as f32) as usize);
    row * WARP_BINS + column
}

/// Sum of the squared flux in each bin.
fn moments<'a>(hits: impl Iterator<Item = &'a Hit>) -> Vec<f64> {
    let mut bins = vec![0.0; WARP_BINS * WARP_BINS];
    for h in hits {
        bins[bin(h.towards)] += h.moment;
    }
    bins
}

/// Every bin shared with its neighbours, a few times: rows end at the square's edge, columns go round it, as azimuths do.
fn smoothed(bins: &[f64], times: u32) -> Vec<f64> {
    let n = WARP_BINS;
    let mut bins = bins.to_vec();
    for _ in 0..times {
        let at = |b: &[f64], row: usize, column: usize| b[row * n + column];
        let across: Vec<f64> = (0..n * n)
            .map(|i| {
                let (r, c) = (i / n, i % n);
                0.25 * (at(&bins, r, (c + n - 1) % n) + at(&bins, r, (c + 1) % n)) + 0.5 * at(&bins, r, c)
            })
            .collect();
        bins = (0..n * n)
            .map(|i| {
                let (r, c) = (i / n, i % n);
                let (before, after) = (r.saturating_sub(1), (r + 1).min(n - 1));
                0.25 * (at(&across, before, c) + at(&across, after, c)) + 0.5 * at(&across, r, c)
            })
            .collect();
    }
    bins
}

/// Density that serves bins with these second moments best: proportional to their roots, but for the part `even`.
fn density(moments: &[f64], even: f64) -> Vec<f64> {
    let mean = moments.iter().map(|m| m.sqrt()).sum::<f64>() / moments.len() as f64;
    moments.iter().map(|m| even + (1.0 - even) * m.sqrt() / mean.max(f64::MIN_POSITIVE)).collect()
}
