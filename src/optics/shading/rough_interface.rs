//! A rough interface of two dielectrics: it reflects and transmits at microfacets \[E43\] (Walter et al. 2007), and rough panes without
//! thickness \[E58\]. Both lobes are followed.
//! Twin: shaders/shading/rough_interface.wgsl.

use crate::optics::shading::dielectric::{fresnel, pane_reflectance, picked_band, refract};
use crate::optics::shading::frame::Frame;
use crate::optics::shading::microfacet::Ggx;
use crate::packed::PackedMaterial;
use crate::packed::constants::ROUGH_SHARE_MIN;
use crate::spectrum::{BLACK, Bands, mul, scale};
use glam::Vec3;

/// One of the two ways on.
#[derive(Debug, Clone, Copy)]
pub(crate) struct RoughWay {
    /// About what it keeps: that of a facet that lies flat, and never nothing.
    pub(crate) albedo: Bands,
    tint: Bands,
    /// Index in each band.
    iors: Bands,
    /// That by which light is bent.
    ior: f32,
    pub(super) is_transmission: bool,
    /// Both faces lie in one place: what is transmitted is the mirror image, about the sheet, of what facets reflect \[E58\].
    is_thin: bool,
    ggx: Ggx,
}

/// The mirror image of a direction about the plane of a normal.
fn mirrored_in(n: Vec3, w: Vec3) -> Vec3 {
    w - n * (2.0 * w.dot(n))
}

/// Reflection and transmission.
pub(super) fn ways(m: &PackedMaterial, f: &Frame) -> [RoughWay; 2] {
    let cosine = f.back.dot(f.specular_normal());
    let is_thin = m.flags().is_thin();
    let of_facet = |ior| of_facet(cosine, ior, is_thin, f.front);
    let flat = m.iors.map(|ior| of_facet(ior).clamp(ROUGH_SHARE_MIN, 1.0 - ROUGH_SHARE_MIN));
    let ggx = Ggx::of(m);
    let way = |tint: Bands, share: Bands, is_transmission: bool| RoughWay {
        albedo: mul(&tint, &share),
        tint,
        iors: m.iors,
        ior: m.ior,
        is_transmission,
        is_thin,
        ggx,
    };
    [way(m.specular, flat, false), way(m.transmission, flat.map(|r| 1.0 - r), true)]
}

/// Reflectance of a facet, or of two where the faces of a pane are one.
fn of_facet(cosine: f32, ior: f32, is_thin: bool, from_front: bool) -> f32 {
    if is_thin {
        return pane_reflectance(fresnel(cosine, ior));
    }
    fresnel(cosine, if from_front { ior } else { 1.0 / ior })
}

impl RoughWay {
    /// True where light is bent.
    fn refracts(&self) -> bool {
        self.is_transmission && !self.is_thin
    }

    /// The direction in which facets reflect what leaves in `w`; `w` itself where light is bent.
    fn unfolded(&self, f: &Frame, w: Vec3) -> Vec3 {
        if self.is_transmission && self.is_thin { mirrored_in(f.specular_normal(), w) } else { w }
    }

    /// The same where bands part: one band goes on, picked by what of each would, and is bent by its own index \[E36\].
    pub(super) fn in_one_band(&self, carried: &Bands, u: f32) -> Self {
        let parts = mul(carried, &self.albedo).map(f64::from);
        let Some(band) = picked_band(&parts, u) else { return Self { albedo: BLACK, tint: BLACK, ..*self } };
        let only = |x: &Bands| {
            let mut of_band = BLACK;
            of_band[band] = (f64::from(x[band]) * parts.iter().sum::<f64>() / parts[band]) as f32;
            of_band
        };
        Self { albedo: only(&self.albedo), tint: only(&self.tint), ior: self.iors[band], ..*self }
    }

    /// Index of the ray's side over that of the other.
    fn eta_i_over_t(&self, f: &Frame) -> f32 {
        match self.is_thin {
            true => 1.0,
            false if f.front => 1.0 / self.ior,
            false => self.ior,
        }
    }

    /// By how much radiance scales on the way to the eye \[E9\].
    pub(super) fn radiance_scale(&self, f: &Frame) -> f32 {
        if self.is_transmission { self.eta_i_over_t(f).powi(2) } else { 1.0 }
    }

    /// Where light leaves; none on the wrong side of the surface, or where a facet reflects all.
    pub(super) fn sample(&self, f: &Frame, u: [f32; 2]) -> Option<Vec3> {
        let h = self.ggx.normal(f.back, f.specular_normal(), u);
        if self.refracts() {
            return refract(-f.back, h, self.eta_i_over_t(f)).filter(|w| w.dot(f.ng) < 0.0);
        }
        let n = f.specular_normal();
        let reflected = (h * (2.0 * f.back.dot(h)) - f.back).normalize();
        if self.is_transmission {
            let through = mirrored_in(n, reflected);
            return Some(through).filter(|w| w.dot(f.ng) < 0.0 && w.dot(n) < 0.0);
        }
        Some(reflected).filter(|w| w.dot(f.ng) > 0.0)
    }

    /// The normal of the facet that sends light from `back` to `w`, on the side of the ray; its length is that of the vector whose
    /// direction it has.
    fn facet(&self, f: &Frame, w: Vec3) -> (Vec3, f32) {
        // of refraction tangential parts add up to nothing
        let sum = if self.refracts() { -(f.back * self.eta_i_over_t(f) + w) } else { f.back + w };
        let length = sum.length().max(f32::MIN_POSITIVE);
        let h = sum / length;
        (if h.dot(f.specular_normal()) < 0.0 { -h } else { h }, length)
    }

    /// pdf_solid_angle of [`RoughWay::sample`]: the density of the facets that `back` sees over the solid angle that turning one sweeps.
    pub(super) fn pdf(&self, f: &Frame, w: Vec3) -> f32 {
        let n = f.specular_normal();
        let unfolded = self.unfolded(f, w);
        let (h, length) = self.facet(f, unfolded);
        let (cos_o, cos_h, cos_w) = (f.back.dot(n), f.back.dot(h), unfolded.dot(h));
        let is_beside = self.is_thin && (w.dot(n) < 0.0) != self.is_transmission;
        if cos_o <= 0.0 || cos_h <= 0.0 || (cos_w < 0.0) != self.refracts() || is_beside {
            return 0.0;
        }
        let of_mirror = self.ggx.pdf(h, n, f.back);
        if self.refracts() { of_mirror * 4.0 * cos_h * -cos_w / (length * length) } else { of_mirror }
    }

    /// f cosθ / pdf_solid_angle of a direction that was sampled, as flux.
    pub(super) fn through(&self, f: &Frame, w: Vec3) -> Bands {
        let n = f.specular_normal();
        let unfolded = self.unfolded(f, w);
        let (h, _) = self.facet(f, unfolded);
        let (cos_o, cos_w, cos_h) = (f.back.dot(n), w.dot(n), f.back.dot(h).clamp(0.0, 1.0));
        if cos_o <= 0.0 || (cos_w < 0.0) != self.is_transmission {
            return BLACK;
        }
        let mut kept = self.tint;
        for (kept, ior) in kept.iter_mut().zip(self.iors) {
            let reflectance = of_facet(cos_h, ior, self.is_thin, f.front);
            *kept *= if self.is_transmission { 1.0 - reflectance } else { reflectance };
        }
        let seen =
            if self.refracts() { self.ggx.seen(w, n) } else { self.ggx.seen_again(unfolded, f.back, n) };
        scale(&kept, seen)
    }
}
