//! Interior: a place about which a surface is known to be whole, flat and free of walls, so that discs there need no measure.

use super::eye::GatherPoint;
use crate::packed::constants::INTERIOR_COS;
use glam::Vec3;

/// A place with nothing but whole surface around it; unknown by default.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Interior {
    center: Vec3,
    /// Distance up to which the surface is whole; 0 where it is not.
    reach: f32,
    normal: Vec3,
}

impl Interior {
    /// The surface about a gather point is whole up to a distance.
    pub(super) fn new(g: &GatherPoint, reach: f32) -> Self {
        Self { center: g.position, reach, normal: g.ng }
    }

    /// True where the whole disc lies in the surface.
    pub(super) fn holds(&self, g: &GatherPoint, radius: f32) -> bool {
        let slack = self.reach - radius;
        slack > 0.0
            && (g.position - self.center).length_squared() < slack * slack
            && g.ng.dot(self.normal) > INTERIOR_COS
    }
}
