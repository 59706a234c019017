//! The scene on the device: nodes, triangles, normals, materials, emitters and the uniforms that never change.

use super::context::Context;
use super::device_buffers::{Buffers, STORAGE, UNIFORM};
use crate::error::{Error, Result};
use crate::film::paths::LightPaths;
use crate::packed::layout::{AreaPoint, PathFilter};
use crate::packed::{
    Guide, HEAP_WORD, MAX_TARGETS, MAX_WARPS, PackedEmitter, PackedScene, Target, VISIBLE_CELL_WORDS,
    WARP_WORDS,
};
use crate::plan::buffers::{
    Buffer, HEAP, SCENE_INFOS, SMALL_EMITTER_LISTS, heap_layout, heap_part_bytes, list_numbers,
};
use crate::plan::{Guides, InBands, Plan};
use glam::Vec3;

/// Upload a scene.
///
/// # Errors
/// [`Error::Capacity`] where it does not fit, [`Error::Device`] where the device fails.
pub(super) fn upload(context: &Context, scene: &PackedScene, plan: &Plan) -> Result<Buffers> {
    let mut targets = [Target { center: Vec3::ZERO, radius: 0.0 }; MAX_TARGETS];
    targets[..scene.targets.len()].copy_from_slice(&scene.targets);
    let guides = &plan.guides;
    let [warps_caustic, warps_diffuse] = [&guides.caustic, &guides.diffuse].map(warp_words);
    let visible_cells = plan.visible_cells.as_ref().map_or(&[0; VISIBLE_CELL_WORDS][..], |m| m.words());
    let filter = path_filter(&plan.settings.paths);
    let layout = heap_layout(scene, plan);
    let numbers = list_numbers(plan);
    let infos = numbers.map(|list| layout.info(list));
    let emitters = lists(scene, guides);
    let mut contents: Vec<(&str, &[u8])> = vec![
        ("nodes", bytemuck::cast_slice(scene.bvh.nodes())),
        ("triangles", bytemuck::cast_slice(&scene.triangles)),
        ("materials", bytemuck::cast_slice(&scene.materials)),
        ("targets", bytemuck::bytes_of(&targets)),
        ("path_filter", bytemuck::bytes_of(&filter)),
        ("warps_caustic", bytemuck::cast_slice(&warps_caustic)),
        ("warps_diffuse", bytemuck::cast_slice(&warps_diffuse)),
        ("visible_cells", bytemuck::cast_slice(visible_cells)),
    ];
    contents.extend(SCENE_INFOS.into_iter().zip(infos.iter().map(bytemuck::bytes_of)));
    contents.extend(SMALL_EMITTER_LISTS.into_iter().zip(emitters.map(bytemuck::cast_slice)));
    let wanted = crate::plan::buffers::scene_buffers(scene, plan, &context.machine());
    check_capacity(context, &wanted)?;
    let mut buffers = Buffers::new();
    for Buffer { name, bytes, .. } in wanted {
        let usage = if HEAP.contains(&name) { STORAGE } else { UNIFORM };
        let buffer = context.buffer(name, bytes, usage)?;
        if let Some((_, content)) = contents.iter().find(|(n, _)| *n == name) {
            context.queue.write_buffer(&buffer, 0, content);
        }
        buffers.insert(name, buffer);
    }
    // kernels without a list of their own use the first
    for names in [SCENE_INFOS, SMALL_EMITTER_LISTS] {
        if let Some(first) = buffers.get(names[0]).cloned() {
            for name in names {
                buffers.entry(name).or_insert_with(|| first.clone());
            }
        }
    }
    let heap = HeapWriter::new(context, &buffers);
    for (first, section) in layout.sections(scene, own_lists(emitters, numbers)) {
        heap.write(first, &section)?;
    }
    context.check()?;
    Ok(buffers)
}

/// Write what depends on the bands of a pass, for whatever is submitted next.
///
/// # Errors
/// [`Error::Device`] where the device fails.
pub(super) fn write_in_bands(
    context: &Context,
    buffers: &Buffers,
    plan: &Plan,
    in_bands: &InBands,
) -> Result<()> {
    let InBands { scene, guides, .. } = in_bands;
    let (emitters, numbers) = (lists(scene, guides), list_numbers(plan));
    let heap = HeapWriter::new(context, buffers);
    for (first, section) in heap_layout(scene, plan).in_bands(scene, own_lists(emitters, numbers)) {
        heap.write(first, section)?;
    }
    let small = SMALL_EMITTER_LISTS.into_iter().zip(emitters.map(bytemuck::cast_slice));
    for (name, content) in small.chain([("materials", bytemuck::cast_slice(&scene.materials))]) {
        if let Some(buffer) = buffers.get(name) {
            context.queue.write_buffer(buffer, 0, content);
        }
    }
    Ok(())
}

/// The emitters that kernels pick from, in the order of [`SCENE_INFOS`].
fn lists<'a>(scene: &'a PackedScene, guides: &'a Guides) -> [&'a [PackedEmitter]; 4] {
    let own = &scene.emitters[..];
    [own, guides.direct.emitters(own), guides.caustic.emitters(own), guides.diffuse.emitters(own)]
}

/// Those of them that the heap has: the first, and those that have a number of their own.
fn own_lists(lists: [&[PackedEmitter]; 4], numbers: [usize; 4]) -> Vec<&[PackedEmitter]> {
    let is_own = |&(i, _): &(usize, _)| i == 0 || numbers[i] > 0;
    lists.into_iter().enumerate().filter(is_own).map(|(_, list)| list).collect()
}

/// Bytes of the heap that are handed over at a time: the device holds a copy until they are written.
const WRITTEN_AT_ONCE: u64 = 16 << 20;

/// Writes sections of the heap, whether it lies in one buffer or in several.
struct HeapWriter<'a> {
    context: &'a Context,
    /// Its buffers in their order.
    parts: Vec<&'a wgpu::Buffer>,
    /// Bytes of each but the last.
    part_bytes: u64,
}

impl<'a> HeapWriter<'a> {
    fn new(context: &'a Context, buffers: &'a Buffers) -> Self {
        let parts = HEAP.iter().filter_map(|name| buffers.get(name)).collect();
        Self { context, parts, part_bytes: heap_part_bytes(&context.machine()) }
    }

    /// Write a section from word `first` on.
    ///
    /// # Errors
    /// [`Error::Device`] where the device fails.
    fn write(&self, first: u32, section: &[u8]) -> Result<()> {
        let mut rest = section;
        let mut at = u64::from(first) * HEAP_WORD;
        while !rest.is_empty() {
            // the last part has all the rest
            let number = (at / self.part_bytes).min(self.parts.len() as u64 - 1);
            let (part, from) = (self.parts[number as usize], at - number * self.part_bytes);
            let here = (part.size() - from).min(rest.len() as u64).min(WRITTEN_AT_ONCE);
            self.context.queue.write_buffer(part, from, &rest[..here as usize]);
            rest = &rest[here as usize..];
            at += here;
            if !rest.is_empty() {
                self.context.submit(self.context.encoder());
                self.context.wait()?;
            }
        }
        Ok(())
    }
}

/// The warps of a guide as the kernels read them; zeros where there are fewer.
pub(super) fn warp_words(guide: &Guide) -> Vec<u32> {
    let mut words = vec![0u32; MAX_WARPS * WARP_WORDS];
    for (place, warp) in words.chunks_exact_mut(WARP_WORDS).zip(guide.warps()) {
        place.copy_from_slice(&warp.words());
    }
    words
}

/// True for a scene that fits into uniform buffers.
pub fn is_small(context: &Context, scene: &PackedScene) -> bool {
    crate::plan::buffers::is_small(scene, &context.machine())
}

/// Check that each of these buffers fits into a binding.
///
/// # Errors
/// [`Error::Capacity`] naming the buffer.
pub(super) fn check_capacity(context: &Context, buffers: &[Buffer]) -> Result<()> {
    let limit = context.machine().storage_binding;
    for &Buffer { name, bytes, .. } in buffers {
        if bytes > limit {
            let remedy = "use --device cpu".to_string();
            return Err(Error::Capacity { buffer: name, need: bytes, limit, remedy });
        }
    }
    Ok(())
}

/// An area point as the kernels read it; its normal in signed 8 bits a component.
pub(super) fn encode_area_point(p: &crate::packed::AreaPoint) -> AreaPoint {
    let [x, y, z] = p.normal.to_array().map(|c| u32::from((c * 127.0).round() as i8 as u8));
    AreaPoint { position: p.position, normal: x | y << 8 | z << 16 }
}

/// The uniform of the path filter.
pub(super) fn path_filter(paths: &LightPaths) -> PathFilter {
    let mut filter = PathFilter { transitions: [[0; 4]; 16], accept: [[0; 4]; 16] };
    for (state, next) in paths.transitions().into_iter().enumerate() {
        for (event, to) in next.into_iter().enumerate() {
            let word = 2 * state + event;
            filter.transitions[word / 4][word % 4] = to;
        }
    }
    for k in 0..64 {
        filter.accept[k / 4][k % 4] = paths.accept_mask_after_specular(k as u32);
    }
    filter
}
