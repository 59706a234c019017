//! Buffers: how the device's buffers are made, and what they are called.

use super::context::Context;
use std::collections::HashMap;

/// Buffers by the names that kernels use.
pub type Buffers = HashMap<&'static str, wgpu::Buffer>;

/// How kernels read a buffer that can be written …
pub(super) const UNIFORM: wgpu::BufferUsages =
    wgpu::BufferUsages::UNIFORM.union(wgpu::BufferUsages::COPY_DST);
/// … and one that can be read back and cleared, too.
pub(super) const STORAGE: wgpu::BufferUsages =
    wgpu::BufferUsages::STORAGE.union(wgpu::BufferUsages::COPY_DST).union(wgpu::BufferUsages::COPY_SRC);

/// A storage buffer that can be written, cleared and read back.
pub(super) fn storage(context: &Context, name: &'static str, size: u64) -> wgpu::Buffer {
    buffer(context, name, size.next_multiple_of(16).max(16), STORAGE)
}

/// A uniform buffer.
pub(super) fn uniform(context: &Context, name: &'static str, size: u64) -> wgpu::Buffer {
    buffer(context, name, size, UNIFORM)
}

/// A buffer.
pub(super) fn buffer(
    context: &Context,
    name: &'static str,
    size: u64,
    usage: wgpu::BufferUsages,
) -> wgpu::Buffer {
    let descriptor = wgpu::BufferDescriptor { label: Some(name), size, usage, mapped_at_creation: false };
    context.device.create_buffer(&descriptor)
}
