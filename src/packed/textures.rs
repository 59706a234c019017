//! Textures as plain arrays: records, texels with their smaller levels, and the texture coordinates of triangles \[E37\].
//!
//! Levels are those of [`crate::scene::texture::levels`].

use super::gpu_struct::gpu_struct;
use super::heap::HEAP_WORD;
use super::surfaces::{PackedMaterial, corner_of};
use crate::scene::texture::levels::Level;
use crate::scene::texture::{
    Bitmap, Channel, Filter, NumberMap, Opacity, Relief, ReliefKind, Space, Texels, Texture, Wrap, f16,
};
use crate::scene::{Material, Scene};
use rustc_hash::FxHashMap;
use std::sync::Arc;

/// A word of the heap.
type Word = [u32; 4];

gpu_struct! {
    /// A texture, 48 bytes.
    pub struct PackedTexture {
        /// First word of its largest level among the texels of all textures; the smaller ones follow.
        pub first: u32,
        /// Texels across the largest level …
        pub width: u32,
        /// … and down.
        pub height: u32,
        /// Bits of [`TextureFlags`].
        pub flag_bits: u32,
        /// Factor on texture coordinates across …
        pub scale_u: f32,
        /// … and up.
        pub scale_v: f32,
        /// What is added to them after that, across …
        pub offset_u: f32,
        /// … and up.
        pub offset_v: f32,
        /// Levels.
        pub levels: u32,
        /// Factor on the one number that is asked of its texels …
        pub factor: f32,
        /// … and which of the four that is: opacity or another.
        pub channel: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// How a texture is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TextureFlags(u32);

impl TextureFlags {
    /// A texel is four half floats, not four bytes.
    pub(crate) const HALVES: u32 = 1;
    /// Bytes of red, green and blue are encoded by the curve of sRGB.
    pub(crate) const SRGB: u32 = 2;
    /// Mirrored outside of the unit square …
    pub(crate) const MIRRORED: u32 = 4;
    /// … or its edge goes on.
    pub(crate) const CLAMPED: u32 = 8;
    /// The nearest texel, not the mean of four.
    pub(crate) const NEAREST: u32 = 16;

    /// Name and value of each bit, as the kernels know it.
    pub(super) const NAMED: [(&str, u32); 5] = [
        ("TEXTURE_HALVES", Self::HALVES),
        ("TEXTURE_SRGB", Self::SRGB),
        ("TEXTURE_MIRRORED", Self::MIRRORED),
        ("TEXTURE_CLAMPED", Self::CLAMPED),
        ("TEXTURE_NEAREST", Self::NEAREST),
    ];

    /// True where a bit is set.
    pub(crate) fn has(self, bit: u32) -> bool {
        self.0 & bit != 0
    }
}

impl PackedTexture {
    /// How it is read.
    pub(crate) fn flags(&self) -> TextureFlags {
        TextureFlags(self.flag_bits)
    }
}

/// Texture coordinates of a triangle's corners: three pairs, and padding to two words of the heap.
pub type PackedUvs = [f32; 8];

/// The textures of a scene.
#[derive(Debug, Clone, Default)]
pub struct Textures {
    /// One for each way in which a picture lies on something.
    pub records: Vec<PackedTexture>,
    /// Words of all levels of all pictures.
    pub texels: Vec<Word>,
    /// Of each triangle, leaf order; empty where there are no textures.
    pub uvs: Vec<PackedUvs>,
    /// Some of some triangle is not there \[E38\].
    pub has_cutouts: bool,
}

/// Most records: a material has two halves of a word to name its own.
const RECORDS_MOST: usize = (1 << 16) - 1;

impl Textures {
    /// Pack the textures of a scene's materials, and write into these which are theirs. Triangles come in leaf order.
    pub(super) fn pack(
        scene: &Scene,
        materials: &mut [PackedMaterial],
        turned: &[bool],
        order: &[u32],
        world_scale: f64,
        first: impl Fn(u32) -> usize,
    ) -> Self {
        let mut packer = Packer::default();
        for (material, packed) in scene.materials.iter().zip(materials) {
            packed.textures = packer.of_material(material);
            packed.facet_textures = packer.of_facets(material);
            let transmission = material.mixture.as_ref().and_then(|m| m.transmission_map.as_ref());
            packed.transmission_texture = packer.number(transmission);
            if let Some(Relief { texture, kind }) = &material.relief {
                packed.relief_texture = packer.record(texture, kind.channel(), 1.0);
                packed.relief = match *kind {
                    ReliefKind::Normals { strength } => strength,
                    ReliefKind::Heights { height, is_relative: true, .. } => height,
                    ReliefKind::Heights { height, .. } => (f64::from(height) / world_scale) as f32,
                };
            }
            if let Some(texture) = &material.emission_texture {
                packed.relief_texture |= packer.record(texture, Channel::Alpha, 1.0) << 16;
            }
        }
        let Packer { records, texels, .. } = packer;
        let is_brushed = scene.materials.iter().any(|m| m.anisotropy.is_some());
        if records.is_empty() && !is_brushed {
            return Self::default();
        }
        let uvs_of = |&i: &u32| {
            let uv = scene.mesh.triangles[i as usize].uv;
            let corner = |k: usize| match uv {
                Some(uv) => scene.mesh.uvs[uv[corner_of(turned[i as usize], first(i), k)] as usize],
                None => [0.0; 2],
            };
            let [[a, b], [c, d], [e, f]] = [0, 1, 2].map(corner);
            [a, b, c, d, e, f, 0.0, 0.0]
        };
        let material_of = |&i: &u32| scene.mesh.triangles[i as usize].material as usize;
        let has_cutouts = order.iter().any(|i| scene.materials[material_of(i)].opacity.is_some());
        Self { records, texels, uvs: order.iter().map(uvs_of).collect(), has_cutouts }
    }

    /// Bytes of all of it.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&self.records[..]) + size_of_val(&self.texels[..]) + size_of_val(&self.uvs[..])
    }
}

/// Bytes of memory that packing a scene's textures takes.
pub(super) fn bytes_of(scene: &Scene) -> u64 {
    // levels are a third more, and the first of them is made in f32, which takes as much as the largest once more
    scene.picture_bytes() * 7 / 3
}

/// What is the same for two textures whose records are the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    bitmap: usize,
    space: Space,
    wrap: Wrap,
    filter: Filter,
    channel: Channel,
    numbers: [u32; 5],
}

#[derive(Default)]
struct Packer {
    records: Vec<PackedTexture>,
    texels: Vec<Word>,
    /// First word and levels of each picture in each space.
    pictures: FxHashMap<(usize, Space), (u32, u32)>,
    known: FxHashMap<Key, u32>,
    /// Where a surface is opaque in part and has no texture.
    white: Option<Arc<Bitmap>>,
}

impl Packer {
    /// Records of a material, counted from 1: of its colour in the low half, of its opacity in the high half.
    fn of_material(&mut self, m: &Material) -> u32 {
        let alpha = Channel::Alpha;
        let colour = m.diffuse_texture.as_ref().map_or(0, |texture| self.record(texture, alpha, 1.0));
        let opacity = match &m.opacity {
            None => 0,
            Some(Opacity { factor, texture: Some(texture) }) => self.record(texture, alpha, *factor),
            Some(Opacity { factor, texture: None }) => {
                let white = self.white.get_or_insert_with(|| Arc::new(Bitmap::white())).clone();
                self.record(&Texture::of(white, Space::Linear), alpha, *factor)
            }
        };
        colour | opacity << 16
    }

    /// Of its roughness in the low half, of its metallic part in the high half.
    fn of_facets(&mut self, m: &Material) -> u32 {
        let metallic = m.metallic.as_ref().and_then(|metal| metal.map.as_ref());
        let metallic = metallic.or(m.mixture.as_ref().and_then(|mixture| mixture.metallic_map.as_ref()));
        self.number(m.roughness.as_ref()) | self.number(metallic) << 16
    }

    /// Of a number that varies; 0 where none does.
    fn number(&mut self, map: Option<&NumberMap>) -> u32 {
        map.map_or(0, |map| self.record(&map.texture, map.channel, map.factor))
    }

    fn record(&mut self, texture: &Texture, channel: Channel, factor: f32) -> u32 {
        let Texture { bitmap, space, wrap, filter, scale: [su, sv], offset: [ou, ov] } = texture;
        let address = Arc::as_ptr(bitmap) as usize;
        let numbers = [*su, *sv, *ou, *ov, factor].map(f32::to_bits);
        let key = Key { bitmap: address, space: *space, wrap: *wrap, filter: *filter, channel, numbers };
        if let Some(&known) = self.known.get(&key) {
            return known;
        }
        let (first, levels) = match self.pictures.get(&(address, *space)) {
            Some(&known) => known,
            None => {
                let first = u32::try_from(self.texels.len()).unwrap_or(u32::MAX);
                let levels = levels(bitmap, *space, &mut self.texels);
                self.pictures.insert((address, *space), (first, levels));
                (first, levels)
            }
        };
        let is_halves = matches!(bitmap.texels, Texels::Halves(_));
        let bit = |on: bool, bit: u32| if on { bit } else { 0 };
        let flag_bits = bit(is_halves, TextureFlags::HALVES)
            | bit(!is_halves && *space == Space::Srgb, TextureFlags::SRGB)
            | bit(*wrap == Wrap::Mirror, TextureFlags::MIRRORED)
            | bit(*wrap == Wrap::Clamp, TextureFlags::CLAMPED)
            | bit(*filter == Filter::Nearest, TextureFlags::NEAREST);
        let [width, height] = bitmap.size;
        assert!(self.records.len() < RECORDS_MOST, "the scene was validated");
        self.records.push(PackedTexture {
            first,
            width,
            height,
            flag_bits,
            scale_u: *su,
            scale_v: *sv,
            offset_u: *ou,
            offset_v: *ov,
            levels,
            factor,
            channel: channel as u32,
            pad1: 0,
        });
        let number = self.records.len() as u32;
        self.known.insert(key, number);
        number
    }
}

/// Appends the words of all levels of a picture; how many levels there are.
fn levels(bitmap: &Bitmap, space: Space, words: &mut Vec<Word>) -> u32 {
    let mut count = 1;
    append_level(&bitmap.texels, words);
    let mut level = Level::after(bitmap, space);
    while let Some(known) = level {
        count += 1;
        append_level(&known.texels_like(&bitmap.texels, space), words);
        level = known.next();
    }
    count
}

/// Appends the words of a level.
fn append_level(texels: &Texels, words: &mut Vec<Word>) {
    match texels {
        Texels::Bytes(texels) => append(texels.iter().map(|t| [u32::from_le_bytes(*t)]), words),
        Texels::Halves(texels) => append(texels.iter().map(|t| half_words(*t)), words),
    }
}

/// A texel of four half floats.
fn half_words(texel: [f16; 4]) -> [u32; 2] {
    let [r, g, b, a] = texel.map(|x| u32::from(x.to_bits()));
    [r | g << 16, b | a << 16]
}

/// Appends texels of `N` numbers each; a level begins with a word.
fn append<const N: usize>(texels: impl Iterator<Item = [u32; N]>, words: &mut Vec<Word>) {
    const NUMBERS: usize = HEAP_WORD as usize / 4;
    let mut at = NUMBERS;
    for texel in texels {
        for number in texel {
            if at == NUMBERS {
                words.push([0; NUMBERS]);
                at = 0;
            }
            if let Some(word) = words.last_mut() {
                word[at] = number;
            }
            at += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Levels are means in linear light, whatever the space; the last one is the mean of all.
    #[test]
    fn levels_are_means_in_linear_light() {
        let grey = |x: u8| [x, x, x, x];
        let size = [3, 2];
        let texels: Vec<[u8; 4]> = [0, 255, 0, 255, 0, 255].map(grey).to_vec();
        for (space, wanted) in [(Space::Linear, 128u32), (Space::Srgb, 188)] {
            let mut words = vec![[7; 4]];
            let count = levels(&Bitmap::new(size, Texels::Bytes(texels.clone())), space, &mut words);
            // three texels across become one, and two rows one
            assert_eq!((count, words.len()), (2, 1 + 2 + 1));
            let [r, g, b, a] = words[3][0].to_le_bytes().map(u32::from);
            assert_eq!([r, g, b, a], [wanted, wanted, wanted, 128], "{space:?}");
        }
        let halves = vec![[0.25, 0.5, 1.0, 1.0].map(f16::from_f32), [0.75, 0.5, 0.0, 0.0].map(f16::from_f32)];
        let mut words = Vec::new();
        levels(&Bitmap::new([2, 1], Texels::Halves(halves)), Space::Linear, &mut words);
        let [rg, ba, ..] = words[1];
        let number = |bits: u32| f16::from_bits(bits as u16).to_f32();
        assert_eq!([number(rg), number(rg >> 16), number(ba), number(ba >> 16)], [0.5; 4]);
    }
}
