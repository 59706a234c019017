//! Emitters: emissive triangles, points, spots and suns in one list, picked with probability proportional to flux.

use super::surfaces::{NO_EMITTER, PackedTriangle};
use crate::bands::{Bands, is_black, scale, sum};
use crate::layout::gpu_struct;
use crate::scene::{Light, Scene};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// What an emitter is.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EmitterKind {
    /// An emissive triangle: `origin`, `e1`, `e2`; `strength` is radiance.
    Triangle = 0,
    /// A point: `origin`; `strength` is radiant intensity.
    Point = 1,
    /// A spot: `origin`, axis `e1`, `e2` = (cos_inner, cos_outer, 0); `strength` is intensity on the axis.
    Spot = 2,
    /// A sun: `origin` is the centre of a disc outside the scene, `e1` the direction of travel, `e2.x` the disc's
    /// radius; `strength` is irradiance across the beam.
    Sun = 3,
}

gpu_struct! {
    /// An emitter, 80 bytes.
    pub struct PackedEmitter {
        /// First vertex, position, or centre of the sun's disc.
        pub origin: Vec3,
        /// A value of [`EmitterKind`].
        pub kind: u32,
        /// See [`EmitterKind`].
        pub e1: Vec3,
        /// Sum of the pick probabilities up to and including this emitter; exactly 1 for the last.
        pub cumulative: f32,
        /// See [`EmitterKind`].
        pub e2: Vec3,
        /// Area of the triangle or of the sun's disc, internal units²; 1 for point and spot.
        pub area: f32,
        /// Radiance, intensity or irradiance, by kind; internal units (intensity is W/sr of internal W).
        pub strength: Bands,
        /// Probability of picking this emitter.
        pub pick: f32,
        /// Flux, internal W per band: π A Le; 4π I; the cone's integral; E times the disc's area.
        pub flux: Bands,
        /// Number of the warp that steers its jotons, from 1; 0 where none does.
        pub warp: u32,
    }
}

impl PackedEmitter {
    /// Middle of an emissive triangle, and the radius of the circle about it that holds it.
    pub fn circle(&self) -> (Vec3, f32) {
        let middle = (self.e1 + self.e2) / 3.0;
        let reach = middle.length().max((self.e1 - middle).length()).max((self.e2 - middle).length());
        (self.origin + middle, reach)
    }
}

/// The sun's disc is this much wider than the scene, so that no surface lies on its rim.
const SUN_MARGIN: f32 = 1.001;

/// Solid angle integral of a spot's smooth falloff over its intensity on the axis: 2π ∫ s(c) dc, sr [E12].
pub(crate) fn spot_solid_angle(cos_inner: f64, cos_outer: f64) -> f64 {
    // full inside the inner cone; the cubic smoothstep has mean 1/2 over the ring
    2.0 * PI * ((1.0 - cos_inner) + 0.5 * (cos_inner - cos_outer))
}

/// All emitters; numbers the emissive triangles on the way. Emitters without flux are dropped.
pub(super) fn pack(
    scene: &Scene,
    triangles: &mut [PackedTriangle],
    world_scale: f64,
    to_internal: impl Fn(DVec3) -> Vec3,
    bounds: [Vec3; 2],
) -> Vec<PackedEmitter> {
    let mut emitters: Vec<PackedEmitter> = Vec::new();
    for t in triangles.iter_mut() {
        let emission = scene.materials[t.material as usize].emission;
        let area = t.area();
        if is_black(&emission) || area <= 0.0 {
            t.emitter = NO_EMITTER;
            continue;
        }
        t.emitter = emitters.len() as u32;
        emitters.push(emitter(EmitterKind::Triangle, t.v0, t.e1, t.e2, area, emission, PI * f64::from(area)));
    }
    // W/sr in internal units: lengths are divided by world_scale, so flux is by its square
    let per_area = (1.0 / (world_scale * world_scale)) as f32;
    for light in &scene.lights {
        let e = match *light {
            Light::Point { position, intensity } => {
                let i = scale(&intensity, per_area);
                emitter(EmitterKind::Point, to_internal(position), Vec3::ZERO, Vec3::ZERO, 1.0, i, 4.0 * PI)
            }
            Light::Spot { position, direction, intensity, cos_inner, cos_outer } => {
                let i = scale(&intensity, per_area);
                let cosines = Vec3::new(cos_inner as f32, cos_outer as f32, 0.0);
                let sr = spot_solid_angle(cos_inner, cos_outer);
                emitter(EmitterKind::Spot, to_internal(position), direction.as_vec3(), cosines, 1.0, i, sr)
            }
            Light::Sun { direction, irradiance } => {
                let (center, direction) = (0.5 * (bounds[0] + bounds[1]), direction.as_vec3());
                let radius = 0.5 * (bounds[1] - bounds[0]).length() * SUN_MARGIN;
                let area = PI * f64::from(radius) * f64::from(radius);
                let origin = center - direction * (2.0 * radius);
                let e2 = Vec3::new(radius, 0.0, 0.0);
                emitter(EmitterKind::Sun, origin, direction, e2, area as f32, irradiance, area)
            }
        };
        if !is_black(&e.flux) {
            emitters.push(e);
        }
    }
    let flux: Vec<f64> = emitters.iter().map(|e| sum(&e.flux)).collect();
    set_picks(&mut emitters, |i| flux[i]);
    emitters
}

fn emitter(
    kind: EmitterKind,
    origin: Vec3,
    e1: Vec3,
    e2: Vec3,
    area: f32,
    strength: Bands,
    factor: f64,
) -> PackedEmitter {
    let flux = strength.map(|s| (f64::from(s) * factor) as f32);
    PackedEmitter {
        origin,
        kind: kind as u32,
        e1,
        cumulative: 0.0,
        e2,
        area,
        strength,
        pick: 0.0,
        flux,
        warp: 0,
    }
}

/// Steps of a random number in [0, 1): its 24 bits.
const PICK_STEPS: u32 = 1 << 24;

/// Pick probabilities, proportional to `weight` up to a step, and never less than one: a light that no random number falls
/// on is dark. Where there are more lights than steps, some are.
pub(super) fn set_picks(emitters: &mut [PackedEmitter], weight: impl Fn(usize) -> f64) {
    let upto = cumulative_steps((0..emitters.len()).map(&weight), PICK_STEPS);
    let mut before = 0;
    for (e, upto) in emitters.iter_mut().zip(upto) {
        // multiples of a step: exact, and the probability that the table really gives
        e.cumulative = upto as f32 / PICK_STEPS as f32;
        e.pick = (upto - before) as f32 / PICK_STEPS as f32;
        before = upto;
    }
}

/// `steps` steps shared out in proportion to `weights`, none of which gets less than one while there are enough: how many
/// have gone when each has had its share.
pub(super) fn cumulative_steps(weights: impl ExactSizeIterator<Item = f64> + Clone, steps: u32) -> Vec<u32> {
    let count = weights.len() as u32;
    let total: f64 = weights.clone().sum();
    let sure = if count < steps { 1 } else { 0 };
    let shared = f64::from(steps - sure * count.min(steps));
    let mut running = 0.0f64;
    (1..=count)
        .zip(weights)
        .map(|(i, weight)| {
            running += if total > 0.0 { weight / total } else { 1.0 / f64::from(count) };
            if i == count { steps } else { sure * i + (shared * running).round() as u32 }
        })
        .collect()
}
