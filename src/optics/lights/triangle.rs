//! An emissive triangle, which shines from its front; `strength` is radiance. Twin: shaders/lights/triangle.wgsl.

use crate::optics::lights::cone::Beam;
use crate::optics::lights::samples::{LightSample, Start};
use crate::optics::ray::{SurfaceInteraction, lift};
use crate::packed::constants::NEAR_WIDTH;
use crate::packed::{PackedEmitter, PackedTriangle, Target};
use crate::sampling::distributions::{cosine_hemisphere, to_world, triangle};
use crate::spectrum::scale;
use glam::Vec3;
use std::f32::consts::PI;

/// A place of it, lifted off its front, and the front's normal.
fn place_on(e: &PackedEmitter, u: [f32; 2]) -> (Vec3, Vec3) {
    let [b, c] = triangle(u);
    let shape = PackedTriangle { v0: e.origin, material: 0, e1: e.e1, flags: 0, e2: e.e2, emitter: 0 };
    let normal = shape.normal();
    (lift(e.origin + e.e1 * b + e.e2 * c, normal, &shape), normal)
}

/// A place of it and its normal, as a beam.
pub(super) fn beam(e: &PackedEmitter, place: [f32; 2]) -> Beam {
    let (through, axis) = place_on(e, place);
    Beam { through, axis, distance: 0.0 }
}

/// A start by its own law, `share` of its flux: even over the area, by the cosine.
pub(super) fn by_law(e: &PackedEmitter, place: [f32; 2], towards: [f32; 2], share: f32) -> Start {
    let (origin, normal) = place_on(e, place);
    // with a texture each place has a radiance of its own
    let flux = if e.texture > 0 { scale(&e.strength, PI * e.area) } else { e.flux };
    Start {
        origin,
        direction: to_world(cosine_hemisphere(towards), normal),
        flux: scale(&flux, share),
        ..Start::default()
    }
}

/// A start into a direction that was drawn otherwise; `weight` in sr.
pub(super) fn along(e: &PackedEmitter, beam: &Beam, direction: Vec3, weight: f32) -> Start {
    let sent = direction.dot(beam.axis).max(0.0) * e.area;
    Start { origin: beam.through, direction, flux: scale(&e.strength, sent * weight), ..Start::default() }
}

/// A place as seen from `position`, as if the triangle were the only light; none where it shines away.
pub(super) fn sample_li(e: &PackedEmitter, position: Vec3, u: [f32; 2]) -> Option<LightSample> {
    let (target, normal) = place_on(e, u);
    let offset = target - position;
    let distance_squared = offset.length_squared();
    let distance = distance_squared.sqrt();
    let wi = offset / distance;
    let cos_l = -wi.dot(normal);
    let weight = e.area * cos_l / distance_squared;
    (distance_squared > 0.0 && cos_l > 0.0).then(|| LightSample {
        wi,
        target,
        distance,
        irradiance: scale(&e.strength, weight),
        pdf: 1.0 / weight,
    })
}

/// pdf_solid_angle with which [`sample_li`] finds its front where `s` met it.
pub(super) fn pdf_li(e: &PackedEmitter, s: &SurfaceInteraction) -> f32 {
    s.distance * s.distance / (e.area * s.back.dot(s.ng))
}

/// True where its front looks at some of a sphere.
pub(super) fn shines_on(e: &PackedEmitter, target: &Target) -> bool {
    (target.center - e.origin).dot(e.e1.cross(e.e2).normalize_or_zero()) > -target.radius
}

/// True where `position` may lie so near that shadow rays alone have fireflies.
pub(super) fn is_near(e: &PackedEmitter, position: Vec3) -> bool {
    let (middle, reach) = e.circle();
    let near = reach + NEAR_WIDTH * (e.area / e.pick).sqrt();
    (middle - position).length_squared() < near * near
}
