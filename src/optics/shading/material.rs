//! The material at a hit. Today it is constant over a surface; what varies over one is looked up here. Twin:
//! shaders/shading/material.wgsl.

use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::Bsdf;

impl Bsdf {
    /// Where a ray met a surface.
    pub(crate) fn at(s: &SurfaceInteraction) -> Self {
        Self::new(s.material, s.frame())
    }
}
