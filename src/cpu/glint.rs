//! Glint: emission that is small in the image (E S* L): a lamp in a water surface, the rim of a lamp. A few camera chains
//! that branch evenly between reflection and refraction find it; a pixel's one eye path would alias it for hundreds of
//! passes. Only in pixels that a pilot marked; the eye path's own emission counts in the others.

use super::eye::{Split, cross, ray_through, survival, wants_emission};
use super::neighbours::around;
use super::streams::{DIMENSION_GLINT, EVENTS_MAX, STREAM_GLINT_CHOICE, STREAM_GLINT_JITTER};
use crate::backend::Tally;
use crate::bands::{BLACK, Bands, add, is_black, max, mul, scale};
use crate::optics::bsdf::sample_mirror;
use crate::optics::ray::Surface;
use crate::pack::PackedScene;
use crate::plan::Plan;
use crate::rng::{random4, sequence_seed, sobol2};
use rayon::prelude::*;

/// Chains of a marked pixel in a pass.
const CHAINS: u32 = 4;
/// Chains of a pixel in the pilot …
const PILOT_CHAINS: u32 = 8;
/// … and of those the ones that tell whether there is anything to see but D surfaces: most pixels need no more.
const PILOT_FIRST: u32 = 2;
/// Events at which both branches get the same chance: into a body, out of it, and one to spare. Longer chains carry too
/// little to be worth a doubling.
const EVEN_EVENTS: u32 = 3;

/// What one chain saw.
struct Seen {
    /// Radiance of the emitters on it.
    emission: Bands,
    /// It ended on an emitter, with nothing specular before.
    direct: bool,
    /// There was a specular event.
    specular: bool,
}

/// What the pilot's chains saw of light in a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Light {
    Nowhere,
    InPart,
    /// Every chain, and directly.
    Everywhere,
}

/// Follow chain `number` of a pixel through specular events only; count the emission that is `wanted` after so many.
/// Nothing is scattered or absorbed by chance: what D events would take is in the reflectance.
fn chain(
    scene: &PackedScene,
    seed: u32,
    pixel: u32,
    number: u32,
    wanted: impl Fn(u32) -> bool,
    tally: &mut Tally,
) -> Seen {
    let place = sobol2(number, sequence_seed(seed, pixel, STREAM_GLINT_JITTER));
    let choices = sobol2(number, sequence_seed(seed, pixel, STREAM_GLINT_CHOICE));
    let mut ray = ray_through(scene, pixel, place);
    let mut throughput = [1.0; crate::bands::BANDS];
    let mut seen = Seen { emission: BLACK, direct: false, specular: false };
    for event in 0..EVENTS_MAX {
        tally.rays += 1;
        let Some(s) = Surface::hit(scene, &ray) else { return seen };
        if s.front && s.flags().is_emissive() && wanted(event) {
            seen.emission = add(&seen.emission, &mul(&throughput, &s.material.emission));
            seen.direct = event == 0;
        }
        if !s.flags().has_delta() {
            return seen;
        }
        (seen.direct, seen.specular) = (false, true);
        let [u_way, u0, u1, u_survive] = random4(seed, number, pixel, DIMENSION_GLINT + event);
        let carried = max(&throughput);
        let (on, kept) = if s.flags().is_dielectric() {
            let split = if event < EVEN_EVENTS { Split::Even } else { Split::ByFlux };
            cross(&s, &mut throughput, choices.get(event as usize).copied().unwrap_or(u_way), split)
        } else {
            throughput = mul(&throughput, &s.material.specular);
            (sample_mirror(&s, [u0, u1]), max(&throughput))
        };
        let Some(direction) = on.filter(|_| !is_black(&throughput)) else { return seen };
        let survival = survival(event, kept / carried);
        if u_survive >= survival {
            return seen;
        }
        throughput = scale(&throughput, 1.0 / survival);
        ray = s.leave(direction);
    }
    tally.truncated += 1;
    seen
}

/// The emission of a marked pixel: one pass's estimate.
pub(super) fn emission(scene: &PackedScene, plan: &Plan, pixel: u32, pass: u32, tally: &mut Tally) -> Bands {
    let first = pass.wrapping_mul(CHAINS);
    let wanted = |chain| wants_emission(plan, chain);
    let sum = (0..CHAINS).fold(BLACK, |sum, i| {
        let seen = chain(scene, plan.settings.seed, pixel, first.wrapping_add(i), wanted, tally);
        add(&sum, &seen.emission)
    });
    scale(&sum, 1.0 / CHAINS as f32)
}

/// The pixels that are left to [`emission`]: those that see light in some of their chains, or see something else than
/// a neighbour does. Pixels inside a lamp, and far from any, are not. The pilot's chains are the last of their
/// sequences: no pass uses them, so the choice costs no bias. It knows no --paths: the parts of an image add up.
pub(super) fn mark(scene: &PackedScene, seed: u32, pilot: u32) -> Vec<bool> {
    let look = |pixel: u32, chains: u32| {
        let (mut lit, mut direct, mut specular) = (0, 0, false);
        for i in 0..chains {
            let number = pilot.wrapping_mul(PILOT_CHAINS).wrapping_add(i);
            let seen = chain(scene, seed, pixel, number, |_| true, &mut Tally::default());
            lit += u32::from(!is_black(&seen.emission));
            direct += u32::from(seen.direct);
            specular |= seen.specular;
        }
        match (lit, direct) {
            // too few chains to say that glass shows no light
            (0, _) if specular && chains < PILOT_CHAINS => Light::InPart,
            (0, _) => Light::Nowhere,
            _ if direct == chains => Light::Everywhere,
            _ => Light::InPart,
        }
    };
    let pixels = || (0..scene.pixels() as u32).into_par_iter();
    let first: Vec<Light> = pixels().map(|pixel| look(pixel, PILOT_FIRST)).collect();
    let open = mixed(&first, scene.size);
    let found: Vec<Light> =
        pixels().map(|i| if open[i as usize] { look(i, PILOT_CHAINS) } else { first[i as usize] }).collect();
    mixed(&found, scene.size)
}

/// Where light is seen in part, or a neighbour sees it otherwise.
fn mixed(found: &[Light], size: [u32; 2]) -> Vec<bool> {
    let is_mixed = |(pixel, here): (usize, &Light)| {
        around(pixel as u32, size).any(|i| found[i] == Light::InPart || found[i] != *here)
    };
    found.iter().enumerate().map(is_mixed).collect()
}
