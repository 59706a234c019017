//! Doubts: what of a scene cannot be meant, as far as some thousands of rays tell. Nothing is changed here, only said.
//!
//! A doubt is raised only where every ray agrees, so that a scene that is as it should be raises none.

use super::bodies;
use super::{
    BODIES_MOST, EmitterKind, MaterialFlags, PackedEmitter, PackedMaterial, PackedScene, PackedTriangle,
};
use crate::error::plain;
use crate::sampling::rng;
use crate::scene::{Interior, Scene, quoted};
use glam::Vec3;
use std::collections::BTreeSet;

/// Rays that look around from a place.
const AROUND: u32 = 96;
/// Rays from each lamp.
const PER_LAMP: usize = 64;
/// Lamps, lights and triangles that are looked at, at most, evenly spread in their lists.
const LAMPS: usize = 256;
const TRIANGLES: usize = 4096;
/// What lies above a lamp by less than this part of the lamp's size covers it.
const COVERED: f32 = 1e-3;
/// Faces nearer than this, in internal units, touch: two units in the last place of the largest coordinates.
const FLUSH: f32 = 1.0 / 8192.0;
/// Cosine between normals of faces that lie upon each other.
const PARALLEL: f32 = 0.9999;
/// Rays leave a place by this, in internal units.
const LIFT: f32 = 1.0 / 512.0;
/// Where a line through a place leaves its plane, in tangents.
const ASLANT: Vec3 = Vec3::new(0.031, 0.057, 0.043);

/// What cannot be meant of `scene`, which is packed as `packed`, a line each. Where surfaces have holes nothing is said: the rays here
/// do not know them.
pub fn doubts(scene: &Scene, packed: &PackedScene) -> Vec<String> {
    if packed.textures.has_cutouts {
        return Vec::new();
    }
    let look = Look { scene, packed };
    let mut lines: Vec<String> = Vec::new();
    lines.extend(look.lights_outside());
    lines.extend(look.lamps_that_light_nothing());
    lines.extend(look.lights_inside());
    lines.extend(look.glass_on_walls());
    lines.extend(look.without_an_inside());
    lines.extend(look.too_many_bodies());
    lines.extend(bodies::doubts(scene, packed));
    // names of materials are in them
    lines.iter().map(|line| plain(line).into_owned()).collect()
}

/// About `count` of the items, evenly spread.
fn some<T>(items: &[T], count: usize) -> impl Iterator<Item = &T> {
    items.iter().step_by(items.len().div_ceil(count).max(1))
}

struct Look<'a> {
    scene: &'a Scene,
    packed: &'a PackedScene,
}

impl<'a> Look<'a> {
    fn name(&self, t: &PackedTriangle) -> &'a str {
        &self.scene.materials[t.material as usize].name
    }

    fn flags(&self, t: &PackedTriangle) -> MaterialFlags {
        self.packed.materials[t.material as usize].flags()
    }

    /// What a ray meets first: how far, and the triangle.
    fn hit(&self, origin: Vec3, direction: Vec3) -> Option<(f32, &'a PackedTriangle)> {
        let hit = self.packed.bvh.closest(&self.packed.triangles, origin, direction, f32::INFINITY)?;
        Some((hit.t, &self.packed.triangles[hit.triangle as usize]))
    }

    fn sees(&self, from: Vec3, to: Vec3) -> bool {
        !self.packed.bvh.stands_between(&self.packed.triangles, from, to)
    }

    /// The triangle whose back is met first in every direction, if all are opaque.
    fn backs_around(&self, place: Vec3) -> Option<&'a PackedTriangle> {
        let mut first = None;
        for i in 0..AROUND {
            let direction = around(i);
            let (_, t) = self.hit(place, direction)?;
            if self.flags(t).passes_light() || direction.dot(t.normal()) <= 0.0 {
                return None;
            }
            first.get_or_insert(t);
        }
        first
    }

    fn lights_outside(&self) -> Option<String> {
        let out = self.packed.out_of_reach.lights;
        let lights = |n: usize| if n == 1 { "light lies" } else { "lights lie" };
        let room = "outside of the closed walls around the camera, and none of their light gets in";
        if self.packed.emitters.is_empty() {
            let around = self.hit(self.packed.camera.eye, around(0)).map(|(_, t)| self.name(t));
            let walls = around.map_or(String::new(), |name| format!(" of \"{name}\""));
            return Some(format!(
                "all light comes from outside of the closed walls{walls} around the camera: the picture is black; move the camera \
                 if it stands inside a body"
            ));
        }
        (out > 0).then(|| format!("{out} of {} {} {room}", self.scene.lights.len(), lights(out)))
    }

    fn lamps_that_light_nothing(&self) -> Option<String> {
        let mut by_material: Vec<Vec<&PackedTriangle>> = vec![Vec::new(); self.packed.materials.len()];
        for t in self.packed.triangles.iter().filter(|t| self.flags(t).is_emissive()) {
            by_material[t.material as usize].push(t);
        }
        by_material.retain(|lamp| !lamp.is_empty());
        let dark: BTreeSet<&str> = some(&by_material, LAMPS)
            .filter(|lamp| self.lights_nothing(lamp))
            .map(|lamp| self.name(lamp[0]))
            .collect();
        let [lamp, its] = if dark.len() > 1 { ["lamps", "their"] } else { ["lamp", "its"] };
        let what = format!("turn {its} faces, whose fronts shine, or move what covers them");
        (!dark.is_empty()).then(|| {
            format!(
                "{lamp} {}: none of {its} light gets out of {its} own body or what is in front; {what}",
                quoted(&dark)
            )
        })
    }

    /// True where all light of a lamp ends on itself, on the inside of an opaque body or on what covers it, unless the camera
    /// is in there, too.
    fn lights_nothing(&self, lamp: &[&PackedTriangle]) -> bool {
        let size = lamp.iter().map(|t| t.area()).sum::<f32>().sqrt();
        let eye = self.packed.camera.eye;
        let each = PER_LAMP.div_ceil(lamp.len()).max(1) as u32;
        some(lamp, PER_LAMP).enumerate().all(|(k, t)| {
            let (normal, place) = (t.normal(), t.v0 + (t.e1 + t.e2) / 3.0);
            let lifted = place + normal * (FLUSH * 0.5);
            let (x, y) = normal.any_orthonormal_pair();
            let is_seen = (eye - place).dot(normal) > 0.0 && self.sees(eye, place + normal * LIFT);
            !is_seen
                && (0..each).all(|i| {
                    let [u, v, ..] = rng::random4(AROUND, 3, k as u32, i);
                    let (r, phi) = (u.sqrt(), std::f32::consts::TAU * v);
                    let direction = (x * phi.cos() + y * phi.sin()) * r + normal * (1.0 - u).max(0.0).sqrt();
                    self.hit(lifted, direction).is_some_and(|(distance, met)| {
                        let is_inside = direction.dot(met.normal()) > 0.0;
                        let is_opaque = !self.flags(met).passes_light();
                        is_opaque
                            && (is_inside
                                || met.material == t.material
                                || distance * direction.dot(normal) < COVERED * size)
                    })
                })
        })
    }

    fn lights_inside(&self) -> Option<String> {
        let eye = self.packed.camera.eye;
        let is_place = |e: &&PackedEmitter| matches!(e.kind(), EmitterKind::Point | EmitterKind::Spot);
        let places: Vec<Vec3> = self.packed.emitters.iter().filter(is_place).map(|e| e.origin).collect();
        let bodies: Vec<&str> = some(&places, LAMPS)
            .filter(|&&place| !self.sees(eye, place))
            .filter_map(|&place| Some(self.name(self.backs_around(place)?)))
            .collect();
        let lights = if bodies.len() == 1 { "a light is" } else { "some lights are" };
        (!bodies.is_empty()).then(|| {
            let all = bodies.into_iter().collect();
            format!("{lights} inside an opaque body, and none of the light gets out: {}", quoted(&all))
        })
    }

    /// Panes of which something is said that is of bodies alone.
    fn without_an_inside(&self) -> Option<String> {
        let is_vain = |t: &&PackedTriangle| {
            let interior = self.scene.materials[t.material as usize].interior;
            self.flags(t).is_thin() && interior != Interior::default()
        };
        let panes: BTreeSet<&str> =
            self.packed.triangles.iter().filter(is_vain).map(|t| self.name(t)).collect();
        let what = "has no inside: its absorption and priority are ignored; close it, or set thin = false";
        (!panes.is_empty()).then(|| format!("the thin pane {} {what}", quoted(&panes)))
    }

    /// Bodies without a number.
    fn too_many_bodies(&self) -> Option<String> {
        let is_body =
            |m: &&PackedMaterial| m.flags().is_dielectric() && !m.flags().is_thin() && m.body() == 0;
        let lost = self.packed.materials.iter().filter(is_body).count();
        (lost > 0 && !self.packed.media.is_empty()).then(|| {
            format!("{lost} materials of glass beyond the first {BODIES_MOST} absorb nothing, and their index is over what is around them")
        })
    }

    fn glass_on_walls(&self) -> Option<String> {
        if !self.packed.has_contacts {
            return None;
        }
        let is_glass = |t: &PackedTriangle| self.flags(t).is_dielectric();
        let (glass, walls): (Vec<&PackedTriangle>, Vec<&PackedTriangle>) =
            self.packed.triangles.iter().partition(|t| is_glass(t));
        if glass.is_empty() {
            return None;
        }
        let (mut panes, mut touched) = (BTreeSet::new(), BTreeSet::new());
        // of a large pane on small walls the places of the walls lie on it, and the other way round
        for t in some(&glass, TRIANGLES).chain(some(&walls, TRIANGLES)) {
            let normal = t.normal();
            let along = (normal + ASLANT).normalize();
            for [u, v] in SPREAD {
                let place = t.v0 + t.e1 * u + t.e2 * v;
                self.packed.bvh.any_near(place, along, FLUSH, |other| {
                    let other = &self.packed.triangles[other as usize];
                    let lies = is_glass(t) != is_glass(other)
                        && other.normal().dot(normal).abs() > PARALLEL
                        && (place - other.v0).dot(other.normal()).abs() < FLUSH
                        && holds(other, place);
                    if lies {
                        let (pane, wall) = if is_glass(t) { (*t, other) } else { (other, *t) };
                        panes.insert(self.name(pane));
                        touched.insert(self.name(wall));
                    }
                    lies
                });
            }
        }
        let what = "where they touch they are in optical contact, without air between them; leave a gap where one is meant";
        (!panes.is_empty())
            .then(|| format!("glass {} lies flush on {}: {what}", quoted(&panes), quoted(&touched)))
    }
}

/// Places on a triangle, as weights of its second and third corner: near its corners and edges, and its middle.
const SPREAD: [[f32; 2]; 7] =
    [[0.33, 0.33], [0.02, 0.02], [0.96, 0.02], [0.02, 0.96], [0.48, 0.02], [0.02, 0.48], [0.48, 0.48]];

/// A direction of an even sample of the sphere (a Fibonacci spiral).
fn around(i: u32) -> Vec3 {
    const GOLDEN_ANGLE: f32 = 2.399_963_2;
    let z = 1.0 - (2 * i + 1) as f32 / AROUND as f32;
    let r = (1.0 - z * z).sqrt();
    let phi = GOLDEN_ANGLE * i as f32;
    // no direction lies in a plane that models like
    Vec3::new(r * phi.cos(), z, r * phi.sin())
}

/// True where a point of the triangle's plane lies in it.
fn holds(t: &PackedTriangle, point: Vec3) -> bool {
    let [e1, e2, s] = [t.e1, t.e2, point - t.v0].map(|v| v.as_dvec3());
    let n = e1.cross(e2);
    let (u, v) = (s.cross(e2).dot(n), e1.cross(s).dot(n));
    u >= 0.0 && v >= 0.0 && u + v <= n.length_squared()
}
