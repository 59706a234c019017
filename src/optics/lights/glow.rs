//! Glow: what a texture leaves of an emissive triangle's radiance at a place of it \[E49\]. Twin: shaders/lights/glow.wgsl.

use crate::optics::shading::texture::{TexturePlace, in_bands};
use crate::packed::{PackedEmitter, PackedScene};
use crate::sampling::distributions::triangle;
use crate::spectrum::Bands;

/// Where `u` lies on an emitter; none where it has no texture.
pub(super) fn at(scene: &PackedScene, e: &PackedEmitter, u: [f32; 2]) -> Option<Bands> {
    if e.texture == 0 {
        return None;
    }
    let [second, third] = triangle(u);
    let uvs = &scene.textures.uvs[e.triangle as usize];
    let place = TexturePlace::on(&scene.triangles[e.triangle as usize], uvs, second, third);
    Some(in_bands(&scene.textures, scene.of_texel.as_ref(), e.texture, place.uv, 0.0))
}
