//! Harness: samplers and discs that the backend keeps to itself, for their tests.

use super::disc::Disc;
use super::eye::{GatherPoint, camera_ray};
use super::streams::*;
use super::trace::jotons;
use crate::backend::Tally;
use crate::optics::lights::cone::{Beam, into_targets};
use crate::optics::lights::pick;
use crate::optics::lights::samples::Start;
use crate::optics::shading::bsdf::Bsdf;
use crate::optics::shading::frame::Frame;
use crate::optics::shading::texture;
use crate::packed::{Guide, Inside, PackedEmitter, PackedMaterial, PackedScene, Target};
use crate::plan::Plan;
use crate::sampling::rng::sequence2;
use crate::spectrum::{BANDS, Bands};
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
    start.map(|Start { origin, direction, flux, .. }| (origin, direction, flux))
}

/// A direction from `origin` into the cones of the targets and its pdf_solid_angle.
pub fn into_cones(targets: &[Target], origin: Vec3, u: [f32; 2]) -> Option<(Vec3, f32)> {
    let (ray, pdf) = into_targets(targets, &Beam { through: origin, axis: Vec3::Z, distance: 0.0 }, u)?;
    Some((ray.direction, pdf))
}

/// Number of the emitter that `u` picks, and what is left of `u`.
pub fn pick(emitters: &[PackedEmitter], u: f32) -> (usize, f32) {
    pick::pick(emitters, u)
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

/// What a texture of a scene, counted from 1, shows at texture coordinates to who sees so much of these at once: red, green and blue, and
/// the number that it is asked for.
pub fn texture_lookup(scene: &PackedScene, number: u32, uv: [f32; 2], width: f32) -> [f32; 4] {
    let [r, g, b, _] = texture::lookup(&scene.textures, number, uv, width);
    [r, g, b, texture::number(&scene.textures, number, uv, width)]
}

/// What the disc of the caustic map about a place on a triangle holds \[E31\]: its radius, the area of the surface in it, and walls as
/// unit normals with their offsets from the place; `front`: the side that is looked at.
pub fn disc(
    scene: &PackedScene,
    triangle: u32,
    front: bool,
    position: Vec3,
    radius: f32,
) -> (f32, f32, Vec<(Vec3, f32)>) {
    let triangle = &scene.triangles[triangle as usize];
    let ng = triangle.normal() * if front { 1.0 } else { -1.0 };
    let frame = Frame { back: ng, ng, ns: ng, front };
    let g = GatherPoint {
        position,
        ng,
        front,
        ns: ng,
        wo: ng,
        throughput: [1.0; BANDS],
        bsdf: Bsdf::new(&scene.materials[triangle.material as usize], frame),
        triangle,
        inside: Inside::default(),
        chain: 0,
        length: 1.0,
    };
    let disc = Disc::about(scene, &g, radius);
    let walls = disc.walls().into_iter().flatten().filter(|(normal, _)| *normal != Vec3::ZERO);
    (disc.radius, disc.area, walls.collect())
}
