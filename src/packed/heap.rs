//! The scene heap: hierarchy, triangles, normals, materials, emitters and textures in one buffer of words of 16 bytes. Kernels read
//! it through the functions of shaders/scene/scene.wgsl; [`SceneInfo`] says where each section begins.

use crate::packed::accel::Node;
use crate::packed::gpu_struct::{GpuStruct, gpu_struct};
use crate::packed::{PackedEmitter, PackedMaterial, PackedScene, PackedTexture, PackedTriangle, PackedUvs};
use crate::spectrum::BANDS;
use bytemuck::Zeroable;
use glam::{Vec2, Vec3};
use std::borrow::Cow;

/// Bytes of a word of the heap.
pub const HEAP_WORD: u64 = 16;

/// Shading normals of a triangle's corners, octahedral, and a word of padding.
pub type PackedNormals = [u32; 4];

gpu_struct! {
    /// First word of each section of the heap, as one kernel sees it; a uniform.
    pub struct SceneInfo {
        /// Nodes of the hierarchy, 5 words each.
        pub nodes: u32,
        /// Triangles, 3 words each.
        pub triangles: u32,
        /// Normals of smooth triangles, a word each.
        pub normals: u32,
        /// Materials, 6 words each.
        pub materials: u32,
        /// Emitters, 5 words each, with the probabilities by which this kernel picks them.
        pub emitters: u32,
        /// Texture coordinates of triangles, 2 words each.
        pub uvs: u32,
        /// Textures, 3 words each.
        pub textures: u32,
        /// Their texels.
        pub texels: u32,
        /// Bodies whose inside matters, and what is in them: [`crate::packed::Media::words`].
        pub media: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// How many of each a scene has.
#[derive(Debug, Clone, Copy, Default)]
pub struct HeapCounts {
    /// Nodes.
    pub nodes: usize,
    /// Triangles.
    pub triangles: usize,
    /// Triangles with shading normals: all or none.
    pub normals: usize,
    /// Materials.
    pub materials: usize,
    /// Emitters of each list.
    pub emitters: usize,
    /// Triangles with texture coordinates: all or none.
    pub uvs: usize,
    /// Textures.
    pub textures: usize,
    /// Words of their texels.
    pub texels: usize,
    /// Words about bodies.
    pub media: usize,
    /// Lists of emitters, which differ in their probabilities.
    pub lists: usize,
}

/// Sections in their order, and the bytes of an entry.
pub const SECTIONS: [(&str, usize); 9] = [
    ("nodes", size_of::<Node>()),
    ("triangles", size_of::<PackedTriangle>()),
    ("normals", size_of::<PackedNormals>()),
    ("materials", size_of::<PackedMaterial>()),
    ("emitters", size_of::<PackedEmitter>()),
    ("uvs", size_of::<PackedUvs>()),
    ("textures", size_of::<PackedTexture>()),
    ("texels", HEAP_WORD as usize),
    ("media", HEAP_WORD as usize),
];

impl HeapCounts {
    /// Of sections that are so many bytes long, by name.
    pub fn of_bytes(bytes: impl Fn(&str) -> usize) -> Self {
        let [nodes, triangles, normals, materials, emitters, uvs, textures, texels, media] =
            SECTIONS.map(|(name, each)| bytes(name) / each);
        Self { nodes, triangles, normals, materials, emitters, uvs, textures, texels, media, lists: 1 }
    }

    /// Of a scene with so many lists of emitters.
    pub fn of(scene: &PackedScene, lists: usize) -> Self {
        Self {
            nodes: scene.bvh.node_count(),
            triangles: scene.triangles.len(),
            normals: scene.shading_normals.len(),
            materials: scene.materials.len(),
            emitters: scene.emitters.len(),
            uvs: scene.textures.uvs.len(),
            textures: scene.textures.records.len(),
            texels: scene.textures.texels.len(),
            media: scene.media.words().len(),
            lists,
        }
    }
}

/// Where everything lies.
#[derive(Debug, Clone)]
pub struct HeapLayout {
    /// As a kernel that picks from the first list of emitters sees it.
    first: SceneInfo,
    /// Words of a list of emitters.
    list: u64,
    /// Words of the heap.
    words: u64,
}

impl HeapLayout {
    /// One section after the other.
    pub fn new(counts: &HeapCounts) -> Self {
        let mut words = 0u64;
        let mut section = |count: usize, each: usize| {
            let first = words;
            words += count as u64 * each as u64 / HEAP_WORD;
            u32::try_from(first).unwrap_or(u32::MAX)
        };
        let first = SceneInfo {
            nodes: section(counts.nodes, size_of::<Node>()),
            triangles: section(counts.triangles, size_of::<PackedTriangle>()),
            normals: section(counts.normals, size_of::<PackedNormals>()),
            materials: section(counts.materials, size_of::<PackedMaterial>()),
            emitters: section(counts.emitters * counts.lists, size_of::<PackedEmitter>()),
            uvs: section(counts.uvs, size_of::<PackedUvs>()),
            textures: section(counts.textures, size_of::<PackedTexture>()),
            texels: section(counts.texels, HEAP_WORD as usize),
            media: section(counts.media, HEAP_WORD as usize),
            ..SceneInfo::zeroed()
        };
        let list = counts.emitters as u64 * size_of::<PackedEmitter>() as u64 / HEAP_WORD;
        Self { first, list, words }
    }

    /// What a kernel sees that picks from list `number` of the emitters.
    pub fn info(&self, number: usize) -> SceneInfo {
        SceneInfo { emitters: self.first.emitters + number as u32 * self.list as u32, ..self.first }
    }

    /// The sections that depend on what the bands are: materials, and the lists of emitters in their order.
    pub fn in_bands<'a>(
        &self,
        scene: &'a PackedScene,
        lists: Vec<&'a [PackedEmitter]>,
    ) -> impl Iterator<Item = (u32, &'a [u8])> {
        let emitters = (0..lists.len()).map(|i| self.info(i).emitters).collect::<Vec<u32>>();
        let lists = emitters.into_iter().zip(lists.into_iter().map(bytemuck::cast_slice));
        std::iter::once((self.first.materials, bytemuck::cast_slice(&scene.materials))).chain(lists)
    }

    /// Every section of a scene, or a part of one: its first word and its bytes. `lists` are the lists of emitters in their order.
    pub fn sections<'a>(
        &self,
        scene: &'a PackedScene,
        lists: Vec<&'a [PackedEmitter]>,
    ) -> impl Iterator<Item = (u32, Cow<'a, [u8]>)> {
        /// Triangles whose normals are encoded together.
        const AT_ONCE: usize = 1 << 16;
        let SceneInfo { nodes, triangles, normals, uvs, textures, texels, media, .. } = self.first;
        let plain = [
            (nodes, Cow::Borrowed(bytemuck::cast_slice(scene.bvh.nodes()))),
            (triangles, Cow::Borrowed(bytemuck::cast_slice(&scene.triangles))),
            (uvs, Cow::Borrowed(bytemuck::cast_slice(&scene.textures.uvs))),
            (textures, Cow::Borrowed(bytemuck::cast_slice(&scene.textures.records))),
            (texels, Cow::Borrowed(bytemuck::cast_slice(&scene.textures.texels))),
            (media, Cow::Owned(bytemuck::cast_slice(&scene.media.words()).to_vec())),
        ];
        let in_bands = self.in_bands(scene, lists).map(|(first, bytes)| (first, Cow::Borrowed(bytes)));
        let normals = scene.shading_normals.chunks(AT_ONCE).enumerate().map(move |(i, some)| {
            let bytes = |n: &[Vec3; 3]| {
                bytemuck::cast::<PackedNormals, [u8; size_of::<PackedNormals>()]>(pack_normals(*n))
            };
            (normals + (i * AT_ONCE) as u32, Cow::Owned(some.iter().flat_map(bytes).collect()))
        });
        plain.into_iter().chain(in_bands).chain(normals)
    }

    /// Bytes of the heap.
    pub fn bytes(&self) -> u64 {
        self.words * HEAP_WORD
    }
}

/// A unit vector in 32 bits, as shaders/sampling/sampling.wgsl encodes it.
pub fn encode_direction(n: Vec3) -> u32 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let e =
        if n.z < 0.0 { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) } else { p };
    let snorm = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32_767.0).round() as i16 as u16);
    snorm(e.x) | snorm(e.y) << 16
}

/// Shading normals of a triangle's corners as the kernels read them.
pub fn pack_normals(normals: [Vec3; 3]) -> PackedNormals {
    let [a, b, c] = normals.map(encode_direction);
    [a, b, c, 0]
}

/// WGSL functions that read a record of the scene: `triangle_at(index)`, `material_at(index)`, `emitter_at(index)`, `texture_at(index)`. They ask
/// `triangle_word(at)` and so on for the words, counted from the beginning of the section.
pub fn readers() -> String {
    let readers = [
        reader::<PackedTriangle>(),
        reader::<PackedMaterial>(),
        reader::<PackedEmitter>(),
        reader::<PackedTexture>(),
    ];
    readers.concat()
}

fn reader<T: GpuStruct>() -> String {
    const COMPONENTS: [&str; 4] = ["x", "y", "z", "w"];
    let record = T::NAME.trim_start_matches("Packed").to_lowercase();
    let words = size_of::<T>() / HEAP_WORD as usize;
    let number = |at: usize| format!("w{}.{}", at / 4, COMPONENTS[at % 4]);
    let fields: Vec<String> = T::offsets()
        .into_iter()
        .zip(T::TYPES)
        .map(|((_, bytes), ty)| {
            let at = bytes / 4;
            let numbers = match *ty {
                "u32" => return number(at),
                "f32" => 1,
                "Vec4" => 4,
                "Bands" => BANDS,
                _ => 3,
            };
            let all: Vec<String> =
                (at..at + numbers).map(|i| format!("bitcast<f32>({})", number(i))).collect();
            if numbers == 1 { all.concat() } else { format!("{ty}({})", all.join(", ")) }
        })
        .collect();
    let loads: String =
        (0..words).map(|i| format!("    let w{i} = {record}_word({words}u * index + {i}u);\n")).collect();
    format!(
        "fn {record}_at(index: u32) -> {} {{\n{loads}    return {}({});\n}}\n",
        T::NAME,
        T::NAME,
        fields.join(", ")
    )
}
