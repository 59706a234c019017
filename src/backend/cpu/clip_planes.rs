//! Clip: the planes of the walls that cut a gather point's disc. Light from behind a wall must not reach the disc's middle,
//! though the surface goes on there: a partition that stands on a floor. A pilot sends a few rays along the surface; what
//! they meet at a steep angle within the disc are walls. Passes keep to the gather point's side of the nearest two.

use super::eye::GatherPoint;
use super::maps::AreaMap;
use super::window::Window;
use crate::film::neighbours::around;
use crate::optics::ray::{Ray, nearest};
use crate::packed::PackedScene;
use crate::packed::constants::{CLIP_LIFT, CLIP_RAYS, CLIP_REACH, CLIP_SAME, CLIP_STEEP};
use crate::sampling::distributions::{basis, unit_circle};
use glam::Vec3;

/// A wall: points with `normal · p` ≥ `offset` lie before it; all of them where the normal is zero.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Plane {
    normal: Vec3,
    offset: f32,
}

/// The two nearest walls of a pixel.
pub(super) type Clip = [Plane; 2];

impl Plane {
    fn is_wall(&self) -> bool {
        self.normal != Vec3::ZERO
    }

    /// True for a plane that is a wall to a surface of this normal, not the surface itself.
    fn is_steep(&self, normal: Vec3) -> bool {
        self.normal.dot(normal).abs() <= CLIP_STEEP
    }
}

/// The walls that cut a disc, the nearer one first; it lies before both.
#[derive(Debug, Clone, Copy)]
pub(super) struct Walls {
    planes: Clip,
    distances: [f32; 2],
    radius: f32,
}

impl Walls {
    fn none(radius: f32) -> Self {
        Self { planes: Clip::default(), distances: [radius; 2], radius }
    }

    /// One plane more, if it is among the two nearest and not there yet.
    fn add(&mut self, plane: Plane, p: Vec3) {
        let signed = plane.normal.dot(p) - plane.offset;
        let distance = signed.abs();
        let turned =
            if signed >= 0.0 { plane } else { Plane { normal: -plane.normal, offset: -plane.offset } };
        let known = turned.normal.dot(self.planes[0].normal) > CLIP_SAME
            && (distance - self.distances[0]).abs() < CLIP_LIFT * self.radius;
        if known || distance >= self.distances[1] {
            return;
        }
        if distance < self.distances[0] {
            self.planes = [turned, self.planes[0]];
            self.distances = [distance, self.distances[0]];
        } else {
            self.planes[1] = turned;
            self.distances[1] = distance;
        }
    }

    /// Those that cut the disc about a pixel's gather point of a pass. Where the pilot saw another surface in the pixel, or
    /// this one elsewhere, in a mirror, the neighbours know better.
    pub(super) fn about(clips: &[Clip], size: [u32; 2], pixel: u32, g: &GatherPoint, radius: f32) -> Self {
        let mut walls = Self::none(radius);
        let own = &clips[pixel as usize];
        if own.iter().all(|plane| plane.is_steep(g.ng)) {
            walls.add_all(own, g);
        }
        if !walls.planes[0].is_wall() {
            around(pixel, size).for_each(|i| walls.add_all(&clips[i], g));
        }
        walls
    }

    /// The planes of a pixel's clip that are walls to this point's surface.
    fn add_all(&mut self, clip: &Clip, g: &GatherPoint) {
        for plane in clip.iter().filter(|p| p.is_wall() && p.is_steep(g.ng)) {
            self.add(*plane, g.position);
        }
    }

    /// Normals, and offsets from `p`; none where there are no walls.
    pub(super) fn from(&self, p: Vec3) -> Option<[(Vec3, f32); 2]> {
        let planes = || self.planes.map(|plane| (plane.normal, plane.offset - plane.normal.dot(p)));
        self.planes[0].is_wall().then(planes)
    }
}

/// Where pixels are larger than this part of the radius, one point of a pixel does not speak for the others.
const LARGE_PIXEL: f32 = 0.15;

/// Look for walls within the radius; nowhere where `area` shows that no other surface is near.
pub(super) fn find(scene: &PackedScene, area: Option<&AreaMap>, g: &GatherPoint, radius: f32) -> Clip {
    // the pixel's other gather points lie about this one
    let footprint = g.pixel_width(scene);
    let large = footprint > LARGE_PIXEL * radius;
    let radius = radius + footprint;
    let mut walls = Walls::none(radius);
    if area.is_some_and(|map| !large && !Window::new(g, radius * radius).sees_others(map)) {
        return walls.planes;
    }
    let (x, y) = basis(g.ng);
    let origin = g.position + g.ng * (CLIP_LIFT * radius);
    for i in 0..CLIP_RAYS {
        let [cos, sin] = unit_circle(i as f32 / CLIP_RAYS as f32);
        let direction = x * cos + y * sin;
        let Some(hit) = nearest(scene, &Ray::new(origin, direction), radius * CLIP_REACH) else {
            continue;
        };
        let triangle = &scene.triangles[hit.triangle as usize];
        // light goes through glass
        if scene.materials[triangle.material as usize].flags().is_dielectric() {
            continue;
        }
        let normal = triangle.normal();
        let plane = Plane { normal, offset: normal.dot(triangle.v0) };
        if plane.is_steep(g.ng) {
            walls.add(plane, g.position);
        }
    }
    walls.planes
}
