//! The mirror, or a narrow Phong lobe about its direction that is followed as one is. Twin: shaders/shading/mirror.wgsl.

use crate::optics::shading::frame::Frame;
use crate::optics::shading::phong::{Phong, mirrored};
use crate::sampling::distributions::{phong_lobe, to_world};
use crate::spectrum::Bands;
use glam::Vec3;

/// Light goes into the mirror direction.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mirror {
    pub(crate) albedo: Bands,
    /// Phong exponent of the lobe; 0 where the mirror is perfect.
    pub(crate) exponent: f32,
}

impl Mirror {
    /// The mirror's direction, about the geometric normal where the shading normal would lead below the surface.
    pub(super) fn direction(f: &Frame) -> Vec3 {
        let about_shading = mirrored(f.back, f.specular_normal());
        if about_shading.dot(f.ng) > 0.0 { about_shading } else { mirrored(f.back, f.ng) }
    }

    /// A direction; none below the surface.
    pub(crate) fn sample(&self, f: &Frame, u: [f32; 2]) -> Option<Vec3> {
        let perfect = Self::direction(f);
        if !self.has_width() {
            return Some(perfect);
        }
        Some(to_world(phong_lobe(u, self.exponent), perfect)).filter(|w| w.dot(f.ng) > 0.0)
    }

    /// False for a perfect mirror.
    pub(super) fn has_width(&self) -> bool {
        self.exponent > 0.0
    }

    /// pdf_solid_angle of [`Mirror::sample`], where it has a width.
    pub(super) fn pdf(&self, f: &Frame, w: Vec3) -> f32 {
        Phong { albedo: self.albedo, exponent: self.exponent }.pdf_about(Self::direction(f), w)
    }
}
