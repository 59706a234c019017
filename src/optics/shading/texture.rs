//! Textures: what a picture shows at a place of a surface \[E37\]. Twin: shaders/shading/texture.wgsl.

use crate::packed::{PackedTexture, PackedTriangle, PackedUvs, TextureFlags, Textures};
use crate::spectrum::{Bands, add, from_rgb, scale};
use glam::Vec3;
use half::f16;
use std::sync::LazyLock;

/// Where a texture lies on a place of a surface.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct TexturePlace {
    /// Texture coordinates.
    pub(crate) uv: [f32; 2],
    /// How many units of them a unit of length is, in the mean over directions.
    pub(crate) per_unit: f32,
    /// How each of them grows along the surface, per unit of length.
    pub(crate) gradients: [Vec3; 2],
}

impl TexturePlace {
    /// On a triangle with these coordinates at its corners, where its second and third corner have these weights.
    pub(crate) fn on(triangle: &PackedTriangle, uvs: &PackedUvs, second: f32, third: f32) -> Self {
        let &[u0, v0, u1, v1, u2, v2, ..] = uvs;
        let first = 1.0 - second - third;
        let (a, b) = ([u1 - u0, v1 - v0], [u2 - u0, v2 - v0]);
        let area = 2.0 * triangle.area();
        let per_unit = if area > 0.0 { ((a[0] * b[1] - b[0] * a[1]).abs() / area).sqrt() } else { 0.0 };
        let across = triangle.e1.cross(triangle.e2);
        let unit = across.normalize_or_zero();
        let [along1, along2] = [triangle.e2.cross(unit), unit.cross(triangle.e1)];
        let gradient = |k: usize| (a[k] * along1 + b[k] * along2) / area.max(f32::MIN_POSITIVE);
        let uv = [first * u0 + second * u1 + third * u2, first * v0 + second * v1 + third * v2];
        Self { uv, per_unit, gradients: [gradient(0), gradient(1)] }
    }
}

/// Numbers in proportion to light of the bytes of sRGB.
static LINEAR: LazyLock<[f32; 256]> = LazyLock::new(|| {
    std::array::from_fn(|byte| {
        let encoded = byte as f64 / 255.0;
        let is_straight = encoded <= 0.040_45;
        (if is_straight { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }) as f32
    })
});

/// What a texture, counted from 1, shows at texture coordinates, to who sees so much of these at once; 0 sees the largest level. Linear
/// red, green and blue, and opacity.
pub(crate) fn lookup(textures: &Textures, number: u32, [u, v]: [f32; 2], width: f32) -> [f32; 4] {
    let t = &textures.records[number as usize - 1];
    let coordinates = [u * t.scale_u + t.offset_u, v * t.scale_v + t.offset_v];
    let texels = width * (t.scale_u * t.scale_v * t.width as f32 * t.height as f32).abs().sqrt();
    let level = texels.max(1.0).log2().min((t.levels - 1) as f32);
    let (finer, coarser) = (level.floor(), level.fract());
    let mut found = at_level(textures, t, finer as u32, coordinates);
    if coarser > 0.0 {
        let next = at_level(textures, t, finer as u32 + 1, coordinates);
        found = std::array::from_fn(|k| (1.0 - coarser) * found[k] + coarser * next[k]);
    }
    found
}

/// Its red, green and blue in the bands of a pass, where a texel of one of these alone is so.
pub(crate) fn in_bands(
    textures: &Textures,
    of_texel: Option<&[Bands; 3]>,
    record: u32,
    uv: [f32; 2],
    width: f32,
) -> Bands {
    let [r, g, b, _] = lookup(textures, record, uv, width);
    match of_texel {
        None => from_rgb([r, g, b]),
        Some([red, green, blue]) => add(&add(&scale(red, r), &scale(green, g)), &scale(blue, b)),
    }
}

/// The one number that a texture, counted from 1, is asked for, likewise.
pub(crate) fn number(textures: &Textures, number: u32, uv: [f32; 2], width: f32) -> f32 {
    let t = &textures.records[number as usize - 1];
    lookup(textures, number, uv, width)[t.channel as usize] * t.factor
}

/// The mean of the texels of a level about a place.
fn at_level(textures: &Textures, t: &PackedTexture, level: u32, [u, v]: [f32; 2]) -> [f32; 4] {
    let size = |level: u32| [t.width, t.height].map(|side| (side >> level).max(1));
    let per_word = if t.flags().has(TextureFlags::HALVES) { 2 } else { 4 };
    let words = |[width, height]: [u32; 2]| (width as usize * height as usize).div_ceil(per_word);
    let first = t.first as usize + (0..level).map(|l| words(size(l))).sum::<usize>();
    let [width, height] = size(level);
    let mut sum = [0.0; 4];
    // the first row is the highest
    for (row, by_row) in neighbours(t.flags(), v, height) {
        for (column, by_column) in neighbours(t.flags(), u, width) {
            let row = height - 1 - row;
            let texel = texel(textures, t, first, per_word, row as usize * width as usize + column as usize);
            sum = std::array::from_fn(|k| sum[k] + texel[k] * (by_row * by_column));
        }
    }
    sum
}

/// Which texels of a row of `count` a coordinate lies between, and their weights; the second may be none.
fn neighbours(flags: TextureFlags, coordinate: f32, count: u32) -> impl Iterator<Item = (u32, f32)> {
    let (mirrored, clamped) = (flags.has(TextureFlags::MIRRORED), flags.has(TextureFlags::CLAMPED));
    let within = if clamped {
        coordinate.clamp(0.0, 1.0)
    } else if mirrored {
        1.0 - (coordinate.rem_euclid(2.0) - 1.0).abs()
    } else {
        coordinate.rem_euclid(1.0)
    };
    let place = within * count as f32;
    let ends = mirrored || clamped;
    let number = move |i: i64| {
        let count = i64::from(count);
        if ends { i.clamp(0, count - 1) as u32 } else { i.rem_euclid(count) as u32 }
    };
    let [first, second] = if flags.has(TextureFlags::NEAREST) {
        [(number((place.floor() as i64).min(i64::from(count) - 1)), 1.0), (0, 0.0)]
    } else {
        let from_middle = place - 0.5;
        let (i, part) = (from_middle.floor() as i64, from_middle - from_middle.floor());
        [(number(i), 1.0 - part), (number(i + 1), part)]
    };
    [first, second].into_iter().filter(|(_, weight)| *weight > 0.0)
}

fn texel(textures: &Textures, t: &PackedTexture, first: usize, per_word: usize, number: usize) -> [f32; 4] {
    let word = &textures.texels[first + number / per_word];
    if t.flags().has(TextureFlags::HALVES) {
        let half = |k: usize| {
            let pair = word[2 * (number % 2) + k / 2];
            f16::from_bits((pair >> (16 * (k % 2))) as u16).to_f32()
        };
        return [0, 1, 2, 3].map(half);
    }
    let bytes = word[number % 4].to_le_bytes();
    let [r, g, b, a] = bytes.map(|byte| f32::from(byte) / 255.0);
    if !t.flags().has(TextureFlags::SRGB) {
        return [r, g, b, a];
    }
    let [r, g, b, _] = bytes.map(|byte| LINEAR[usize::from(byte)]);
    [r, g, b, a]
}
