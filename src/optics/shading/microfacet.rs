//! A lobe of microfacets: f_r = F D V and what is scattered more than once, D the density of GGX's normals, V = G₂/(4 cosθi cosθo) with Smith's masking of correlated heights
//! \[E41\] (Walter et al. 2007, Heitz 2014). Twin: shaders/shading/microfacet.wgsl.

use crate::optics::shading::anisotropy::Brushed;
use crate::optics::shading::fresnel::Fresnel;
use crate::optics::shading::layers::{Layers, covered};
use crate::packed::PackedMaterial;
use crate::packed::constants::GGX_LOST;
use crate::sampling::distributions::{to_world, unit_circle};
use crate::spectrum::{BLACK, Bands, add, scale};
use glam::{Mat3, Vec3};
use std::f32::consts::PI;

/// GGX normals of roughness α about a surface normal.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ggx {
    /// Of brushed ones that by which they mask each other.
    pub(super) alpha: f32,
    pub(super) brushed: Option<Brushed>,
}

impl Ggx {
    /// As rough each way.
    pub(super) fn even(alpha: f32) -> Self {
        Self { alpha, brushed: None }
    }

    /// Of a material that has been met.
    pub(super) fn of(m: &PackedMaterial) -> Self {
        // where a picture of roughness is 0 there is a mirror
        let brushed = Brushed::of(m).filter(|_| m.alpha > 0.0);
        Self { alpha: brushed.map_or(m.alpha, |brushed| brushed.masking_alpha()), brushed }
    }

    /// Density of normals, 1/sr.
    fn density(&self, h: Vec3, n: Vec3) -> f32 {
        if let Some(brushed) = &self.brushed {
            return brushed.density(h, n);
        }
        // a cross product: near the normal a cosine has no digits
        let sin2 = n.cross(h).length_squared();
        let cos = n.dot(h);
        let a2 = self.alpha * self.alpha;
        let stretched = sin2 + a2 * cos * cos;
        a2 / (PI * stretched * stretched)
    }

    /// √(α² + (1 − α²) cos²): Smith's Λ is this over 2 cosθ, less a half.
    fn slope(&self, w: Vec3, n: Vec3, cosine: f32) -> f32 {
        if let Some(brushed) = &self.brushed {
            return brushed.slope(w, n);
        }
        let a2 = self.alpha * self.alpha;
        (a2 + (1.0 - a2) * cosine * cosine).sqrt()
    }

    /// G₂/(4 cosθi cosθo).
    fn visibility(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        0.5 / (cos_i * self.slope(wo, n, cos_o) + cos_o * self.slope(wi, n, cos_i))
    }

    /// G₂/G₁(o): part of the facets that `o` sees which `i` sees as well.
    pub(super) fn seen_again(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        let (slope_i, slope_o) = (self.slope(wi, n, cos_i), self.slope(wo, n, cos_o));
        cos_i * (cos_o + slope_o) / (cos_i * slope_o + cos_o * slope_i)
    }

    /// G₁: part of the facets toward a direction that it sees.
    pub(super) fn seen(&self, w: Vec3, n: Vec3) -> f32 {
        let cosine = w.dot(n).abs();
        2.0 * cosine / (cosine + self.slope(w, n, cosine))
    }

    /// √α to the powers 0 to 3.
    fn powers(&self) -> [f32; 4] {
        let root = self.alpha.sqrt();
        [1.0, root, self.alpha, self.alpha * root]
    }

    /// Part of the light at this cosine that facets mask from each other.
    fn lost(&self, cosine: f32) -> f32 {
        let root = cosine.max(0.0).sqrt();
        let powers = self.powers();
        GGX_LOST.iter().rev().fold(0.0, |sum, row| sum * root + dot(row, &powers)).max(0.0)
    }

    /// Of even light, ∫ 2c lost(c) dc: each c^(j/2) has 4/(4 + j). The fit says too little of smooth surfaces.
    fn lost_of_even_light(&self) -> f32 {
        let powers = self.powers();
        let parts = GGX_LOST.iter().enumerate().map(|(j, row)| 4.0 / (4.0 + j as f32) * dot(row, &powers));
        parts.sum::<f32>().max((0.9 * self.alpha * self.alpha).min(0.0152))
    }

    /// Shape of what is scattered more than once, 1/sr: as a diffuse lobe that light finds and leaves as facets mask it.
    fn again(&self, cos_i: f32, cos_o: f32, lost: f32) -> f32 {
        // none where the fit does not reach
        let rough = ((self.alpha - 0.02) / 0.03).clamp(0.0, 1.0);
        rough * self.lost(cos_i) * self.lost(cos_o) / (PI * lost)
    }

    /// pdf_solid_angle of the mirror image of `wo` about one of [`Ggx::normal`].
    pub(super) fn pdf(&self, h: Vec3, n: Vec3, wo: Vec3) -> f32 {
        let cos_o = wo.dot(n);
        self.density(h, n) / (2.0 * (cos_o + self.slope(wo, n, cos_o)))
    }

    /// The normal of one of the facets that `wo` sees, each by the area that it shows (Dupuy & Benyoub 2023).
    pub(super) fn normal(&self, wo: Vec3, n: Vec3, u: [f32; 2]) -> Vec3 {
        let (frame, [a, b]) = match &self.brushed {
            Some(brushed) => (brushed.frame(n), brushed.alphas),
            None => (Mat3::from_cols(to_world(Vec3::X, n), to_world(Vec3::Y, n), n), [self.alpha; 2]),
        };
        let stretched = |v: Vec3| Vec3::new(a * v.x, b * v.y, v.z);
        let o = stretched(frame.transpose() * wo).normalize();
        let [cos_phi, sin_phi] = unit_circle(u[0]);
        let z = (1.0 - u[1]) * (1.0 + o.z) - o.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let h = stretched(Vec3::new(r * cos_phi, r * sin_phi, z) + o);
        (frame * Vec3::new(h.x, h.y, h.z.max(0.0))).normalize()
    }
}

/// A reflecting lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Microfacet {
    fresnel: Fresnel,
    ggx: Ggx,
    /// Part of even light that facets mask from each other, and what of it leaves after all (Kulla & Conty 2017).
    lost: f32,
    kept: Bands,
    /// What lies over it.
    layers: Option<Layers>,
    /// Reflectance of a facet that lies flat, at the angle of the view: near the lobe's.
    pub(crate) albedo: Bands,
}

impl Microfacet {
    /// Of a material seen at this cosine to the normal; `tint` is what it says of the lobe.
    pub(super) fn new(m: &PackedMaterial, tint: Bands, cosine: f32) -> Self {
        let fresnel = Fresnel::of(m, tint);
        let ggx = Ggx::of(m);
        let lost = ggx.lost_of_even_light();
        let kept = fresnel.of_even_light().map(|r| r * r * (1.0 - lost) / (1.0 - r * lost));
        let layers = Layers::over(m);
        let albedo = covered(layers, fresnel.at(cosine), cosine, cosine);
        Self { fresnel, ggx, lost, kept, layers, albedo }
    }

    /// What reflects once, under nothing else.
    pub(super) fn once(fresnel: Fresnel, ggx: Ggx, cosine: f32) -> Self {
        Self { fresnel, ggx, lost: 1.0, kept: BLACK, layers: None, albedo: fresnel.at(cosine) }
    }

    /// False for a smooth surface.
    pub(super) fn has_width(&self) -> bool {
        self.ggx.alpha > 0.0
    }

    /// f_r, 1/sr; unit vectors that leave the surface.
    pub(crate) fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        let (cos_i, cos_o) = (wi.dot(n), wo.dot(n));
        if cos_i <= 0.0 || cos_o <= 0.0 {
            return BLACK;
        }
        let h = (wi + wo).normalize();
        let shape = self.ggx.density(h, n) * self.ggx.visibility(wi, wo, n);
        let bare = add(&scale(&self.fresnel.at(wo.dot(h)), shape), &self.again(cos_i, cos_o));
        covered(self.layers, bare, cos_i, cos_o)
    }

    /// f_r of what is scattered more than once, 1/sr.
    fn again(&self, cos_i: f32, cos_o: f32) -> Bands {
        if self.kept == BLACK { BLACK } else { scale(&self.kept, self.ggx.again(cos_i, cos_o, self.lost)) }
    }

    /// pdf_solid_angle of [`Microfacet::sample`].
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
        let once = scale(&self.fresnel.at(wo.dot(h)), self.ggx.seen_again(wi, wo, n));
        let pdf = self.ggx.pdf(h, n, wo);
        let bare = add(&once, &scale(&self.again(cos_i, cos_o), cos_i / pdf.max(f32::MIN_POSITIVE)));
        covered(self.layers, bare, cos_i, cos_o)
    }
}

fn dot(a: &[f32; 4], b: &[f32; 4]) -> f32 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Anisotropy, FacetKind, Facets, Material};

    /// Where a picture says that a brushed surface is smooth, its lobe has no width, as that of any smooth surface.
    #[test]
    fn a_smooth_place_of_a_brushed_surface_is_a_mirror() {
        let brushed = PackedMaterial::new(&Material {
            glossy: [0.5; 3],
            facets: Some(Facets { alpha: 0.25, kind: FacetKind::Schlick { ior: 1.5 } }),
            anisotropy: Some(Anisotropy { strength: 0.8, rotation: 0.0, is_around: false }),
            ..Material::matte("brushed", BLACK)
        });
        let lobe = |m: &PackedMaterial| Microfacet::new(m, m.glossy, 0.7);
        assert!(lobe(&brushed).has_width() && brushed.brush().is_some());
        assert!(!lobe(&PackedMaterial { alpha: 0.0, ..brushed }).has_width());
    }
}
