//! Frame: where to put the camera when a file does not say.

use super::scene_file::DEFAULT_FOV_X;
use super::{Camera, Light, Material, Mesh};
use glam::DVec3;

/// Looks at the whole mesh.
pub(crate) fn frame(mesh: &Mesh, _materials: &[Material], _lights: &[Light], size: [u32; 2]) -> Camera {
    let mut low = DVec3::INFINITY;
    let mut high = DVec3::NEG_INFINITY;
    for p in &mesh.positions {
        low = low.min(*p);
        high = high.max(*p);
    }
    let target = (low + high) / 2.0;
    let radius = (high - low).length() / 2.0;
    let tangent = (DEFAULT_FOV_X.to_radians() / 2.0).tan();
    let tan_half_fov = [tangent, tangent * f64::from(size[1]) / f64::from(size[0])];
    let position = target + DVec3::Z * radius * (1.0 + 1.0 / tan_half_fov[0].min(tan_half_fov[1]));
    Camera { position, target, up: DVec3::Y, tan_half_fov }
}
