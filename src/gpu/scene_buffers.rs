//! The scene on the device: nodes, triangles, normals, materials, emitters and the uniforms that never change.

use super::context::Context;
use super::kernel::Buffers;
use super::map;
use super::ring::RING_BYTES;
use crate::error::Result;
use crate::layout::{
    AreaPoint, PathFilter, SMALL_EMITTERS, SMALL_MATERIALS, SMALL_NODE_WORDS, SMALL_TRIANGLES,
};
use crate::pack::{Guide, MARK_WORDS, MAX_WARPS, PackedScene, Target, WARP_WORDS};
use crate::paths::LightPaths;
use crate::plan::Plan;
use glam::{Vec2, Vec3};

/// Bytes of each uniform buffer of a small scene: WebGPU's least limit.
const SMALL_BYTES: u64 = 1 << 16;
/// Words of 16 bytes in a node.
const NODE_WORDS: usize = 5;
/// Targets that the uniform holds.
const TARGETS: usize = 16;

/// Upload a scene.
///
/// # Errors
/// [`crate::Error::Capacity`] where it does not fit.
pub(super) fn upload(context: &Context, scene: &PackedScene, plan: &Plan) -> Result<Buffers> {
    let nodes = scene.bvh.nodes();
    let normals: Vec<[u32; 4]> = if scene.shading_normals.is_empty() {
        vec![[0; 4]]
    } else {
        scene.shading_normals.iter().map(|n| [encode(n[0]), encode(n[1]), encode(n[2]), 0]).collect()
    };
    let mut targets = [Target { center: Vec3::ZERO, radius: 0.0 }; TARGETS];
    targets[..scene.targets.len()].copy_from_slice(&scene.targets);
    let guides = &plan.guides;
    let [warps_caustic, warps_diffuse] = [&guides.caustic, &guides.diffuse].map(warp_words);
    let mut buffers = Buffers::new();
    let mut contents: Vec<(&'static str, &[u8])> = vec![
        ("nodes", bytemuck::cast_slice(&nodes)),
        ("triangles", bytemuck::cast_slice(&scene.triangles)),
        ("shading_normals", bytemuck::cast_slice(&normals)),
        ("materials", bytemuck::cast_slice(&scene.materials)),
        ("emitters", bytemuck::cast_slice(&scene.emitters)),
    ];
    let learned = [
        ("emitters_direct", &guides.direct),
        ("emitters_caustic", &guides.caustic),
        ("emitters_diffuse", &guides.diffuse),
    ];
    for (name, guide) in learned {
        if !guide.is_empty() {
            contents.push((name, bytemuck::cast_slice(guide.emitters(&scene.emitters))));
        }
    }
    let sizes: Vec<(&'static str, u64)> =
        contents.iter().map(|(n, bytes)| (*n, bytes.len() as u64)).collect();
    map::check_capacity(context, &sizes)?;
    let small = is_small(context, scene);
    for (name, bytes) in contents {
        let buffer = if small && name != "shading_normals" {
            // as long as the kernels say, whatever is in it
            let usage =
                wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST;
            buffer(context, name, SMALL_BYTES, usage)
        } else {
            storage(context, name, bytes.len() as u64)
        };
        context.queue.write_buffer(&buffer, 0, bytes);
        buffers.insert(name, buffer);
    }
    for (name, _) in learned {
        let emitters = buffers["emitters"].clone();
        buffers.entry(name).or_insert(emitters);
    }
    let filter = path_filter(&plan.settings.paths);
    for (name, bytes) in [
        ("targets", bytemuck::bytes_of(&targets)),
        ("path_filter", bytemuck::bytes_of(&filter)),
        ("warps_caustic", bytemuck::cast_slice(&warps_caustic)),
        ("marks", bytemuck::cast_slice(plan.marks.as_ref().map_or(&[0; MARK_WORDS][..], |m| m.words()))),
        ("warps_diffuse", bytemuck::cast_slice(&warps_diffuse)),
    ] {
        let buffer = uniform(context, name, bytes.len() as u64);
        context.queue.write_buffer(&buffer, 0, bytes);
        buffers.insert(name, buffer);
    }
    buffers.insert("ring", uniform(context, "ring", RING_BYTES));
    context.check()?;
    Ok(buffers)
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
    let fits = |count: usize, most: u32| count <= most as usize;
    context.limits.max_uniform_buffer_binding_size >= SMALL_BYTES
        && fits(scene.bvh.node_count() * NODE_WORDS, SMALL_NODE_WORDS)
        && fits(scene.triangles.len(), SMALL_TRIANGLES)
        && fits(scene.materials.len(), SMALL_MATERIALS)
        && fits(scene.emitters.len(), SMALL_EMITTERS)
}

/// A storage buffer that can be written, cleared and read back.
pub(super) fn storage(context: &Context, name: &'static str, size: u64) -> wgpu::Buffer {
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::COPY_SRC;
    buffer(context, name, size.next_multiple_of(16).max(16), usage)
}

/// A uniform buffer.
pub(super) fn uniform(context: &Context, name: &'static str, size: u64) -> wgpu::Buffer {
    buffer(context, name, size, wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST)
}

fn buffer(context: &Context, name: &'static str, size: u64, usage: wgpu::BufferUsages) -> wgpu::Buffer {
    let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
    context.device.create_buffer(&descriptor)
}

/// A unit vector in 32 bits, as shaders/shared/sampling.wgsl encodes it.
pub fn encode(n: Vec3) -> u32 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let e =
        if n.z < 0.0 { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) } else { p };
    let snorm = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32_767.0).round() as i16 as u16);
    snorm(e.x) | snorm(e.y) << 16
}

/// An area point as the kernels read it; its normal in signed 8 bits a component.
pub(super) fn encode_area_point(p: &crate::pack::AreaPoint) -> AreaPoint {
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
