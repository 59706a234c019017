//! Frame: the directions at a hit that lobes depend on.

use glam::Vec3;

/// Unit vectors at a hit.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    /// Back along the ray.
    pub(crate) back: Vec3,
    /// Geometric normal on the ray's side.
    pub(crate) ng: Vec3,
    /// Shading normal, in the hemisphere of `ng`.
    pub(crate) ns: Vec3,
    /// The ray came from the front.
    pub(crate) front: bool,
}

impl Frame {
    /// The shading normal where the ray sees its front, else the geometric one: what delta lobes turn about.
    pub(crate) fn specular_normal(&self) -> Vec3 {
        if self.ns.dot(self.back) > 0.0 { self.ns } else { self.ng }
    }
}
