//! The material at a hit: what varies over a surface is looked up here. Twin: shaders/shading/material.wgsl.

use super::{anisotropy, facet_textures, texture};
use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::constants::TEXTURE_PIXELS;
use crate::packed::{PackedMaterial, PackedScene};
use crate::spectrum::mul;

impl Bsdf {
    /// Where a ray met a surface, with textures as fine as they are.
    pub(crate) fn at(s: &SurfaceInteraction) -> Self {
        Self::of_width(s, 0.0)
    }

    /// Where a ray met a surface that has come so far from the eye: of a texture it sees a part of a pixel at once \[E37\].
    pub(crate) fn seen(scene: &PackedScene, s: &SurfaceInteraction, length: f32) -> Self {
        Self::of_width(s, seen_width(scene, length))
    }

    /// To who sees so wide a part of the surface at once, internal units.
    fn of_width(s: &SurfaceInteraction, width: f32) -> Self {
        let m = s.between();
        let frame = if width > 0.0 { s.frame_seen(width) } else { s.frame() };
        let place = s.texture;
        let of_texture = width * place.per_unit;
        let coloured = m.colour_texture().map(|number| {
            let reflected = texture::in_bands(s.textures, s.of_texel, number, place.uv, of_texture);
            // a body is passed by two faces
            let passed = |x: &f32| if m.flags().is_thin() { *x } else { x.max(0.0).sqrt() };
            let transmission = match m.flags() {
                flags if flags.is_translucent() => mul(&m.transmission, &reflected),
                flags if flags.is_dielectric() => {
                    mul(&m.transmission, &reflected.each_ref().map(passed).map(|x| x.min(1.0)))
                }
                _ => m.transmission,
            };
            PackedMaterial { diffuse: mul(&m.diffuse, &reflected), transmission, ..*m }
        });
        let m = coloured.as_ref().unwrap_or(m);
        let brushed = anisotropy::at(m, &place, s.plain, frame.ns);
        let m = brushed.as_ref().unwrap_or(m);
        if m.flags().is_varied() {
            return Self::new(&facet_textures::at(m, s.textures, place.uv, of_texture, s.met), frame);
        }
        Self::new(m, frame)
    }
}

/// How wide a part of a surface is seen at once by a path that has come so far from the eye, internal units.
pub(crate) fn seen_width(scene: &PackedScene, length: f32) -> f32 {
    TEXTURE_PIXELS * length * scene.pixel_angle()
}
