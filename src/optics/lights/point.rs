//! A light at a place: a point or a spot; `strength` is radiant intensity, of a spot on its axis. Twin: shaders/lights/point.wgsl.

use crate::optics::lights::cone::{Beam, ConeRay};
use crate::optics::lights::samples::{LightSample, Start};
use crate::packed::{FAR, PackedEmitter};
use crate::spectrum::scale;
use glam::Vec3;
use std::f32::consts::TAU;

/// Part of the intensity that is sent along a way from the light.
pub(super) type Shape = fn(&PackedEmitter, Vec3) -> f32;

/// A point's.
pub(super) fn even(_: &PackedEmitter, _: Vec3) -> f32 {
    1.0
}

/// The way from the light to a place.
pub(super) fn from_light(e: &PackedEmitter, place: Vec3) -> Vec3 {
    // first what is near, then the way to the light
    (place - e.origin) + e.e1 * e.e2.z
}

/// Its axis; where it is far away, of the cone that holds the scene.
pub(super) fn beam(e: &PackedEmitter) -> Beam {
    let distance = e.origin.length();
    if e.e2.z == 0.0 && distance > FAR {
        // a spot that is far away and wide: the cone that holds the scene has an axis of its own
        return Beam { through: Vec3::ZERO, axis: -e.origin / distance, distance };
    }
    Beam { through: e.origin, axis: e.e1, distance: e.e2.z }
}

/// A start by its own law, `share` of its flux: even over its cone.
pub(super) fn by_law(e: &PackedEmitter, shape: Shape, towards: [f32; 2], share: f32) -> Start {
    let beam = beam(e);
    along(e, shape, &beam, beam.own(e.area / TAU, towards), e.area * share)
}

/// A start along a ray; `weight` in sr.
pub(super) fn along(e: &PackedEmitter, shape: Shape, beam: &Beam, ray: ConeRay, weight: f32) -> Start {
    let way = if beam.distance > 0.0 { from_light(e, ray.foot) } else { ray.direction };
    let flux = scale(&e.strength, shape(e, way) * weight);
    Start { origin: beam.start(&ray), direction: ray.direction, flux, ..Start::default() }
}

/// As seen from `position`, as if it were the only light; none where it sends nothing there.
pub(super) fn sample_li(e: &PackedEmitter, shape: Shape, position: Vec3) -> Option<LightSample> {
    let way = from_light(e, position);
    let distance_squared = way.length_squared();
    let sent = shape(e, way);
    let distance = distance_squared.sqrt();
    (sent > 0.0 && distance > 0.0).then(|| LightSample {
        wi: -way / distance,
        target: e.position(),
        distance,
        irradiance: scale(&e.strength, sent / distance_squared),
        pdf: 0.0,
    })
}
