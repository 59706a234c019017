//! Indirect: light that reaches a gather point by way of other D surfaces (E S* D (S* D)+ … L), by an eye path that goes on [E28].
//!
//! The path leaves the gather point by its D lobes, goes through mirrors and glass to the next D surface, adds the direct light and the
//! caustic map there, and goes on by Russian roulette. Each path of light counts once: what light does between its lamp and the first
//! D surface is direct light or caustic; emission that the path meets itself is neither, and is left out.

use super::Pass;
use super::direct::Direct;
use super::eye::{GatherPoint, survival};
use super::gather::{caustic, caustic_limits};
use super::streams::{
    DIMENSION_INDIRECT, DIMENSION_INDIRECT_LIGHT, EVENTS_MAX, STREAM_INDIRECT, STREAM_INDIRECT_BAND,
    STREAM_INDIRECT_LIGHT,
};
use crate::backend::Tally;
use crate::estimators::indirect::tile_point;
use crate::estimators::maps::MapKind;
use crate::film::paths::{Event, LightPaths};
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::constants::{INDIRECT_DISC, SURE_EVENTS, SURVIVAL_MAX};
use crate::sampling::rng::{golden, random4, sequence_seed, sequence2};
use crate::spectrum::{BLACK, Bands, add, max, mul, scale};

/// Draws of an event: the way on through mirrors and glass; where to from a D surface; its light.
const DRAWS: u32 = 3;

/// The random numbers of a path.
#[derive(Clone, Copy)]
struct Draws {
    seed: u32,
    index: u32,
    pixel: u32,
}

impl Draws {
    /// Draw `k` of an event.
    fn of(self, event: u32, k: u32) -> [f32; 4] {
        random4(self.seed, self.index, self.pixel, DIMENSION_INDIRECT + DRAWS * event + k)
    }

    /// The number that tells in which band it is transmitted where they part.
    fn band(self) -> f32 {
        golden(self.index, sequence_seed(self.seed, self.pixel, STREAM_INDIRECT_BAND))
    }
}

/// Indirect light at a gather point, times its throughput: one path. `accepted` masks the automaton's states after the D event of the
/// gather point, none where every path is wanted.
pub(super) fn light(
    pass: &Pass,
    g: &GatherPoint,
    pixel: u32,
    index: u32,
    accepted: Option<u32>,
    tally: &mut Tally,
) -> Bands {
    let (scene, plan) = (pass.scene, pass.plan);
    let seed = plan.settings.seed;
    let paths = &plan.settings.paths;
    // the paths of a tile cover its first two pairs of dimensions evenly together
    let (tile, number) = tile_point(pixel, index, scene.size);
    let even = |stream: u32, number: u64| sequence2(number, seed, tile, stream);
    let candidates = plan.light_candidates;
    let mut accepted = accepted;
    let mut sum = BLACK;
    let mut events = 0;
    let draws = Draws { seed, index, pixel };
    let before = |mask: u32, event| paths.states_before(mask, event);
    let mut here = g.clone();
    for vertex in 0.. {
        let u = draws.of(events, 1);
        let way = if events == 0 { even(STREAM_INDIRECT, number) } else { [u[1], u[2]] };
        let leaving = here.bsdf.sample_scatter(u[0], way).filter(|wi| here.bsdf.cosine(*wi) > 0.0);
        let Some(wi) = leaving else { return sum };
        let throughput = mul(&here.throughput, &here.bsdf.weight_scatter(wi));
        // the first goes on for sure: neighbours share what it finds
        let kept = if events == 0 { 1.0 } else { max(&throughput) / max(&here.throughput) };
        let survives = if events < SURE_EVENTS { kept.min(1.0) } else { kept.min(SURVIVAL_MAX) };
        if u[3] >= survives || max(&throughput) <= 0.0 {
            return sum;
        }
        events += 1;
        let throughput = scale(&throughput, 1.0 / survives);
        accepted = accepted.map(|mask| before(mask, Event::D));
        let Some(next) = follow(pass, here.ray(wi), throughput, here.length, &mut events, draws, tally)
        else {
            return sum;
        };
        accepted = accepted.map(|mask| (0..next.chain).fold(mask, |mask, _| before(mask, Event::S)));
        let after_d = paths.step(LightPaths::START, Event::D);
        if accepted.is_none_or(|mask| mask >> after_d & 1 == 1) {
            let direct = Direct::at(scene, plan, &next);
            let places = (0..candidates).map(|k| {
                if vertex == 0 {
                    return even(STREAM_INDIRECT_LIGHT, number * u64::from(candidates) + u64::from(k));
                }
                let [x, y, ..] =
                    random4(seed, index, pixel, DIMENSION_INDIRECT_LIGHT + candidates * events + k);
                [x, y]
            });
            sum = add(&sum, &mul(&next.throughput, &direct.sample(places, draws.of(events, 2), tally)));
        }
        if plan.has_map(MapKind::Caustic) {
            let [_, largest] = caustic_limits(scene, plan, &next);
            let radius = INDIRECT_DISC * largest * pass.caustic_shrink.sqrt();
            sum = add(&sum, &caustic(pass, &next, radius, false, accepted));
        }
        here = next;
    }
    sum
}

/// The next D vertex of a path, through mirrors and glass.
fn follow<'a>(
    pass: &Pass<'a>,
    mut ray: Ray,
    mut throughput: Bands,
    mut length: f32,
    events: &mut u32,
    draws: Draws,
    tally: &mut Tally,
) -> Option<GatherPoint<'a>> {
    for chain in 0.. {
        if *events >= EVENTS_MAX / DRAWS {
            tally.truncated += 1;
            return None;
        }
        tally.rays += 1;
        let s = SurfaceInteraction::hit(pass.scene, &ray)?;
        length += s.distance;
        throughput = s.through(&throughput);
        let mut bsdf = Bsdf::at(&s);
        let shares = bsdf.shares(&throughput);
        let kept = shares.kept();
        if kept <= 0.0 {
            return None;
        }
        let [u_way, u0, u1, u_survive] = draws.of(*events, 0);
        let choice = u_way * kept;
        if choice < shares.scatter {
            return Some(GatherPoint {
                position: s.position,
                ng: s.ng,
                front: s.front,
                ns: s.ns,
                wo: s.back,
                throughput: scale(&throughput, kept / shares.scatter),
                bsdf,
                triangle: s.triangle,
                inside: s.sides.here,
                chain,
                length,
            });
        }
        bsdf.part_bands(s.between(), &throughput, || draws.band());
        let lobe = shares.pick_delta(choice - shares.scatter);
        let direction = bsdf.sample_delta(lobe, [u0, u1])?;
        let survival = survival(*events, kept);
        if u_survive >= survival {
            return None;
        }
        let chance = shares.delta[lobe] / kept * survival;
        throughput = scale(&bsdf.through_delta(lobe, direction, &throughput), 1.0 / chance);
        ray = s.leave(direction);
        *events += 1;
    }
    None
}
