//! A spot: a point whose intensity falls off from its axis. `e1` is the axis, `e2` = (1 − cos inner, 1 − cos outer, distance) [E12].
//! Twin: shaders/lights/spot.wgsl.

use crate::optics::lights::cone::between;
use crate::optics::lights::point::from_light;
use crate::packed::{PackedEmitter, Target};
use glam::Vec3;

/// Part of the intensity on the axis that goes along `way`: 1 inside the inner cone, cubic smoothstep of the cosine to 0 at
/// the outer.
pub(super) fn falloff(e: &PackedEmitter, way: Vec3) -> f32 {
    let (inner, outer) = (e.e2.x, e.e2.y);
    let at = between(way, e.e1);
    if at <= inner {
        return 1.0;
    }
    let x = ((outer - at) / (outer - inner)).clamp(0.0, 1.0);
    x * x * (3.0 - 2.0 * x)
}

/// Directions are rounded to f32: angles are not known better, rad.
const ANGLE_SLACK: f32 = 1e-6;

/// Angle whose 1 − cosine this is, rad.
fn angle(one_minus_cos: f32) -> f32 {
    2.0 * (0.5 * one_minus_cos).sqrt().min(1.0).asin()
}

/// True where some of its cone meets a sphere.
pub(super) fn shines_on(e: &PackedEmitter, target: &Target) -> bool {
    let to_center = from_light(e, target.center);
    let distance = to_center.length();
    // half angles of the cone and of the sphere, and the angle between them
    distance <= target.radius
        || angle(between(to_center, e.e1)) < angle(e.e2.y) + (target.radius / distance).asin() + ANGLE_SLACK
}
