//! The material at a place. Today it is constant over a surface; what varies over one is looked up here. Twin:
//! shaders/shading/material.wgsl.

use crate::optics::ray::SurfaceInteraction;
use crate::packed::PackedMaterial;

/// Where a ray met a surface.
pub(super) fn resolved<'a>(s: &SurfaceInteraction<'a>) -> &'a PackedMaterial {
    s.material
}
