//! Recorder: dispatches of a submission, one compute pass each, with timestamps where they are wanted.

use super::context::{Context, Copy};
use super::kernel::{BoundKernel, Offsets};
use super::ring::Ring;
use super::tiles::{BINDING_BYTES, TILES_PER_DISPATCH};
use crate::error::Result;
use std::collections::BTreeMap;

/// Timestamps that wait to be read, at most: WebGPU's limit of a query set.
const QUERIES: u32 = 4096;

/// Seconds and dispatches of each kernel.
pub(super) type KernelSeconds = BTreeMap<String, (f64, u64)>;

/// Measures kernels by timestamps.
pub(super) struct Timer {
    queries: wgpu::QuerySet,
    resolved: wgpu::Buffer,
    /// What was dispatched since they were resolved last.
    labels: Vec<String>,
    seconds: KernelSeconds,
}

/// Times of dispatches on their way to the host, and the names of these.
pub(super) struct Timed {
    labels: Vec<String>,
    copy: Copy,
}

impl Timer {
    /// A timer, where the device has timestamps.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where there is no memory for it.
    pub(super) fn new(context: &Context) -> Result<Option<Self>> {
        if !context.device.features().contains(wgpu::Features::TIMESTAMP_QUERY) {
            return Ok(None);
        }
        let queries = context.device.create_query_set(&wgpu::QuerySetDescriptor {
            label: Some("timer"),
            ty: wgpu::QueryType::Timestamp,
            count: QUERIES,
        });
        let usage = wgpu::BufferUsages::QUERY_RESOLVE | wgpu::BufferUsages::COPY_SRC;
        let resolved = context.buffer("timer", u64::from(QUERIES) * 8, usage)?;
        Ok(Some(Self { queries, resolved, labels: Vec::new(), seconds: KernelSeconds::new() }))
    }

    /// Whether those of another pass may not fit.
    pub(super) fn is_nearly_full(&self) -> bool {
        self.labels.len() as u32 > QUERIES / 4
    }

    /// Record a copy of the times of all dispatches so far; none where there are none.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where there is no memory for it.
    pub(super) fn copy_out(
        &mut self,
        context: &Context,
        encoder: &mut wgpu::CommandEncoder,
    ) -> Result<Option<Timed>> {
        let count = self.labels.len() as u32 * 2;
        if count == 0 {
            return Ok(None);
        }
        encoder.resolve_query_set(&self.queries, 0..count, &self.resolved, 0);
        let copy = context.copy_out(None, &[(&self.resolved, 0..u64::from(count) * 8)], encoder)?;
        Ok(Some(Timed { labels: std::mem::take(&mut self.labels), copy }))
    }

    /// Wait for times that were handed over, and add them up.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where reading back fails.
    pub(super) fn add(
        &mut self,
        context: &Context,
        Timed { labels, copy }: Timed,
        submission: wgpu::SubmissionIndex,
    ) -> Result<()> {
        let mut ticks: Vec<u64> = Vec::new();
        context.see_copy(copy, submission, &mut |_, bytes| ticks = bytemuck::pod_collect_to_vec(bytes))?;
        let period = f64::from(context.queue.get_timestamp_period()) * 1e-9;
        for (label, pair) in labels.into_iter().zip(ticks.chunks_exact(2)) {
            let entry = self.seconds.entry(label).or_default();
            entry.0 += pair[1].saturating_sub(pair[0]) as f64 * period;
            entry.1 += 1;
        }
        Ok(())
    }

    /// Wait, and add up what the last submissions took.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where reading back fails.
    pub(super) fn collect(&mut self, context: &Context) -> Result<()> {
        let mut encoder = context.encoder();
        match self.copy_out(context, &mut encoder)? {
            Some(timed) => {
                let submission = context.submit(encoder);
                self.add(context, timed, submission)
            }
            None => Ok(()),
        }
    }

    /// Seconds and dispatches so far.
    pub(super) fn seconds(&self) -> &KernelSeconds {
        &self.seconds
    }
}

/// Where in the list of tiles each dispatch over the first so many begins, and how many it takes.
fn parts(tiles: u32) -> impl Iterator<Item = (u32, u32)> {
    let firsts = (0..tiles).step_by(TILES_PER_DISPATCH as usize);
    (0..)
        .zip(firsts)
        .map(move |(part, first)| (part * BINDING_BYTES, (tiles - first).min(TILES_PER_DISPATCH)))
}

/// Records one submission.
pub(super) struct Recorder<'a> {
    encoder: wgpu::CommandEncoder,
    /// The uniforms.
    pub(super) ring: &'a mut Ring,
    timer: Option<&'a mut Timer>,
}

impl<'a> Recorder<'a> {
    /// Start recording.
    pub(super) fn new(context: &Context, ring: &'a mut Ring, timer: Option<&'a mut Timer>) -> Self {
        Self::after(context.encoder(), ring, timer)
    }

    /// Go on after what was recorded.
    pub(super) fn after(
        encoder: wgpu::CommandEncoder,
        ring: &'a mut Ring,
        timer: Option<&'a mut Timer>,
    ) -> Self {
        ring.clear();
        Self { encoder, ring, timer }
    }

    /// Set a buffer to zero.
    pub(super) fn clear(&mut self, buffer: &wgpu::Buffer) {
        self.encoder.clear_buffer(buffer, 0, None);
    }

    /// At least `invocations` of a kernel.
    pub(super) fn dispatch(&mut self, step: &BoundKernel, offsets: Offsets<'_>, invocations: u32) {
        if invocations > 0 {
            let [x, y] = step.groups_for(invocations);
            self.dispatch_groups(step, offsets, [x, y]);
        }
    }

    /// A kernel whose workgroups are the first so many tiles of the list.
    pub(super) fn dispatch_tiles(&mut self, step: &BoundKernel, offsets: Offsets<'_>, tiles: u32) {
        for (offset, count) in parts(tiles) {
            self.dispatch_groups(step, &[offsets, &[("tiles", offset)]].concat(), [count, 1]);
        }
    }

    /// Likewise for a kernel whose invocations take pixels from a queue: a counter of those that were taken.
    pub(super) fn dispatch_queue(
        &mut self,
        step: &BoundKernel,
        offsets: Offsets<'_>,
        tiles: u32,
        queue: &wgpu::Buffer,
    ) {
        for (offset, count) in parts(tiles) {
            self.clear(queue);
            self.dispatch_groups(step, &[offsets, &[("tiles", offset)]].concat(), [count, 1]);
        }
    }

    /// `x` × `y` workgroups of a kernel.
    pub(super) fn dispatch_groups(&mut self, step: &BoundKernel, offsets: Offsets<'_>, groups: [u32; 2]) {
        let stamps = match &mut self.timer {
            Some(timer) if (timer.labels.len() as u32 + 1) * 2 <= QUERIES => {
                let at = timer.labels.len() as u32 * 2;
                timer.labels.push(step.label().to_string());
                Some(wgpu::ComputePassTimestampWrites {
                    query_set: &timer.queries,
                    beginning_of_pass_write_index: Some(at),
                    end_of_pass_write_index: Some(at + 1),
                })
            }
            _ => None,
        };
        let mut pass = self
            .encoder
            .begin_compute_pass(&wgpu::ComputePassDescriptor { label: None, timestamp_writes: stamps });
        step.dispatch_groups(&mut pass, offsets, groups);
    }

    /// What was recorded. Its uniforms are on their way: it is handed over before any others are.
    pub(super) fn finish(self, context: &Context, ring_buffer: &wgpu::Buffer) -> wgpu::CommandEncoder {
        self.ring.write(context, ring_buffer);
        self.encoder
    }

    /// Hand everything to the queue.
    pub(super) fn submit(self, context: &Context, ring_buffer: &wgpu::Buffer) {
        let encoder = self.finish(context, ring_buffer);
        context.submit(encoder);
    }
}
