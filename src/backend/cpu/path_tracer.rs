//! The plain path tracer: unidirectional, next-event estimation with MIS, Russian roulette and no other cut.
//!
//! Every class of path, caustics included (found by chance). Slow where a path tracer is slow, and unbiased: ground
//! truth for the maps. Paths are classed and filtered by their events in light order.

use super::eye::camera_ray;
use super::streams::{DIMENSION_PATH, STREAM_PATH_BAND};
use crate::backend::{Backend, Batch, Cause, NonFinite, Tally};
use crate::error::Result;
use crate::film::paths::{Event, LightPaths};
use crate::film::{LAYERS, Layer};
use crate::optics::lights::pick::{pdf_light, sample_light};
use crate::optics::lights::{le, on_miss};
use crate::optics::ray::{Ray, SurfaceInteraction, lift, reaches, visible};
use crate::optics::shading::bsdf::{Bsdf, Followed, Shares};
use crate::packed::constants::SURVIVAL_MAX;
use crate::packed::{CameraRay, PackedScene};
use crate::plan::{InBands, Plan};
use crate::sampling::rng::{golden, random4, sequence_seed};
use crate::spectrum::{BLACK, Bands, add, max, mul, scale};
use rayon::prelude::*;
use std::sync::Arc;

/// Events before Russian roulette starts.
const CERTAIN_EVENTS: usize = 4;

/// Renders passes of one path a pixel.
pub struct PathTracer {
    scene: Arc<PackedScene>,
    plan: Plan,
}

impl PathTracer {
    /// A path tracer of a scene; of the plan it reads seed, paths and the layers that can hold light.
    pub fn new(scene: Arc<PackedScene>, plan: Plan) -> Self {
        Self { scene, plan }
    }
}

impl Backend for PathTracer {
    fn describe(&self) -> String {
        format!("CPU path tracer, {} threads", rayon::current_num_threads())
    }

    fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
        let width = self.scene.size[0];
        let passes = first..first + u64::from(count);
        let in_bands: Vec<Option<InBands>> =
            passes.clone().map(|pass| InBands::of(&self.scene, &self.plan, pass)).collect();
        let rows: Vec<(Vec<[Bands; LAYERS]>, Tally)> = (0..self.scene.size[1])
            .into_par_iter()
            .map(|y| {
                let mut tally = Tally::default();
                let row = (0..width)
                    .map(|x| {
                        let mut sum = [BLACK; LAYERS];
                        for (pass, in_bands) in passes.clone().zip(&in_bands) {
                            let scene = in_bands.as_ref().map_or(&*self.scene, |b| &b.scene);
                            let path = Path::new(scene, &self.plan, y * width + x, pass as u32);
                            let (layers, rays, non_finite) = path.trace();
                            tally.rays += rays;
                            tally.non_finite += non_finite;
                            for (s, l) in sum.iter_mut().zip(layers) {
                                *s = add(s, &in_bands.as_ref().map_or(l, |b| b.bands.rgb(&l)));
                            }
                        }
                        sum
                    })
                    .collect();
                (row, tally)
            })
            .collect();
        let mut tally = Tally::default();
        let mut layers: [Vec<Bands>; LAYERS] =
            std::array::from_fn(|_| Vec::with_capacity(self.scene.pixels()));
        for (row, counts) in rows {
            tally += counts;
            for pixel in row {
                layers.iter_mut().zip(pixel).for_each(|(layer, radiance)| layer.push(radiance));
            }
        }
        Ok(Batch { layers, tally })
    }
}

struct Path<'a> {
    scene: &'a PackedScene,
    plan: &'a Plan,
    pixel: u32,
    pass: u32,
    /// Events so far, from the eye.
    events: Vec<Event>,
    layers: [Bands; LAYERS],
    rays: u64,
    non_finite: NonFinite,
}

impl<'a> Path<'a> {
    fn new(scene: &'a PackedScene, plan: &'a Plan, pixel: u32, pass: u32) -> Self {
        Self {
            scene,
            plan,
            pixel,
            pass,
            events: Vec::new(),
            layers: [BLACK; LAYERS],
            rays: 0,
            non_finite: NonFinite::default(),
        }
    }

    fn random(&self, draw: u32) -> [f32; 4] {
        let dimension = DIMENSION_PATH + 4 * self.events.len() as u32 + draw;
        random4(self.plan.settings.seed, self.pass, self.pixel, dimension)
    }

    /// Light found at the end of the events so far: to the layer of its class, if its path is wanted.
    fn found(&mut self, radiance: &Bands) {
        let light_order = || self.events.iter().rev();
        let paths = &self.plan.settings.paths;
        let state = light_order().fold(LightPaths::START, |q, &e| paths.step(q, e));
        if paths.accept_mask_after_specular(0) >> state & 1 == 0 {
            return;
        }
        let bounces = self.events.iter().filter(|&&e| e == Event::D).count();
        let layer = match (bounces, light_order().next()) {
            (0, _) => Layer::Emission,
            (1, Some(Event::D)) => Layer::Direct,
            (1, _) => Layer::Caustic,
            _ => Layer::Diffuse,
        };
        if radiance.iter().any(|x| !x.is_finite()) {
            self.non_finite.count(Cause::Path);
            return;
        }
        let sum = &mut self.layers[layer as usize];
        *sum = add(sum, radiance);
    }

    /// The radiance of one path, by layer; rays; contributions left out.
    fn trace(mut self) -> ([Bands; LAYERS], u64, NonFinite) {
        self.walk();
        (self.layers, self.rays, self.non_finite)
    }

    fn walk(&mut self) {
        let scene = self.scene;
        let CameraRay { origin, direction, .. } =
            camera_ray(scene, self.plan.settings.seed, self.pixel, self.pass);
        let mut ray = Ray::new(origin, direction).within(scene.media.camera);
        let mut throughput = [1.0; crate::spectrum::BANDS];
        // throughput without the (η_i/η_t)² of crossings: leaving a body must not look like a gain
        let mut eta_squared = 1.0;
        // pdf_solid_angle of the last D event; None where no shadow ray competes
        let mut pdf_last: Option<f32> = None;
        loop {
            self.rays += 1;
            let Some(s) = SurfaceInteraction::hit(scene, &ray) else {
                self.found(&mul(&throughput, &ray.brings_from_afar(scene, &on_miss(ray.direction))));
                return;
            };
            throughput = s.through(&throughput);
            if let Some(le) = le(&s) {
                let weight = pdf_last.map_or(1.0, |pdf| pdf / (pdf + pdf_light(&scene.emitters, &s)));
                self.found(&scale(&mul(&throughput, &le), weight));
            }
            let [u_way, u0, u1, u_lobe] = self.random(0);
            let mut bsdf = Bsdf::at(&s);
            let shares = bsdf.shares(&throughput);
            if shares.kept() <= 0.0 {
                return;
            }
            let choice = u_way * shares.kept();
            let leaving = if choice < shares.scatter {
                throughput = scale(&throughput, shares.kept() / shares.scatter);
                let [_, l0, l1, _] = self.random(1);
                self.events.push(Event::D);
                self.next_event(&s, &bsdf, &throughput, [l0, l1]);
                let leaving = bsdf.sample_scatter(u_lobe, [u0, u1]).filter(|wi| bsdf.cosine(*wi) > 0.0);
                if let Some(wi) = leaving {
                    throughput = mul(&throughput, &bsdf.weight_scatter(wi));
                    pdf_last = Some(bsdf.pdf_scatter(wi));
                }
                leaving
            } else {
                bsdf.part_bands(s.between(), &throughput, || {
                    golden(self.pass, sequence_seed(self.plan.settings.seed, self.pixel, STREAM_PATH_BAND))
                });
                let lobe = shares.pick_delta(choice - shares.scatter);
                let arriving = scale(&throughput, shares.kept() / shares.delta[lobe]);
                let [_, l0, l1, _] = self.random(1);
                self.events.push(Event::S);
                if bsdf.has_width() {
                    let followed = scale(&throughput, shares.kept() / shares.followed());
                    self.followed_lobe(&s, &bsdf, &followed, &shares, [l0, l1]);
                }
                let leaving = bsdf.sample_delta(lobe, [u0, u1]);
                if let Some(w) = leaving {
                    throughput = bsdf.through_delta(lobe, w, &arriving);
                    pdf_last =
                        bsdf.pdf_delta(lobe, w).map(|pdf| pdf * shares.delta[lobe] / shares.followed());
                    eta_squared *= bsdf.radiance_scale(lobe);
                }
                leaving
            };
            let Some(direction) = leaving else { return };
            if self.events.len() > CERTAIN_EVENTS {
                let survival = (max(&throughput) / eta_squared).clamp(0.0, SURVIVAL_MAX);
                if self.random(2)[0] >= survival {
                    return;
                }
                throughput = scale(&throughput, 1.0 / survival);
            }
            ray = s.leave(direction);
        }
    }

    /// A shadow ray to an emitter.
    fn next_event(&mut self, s: &SurfaceInteraction, bsdf: &Bsdf, throughput: &Bands, u: [f32; 2]) {
        let origin = lift(s.position, s.ng, s.triangle);
        let Some(l) = sample_light(self.scene, &self.scene.emitters, origin, u) else { return };
        let cos_s = bsdf.cosine(l.wi);
        if cos_s <= 0.0 {
            return;
        }
        self.rays += 1;
        if !visible(self.scene, s.origin_toward(l.wi), l.target) {
            return;
        }
        let weight = if l.pdf > 0.0 { l.pdf / (l.pdf + bsdf.pdf_scatter(l.wi)) } else { 1.0 };
        let light = l.through(self.scene, s.sides.here);
        self.found(&scale(&mul(&mul(throughput, &bsdf.eval_scatter(l.wi)), &light), cos_s * weight));
    }

    /// A shadow ray to an emitter from a lobe that is followed, on the side of the surface that the emitter is on. `throughput` is that of
    /// paths that follow some lobe.
    fn followed_lobe(
        &mut self,
        s: &SurfaceInteraction,
        bsdf: &Bsdf,
        throughput: &Bands,
        shares: &Shares,
        u: [f32; 2],
    ) {
        let Some(l) = sample_light(self.scene, &self.scene.emitters, s.position, u) else { return };
        let mut lobes = bsdf.followed_from(l.wi).peekable();
        if lobes.peek().is_none() {
            return;
        }
        self.rays += 1;
        if !reaches(self.scene, &s.leave(l.wi), l.target) {
            return;
        }
        let light = l.through(self.scene, s.sides.toward(l.wi.dot(s.ng) < 0.0));
        for Followed { lobe, f_cos, pdf } in lobes {
            let by_lobe = pdf * shares.delta[lobe] / shares.followed();
            let weight = if l.pdf > 0.0 { l.pdf / (l.pdf + by_lobe) } else { 1.0 };
            self.found(&scale(&mul(&mul(throughput, &f_cos), &light), weight));
        }
    }
}
