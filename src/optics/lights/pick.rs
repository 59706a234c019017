//! Picking one of the emitters, and what is asked of the one that was picked. Twin: shaders/lights/pick.wgsl.

use crate::optics::lights::samples::{LightSample, Start};
use crate::optics::lights::{pdf_li, sample_le, sample_le_aimed, sample_li};
use crate::optics::ray::SurfaceInteraction;
use crate::packed::{Guide, NO_EMITTER, PackedEmitter, PackedScene};
use crate::spectrum::scale;
use glam::Vec3;

/// The number of the emitter that `u` picks, and what is left of `u`, again uniform in [0, 1).
pub(crate) fn pick(emitters: &[PackedEmitter], u: f32) -> (usize, f32) {
    let i = emitters.partition_point(|e| e.cumulative <= u).min(emitters.len() - 1);
    let below = if i == 0 { 0.0 } else { emitters[i - 1].cumulative };
    let rest = (u - below) / (emitters[i].cumulative - below);
    (i, rest.clamp(0.0, 1.0 - f32::EPSILON))
}

/// A joton's start by the law of an emitter that the guide picks, the way that it steers [E2, E20]; `count` jotons a pass.
pub(crate) fn by_law(
    scene: &PackedScene,
    guide: &Guide,
    place: [f32; 2],
    towards: [f32; 2],
    count: f32,
) -> Start {
    let emitters = guide.emitters(&scene.emitters);
    let (number, rest) = pick(emitters, place[0]);
    let e = &emitters[number];
    let (towards, density) = guide.steer(e, towards);
    let start = sample_le(scene, e, [rest, place[1]], towards, 1.0 / (e.pick * count * density));
    Start { inside: scene.media.of_emitter(number), ..start }
}

/// A start aimed at the specular bodies [E13], of an emitter that the guide picks, the way that it steers. None where no flux
/// goes the way that was drawn.
pub(crate) fn aimed(
    scene: &PackedScene,
    guide: &Guide,
    place: [f32; 2],
    towards: [f32; 2],
    count: f32,
) -> Option<Start> {
    let emitters = guide.emitters(&scene.emitters);
    let (number, rest) = pick(emitters, place[0]);
    let e = &emitters[number];
    let (towards, density) = guide.steer(e, towards);
    let start = sample_le_aimed(scene, e, [rest, place[1]], towards, 1.0 / (e.pick * count * density))?;
    Some(Start { inside: scene.media.of_emitter(number), ..start })
}

/// A place on one of `emitters`, picked by their probabilities; None where it shines away from `position`, or where there
/// are none.
pub(crate) fn sample_light(
    scene: &PackedScene,
    emitters: &[PackedEmitter],
    position: Vec3,
    u: [f32; 2],
) -> Option<LightSample> {
    if emitters.is_empty() {
        return None;
    }
    let (number, rest) = pick(emitters, u[0]);
    let e = &emitters[number];
    let l = sample_li(scene, e, position, [rest, u[1]])?;
    Some(LightSample { irradiance: scale(&l.irradiance, 1.0 / e.pick), pdf: l.pdf * e.pick, ..l })
}

/// pdf_solid_angle with which [`sample_light`] finds the emissive surface `s` from where its ray came.
pub(crate) fn pdf_light(emitters: &[PackedEmitter], s: &SurfaceInteraction) -> f32 {
    if s.triangle.emitter == NO_EMITTER {
        return 0.0;
    }
    let e = &emitters[s.triangle.emitter as usize];
    e.pick * pdf_li(e, s)
}
