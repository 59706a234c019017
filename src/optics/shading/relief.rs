//! Relief: which way a surface faces by a picture of normals or of heights \[E48\]. Twin: shaders/shading/relief.wgsl.

use super::texture::{self, TexturePlace};
use crate::packed::constants::{RELIEF_COS_LEAST, RELIEF_SPAN_LEAST};
use crate::packed::{PackedMaterial, Textures};
use glam::Vec3;

/// A place of a surface before its relief is looked up.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plain {
    /// Unit geometric normal of the front.
    pub(crate) front: Vec3,
    /// Unit shading normal of the front.
    pub(crate) ns: Vec3,
}

/// The shading normal toward `back`, from which it is seen, to who sees so much of texture coordinates at once; none where the material
/// has no relief.
pub(crate) fn seen(
    textures: &Textures,
    m: &PackedMaterial,
    place: &TexturePlace,
    plain: Plain,
    back: Vec3,
    width: f32,
) -> Option<Vec3> {
    let number = m.relief_texture()?;
    let of_front = if m.flags().has_normal_map() {
        by_normals(textures, number, place, plain, m.relief, width)
    } else {
        let relative = m.flags().has_relative_height();
        by_heights(textures, number, place, plain.ns, m.relief, relative, width)
    };
    let n = if back.dot(plain.front) > 0.0 { of_front } else { -of_front };
    Some(turned(n, back))
}

/// A normal that faces away from who sees it is turned until it does not.
pub(crate) fn turned(n: Vec3, back: Vec3) -> Vec3 {
    let short = (RELIEF_COS_LEAST - n.dot(back)).max(0.0);
    (n + back * short).normalize_or(back)
}

fn by_normals(
    textures: &Textures,
    number: u32,
    place: &TexturePlace,
    Plain { front, ns }: Plain,
    strength: f32,
    width: f32,
) -> Vec3 {
    let t = &textures.records[number as usize - 1];
    let [right, up] = [place.gradients[0] * t.scale_u, place.gradients[1] * t.scale_v];
    let handed = right.cross(up).dot(front);
    let [x, y, z, _] = texture::lookup(textures, number, place.uv, width).map(|c| 2.0 * c - 1.0);
    // along which the picture goes right and stays as high as it is
    let level = up.cross(front).normalize_or_zero() * handed.signum();
    let tangent = (level - ns * ns.dot(level)).normalize_or_zero();
    if handed == 0.0 || tangent == Vec3::ZERO {
        return ns;
    }
    let bitangent = ns.cross(tangent) * handed.signum();
    (tangent * (x * strength) + bitangent * (y * strength) + ns * z.max(RELIEF_COS_LEAST)).normalize()
}

fn by_heights(
    textures: &Textures,
    number: u32,
    place: &TexturePlace,
    ns: Vec3,
    height: f32,
    is_relative: bool,
    width: f32,
) -> Vec3 {
    let t = &textures.records[number as usize - 1];
    let scale = [t.scale_u, t.scale_v];
    let height = if is_relative {
        // widths of the picture; none where coordinates span no area
        let pictures = place.per_unit * (scale[0] * scale[1]).abs().sqrt();
        if pictures > RELIEF_SPAN_LEAST { height / pictures } else { 0.0 }
    } else {
        height
    };
    let slope = |k: usize| {
        let texels = [t.width, t.height][k] as f32 * scale[k].abs();
        let step = 0.5 * (1.0 / texels.max(f32::MIN_POSITIVE)).max(width);
        let at = |side: f32| {
            let mut uv = place.uv;
            uv[k] += side * step;
            texture::number(textures, number, uv, width)
        };
        place.gradients[k] * ((at(1.0) - at(-1.0)) * 0.5 / step)
    };
    (ns - (slope(0) + slope(1)) * height).normalize_or(ns)
}
