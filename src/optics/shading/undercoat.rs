//! What is diffuse under a clear coat: f_r = albedo/π T(θi) T(θo), T = 1 − R of the coat \[E42\]. Twin: shaders/shading/undercoat.wgsl.

use crate::optics::shading::fresnel::Fresnel;
use crate::optics::shading::layers::{Layers, covered};
use crate::packed::PackedMaterial;
use crate::sampling::distributions::{cosine_hemisphere, to_world};
use crate::spectrum::{Bands, scale};
use glam::Vec3;
use std::f32::consts::FRAC_1_PI;

/// The lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Undercoat {
    /// What leaves the base over what enters the coat, per band.
    base: Bands,
    /// The bare coat.
    coat: Fresnel,
    /// What lies over both.
    layers: Option<Layers>,
    /// Reflectance for light that leaves, or arrives, at the angle of the view.
    pub(super) albedo: Bands,
}

impl Undercoat {
    /// Of a material seen at this cosine to the normal.
    pub(super) fn new(m: &PackedMaterial, cosine: f32) -> Self {
        let coat = Fresnel::of_bare_coat(m);
        let passes = passed(&coat, cosine) * m.coat_transmittance;
        let layers = Layers::over(m);
        let albedo = covered(layers, scale(&m.diffuse, passes), cosine, cosine);
        Self { base: m.diffuse, coat, layers, albedo }
    }

    /// f_r, 1/sr.
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        let bare = scale(&self.base, FRAC_1_PI * passed(&self.coat, cos_i) * passed(&self.coat, cos_o));
        covered(self.layers, bare, cos_i, cos_o)
    }

    /// pdf_solid_angle of [`Undercoat::sample`].
    pub(super) fn pdf(&self, wi: Vec3, n: Vec3) -> f32 {
        wi.dot(n).max(0.0) * FRAC_1_PI
    }

    /// A direction by its cosine.
    pub(super) fn sample(&self, n: Vec3, u: [f32; 2]) -> Vec3 {
        to_world(cosine_hemisphere(u), n)
    }
}

/// Part of light at this cosine that the coat lets through.
fn passed(coat: &Fresnel, cosine: f32) -> f32 {
    1.0 - coat.at(cosine)[0]
}
