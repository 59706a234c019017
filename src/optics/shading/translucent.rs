//! What is scattered through a surface: f = albedo/π toward the other side, pdf_solid_angle = |cosθ|/π \[E55\]. Twin:
//! shaders/shading/translucent.wgsl.

use crate::sampling::distributions::{cosine_hemisphere, to_world};
use crate::spectrum::{Bands, scale};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// Light goes to all directions beyond the surface alike.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Translucent {
    pub(crate) albedo: Bands,
}

impl Translucent {
    /// f, 1/sr, of light from the other side.
    pub(crate) fn eval(&self) -> Bands {
        scale(&self.albedo, FRAC_1_PI)
    }

    /// pdf_solid_angle of [`Translucent::sample`].
    pub(crate) fn pdf(&self, wi: Vec3, n: Vec3) -> f32 {
        (-wi.dot(n)).max(0.0) * FRAC_1_PI
    }

    /// A direction about the other side's normal; `n` is on this side.
    pub(crate) fn sample(&self, n: Vec3, u: [f32; 2]) -> Vec3 {
        to_world(cosine_hemisphere(u), -n)
    }
}
