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
use crate::optics::emit::kind;
use crate::optics::light::{pdf_light, sample_light};
use crate::optics::ray::{Ray, Surface, lift, visible};
use crate::pack::{EmitterKind, PackedEmitter, PackedScene};
use crate::plan::Plan;
use crate::rng::{random4, sequence_seed, sobol2};
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
    let seed = sequence_seed(settings.seed, pixel, STREAM_LIGHT);
    let shared = g.material.flags().has_glossy() || near_emitter(lights, g.position);
    let mut sum = BLACK;
    for ray in 0..count {
        let index = pass.wrapping_mul(count).wrapping_add(ray);
        sum = add(&sum, &by_light(scene, lights, g, sobol2(index, seed), shared, tally));
        if shared {
            let u = random4(settings.seed, pass, pixel, DIMENSION_BSDF + ray);
            sum = add(&sum, &by_bsdf(scene, lights, g, u, tally));
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
fn near_emitter(lights: &[PackedEmitter], position: Vec3) -> bool {
    lights.len() > NEAR_EMITTERS_MAX
        || lights.iter().filter(|e| kind(e) == EmitterKind::Triangle).any(|e| {
            let to_center = (e.e1 + e.e2) / 3.0;
            let reach = to_center.length().max((e.e1 - to_center).length()).max((e.e2 - to_center).length());
            let near = reach + NEAR_WIDTH * (e.area / e.pick).sqrt();
            (e.origin + to_center - position).length_squared() < near * near
        })
}

fn by_light(
    scene: &PackedScene,
    lights: &[PackedEmitter],
    g: &GatherPoint,
    u: [f32; 2],
    shared: bool,
    tally: &mut Tally,
) -> Bands {
    let origin = lift(g.position, g.ng, g.triangle);
    let Some(l) = sample_light(lights, origin, u) else { return BLACK };
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

fn by_bsdf(
    scene: &PackedScene,
    lights: &[PackedEmitter],
    g: &GatherPoint,
    u: [f32; 4],
    tally: &mut Tally,
) -> Bands {
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
    let weight = wi.dot(g.ns) / (pdf_d(g.material, wi, g.wo, g.ns) + pdf_light(lights, &s));
    scale(&mul(&eval_d(g.material, wi, g.wo, g.ns), &s.material.emission), weight)
}
