//! Lights: how jotons leave them (`sample_le`), how shadow rays find them (`sample_li`, `pdf_li`), and what a ray finds by itself (`le`,
//! `on_miss`). A new kind is a file and a line in each of the functions here. Twin: shaders/lights/light.wgsl.

pub(crate) mod cone;
mod glow;
pub(crate) mod pick;
mod point;
pub mod reservoir;
pub(crate) mod samples;
mod spot;
mod sun;
mod triangle;

use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::material::seen_width;
use crate::optics::shading::texture::in_bands;
use crate::packed::{EmitterKind, PackedEmitter, PackedScene, Target};
use crate::spectrum::{BLACK, Bands, mul};
use cone::into_targets;
use glam::Vec3;
use samples::{LightSample, Start};

/// How the intensity of a light at a place depends on direction.
fn shape(e: &PackedEmitter) -> point::Shape {
    if e.kind() == EmitterKind::Spot { spot::falloff } else { point::even }
}

/// A joton's start by the law of one emitter; `share` of its flux.
pub(crate) fn sample_le(
    scene: &PackedScene,
    e: &PackedEmitter,
    place: [f32; 2],
    towards: [f32; 2],
    share: f32,
) -> Start {
    let mut start = match e.kind() {
        EmitterKind::Triangle => triangle::by_law(e, place, towards, share),
        EmitterKind::Point | EmitterKind::Spot => point::by_law(e, shape(e), towards, share),
        EmitterKind::Sun => sun::by_law(e, towards, share),
    };
    if let Some(glow) = glow::at(scene, e, place) {
        start.flux = mul(&start.flux, &glow);
    }
    start
}

/// A joton's start aimed at the specular bodies [E13], `share` of the emitter's flux; by its law where it starts inside one. None
/// where no flux goes the way that was drawn.
pub(crate) fn sample_le_aimed(
    scene: &PackedScene,
    e: &PackedEmitter,
    place: [f32; 2],
    towards: [f32; 2],
    share: f32,
) -> Option<Start> {
    let targets = &scene.targets;
    if targets.is_empty() {
        return Some(sample_le(scene, e, place, towards, share));
    }
    let is_triangle = e.kind() == EmitterKind::Triangle;
    let beam = match e.kind() {
        EmitterKind::Triangle => triangle::beam(e, place),
        EmitterKind::Point | EmitterKind::Spot => point::beam(e),
        EmitterKind::Sun => return sun::aimed(e, targets, towards, share),
    };
    // where its own cone is narrower than those of the targets, a light's own law serves better
    let is_narrow = !is_triangle && e.area <= beam.solid_angle_of(targets);
    if is_narrow || targets.iter().any(|t| beam.is_inside(t)) {
        return Some(sample_le(scene, e, place, towards, share));
    }
    let (ray, pdf_solid_angle) = into_targets(targets, &beam, towards)?;
    let weight = share / pdf_solid_angle;
    let mut start = match e.kind() {
        EmitterKind::Triangle => triangle::along(e, &beam, ray.direction, weight),
        EmitterKind::Point | EmitterKind::Spot => point::along(e, shape(e), &beam, ray, weight),
        EmitterKind::Sun => return None,
    };
    if let Some(glow) = glow::at(scene, e, place) {
        start.flux = mul(&start.flux, &glow);
    }
    (start.flux != BLACK).then_some(start)
}

/// A place on an emitter, as if it were the only one; None where it shines away from `position`.
pub(crate) fn sample_li(
    scene: &PackedScene,
    e: &PackedEmitter,
    position: Vec3,
    u: [f32; 2],
) -> Option<LightSample> {
    let sample = match e.kind() {
        EmitterKind::Triangle => triangle::sample_li(e, position, u),
        EmitterKind::Point | EmitterKind::Spot => point::sample_li(e, shape(e), position),
        EmitterKind::Sun => Some(sun::sample_li(e, position)),
    };
    match glow::at(scene, e, u) {
        Some(glow) => sample.map(|l| LightSample { irradiance: mul(&l.irradiance, &glow), ..l }),
        None => sample,
    }
}

/// pdf_solid_angle with which [`sample_li`] finds the emitter where a ray met it; no ray meets lights without area.
pub(crate) fn pdf_li(e: &PackedEmitter, s: &SurfaceInteraction) -> f32 {
    match e.kind() {
        EmitterKind::Triangle => triangle::pdf_li(e, s),
        EmitterKind::Point | EmitterKind::Spot | EmitterKind::Sun => 0.0,
    }
}

/// Radiance that a surface sends back along the ray that met it; none but from the front of a light.
pub(crate) fn le(s: &SurfaceInteraction) -> Option<Bands> {
    le_of_width(s, 0.0)
}

/// The same along a ray that has come so far from the eye: of a texture it sees a part of a pixel at once \[E37\].
pub(crate) fn le_seen(scene: &PackedScene, s: &SurfaceInteraction, length: f32) -> Option<Bands> {
    le_of_width(s, seen_width(scene, length))
}

fn le_of_width(s: &SurfaceInteraction, width: f32) -> Option<Bands> {
    let m = s.material;
    let plain = (s.front && s.flags().is_emissive()).then_some(m.emission)?;
    Some(m.emission_texture().map_or(plain, |number| {
        let place = s.texture;
        mul(&plain, &in_bands(s.textures, s.of_texel, number, place.uv, width * place.per_unit))
    }))
}

/// Radiance that a ray finds where it leaves the scene. A sun has no extent: no ray meets it.
pub(crate) fn on_miss(_direction: Vec3) -> Bands {
    BLACK
}

/// True where an emitter can shine on a sphere.
pub(crate) fn shines_on(e: &PackedEmitter, target: &Target) -> bool {
    match e.kind() {
        EmitterKind::Triangle => triangle::shines_on(e, target),
        EmitterKind::Spot => spot::shines_on(e, target),
        EmitterKind::Point | EmitterKind::Sun => true,
    }
}

/// True where `position` may lie so near to an emitter that shadow rays alone have fireflies.
pub(crate) fn is_near(e: &PackedEmitter, position: Vec3) -> bool {
    e.kind() == EmitterKind::Triangle && triangle::is_near(e, position)
}
