//! Direct: light that reaches a gather point straight from an emitter (L D S* E), by shadow rays.
//!
//! L = Σ f Le |cos_s| cos_l V / (d² pick pdf_area) [E5]; where the surface is glossy or
//! touches an emitter, each shadow ray shares its weight with one BSDF sample by the balance heuristic (Veach & Guibas
//! 1995).

use super::eye::GatherPoint;
use super::streams::{DIMENSION_BSDF, STREAM_LIGHT};
use crate::backend::Tally;
use crate::bands::{BLACK, Bands, add, mul, scale};
use crate::optics::bsdf::{eval_d, pdf_d, sample_d};
use crate::optics::emit::{falloff, kind, pick, place_on};
use crate::optics::ray::{Ray, Surface, lift, visible};
use crate::pack::{EmitterKind, NO_EMITTER, PackedScene};
use crate::plan::Plan;
use crate::rng::{random4, sequence_seed, sobol2};
use glam::Vec3;

/// A place on an emitter, seen from a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct LightSample {
    /// Unit vector toward the emitter.
    pub(super) wi: Vec3,
    /// Where a shadow ray must arrive.
    pub(super) target: Vec3,
    /// Irradiance across `wi` over the probability of this sample: Le cos_l/(d² pick pdf_area), I/(d² pick), E/pick.
    pub(super) irradiance: Bands,
    /// pdf_solid_angle with `pick`; 0 where no BSDF sample can find the emitter.
    pub(super) pdf: f32,
}

/// Shadow rays to the sun end outside the scene: its radius is below 1024 internal units.
const BEYOND: f32 = 4096.0;

/// A place on an emitter picked by flux; None where it shines away from `position`.
pub(super) fn sample_light(scene: &PackedScene, position: Vec3, u: [f32; 2]) -> Option<LightSample> {
    let (e, rest) = pick(&scene.emitters, u[0]);
    let towards = |target: Vec3| {
        let offset = target - position;
        let distance_squared = offset.length_squared();
        (distance_squared > 0.0).then(|| (offset / distance_squared.sqrt(), distance_squared))
    };
    match kind(e) {
        EmitterKind::Triangle => {
            let (target, normal) = place_on(e, [rest, u[1]]);
            let (wi, distance_squared) = towards(target)?;
            let cos_l = -wi.dot(normal);
            let per_solid_angle = e.area * cos_l / distance_squared;
            let weight = per_solid_angle / e.pick;
            (cos_l > 0.0).then(|| LightSample {
                wi,
                target,
                irradiance: scale(&e.strength, weight),
                pdf: 1.0 / weight,
            })
        }
        EmitterKind::Point | EmitterKind::Spot => {
            let (wi, distance_squared) = towards(e.origin)?;
            let shape = if kind(e) == EmitterKind::Spot { falloff(e, -wi) } else { 1.0 };
            let irradiance = scale(&e.strength, shape / (distance_squared * e.pick));
            (shape > 0.0).then_some(LightSample { wi, target: e.origin, irradiance, pdf: 0.0 })
        }
        EmitterKind::Sun => Some(LightSample {
            wi: -e.e1,
            target: position - e.e1 * BEYOND,
            irradiance: scale(&e.strength, 1.0 / e.pick),
            pdf: 0.0,
        }),
    }
}

/// pdf_solid_angle with which [`sample_light`] finds the emissive surface `s` from where its ray came.
pub(super) fn pdf_light(scene: &PackedScene, s: &Surface) -> f32 {
    if s.triangle.emitter == NO_EMITTER {
        return 0.0;
    }
    let e = &scene.emitters[s.triangle.emitter as usize];
    e.pick * s.distance * s.distance / (e.area * s.back.dot(s.ng))
}

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
    let count = settings.shadow_rays;
    let seed = sequence_seed(settings.seed, pixel, STREAM_LIGHT);
    let shared = g.material.flags().has_glossy() || near_emitter(scene, g.position);
    let mut sum = BLACK;
    for ray in 0..count {
        let index = pass.wrapping_mul(count).wrapping_add(ray);
        sum = add(&sum, &by_light(scene, g, sobol2(index, seed), shared, tally));
        if shared {
            let u = random4(settings.seed, pass, pixel, DIMENSION_BSDF + ray);
            sum = add(&sum, &by_bsdf(scene, g, u, tally));
        }
    }
    scale(&mul(&sum, &g.throughput), 1.0 / count as f32)
}

/// Emitters whose distance is worth a look, one by one.
const NEAR_EMITTERS_MAX: usize = 64;
/// An emitter is near within this part of the width √(A/pick) that it stands for: 1/d² makes the weight of a shadow
/// ray unbounded there, its variance infinite.
const NEAR_WIDTH: f32 = 0.5;

/// True where `position` may lie so near to an emissive triangle that shadow rays alone have fireflies. Depends on no
/// random number but the place, so the choice of estimator costs no bias.
fn near_emitter(scene: &PackedScene, position: Vec3) -> bool {
    scene.emitters.len() > NEAR_EMITTERS_MAX
        || scene.emitters.iter().filter(|e| kind(e) == EmitterKind::Triangle).any(|e| {
            let to_center = (e.e1 + e.e2) / 3.0;
            let reach = to_center.length().max((e.e1 - to_center).length()).max((e.e2 - to_center).length());
            let near = reach + NEAR_WIDTH * (e.area / e.pick).sqrt();
            (e.origin + to_center - position).length_squared() < near * near
        })
}

fn by_light(scene: &PackedScene, g: &GatherPoint, u: [f32; 2], shared: bool, tally: &mut Tally) -> Bands {
    let origin = lift(g.position, g.ng, g.triangle);
    let Some(l) = sample_light(scene, origin, u) else { return BLACK };
    let cos_s = l.wi.dot(g.ns);
    if cos_s <= 0.0 || l.wi.dot(g.ng) <= 0.0 {
        return BLACK;
    }
    tally.rays += 1;
    if !visible(scene, origin, l.target) {
        return BLACK;
    }
    let weight =
        if shared && l.pdf > 0.0 { l.pdf / (l.pdf + pdf_d(g.material, l.wi, g.wo, g.ns)) } else { 1.0 };
    scale(&mul(&eval_d(g.material, l.wi, g.wo, g.ns), &l.irradiance), cos_s * weight)
}

fn by_bsdf(scene: &PackedScene, g: &GatherPoint, u: [f32; 4], tally: &mut Tally) -> Bands {
    let Some(wi) = sample_d(g.material, g.wo, g.ns, u[2], [u[0], u[1]]) else { return BLACK };
    if wi.dot(g.ng) <= 0.0 {
        return BLACK;
    }
    tally.rays += 1;
    let ray = Ray { origin: lift(g.position, g.ng, g.triangle), direction: wi };
    let Some(s) = Surface::hit(scene, &ray) else { return BLACK };
    if !s.front || !s.flags().is_emissive() {
        return BLACK;
    }
    // balance heuristic: f Le cos/pdf · pdf/(pdf + pdf_light)
    let weight = wi.dot(g.ns) / (pdf_d(g.material, wi, g.wo, g.ns) + pdf_light(scene, &s));
    scale(&mul(&eval_d(g.material, wi, g.wo, g.ns), &s.material.emission), weight)
}
