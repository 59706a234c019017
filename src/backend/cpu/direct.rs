//! Direct: light that reaches a gather point straight from an emitter (L D S* E), by shadow rays.
//!
//! L = Σ f Le |cos_s| cos_l V / (d² pick pdf_area) [E5]; where the surface is glossy or
//! touches an emitter, each shadow ray shares its weight with one BSDF sample by the balance heuristic (Veach & Guibas
//! 1995).

use super::eye::GatherPoint;
use super::streams::{DIMENSION_BSDF, STREAM_LIGHT};
use crate::backend::Tally;
use crate::optics::lights::pick::{pdf_light, sample_light};
use crate::optics::lights::reservoir::Reservoir;
use crate::optics::lights::samples::LightSample;
use crate::optics::lights::{is_near, le, on_miss};
use crate::optics::ray::{Ray, SurfaceInteraction, lift, visible};
use crate::packed::constants::NEAR_EMITTERS_MAX;
use crate::packed::{PackedEmitter, PackedScene};
use crate::plan::Plan;
use crate::sampling::rng::{random4, sequence2};
use crate::spectrum::{BLACK, Bands, add, is_black, max, mul, scale};
use glam::Vec3;

/// Direct light at a gather point, times its throughput: one pass's estimate.
pub(super) fn light(
    scene: &PackedScene,
    plan: &Plan,
    g: &GatherPoint,
    pixel: u32,
    pass: u32,
    tally: &mut Tally,
) -> Bands {
    let settings = &plan.settings;
    let lights = plan.guides.direct.emitters(&scene.emitters);
    let count = settings.shadow_rays;
    let shared = g.bsdf.scatter.varies() || near_emitter(lights, g.position);
    let mut sum = BLACK;
    for ray in 0..count {
        let is_drawn = shared || plan.light_candidates > 1;
        let u = if is_drawn { random4(settings.seed, pass, pixel, DIMENSION_BSDF + ray) } else { [0.0; 4] };
        let [pass, count, ray, number] = [pass, count, ray, plan.light_candidates].map(u64::from);
        let first = (pass * count + ray) * number;
        let candidates = (0..plan.light_candidates)
            .map(|k| sequence2(first + u64::from(k), settings.seed, pixel, STREAM_LIGHT));
        sum = add(&sum, &by_light(scene, lights, g, candidates, u[3], shared, tally));
        if shared {
            sum = add(&sum, &by_bsdf(scene, lights, g, u, plan.light_candidates as f32, tally));
        }
    }
    scale(&mul(&sum, &g.throughput), 1.0 / count as f32)
}

/// True where `position` may lie so near to a light that shadow rays alone have fireflies. Depends on no
/// random number but the place, so the choice of estimator costs no bias.
fn near_emitter(lights: &[PackedEmitter], position: Vec3) -> bool {
    lights.len() > NEAR_EMITTERS_MAX as usize || lights.iter().any(|e| is_near(e, position))
}

/// The light of one of some candidates, picked by what each would give if nothing shaded it, for all of them [E24].
fn by_light(
    scene: &PackedScene,
    lights: &[PackedEmitter],
    g: &GatherPoint,
    candidates: impl ExactSizeIterator<Item = [f32; 2]>,
    choice: f32,
    shared: bool,
    tally: &mut Tally,
) -> Bands {
    let origin = lift(g.position, g.ng, g.triangle);
    let number = candidates.len() as f32;
    let mut picked: Option<(LightSample, Bands)> = None;
    let mut reservoir = Reservoir::new(choice);
    for u in candidates {
        let Some(l) = sample_light(lights, origin, u) else { continue };
        let given = unshadowed(g, &l, number, shared);
        let size = max(&given);
        if size <= 0.0 {
            continue;
        }
        if reservoir.takes(size) {
            picked = Some((l, given));
        }
        tally.shadow_rays_saved += 1;
    }
    let Some((l, given)) = picked else { return BLACK };
    tally.rays += 1;
    tally.shadow_rays_saved -= 1;
    if visible(scene, origin, l.target) {
        scale(&given, reservoir.total / (number * max(&given)))
    } else {
        BLACK
    }
}

/// What a light sample, one of `number` candidates, gives if nothing shades it, with its share of the weight.
fn unshadowed(g: &GatherPoint, l: &LightSample, number: f32, shared: bool) -> Bands {
    let cos_s = l.wi.dot(g.ns);
    if cos_s <= 0.0 || l.wi.dot(g.ng) <= 0.0 {
        return BLACK;
    }
    let pdf = number * l.pdf;
    let weight = if shared && pdf > 0.0 { pdf / (pdf + g.bsdf.pdf_scatter(l.wi)) } else { 1.0 };
    let matte = g.bsdf.eval_scatter(l.wi);
    // what has an area is met where the lobe is followed
    let f = if l.pdf > 0.0 { matte } else { add(&matte, &g.bsdf.eval_narrow(l.wi)) };
    scale(&mul(&f, &l.irradiance), cos_s * weight)
}

/// Light that one sample of the D lobes finds, beside `number` candidates.
fn by_bsdf(
    scene: &PackedScene,
    lights: &[PackedEmitter],
    g: &GatherPoint,
    u: [f32; 4],
    number: f32,
    tally: &mut Tally,
) -> Bands {
    let Some(wi) = g.bsdf.sample_scatter(u[2], [u[0], u[1]]) else { return BLACK };
    if wi.dot(g.ng) <= 0.0 {
        return BLACK;
    }
    tally.rays += 1;
    let ray = Ray::new(lift(g.position, g.ng, g.triangle), wi);
    let (found, pdf_light) = match SurfaceInteraction::hit(scene, &ray) {
        Some(s) => (le(&s).copied().unwrap_or(BLACK), number * pdf_light(lights, &s)),
        None => (on_miss(wi), 0.0),
    };
    if is_black(&found) {
        return BLACK;
    }
    // balance heuristic: f Le cos/pdf · pdf/(pdf + pdf_light)
    let weight = wi.dot(g.ns) / (g.bsdf.pdf_scatter(wi) + pdf_light);
    scale(&mul(&g.bsdf.eval_scatter(wi), &found), weight)
}
