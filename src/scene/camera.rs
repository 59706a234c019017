//! The camera: a pinhole.

use glam::DVec3;

/// A pinhole camera; right-handed world, image right = cross(forward, up), row 0 is the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Eye point, world units.
    pub position: DVec3,
    /// A point that is seen in the middle of the image.
    pub target: DVec3,
    /// What is up in the image; not parallel to the view.
    pub up: DVec3,
    /// Tangents of half the field of view across the width and the height.
    pub tan_half_fov: [f64; 2],
}

impl Camera {
    /// Unit vectors right, up, forward in the world.
    pub fn basis(&self) -> [DVec3; 3] {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }
}
