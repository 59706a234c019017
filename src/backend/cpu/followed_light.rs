//! Followed light: light samples in lobes that are followed but have a width, narrow metal, coats and rough glass (E S* L). Where such a lobe
//! is wide and the light small, a path that follows the lobe seldom meets the light; where it is the other way round a light sample seldom
//! lies in the lobe. Each path of light is weighed by what all ways of finding it would find: eye paths, trees, light samples [E46].
//! Twin: shaders/lights/followed.wgsl.

use super::candidates::brightest;
use super::splits::Splits;
use super::streams::{DIMENSION_FOLLOWED, STREAM_FOLLOWED_LIGHT};
use crate::backend::Tally;
use crate::optics::lights::pick::pdf_light;
use crate::optics::lights::samples::LightSample;
use crate::optics::ray::{SurfaceInteraction, reaches};
use crate::optics::shading::bsdf::{Bsdf, Followed, Shares};
use crate::packed::{PackedEmitter, PackedScene};
use crate::plan::Plan;
use crate::sampling::rng::{random4, seed_at, sequence2};
use crate::spectrum::{BLACK, Bands, add, mul, scale};

/// The lights of a scene, as shadow rays pick them.
pub(super) struct FollowedLight<'a> {
    scene: &'a PackedScene,
    lights: &'a [PackedEmitter],
    seed: u32,
    /// Light samples of which one gets a shadow ray.
    candidates: u32,
}

/// A vertex of an eye path.
pub(super) struct Vertex<'a> {
    pub(super) surface: &'a SurfaceInteraction<'a>,
    pub(super) bsdf: &'a Bsdf,
    pub(super) shares: &'a Shares,
    /// Up to the vertex.
    pub(super) splits: &'a Splits,
    /// Trees a pass.
    pub(super) trees: f32,
}

impl<'a> FollowedLight<'a> {
    pub(super) fn new(scene: &'a PackedScene, plan: &'a Plan) -> Self {
        let lights = plan.guides.direct.emitters(&scene.emitters);
        Self { scene, lights, seed: plan.settings.seed, candidates: plan.light_candidates }
    }

    /// pdf_solid_angle with which all the light samples of a vertex find the lit surface that a ray from there has met.
    pub(super) fn pdf(&self, s: &SurfaceInteraction) -> f32 {
        self.candidates as f32 * pdf_light(self.lights, s)
    }

    /// Radiance that the lobes of a vertex send on from a light, as light samples find it and as these weigh; without the throughput.
    pub(super) fn in_lobes(&self, v: &Vertex, [pixel, pass, event]: [u32; 3], tally: &mut Tally) -> Bands {
        let s = v.surface;
        let first = u64::from(pass) * u64::from(self.candidates);
        let seed = seed_at(self.seed, event);
        let draws =
            (0..self.candidates).map(|k| sequence2(first + u64::from(k), seed, pixel, STREAM_FOLLOWED_LIGHT));
        let [choice, ..] = random4(self.seed, pass, pixel, DIMENSION_FOLLOWED + event);
        let given = |l: &LightSample| self.unshadowed(v, l);
        let Some((l, light)) = brightest(self.scene, self.lights, s.position, draws, choice, given, tally)
        else {
            return BLACK;
        };
        tally.rays += 1;
        if reaches(self.scene, &s.leave(l.wi), l.target) { light } else { BLACK }
    }

    /// What a light sample gives if nothing shades it, with its share of the weight.
    fn unshadowed(&self, v: &Vertex, l: &LightSample) -> Bands {
        v.bsdf.followed_from(l.wi).fold(BLACK, |sum, followed| add(&sum, &self.by_lobe(v, l, &followed)))
    }

    /// The same of one of the lobes.
    fn by_lobe(&self, v: &Vertex, l: &LightSample, followed: &Followed) -> Bands {
        let s = v.surface;
        let inside = s.sides.toward(l.wi.dot(s.ng) < 0.0);
        let given = mul(&followed.f_cos, &l.through(self.scene, inside));
        if l.pdf <= 0.0 {
            // no path meets it
            return given;
        }
        let after = v.splits.after(v.shares, followed.lobe, Some(followed.pdf));
        scale(&given, after.weight_of_light(v.trees, self.candidates as f32 * l.pdf))
    }
}
