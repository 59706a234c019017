//! The scene heap: hierarchy, triangles, normals, materials and emitters in one buffer of words of 16 bytes. Kernels read
//! it through the functions of shaders/scene/scene.wgsl; [`SceneInfo`] says where each section begins.

use crate::packed::accel::Node;
use crate::packed::gpu_struct::{GpuStruct, gpu_struct};
use crate::packed::{PackedEmitter, PackedMaterial, PackedTriangle};
use crate::spectrum::BANDS;

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
        /// Materials, 5 words each.
        pub materials: u32,
        /// Emitters, 5 words each, with the probabilities by which this kernel picks them.
        pub emitters: u32,
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
    /// Lists of emitters, which differ in their probabilities.
    pub lists: usize,
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
            pad0: 0,
            pad1: 0,
            pad2: 0,
        };
        let list = counts.emitters as u64 * size_of::<PackedEmitter>() as u64 / HEAP_WORD;
        Self { first, list, words }
    }

    /// What a kernel sees that picks from list `number` of the emitters.
    pub fn info(&self, number: usize) -> SceneInfo {
        SceneInfo { emitters: self.first.emitters + number as u32 * self.list as u32, ..self.first }
    }

    /// Bytes of the heap.
    pub fn bytes(&self) -> u64 {
        self.words * HEAP_WORD
    }
}

/// WGSL functions that read a record of the scene: `triangle_at(index)`, `material_at(index)`, `emitter_at(index)`. They ask
/// `triangle_word(at)` and so on for the words, counted from the beginning of the section.
pub fn readers() -> String {
    [reader::<PackedTriangle>(), reader::<PackedMaterial>(), reader::<PackedEmitter>()].concat()
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
