//! The Phong lobe: f_r = albedo (e + 2)/2π cosᵉα, α between wo and the mirror direction of wi, pdf_solid_angle = (e + 1)/2π cosᵉα
//! \[E6\] (Lafortune & Willems 1994). Symmetric in wi and wo. Twin: shaders/shading/phong.wgsl.

use crate::sampling::distributions::{phong_lobe, to_world};
use crate::spectrum::{Bands, scale};
use glam::Vec3;
use std::f32::consts::TAU;

/// Light goes about the mirror direction.
#[derive(Debug, Clone, Copy)]
pub struct Phong {
    /// Reflectance head on, per band.
    pub albedo: Bands,
    /// Exponent e.
    pub exponent: f32,
}

impl Phong {
    /// cosᵉα, α between two directions, from 1 − cosα: near one a cosine has no digits for a large exponent.
    #[inline]
    fn power(&self, a: Vec3, b: Vec3) -> f32 {
        let below = 0.5 * (a - b).length_squared();
        if below >= 1.0 { 0.0 } else { (self.exponent * (-below).ln_1p()).exp() }
    }

    /// f_r, 1/sr; unit vectors that leave the surface.
    #[inline]
    pub fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        scale(&self.albedo, (self.exponent + 2.0) / TAU * self.power(mirrored(wi, n), wo))
    }

    /// pdf_solid_angle of [`Phong::sample`].
    pub fn pdf(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        self.pdf_about(mirrored(wi, n), wo)
    }

    /// The same of a direction about an axis.
    pub(super) fn pdf_about(&self, axis: Vec3, w: Vec3) -> f32 {
        (self.exponent + 1.0) / TAU * self.power(axis, w)
    }

    /// A direction about the mirror image of `wo`; it may lie below the surface.
    pub fn sample(&self, wo: Vec3, n: Vec3, u: [f32; 2]) -> Vec3 {
        to_world(phong_lobe(u, self.exponent), mirrored(wo, n))
    }
}

/// The mirror image of `w` about `n`, both leaving the surface.
pub(super) fn mirrored(w: Vec3, n: Vec3) -> Vec3 {
    n * (2.0 * w.dot(n)) - w
}
