//! Media: the bodies of a scene whose inside matters to light, by number, and in which of them the camera and each light are.
//!
//! Where some body absorbs or has a priority, every path keeps which bodies it is in, the one that counts first ([`Inside`]). What starts
//! inside of a body is found here: rays go from the place in all directions, until they meet something opaque, and each says of a body that it
//! meets first from behind that the place is in it. So the level of a pool has an inside, too, though it is open.

use super::surfaces::{BODY_SHIFT, NESTED, PackedMaterial, PackedTriangle};
use super::{EmitterKind, FAR, PackedEmitter};
use crate::packed::accel::Bvh;
use crate::scene::Scene;
use crate::spectrum::is_black;
use glam::Vec3;
use rayon::prelude::*;

/// Bodies that a path can be in at once, at most: of more, those that count least are forgotten.
pub const NESTED_MOST: usize = 4;
/// Materials of bodies that have a number, at most.
pub const BODIES_MOST: usize = 255;
/// What is absorbed per internal unit of length, at most: it leaves nothing, and no overflow.
pub(super) const ABSORPTION_MOST: f64 = 1e6;
/// Rays that look around from a place …
const AROUND: u32 = 64;
/// … and boundaries that each passes, at most.
const CROSSINGS: usize = 64;
/// Places on lamps are lifted off them by this, internal units.
const LIFT: f32 = 1.0 / 512.0;

/// The bodies that light is in, by their numbers, the one that counts first; 0 where there are no more.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Inside {
    /// Numbers of bodies.
    pub bodies: [u8; NESTED_MOST],
}

impl Inside {
    /// As the kernels have it.
    pub fn word(self) -> u32 {
        u32::from_le_bytes(self.bodies)
    }
}

/// A body whose inside matters.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Body {
    /// Its material.
    pub material: u32,
    /// Its place in the order of priorities, alike where these are; of several in one place the lowest counts.
    pub rank: u32,
}

/// The bodies of a scene, where their inside matters.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Media {
    /// Each body, by its number less one; none where no body absorbs or has a priority.
    pub bodies: Vec<Body>,
    /// Some body has a priority: then all indices are over vacuum.
    pub has_priorities: bool,
    /// Where the camera is.
    pub camera: Inside,
    /// Where each emitter is, on the side that it shines to; all outside where this is empty.
    pub emitters: Vec<Inside>,
}

impl Media {
    /// Number the bodies of a scene, and tell its materials what they absorb.
    pub(super) fn of(scene: &Scene, materials: &mut [PackedMaterial], world_scale: f64) -> Self {
        let interior = |i: usize| &scene.materials[i].interior;
        let is_body = |m: &PackedMaterial| m.flags().is_dielectric() && !m.flags().is_thin();
        let all: Vec<usize> = (0..materials.len()).filter(|&i| is_body(&materials[i])).collect();
        let mut priorities: Vec<i64> = all.iter().filter_map(|&i| interior(i).priority).collect();
        priorities.sort_unstable();
        priorities.dedup();
        let has_priorities = !priorities.is_empty();
        if !has_priorities && all.iter().all(|&i| is_black(&interior(i).absorption)) {
            return Self::default();
        }
        let mut bodies = Vec::new();
        for i in all.into_iter().take(BODIES_MOST) {
            // those without a priority come after all that have one
            let rank =
                interior(i).priority.map_or(priorities.len(), |p| priorities.partition_point(|q| *q < p));
            bodies.push(Body { material: i as u32, rank: rank as u32 });
            materials[i].flag_bits |= (bodies.len() as u32) << BODY_SHIFT;
            materials[i].extinction =
                interior(i).absorption.map(|a| (f64::from(a) * world_scale).min(ABSORPTION_MOST) as f32);
            if let Some(rest) = materials[i].rest() {
                materials[rest].flag_bits |= (bodies.len() as u32) << BODY_SHIFT;
            }
        }
        Self { bodies, has_priorities, ..Self::default() }
    }

    /// True where no body's inside matters.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Mark the boundaries between bodies of which the priority decides.
    pub(super) fn mark(&self, triangles: &mut [PackedTriangle], materials: &[PackedMaterial]) {
        let bounds = |t: &&mut PackedTriangle| materials[t.material as usize].body() > 0;
        if self.has_priorities {
            triangles.iter_mut().filter(bounds).for_each(|t| t.flags |= NESTED);
        }
    }

    /// The bodies, and where the camera at `eye` and these emitters are.
    pub(super) fn with_starts(self, look: &Look, eye: Vec3, emitters: &[PackedEmitter]) -> Self {
        if self.is_empty() {
            return self;
        }
        let around =
            |place: Vec3| if place.length() < FAR { look.inside(&self, place) } else { Inside::default() };
        let of = |e: &PackedEmitter| match e.kind() {
            EmitterKind::Triangle => around(e.middle() + e.e1.cross(e.e2).normalize_or_zero() * LIFT),
            EmitterKind::Point | EmitterKind::Spot => around(e.position()),
            EmitterKind::Sun => Inside::default(),
        };
        let (camera, emitters) = (around(eye), emitters.par_iter().map(of).collect());
        Self { camera, emitters, ..self }
    }

    /// Where an emitter is.
    pub fn of_emitter(&self, number: usize) -> Inside {
        self.emitters.get(number).copied().unwrap_or_default()
    }

    /// The section of the heap: where the camera is; material and rank of each body by its number; where the emitters are, four a word.
    pub fn words(&self) -> Vec<[u32; 4]> {
        if self.is_empty() {
            return Vec::new();
        }
        let camera = [self.camera.word(), self.bodies.len() as u32 + 1, u32::from(self.has_priorities), 0];
        let bodies = self.bodies.iter().map(|body| [body.material, body.rank, 0, 0]);
        let four = |some: &[Inside]| std::array::from_fn(|i| some.get(i).map_or(0, |inside| inside.word()));
        std::iter::once(camera).chain(bodies).chain(self.emitters.chunks(4).map(four)).collect()
    }
}

/// What surrounds a place.
pub(super) struct Look<'a> {
    pub(super) bvh: &'a Bvh,
    pub(super) triangles: &'a [PackedTriangle],
    pub(super) materials: &'a [PackedMaterial],
}

impl Look<'_> {
    /// The bodies that a place is in.
    fn inside(&self, media: &Media, place: Vec3) -> Inside {
        // of each body: rays that meet it first from behind less those that do from before, and how near
        let mut votes = [(0i32, f32::INFINITY); BODIES_MOST + 1];
        for i in 0..AROUND {
            self.ask(place, around(i), &mut votes);
        }
        let mut holders: Vec<usize> = (1..votes.len()).filter(|&number| votes[number].0 > 0).collect();
        // of those of one rank, who is left first is the inner one
        let rank = |number: usize| media.bodies[number - 1].rank;
        holders.sort_by(|&a, &b| rank(a).cmp(&rank(b)).then(votes[a].1.total_cmp(&votes[b].1)));
        let mut inside = Inside::default();
        inside.bodies.iter_mut().zip(holders).for_each(|(body, number)| *body = number as u8);
        inside
    }

    fn ask(&self, place: Vec3, direction: Vec3, votes: &mut [(i32, f32)]) {
        let mut passed: Vec<u32> = Vec::new();
        let mut met = [false; BODIES_MOST + 1];
        while passed.len() < CROSSINGS {
            let is_new = |number: u32, _: f32, _: f32| !passed.contains(&number);
            let found =
                self.bvh.closest_from_within(self.triangles, place, direction, f32::INFINITY, 0.0, is_new);
            let Some(hit) = found else { return };
            let t = &self.triangles[hit.triangle as usize];
            let m = &self.materials[t.material as usize];
            if !m.flags().is_dielectric() {
                return;
            }
            let number = m.body() as usize;
            if !std::mem::replace(&mut met[number], true) {
                let is_from_behind = direction.dot(t.e1.cross(t.e2)) > 0.0;
                let (count, nearest) = &mut votes[number];
                *count += if is_from_behind { 1 } else { -1 };
                *nearest = nearest.min(hit.t);
            }
            passed.push(hit.triangle);
        }
    }
}

/// A direction of an even sample of the sphere (a Fibonacci spiral), none of which lies in a plane that models like.
fn around(i: u32) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let z = 1.0 - (2 * i + 1) as f32 / AROUND as f32;
    let r = (1.0 - z * z).sqrt();
    let phi = GOLDEN_ANGLE * i as f32 + 0.1;
    Vec3::new(r * phi.cos(), z, r * phi.sin())
}
