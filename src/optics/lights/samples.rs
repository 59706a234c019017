//! What lights are asked for: where a joton starts, and where a shadow ray goes.

use crate::spectrum::Bands;
use glam::Vec3;

/// A joton that has just left its emitter.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Start {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Flux, internal W per band, divided by the number of jotons.
    pub(crate) flux: Bands,
}

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
