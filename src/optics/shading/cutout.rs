//! Cut-outs: surfaces of which some is not there \[E38\]. A ray goes straight through where a number that it and the triangle make is
//! no less than the opacity at the hit: the same ray always does the same. Twin: shaders/accel/cutout.wgsl.

use super::texture::{self, TexturePlace};
use crate::packed::{CUT, PackedMaterial, PackedScene, Textures};
use crate::sampling::rng::{pcg4d, unit};
use glam::Vec3;

/// How much of a surface is there.
pub(crate) fn opacity(textures: &Textures, material: &PackedMaterial, uv: [f32; 2]) -> f32 {
    material.opacity_texture().map_or(1.0, |number| texture::number(textures, number, uv, 0.0))
}

/// Whether a ray meets a triangle, by its number and the weights of its second and third corner: it may go through.
pub(crate) fn stops(
    scene: &PackedScene,
    origin: Vec3,
    direction: Vec3,
) -> impl Fn(u32, f32, f32) -> bool + Copy + '_ {
    let [ox, oy, oz] = origin.to_array().map(f32::to_bits);
    let [dx, dy, dz] = direction.to_array().map(f32::to_bits);
    move |number, second, third| {
        let triangle = &scene.triangles[number as usize];
        if triangle.flags & CUT == 0 {
            return true;
        }
        let uvs = &scene.textures.uvs[number as usize];
        let uv = TexturePlace::on(triangle, uvs, second, third).uv;
        let there = opacity(&scene.textures, &scene.materials[triangle.material as usize], uv);
        let [a, b, c, d] = pcg4d([ox, oy, oz, number]);
        unit(pcg4d([a ^ dx, b ^ dy, c ^ dz, d])[0]) < there
    }
}
