//! Mixtures: surfaces that are glass in part and opaque in part \[E57\]. Which of the two a ray meets is chance: a number that the place and
//! the ray's direction make, so that the same ray always meets the same. Twin: shaders/shading/mixture.wgsl.

use super::texture;
use crate::packed::{PackedMaterial, Textures};
use crate::sampling::rng::{pcg4d, unit};
use glam::Vec3;

/// Which part of a surface was met.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Met {
    /// How much of the surface is glass.
    pub(crate) glass: f32,
    /// It is the rest.
    pub(crate) is_rest: bool,
}

impl Met {
    /// Of a material, at texture coordinates. None where it is one thing all over.
    pub(crate) fn at(
        m: &PackedMaterial,
        textures: &Textures,
        uv: [f32; 2],
        position: Vec3,
        direction: Vec3,
    ) -> Option<Self> {
        m.rest()?;
        let number = |map: Option<u32>, plain: f32| {
            map.map_or(plain, |map| texture::number(textures, map, uv, 0.0).min(1.0))
        };
        let metallic = number(m.metallic_texture(), m.metallic);
        let glass = number(m.transmission_texture(), m.clear_coat) * (1.0 - metallic);
        let [px, py, pz] = position.to_array().map(f32::to_bits);
        let [dx, dy, dz] = direction.to_array().map(f32::to_bits);
        let [a, b, c, d] = pcg4d([px, py, pz, m.rest]);
        let is_rest = unit(pcg4d([a ^ dx, b ^ dy, c ^ dz, d])[0]) >= glass;
        Some(Self { glass, is_rest })
    }

    /// What of the surface that is no glass is metal, where that much of all of it is.
    pub(crate) fn metallic_of_rest(&self, metallic: f32) -> f32 {
        if self.glass < 1.0 { (metallic / (1.0 - self.glass)).min(1.0) } else { 0.0 }
    }
}
