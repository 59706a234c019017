//! Buffers: how the device's buffers are made, and what they are called.

use super::context::Context;
use crate::error::Result;
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
///
/// # Errors
/// [`crate::Error::Device`] where there is no memory for it.
pub(super) fn storage(context: &Context, name: &'static str, size: u64) -> Result<wgpu::Buffer> {
    context.buffer(name, size.next_multiple_of(16).max(16), STORAGE)
}

/// A uniform buffer.
///
/// # Errors
/// [`crate::Error::Device`] where there is no memory for it.
pub(super) fn uniform(context: &Context, name: &'static str, size: u64) -> Result<wgpu::Buffer> {
    context.buffer(name, size, UNIFORM)
}
