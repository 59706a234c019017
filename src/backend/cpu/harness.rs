//! Harness: samplers that the backend keeps to itself, for the tests of their distributions.

use super::eye::camera_ray;
use super::streams::*;
use super::trace::jotons;
use crate::backend::Tally;
use crate::optics::lights::cone::{Beam, into_targets};
use crate::optics::lights::pick;
use crate::optics::lights::samples::Start;
use crate::optics::shading::bsdf::Bsdf;
use crate::optics::shading::frame::Frame;
use crate::packed::{Guide, PackedEmitter, PackedMaterial, PackedScene, Target};
use crate::plan::Plan;
use crate::sampling::rng::sequence2;
use crate::spectrum::Bands;
use glam::Vec3;

/// Every stream of Sobol pairs.
pub const STREAMS: [u32; 9] = [
    STREAM_JITTER,
    STREAM_LIGHT,
    STREAM_CAUSTIC_PLACE,
    STREAM_CAUSTIC_DIRECTION,
    STREAM_DIFFUSE_PLACE,
    STREAM_DIFFUSE_DIRECTION,
    STREAM_AREA,
    STREAM_CHOICE,
    STREAM_GLINT_JITTER,
];

/// First dimension of hashed numbers of each purpose.
pub const DIMENSIONS: [u32; 7] = [
    DIMENSION_EYE,
    DIMENSION_BSDF,
    DIMENSION_CAUSTIC,
    DIMENSION_DIFFUSE,
    DIMENSION_PATH,
    DIMENSION_GLINT,
    DIMENSION_UNSEEN,
];

/// Where the jotons of a map are stored in a pass.
pub fn stored(scene: &PackedScene, plan: &Plan, pass: u32, caustic: bool) -> Vec<Vec3> {
    let jotons = jotons(scene, plan, pass, caustic, &mut Tally::default());
    jotons.iter().map(|joton| joton.position).collect()
}

/// Origin, direction and flux of joton `index`, of `count` a pass, by a guide; none where it would carry nothing.
pub fn emit(
    scene: &PackedScene,
    guide: &Guide,
    seed: u32,
    caustic: bool,
    index: impl Into<u64>,
    count: u32,
) -> Option<(Vec3, Vec3, Bands)> {
    let index = index.into();
    let draw = |stream| sequence2(index, seed, 0, stream);
    let count = count as f32;
    let start = if caustic {
        pick::aimed(scene, guide, draw(STREAM_CAUSTIC_PLACE), draw(STREAM_CAUSTIC_DIRECTION), count)
    } else {
        Some(pick::by_law(scene, guide, draw(STREAM_DIFFUSE_PLACE), draw(STREAM_DIFFUSE_DIRECTION), count))
    };
    start.map(|Start { origin, direction, flux }| (origin, direction, flux))
}

/// A direction from `origin` into the cones of the targets and its pdf_solid_angle.
pub fn into_cones(targets: &[Target], origin: Vec3, u: [f32; 2]) -> Option<(Vec3, f32)> {
    let (ray, pdf) = into_targets(targets, &Beam { through: origin, axis: Vec3::Z, distance: 0.0 }, u)?;
    Some((ray.direction, pdf))
}

/// Number of the emitter that `u` picks, and what is left of `u`.
pub fn pick(emitters: &[PackedEmitter], u: f32) -> (usize, f32) {
    let (picked, rest) = pick::pick(emitters, u);
    let number = emitters.iter().position(|e| std::ptr::eq(e, picked));
    (number.unwrap_or(emitters.len()), rest)
}

/// Direction of the camera's ray of a pixel in a pass.
pub fn camera_direction(scene: &PackedScene, seed: u32, pixel: u32, pass: u32) -> Vec3 {
    camera_ray(scene, seed, pixel, pass).direction
}

/// A direction of the S lobe of `material` on a flat surface, toward `back` before.
pub fn mirror_lobe(material: &PackedMaterial, back: Vec3, normal: Vec3, u: [f32; 2]) -> Option<Vec3> {
    let frame = Frame { back, ng: normal, ns: normal, front: true };
    Bsdf::new(material, frame).sample_delta(0, u)
}
