//! Ring: the uniforms of a submission, one slot each, written at once and bound by offset.

use super::context::Context;
use crate::plan::buffers::RING_BYTES;

/// Uniforms of one submission.
pub(super) struct Ring {
    bytes: Vec<u8>,
    alignment: usize,
    capacity: usize,
}

impl Ring {
    /// An empty ring for a device.
    pub(super) fn new(context: &Context) -> Self {
        let alignment = context.limits.min_uniform_buffer_offset_alignment as usize;
        Self { bytes: Vec::new(), alignment, capacity: RING_BYTES as usize }
    }

    /// Append a uniform; its offset.
    pub(super) fn push<T: bytemuck::Pod>(&mut self, uniform: &T) -> u32 {
        self.push_bytes(bytemuck::bytes_of(uniform))
    }

    /// Append the bytes of a uniform; its offset.
    pub(super) fn push_bytes(&mut self, uniform: &[u8]) -> u32 {
        let at = self.bytes.len().next_multiple_of(self.alignment);
        self.bytes.resize(at, 0);
        self.bytes.extend_from_slice(uniform);
        assert!(self.bytes.len() <= self.capacity, "a submission has few passes");
        at as u32
    }

    /// Forget all uniforms.
    pub(super) fn clear(&mut self) {
        self.bytes.clear();
    }

    /// Write what was pushed.
    pub(super) fn write(&mut self, context: &Context, buffer: &wgpu::Buffer) {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        context.queue.write_buffer(buffer, 0, &self.bytes);
    }
}
