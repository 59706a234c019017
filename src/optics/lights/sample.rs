//! Light: places on emitters, as shadow rays find them.

use crate::optics::lights::emit::{falloff, from_light, kind, pick, place_on};
use crate::optics::ray::SurfaceInteraction;
use crate::packed::{EmitterKind, NO_EMITTER, PackedEmitter};
use crate::spectrum::{Bands, scale};
use glam::Vec3;

/// A place on an emitter, seen from a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Unit vector toward the emitter.
    pub(crate) wi: Vec3,
    /// Where a shadow ray must arrive.
    pub(crate) target: Vec3,
    /// Irradiance across `wi` over the probability of this sample: Le cos_l/(d² pick pdf_area), I/(d² pick), E/pick.
    pub(crate) irradiance: Bands,
    /// pdf_solid_angle with `pick`; 0 where no BSDF sample can find the emitter.
    pub(crate) pdf: f32,
}

/// Shadow rays to the sun end outside the scene: its radius is below 1024 internal units.
const BEYOND: f32 = 4096.0;

/// A place on one of `emitters`, picked by their probabilities; None where it shines away from `position`, or where there
/// are none.
pub(crate) fn sample_light(emitters: &[PackedEmitter], position: Vec3, u: [f32; 2]) -> Option<LightSample> {
    if emitters.is_empty() {
        return None;
    }
    let (e, rest) = pick(emitters, u[0]);
    let l = sample_emitter(e, position, [rest, u[1]])?;
    Some(LightSample { irradiance: scale(&l.irradiance, 1.0 / e.pick), pdf: l.pdf * e.pick, ..l })
}

/// A place on an emitter, as if it were the only one; None where it shines away from `position`.
pub(crate) fn sample_emitter(e: &PackedEmitter, position: Vec3, u: [f32; 2]) -> Option<LightSample> {
    let towards = |target: Vec3| {
        let offset = target - position;
        let distance_squared = offset.length_squared();
        (distance_squared > 0.0).then(|| (offset / distance_squared.sqrt(), distance_squared))
    };
    match kind(e) {
        EmitterKind::Triangle => {
            let (target, normal) = place_on(e, u);
            let (wi, distance_squared) = towards(target)?;
            let cos_l = -wi.dot(normal);
            let weight = e.area * cos_l / distance_squared;
            (cos_l > 0.0).then(|| LightSample {
                wi,
                target,
                irradiance: scale(&e.strength, weight),
                pdf: 1.0 / weight,
            })
        }
        EmitterKind::Point | EmitterKind::Spot => {
            let way = from_light(e, position);
            let distance_squared = way.length_squared();
            let shape = if kind(e) == EmitterKind::Spot { falloff(e, way) } else { 1.0 };
            let irradiance = scale(&e.strength, shape / distance_squared);
            let wi = -way / distance_squared.sqrt();
            (shape > 0.0 && distance_squared > 0.0).then_some(LightSample {
                wi,
                target: e.position(),
                irradiance,
                pdf: 0.0,
            })
        }
        EmitterKind::Sun => Some(LightSample {
            wi: -e.e1,
            target: position - e.e1 * BEYOND,
            irradiance: e.strength,
            pdf: 0.0,
        }),
    }
}

/// pdf_solid_angle with which [`sample_light`] finds the emissive surface `s` from where its ray came.
pub(crate) fn pdf_light(emitters: &[PackedEmitter], s: &SurfaceInteraction) -> f32 {
    if s.triangle.emitter == NO_EMITTER {
        return 0.0;
    }
    let e = &emitters[s.triangle.emitter as usize];
    e.pick * s.distance * s.distance / (e.area * s.back.dot(s.ng))
}
