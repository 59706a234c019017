//! The material at a hit: what varies over a surface is looked up here. Twin: shaders/shading/material.wgsl.

use super::texture;
use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::constants::TEXTURE_PIXELS;
use crate::packed::{PackedMaterial, PackedScene};
use crate::spectrum::{add, from_rgb, mul, scale};

impl Bsdf {
    /// Where a ray met a surface, with textures as fine as they are.
    pub(crate) fn at(s: &SurfaceInteraction) -> Self {
        Self::of_width(s, 0.0)
    }

    /// Where a ray met a surface that has come so far from the eye: of a texture it sees a part of a pixel at once \[E37\].
    pub(crate) fn seen(scene: &PackedScene, s: &SurfaceInteraction, length: f32) -> Self {
        Self::of_width(s, TEXTURE_PIXELS * length * scene.pixel_angle())
    }

    /// To who sees so wide a part of the surface at once, internal units.
    fn of_width(s: &SurfaceInteraction, width: f32) -> Self {
        match s.material.colour_texture() {
            None => Self::new(s.between(), s.frame()),
            Some(number) => {
                let place = s.texture;
                let [r, g, b, _] = texture::lookup(s.textures, number, place.uv, width * place.per_unit);
                let reflected = match s.of_texel {
                    None => from_rgb([r, g, b]),
                    Some([red, green, blue]) => add(&add(&scale(red, r), &scale(green, g)), &scale(blue, b)),
                };
                let diffuse = mul(&s.material.diffuse, &reflected);
                Self::new(&PackedMaterial { diffuse, ..*s.material }, s.frame())
            }
        }
    }
}
