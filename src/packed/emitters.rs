//! Emitters: emissive triangles, points, spots and suns in one list, picked with probability proportional to flux.

use super::surfaces::{NO_EMITTER, PackedMaterial, PackedTriangle};
use super::textures::PackedUvs;
use crate::packed::constants::SCENE_RADIUS;
use crate::packed::gpu_struct::gpu_struct;
use crate::scene::{Light, Scene};
use crate::spectrum::{BANDS, Bands, from_rgb, is_black, mul, scale, sum};
use glam::{DVec3, Vec3};
use std::f64::consts::PI;

/// What an emitter is.
#[repr(u32)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum EmitterKind {
    /// An emissive triangle: `origin`, `e1`, `e2`; `strength` is radiance.
    Triangle = 0,
    /// A point; `strength` is radiant intensity. It lies `e2.z` behind `origin` along the unit axis `e1`: 0 where it is
    /// near; where it is far, `origin` is the middle of the scene, so that rays keep their digits there.
    Point = 1,
    /// A spot, axis `e1`, `e2` = (1 − cos inner, 1 − cos outer, distance); `strength` is intensity on the axis. It lies
    /// `e2.z` behind `origin`: 0 but for one that is far and narrow, whose `origin` is the place on its axis nearest to
    /// the middle of the scene.
    Spot = 2,
    /// A sun: `origin` is the centre of a disc outside the scene, `e1` the direction of travel, `e2.x` the disc's
    /// radius; `strength` is irradiance across the beam.
    Sun = 3,
}

impl EmitterKind {
    /// Name and value of each kind, as the kernels know it.
    pub(super) const NAMED: [(&str, u32); 4] = [
        ("EMITTER_TRIANGLE", Self::Triangle as u32),
        ("EMITTER_POINT", Self::Point as u32),
        ("EMITTER_SPOT", Self::Spot as u32),
        ("EMITTER_SUN", Self::Sun as u32),
    ];
}

gpu_struct! {
    /// An emitter, 96 bytes.
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
        /// Area of the triangle or of the sun's disc, internal units²; of point and spot the solid angle that jotons
        /// start into, sr: the spot's cone, or the cone that holds the scene where that is far away and narrower.
        pub area: f32,
        /// Radiance, intensity or irradiance, by kind; internal units (intensity is W/sr of internal W).
        pub strength: Bands,
        /// Probability of picking this emitter.
        pub pick: f32,
        /// Flux, internal W per band: π A Le; 4π I; the cone's integral; E times the disc's area. Of a light that is far
        /// away, as of the sun, what goes into the cone that holds the scene.
        pub flux: Bands,
        /// Number of the warp that steers its jotons, from 1; 0 where none does.
        pub warp: u32,
        /// Number of its triangle, where a texture is a factor on its radiance …
        pub triangle: u32,
        /// … and that of the texture, from 1; 0 where there is none.
        pub texture: u32,
    }
    words 12 + 2 * BANDS + 4
}

impl PackedEmitter {
    /// What it is.
    pub fn kind(&self) -> EmitterKind {
        match self.kind {
            0 => EmitterKind::Triangle,
            1 => EmitterKind::Point,
            2 => EmitterKind::Spot,
            _ => EmitterKind::Sun,
        }
    }

    /// True where rays can meet it.
    pub fn has_area(&self) -> bool {
        self.kind() == EmitterKind::Triangle
    }

    /// A place in the middle of where its jotons start.
    pub fn middle(&self) -> Vec3 {
        match self.kind() {
            EmitterKind::Triangle => self.circle().0,
            EmitterKind::Point | EmitterKind::Spot => self.position(),
            EmitterKind::Sun => self.origin,
        }
    }

    /// Where a point or a spot is.
    pub fn position(&self) -> Vec3 {
        self.origin - self.e1 * self.e2.z
    }

    /// Middle of an emissive triangle, and the radius of the circle about it that holds it.
    pub fn circle(&self) -> (Vec3, f32) {
        let middle = (self.e1 + self.e2) / 3.0;
        let reach = middle.length().max((self.e1 - middle).length()).max((self.e2 - middle).length());
        (self.origin + middle, reach)
    }
}

/// Where the light of an emitter comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Source {
    /// Number of the emission: of a material, or past all of them of a light.
    pub(super) emission: u32,
    /// [`PackedEmitter::strength`] over what the emission says: 1 / `world_scale`² for an intensity.
    pub(super) scale: f32,
}

/// Lights farther than this from the middle of the scene send jotons into the cone that holds the scene, internal units.
pub const FAR: f32 = 2.0 * SCENE_RADIUS;

/// The sun's disc is this much wider than the scene, so that no surface lies on its rim.
const SUN_MARGIN: f32 = 1.001;

/// 1 − cos of an angle, which keeps its digits where the angle is small.
fn one_minus_cos(angle: f64) -> f64 {
    2.0 * (0.5 * angle).sin().powi(2)
}

/// Solid angle integral of a spot's smooth falloff over its intensity on the axis, from 1 − cos of both angles:
/// 2π ∫ s(c) dc, sr [E12].
fn spot_solid_angle([inner, outer]: [f64; 2]) -> f64 {
    // full inside the inner cone; the cubic smoothstep has mean 1/2 over the ring
    PI * (inner + outer)
}

/// Falloff of a spot from 1 − cos of both its angles and of the direction's [E12].
fn spot_falloff([inner, outer]: [f64; 2], at: f64) -> f64 {
    if at <= inner {
        return 1.0;
    }
    let x = ((outer - at) / (outer - inner)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// The cone about a far point or spot that holds the scene.
struct Beam {
    /// Unit axis, from the light to the middle of the scene, which is the internal origin.
    axis: DVec3,
    distance: f64,
    /// Half angle, rad.
    angle: f64,
}

impl Beam {
    /// From a light at `position`, internal units; none where it is near.
    fn new(position: DVec3, scene_radius: f64) -> Option<Self> {
        let distance = position.length();
        let angle = (scene_radius / distance).asin();
        (distance > f64::from(FAR)).then(|| Self { axis: -position / distance, distance, angle })
    }

    /// Solid angle, sr.
    fn solid_angle(&self) -> f64 {
        2.0 * PI * one_minus_cos(self.angle)
    }

    /// Integral over the cone of the falloff of a spot along `axis`, sr: the mean over an even lattice of directions.
    fn integral(&self, axis: DVec3, cone: [f64; 2]) -> f64 {
        /// Directions of the lattice.
        const COUNT: u32 = 1 << 12;
        /// Turn between two directions, parts of the circle: the golden ratio.
        const TURN: f64 = 0.618_033_988_749_894_9;
        let (x, y) = self.axis.any_orthonormal_pair();
        let sum: f64 = (0..COUNT)
            .map(|i| {
                let below = one_minus_cos(self.angle) * (f64::from(i) + 0.5) / f64::from(COUNT);
                let (sin, cos) = (2.0 * PI * TURN * f64::from(i)).sin_cos();
                let radius = (below * (2.0 - below)).sqrt();
                let direction = self.axis * (1.0 - below) + (x * cos + y * sin) * radius;
                spot_falloff(cone, 0.5 * (direction - axis).length_squared())
            })
            .sum();
        self.solid_angle() * sum / f64::from(COUNT)
    }
}

/// A point.
fn point(position: DVec3, intensity: Bands, scene_radius: f64) -> PackedEmitter {
    let everywhere = [2.0; 2];
    match Beam::new(position, scene_radius) {
        None => cone(EmitterKind::Point, position, DVec3::Z, (everywhere, 0.0), intensity, [4.0 * PI; 2]),
        Some(b) => {
            let size = [b.solid_angle(); 2];
            cone(EmitterKind::Point, DVec3::ZERO, b.axis, (everywhere, b.distance), intensity, size)
        }
    }
}

/// A spot with a unit axis and half angles, rad.
fn spot(
    position: DVec3,
    axis: DVec3,
    angles: [f64; 2],
    intensity: Bands,
    scene_radius: f64,
) -> PackedEmitter {
    let edges = angles.map(one_minus_cos);
    let own = [2.0 * PI * edges[1], spot_solid_angle(edges)];
    let packed = |origin, distance, [starts, sent]: [f64; 2]| {
        cone(EmitterKind::Spot, origin, axis, (edges, distance), intensity, [starts, sent])
    };
    match Beam::new(position, scene_radius) {
        None => packed(position, 0.0, own),
        // jotons start into the narrower of both cones
        Some(b) if angles[1] < b.angle => {
            let between = 2.0 * (0.5 * (axis - b.axis).length()).min(1.0).asin();
            let distance = -position.dot(axis);
            let sent = if between < angles[1] + b.angle { own[1] } else { 0.0 };
            packed(position + axis * distance, distance, [own[0], sent])
        }
        Some(b) => packed(position, 0.0, [b.solid_angle(), b.integral(axis, edges)]),
    }
}

/// A point or a spot: 1 − cos of its edges and its distance behind `origin`; solid angles that jotons start into, and
/// that its light fills.
fn cone(
    kind: EmitterKind,
    origin: DVec3,
    axis: DVec3,
    (edges, distance): ([f64; 2], f64),
    intensity: Bands,
    [starts, sent]: [f64; 2],
) -> PackedEmitter {
    let e2 = DVec3::new(edges[0], edges[1], distance).as_vec3();
    emitter(kind, origin.as_vec3(), axis.as_vec3(), e2, starts as f32, intensity, sent)
}

/// All emitters, and where the light of each comes from; numbers the emissive triangles on the way. Emitters without flux are dropped.
pub(super) fn pack(
    scene: &Scene,
    triangles: &mut [PackedTriangle],
    (materials, uvs): (&[PackedMaterial], &[PackedUvs]),
    world_scale: f64,
    to_internal: impl Fn(DVec3) -> DVec3,
    bounds: [Vec3; 2],
) -> (Vec<PackedEmitter>, Vec<Source>) {
    let mut emitters: Vec<PackedEmitter> = Vec::new();
    let mut sources: Vec<Source> = Vec::new();
    for (i, t) in triangles.iter_mut().enumerate() {
        let material = &scene.materials[t.material as usize];
        let emission = material.emission;
        let area = t.area();
        let shown = material.emission_texture.as_ref().map(|texture| {
            let [a, b, c, d, e, f, ..] = uvs[i];
            from_rgb(texture.mean_over([[a, b], [c, d], [e, f]]))
        });
        let radiance = shown.map_or(emission, |shown| mul(&emission, &shown));
        if is_black(&radiance) || area <= 0.0 {
            t.emitter = NO_EMITTER;
            continue;
        }
        t.emitter = emitters.len() as u32;
        let mut e = emitter(EmitterKind::Triangle, t.v0, t.e1, t.e2, area, emission, PI * f64::from(area));
        if shown.is_some() {
            (e.triangle, e.texture) =
                (i as u32, materials[t.material as usize].emission_texture().unwrap_or(0));
            e.flux = radiance.map(|le| (f64::from(le) * PI * f64::from(area)) as f32);
        }
        emitters.push(e);
        sources.push(Source { emission: t.material, scale: 1.0 });
    }
    let scene_radius = f64::from(0.5 * (bounds[1] - bounds[0]).length() * SUN_MARGIN);
    // W/sr in internal units: lengths are divided by world_scale, so flux is by its square
    let per_area = (1.0 / (world_scale * world_scale)) as f32;
    for (i, light) in scene.lights.iter().enumerate() {
        let e = match *light {
            Light::Point { position, intensity } => {
                point(to_internal(position), scale(&intensity, per_area), scene_radius)
            }
            Light::Spot { position, direction, intensity, angle_inner, angle_outer } => spot(
                to_internal(position),
                direction.normalize(),
                [angle_inner, angle_outer],
                scale(&intensity, per_area),
                scene_radius,
            ),
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
            let scale = if matches!(light, Light::Sun { .. }) { 1.0 } else { per_area };
            sources.push(Source { emission: (scene.materials.len() + i) as u32, scale });
        }
    }
    let flux: Vec<f64> = emitters.iter().map(|e| sum(&e.flux)).collect();
    set_picks(&mut emitters, |i| flux[i]);
    (emitters, sources)
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
        triangle: 0,
        texture: 0,
        pad: Default::default(),
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
