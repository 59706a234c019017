//! The Lambert lobe: f_r = albedo/π, pdf_solid_angle = cosθ/π. Twin: shaders/shading/lambert.wgsl.

use crate::sampling::distributions::{cosine_hemisphere, to_world};
use crate::spectrum::{Bands, scale};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Light goes into all directions alike.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Lambert {
    pub(crate) albedo: Bands,
}

impl Lambert {
    /// f_r, 1/sr.
    pub(crate) fn eval(&self) -> Bands {
        scale(&self.albedo, FRAC_1_PI)
    }

    /// pdf_solid_angle of [`Lambert::sample`].
    pub(crate) fn pdf(&self, wi: Vec3, n: Vec3) -> f32 {
        wi.dot(n).max(0.0) * FRAC_1_PI
    }

    /// A direction about `n`.
    pub(crate) fn sample(&self, n: Vec3, u: [f32; 2]) -> Vec3 {
        to_world(cosine_hemisphere(u), n)
    }
}
