//! A clear coat of index 1.5 over all else: a lobe of GGX's microfacets that reflect by Schlick's formula \[E50\]. Twin:
//! shaders/shading/clear_coat.wgsl.

use crate::optics::shading::fresnel::of_clear_coat;
use crate::optics::shading::microfacet::Ggx;
use crate::packed::PackedMaterial;
use crate::spectrum::{BANDS, BLACK, Bands};
use glam::Vec3;

/// The lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ClearCoat {
    /// How much of it is there.
    amount: f32,
    ggx: Ggx,
    /// Reflectance of a facet that lies flat, at the angle of the view: near the lobe's.
    pub(super) albedo: Bands,
}

impl ClearCoat {
    /// Of a material seen at this cosine to the normal.
    pub(super) fn new(m: &PackedMaterial, cosine: f32) -> Self {
        Self {
            amount: m.clear_coat,
            ggx: Ggx { alpha: m.clear_coat_alpha, brushed: None },
            albedo: [of_clear_coat(m.clear_coat, cosine); BANDS],
        }
    }

    /// False for a smooth coat.
    pub(super) fn has_width(&self) -> bool {
        self.ggx.alpha > 0.0
    }

    /// f_r, 1/sr; unit vectors that leave the surface.
    pub(super) fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return BLACK;
        }
        let h = (wi + wo).normalize();
        let shape = self.ggx.density(h, n) * self.ggx.visibility(wi, wo, n);
        [of_clear_coat(self.amount, wo.dot(h)) * shape; BANDS]
    }

    /// pdf_solid_angle of [`ClearCoat::sample`].
    pub(super) fn pdf(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        if wi.dot(n) <= 0.0 || wo.dot(n) <= 0.0 {
            return 0.0;
        }
        self.ggx.pdf((wi + wo).normalize(), n, wo)
    }

    /// The mirror image of `wo` about one of the facets; it may lie below the surface.
    pub(super) fn sample(&self, wo: Vec3, n: Vec3, u: [f32; 2]) -> Vec3 {
        let h = self.ggx.normal(wo, n, u);
        (h * (2.0 * wo.dot(h)) - wo).normalize()
    }

    /// f_r cosθ / pdf_solid_angle of a direction that was sampled.
    pub(super) fn reflected(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return BLACK;
        }
        let h = (wi + wo).normalize();
        [of_clear_coat(self.amount, wo.dot(h)) * self.ggx.seen_again(wi, wo, n); BANDS]
    }
}
