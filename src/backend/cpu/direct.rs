//! Direct: light that reaches a gather point straight from an emitter (L D S* E), by shadow rays.
//!
//! L = Σ f Le |cos_s| cos_l V / (d² pick pdf_area) [E5]; where the surface is glossy or
//! touches an emitter, each shadow ray shares its weight with one BSDF sample by the balance heuristic (Veach & Guibas
//! 1995).

use super::candidates::brightest;
use super::eye::GatherPoint;
use super::streams::{DIMENSION_BSDF, STREAM_LIGHT};
use crate::backend::Tally;
use crate::optics::lights::pick::pdf_light;
use crate::optics::lights::samples::LightSample;
use crate::optics::lights::{is_near, le, on_miss};
use crate::optics::ray::{SurfaceInteraction, lift, toward, visible};
use crate::packed::constants::NEAR_EMITTERS_MAX;
use crate::packed::{PackedEmitter, PackedScene};
use crate::plan::Plan;
use crate::sampling::rng::{random4, sequence2};
use crate::spectrum::{BLACK, Bands, add, is_black, mul, scale};
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
    let direct = Direct::at(scene, plan, g);
    let count = settings.shadow_rays;
    let mut sum = BLACK;
    for ray in 0..count {
        let u =
            if direct.draws() { random4(settings.seed, pass, pixel, DIMENSION_BSDF + ray) } else { [0.0; 4] };
        let [pass, count, ray, number] = [pass, count, ray, plan.light_candidates].map(u64::from);
        let first = (pass * count + ray) * number;
        let candidates = (0..plan.light_candidates)
            .map(|k| sequence2(first + u64::from(k), settings.seed, pixel, STREAM_LIGHT));
        sum = add(&sum, &direct.sample(candidates, u, tally));
    }
    scale(&mul(&sum, &g.throughput), 1.0 / count as f32)
}

/// Direct light at a place: what is the same for all of its samples.
pub(super) struct Direct<'a> {
    scene: &'a PackedScene,
    lights: &'a [PackedEmitter],
    g: &'a GatherPoint<'a>,
    /// Light samples of which one gets a shadow ray.
    number: u32,
    /// Shadow rays share their weight with BSDF samples.
    shared: bool,
}

impl<'a> Direct<'a> {
    /// At a gather point.
    pub(super) fn at(scene: &'a PackedScene, plan: &'a Plan, g: &'a GatherPoint<'a>) -> Self {
        let lights = plan.guides.direct.emitters(&scene.emitters);
        let shared = g.bsdf.scatter.varies() || near_emitter(lights, g.position);
        Self { scene, lights, g, number: plan.light_candidates, shared }
    }

    /// True where samples need further random numbers.
    fn draws(&self) -> bool {
        self.shared || self.number > 1
    }

    /// Light of one shadow ray, and of one BSDF sample where these share the weight; without the throughput. `u`: a direction, its lobe,
    /// and which candidate.
    pub(super) fn sample(
        &self,
        candidates: impl ExactSizeIterator<Item = [f32; 2]>,
        u: [f32; 4],
        tally: &mut Tally,
    ) -> Bands {
        let by_light = self.by_light(candidates, u[3], tally);
        if self.shared { add(&by_light, &self.by_bsdf(u, tally)) } else { by_light }
    }

    /// The light of one of some candidates.
    fn by_light(
        &self,
        candidates: impl ExactSizeIterator<Item = [f32; 2]>,
        choice: f32,
        tally: &mut Tally,
    ) -> Bands {
        let g = self.g;
        let origin = lift(g.position, g.ng, g.triangle);
        let given = |l: &LightSample| self.unshadowed(l, &l.through(self.scene, g.inside));
        let Some((l, light)) = brightest(self.scene, self.lights, origin, candidates, choice, given, tally)
        else {
            return BLACK;
        };
        tally.rays += 1;
        let origin = toward(g.position, g.ng, g.triangle, l.wi);
        if visible(self.scene, origin, l.target) { light } else { BLACK }
    }

    /// What a light sample, one of the candidates, gives if nothing shades it, with its share of the weight.
    fn unshadowed(&self, l: &LightSample, irradiance: &Bands) -> Bands {
        let g = self.g;
        let cos_s = g.bsdf.cosine(l.wi);
        if cos_s <= 0.0 {
            return BLACK;
        }
        let pdf = self.number as f32 * l.pdf;
        let weight = if self.shared && pdf > 0.0 { pdf / (pdf + g.bsdf.pdf_scatter(l.wi)) } else { 1.0 };
        scale(&mul(&g.bsdf.eval_scatter(l.wi), irradiance), cos_s * weight)
    }

    /// Light that one sample of the D lobes finds, beside the candidates.
    fn by_bsdf(&self, u: [f32; 4], tally: &mut Tally) -> Bands {
        let g = self.g;
        let Some(wi) = g.bsdf.sample_scatter(u[2], [u[0], u[1]]) else { return BLACK };
        let cos_s = g.bsdf.cosine(wi);
        if cos_s <= 0.0 {
            return BLACK;
        }
        tally.rays += 1;
        let ray = g.ray(wi);
        let (found, pdf_light) = match SurfaceInteraction::hit(self.scene, &ray) {
            Some(s) => {
                let light = le(&s).map_or(BLACK, |le| s.through(&le));
                (light, self.number as f32 * pdf_light(self.lights, &s))
            }
            None => (ray.brings_from_afar(self.scene, &on_miss(wi)), 0.0),
        };
        if is_black(&found) {
            return BLACK;
        }
        // balance heuristic: f Le cos/pdf · pdf/(pdf + pdf_light)
        let weight = cos_s / (g.bsdf.pdf_scatter(wi) + pdf_light);
        scale(&mul(&g.bsdf.eval_scatter(wi), &found), weight)
    }
}

/// True where `position` may lie so near to a light that shadow rays alone have fireflies. Depends on no
/// random number but the place, so the choice of estimator costs no bias.
fn near_emitter(lights: &[PackedEmitter], position: Vec3) -> bool {
    lights.len() > NEAR_EMITTERS_MAX as usize || lights.iter().any(|e| is_near(e, position))
}
