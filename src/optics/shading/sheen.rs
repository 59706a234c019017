//! Sheen: fibres that stand up from a surface, by Charlie's distribution of normals, D = (2 + 1/α) sin^(1/α)θh / 2π, and its shadowing
//! \[E51\] (Estevez & Kulla 2017). Twin: shaders/shading/sheen.wgsl.

use crate::optics::shading::fresnel::of_clear_coat;
use crate::packed::PackedMaterial;
use crate::packed::constants::SHEEN_ALBEDO;
use crate::sampling::distributions::{cone, to_world};
use crate::spectrum::{BLACK, Bands, scale};
use glam::Vec3;
use std::f32::consts::TAU;

/// Terms a to e of the fit of Λ, rough (α = 0) and smooth (α = 1).
const TERMS: [[f32; 2]; 5] =
    [[25.3245, 21.5473], [3.32435, 3.82987], [0.16801, 0.19823], [-1.27393, -1.97760], [-4.85967, -4.32054]];

/// Part of white light at this cosine that the lobe sends on, by a fit from above.
pub(super) fn albedo(roughness: f32, cosine: f32) -> f32 {
    let root = cosine.max(0.0).sqrt();
    let in_roughness = |row: &[f32; 4]| row.iter().rev().fold(0.0, |sum, k| sum * roughness + k);
    SHEEN_ALBEDO.iter().rev().fold(0.0, |sum, row| sum * root + in_roughness(row)).clamp(0.0, 1.0)
}

/// The lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sheen {
    colour: Bands,
    alpha: f32,
    /// How much of a clear coat lies over it.
    clear_coat: f32,
    /// Reflectance at the angle of the view, about.
    pub(super) albedo: Bands,
}

impl Sheen {
    /// Of a material seen at this cosine to the normal.
    pub(super) fn new(m: &PackedMaterial, cosine: f32) -> Self {
        let (colour, clear_coat) = (m.extinction, m.clear_coat);
        let [roughness, _] = m.sheen_numbers();
        let sent = albedo(roughness, cosine) * (1.0 - of_clear_coat(clear_coat, cosine));
        Self { colour, alpha: roughness * roughness, clear_coat, albedo: scale(&colour, sent) }
    }

    /// Λ of Smith's shadowing.
    fn lambda(&self, cosine: f32) -> f32 {
        let rest = (1.0 - self.alpha).powi(2);
        let [a, b, c, d, e] = TERMS.map(|[rough, smooth]| smooth + rest * (rough - smooth));
        let exponent = |x: f32| a / (1.0 + b * x.powf(c)) + d * x + e;
        let power = if cosine < 0.5 {
            exponent(cosine)
        } else {
            2.0 * exponent(0.5) - exponent((1.0 - cosine).max(0.0))
        };
        power.exp()
    }

    /// f_r, 1/sr; unit vectors that leave the surface.
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return BLACK;
        }
        let sin_h = (wi + wo).normalize().cross(n).length().min(1.0);
        let density = (2.0 + 1.0 / self.alpha) * sin_h.powf(1.0 / self.alpha) / TAU;
        let seen = 0.25 / ((1.0 + self.lambda(cos_i) + self.lambda(cos_o)) * cos_i * cos_o);
        let passed =
            1.0 - [cos_i, cos_o].map(|c| of_clear_coat(self.clear_coat, c)).into_iter().fold(0.0, f32::max);
        scale(&self.colour, density * seen * passed)
    }

    /// pdf_solid_angle of [`Sheen::sample`]: all directions alike.
    pub(super) fn pdf(&self, wi: Vec3, n: Vec3) -> f32 {
        if wi.dot(n) > 0.0 { 1.0 / TAU } else { 0.0 }
    }

    /// A direction above the surface.
    pub(super) fn sample(&self, n: Vec3, u: [f32; 2]) -> Vec3 {
        to_world(cone(u, 1.0), n)
    }
}
