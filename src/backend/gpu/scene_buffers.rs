//! The scene on the device: nodes, triangles, normals, materials, emitters and the uniforms that never change.

use super::context::Context;
use super::device_buffers::{Buffers, STORAGE, UNIFORM, buffer};
use crate::error::{Error, Result};
use crate::film::paths::LightPaths;
use crate::packed::layout::{AreaPoint, PathFilter};
use crate::packed::{Guide, MAX_TARGETS, MAX_WARPS, PackedScene, Target, VISIBLE_CELL_WORDS, WARP_WORDS};
use crate::plan::Plan;
use crate::plan::buffers::{Buffer, TRIANGLES, triangles_part_bytes};
use glam::{Vec2, Vec3};

/// Upload a scene.
///
/// # Errors
/// [`crate::Error::Capacity`] where it does not fit.
pub(super) fn upload(context: &Context, scene: &PackedScene, plan: &Plan) -> Result<Buffers> {
    let nodes = scene.bvh.nodes();
    let normals: Vec<[u32; 4]> =
        scene.shading_normals.iter().map(|n| [encode(n[0]), encode(n[1]), encode(n[2]), 0]).collect();
    let mut targets = [Target { center: Vec3::ZERO, radius: 0.0 }; MAX_TARGETS];
    targets[..scene.targets.len()].copy_from_slice(&scene.targets);
    let guides = &plan.guides;
    let [warps_caustic, warps_diffuse] = [&guides.caustic, &guides.diffuse].map(warp_words);
    let visible_cells = plan.visible_cells.as_ref().map_or(&[0; VISIBLE_CELL_WORDS][..], |m| m.words());
    let filter = path_filter(&plan.settings.paths);
    let contents: [(&str, &[u8]); 13] = [
        ("nodes", bytemuck::cast_slice(&nodes)),
        ("triangles", bytemuck::cast_slice(&scene.triangles)),
        ("shading_normals", bytemuck::cast_slice(&normals)),
        ("materials", bytemuck::cast_slice(&scene.materials)),
        ("emitters", bytemuck::cast_slice(&scene.emitters)),
        ("emitters_direct", bytemuck::cast_slice(guides.direct.emitters(&scene.emitters))),
        ("emitters_caustic", bytemuck::cast_slice(guides.caustic.emitters(&scene.emitters))),
        ("emitters_diffuse", bytemuck::cast_slice(guides.diffuse.emitters(&scene.emitters))),
        ("targets", bytemuck::bytes_of(&targets)),
        ("path_filter", bytemuck::bytes_of(&filter)),
        ("warps_caustic", bytemuck::cast_slice(&warps_caustic)),
        ("warps_diffuse", bytemuck::cast_slice(&warps_diffuse)),
        ("visible_cells", bytemuck::cast_slice(visible_cells)),
    ];
    let wanted = crate::plan::buffers::scene_buffers(scene, plan, &context.machine());
    check_capacity(context, &wanted)?;
    let small = is_small(context, scene);
    let mut buffers = Buffers::new();
    for Buffer { name, bytes, .. } in wanted {
        let usage = match name {
            "targets" | "path_filter" | "warps_caustic" | "warps_diffuse" | "visible_cells" | "tiles"
            | "ring" => UNIFORM,
            "shading_normals" => STORAGE,
            _ if small => UNIFORM | STORAGE,
            _ => STORAGE,
        };
        let buffer = buffer(context, name, bytes, usage);
        let part = TRIANGLES.iter().position(|n| *n == name).unwrap_or(0);
        let whole = if part > 0 { TRIANGLES[0] } else { name };
        if let Some((_, content)) = contents.iter().find(|(n, _)| *n == whole) {
            let from = (part as u64 * triangles_part_bytes(&context.machine())).min(content.len() as u64);
            let rest = &content[from as usize..];
            context.queue.write_buffer(&buffer, 0, &rest[..rest.len().min(bytes as usize)]);
        }
        buffers.insert(name, buffer);
    }
    for name in ["emitters_direct", "emitters_caustic", "emitters_diffuse"] {
        let emitters = buffers["emitters"].clone();
        buffers.entry(name).or_insert(emitters);
    }
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

/// A unit vector in 32 bits, as shaders/sampling/sampling.wgsl encodes it.
pub fn encode(n: Vec3) -> u32 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    let e =
        if n.z < 0.0 { Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y)) } else { p };
    let snorm = |x: f32| u32::from((x.clamp(-1.0, 1.0) * 32_767.0).round() as i16 as u16);
    snorm(e.x) | snorm(e.y) << 16
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
