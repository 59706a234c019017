//! What lights are asked for: where a joton starts, and where a shadow ray goes.

use crate::optics::media::transmittance;
use crate::optics::ray::Ray;
use crate::packed::{Inside, PackedScene};
use crate::spectrum::{Bands, mul};
use glam::Vec3;

/// A joton that has just left its emitter.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Start {
    pub(crate) origin: Vec3,
    pub(crate) direction: Vec3,
    /// Flux, internal W per band, divided by the number of jotons.
    pub(crate) flux: Bands,
    /// The bodies that it starts in, once it is known which emitter it left.
    pub(crate) inside: Inside,
}

impl Start {
    /// Its ray.
    pub(crate) fn ray(&self) -> Ray {
        Ray::new(self.origin, self.direction).within(self.inside)
    }
}

/// A place on an emitter, seen from a point.
#[derive(Debug, Clone, Copy)]
pub(crate) struct LightSample {
    /// Unit vector toward the emitter.
    pub(crate) wi: Vec3,
    /// Where a shadow ray must arrive.
    pub(crate) target: Vec3,
    /// How far away the emitter is; infinite for a sun.
    pub(crate) distance: f32,
    /// Irradiance across `wi` over the probability of this sample: Le cos_l/(d² pick pdf_area), I/(d² pick), E/pick.
    pub(crate) irradiance: Bands,
    /// pdf_solid_angle with `pick`; 0 where no BSDF sample can find the emitter.
    pub(crate) pdf: f32,
}

impl LightSample {
    /// Its irradiance at the place that it was drawn for, in these bodies, where nothing shades it: a shadow ray crosses no boundary \[E44\].
    pub(crate) fn through(&self, scene: &PackedScene, inside: Inside) -> Bands {
        let left = transmittance(scene, inside, self.distance);
        left.map_or(self.irradiance, |left| mul(&self.irradiance, &left))
    }
}
