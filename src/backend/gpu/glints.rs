//! Split paths on the device: the lists of pixels that have trees, strip by strip, and the dispatches that grow them.

use super::pipelines::{Glint, PassGraph};
use super::recorder::Recorder;
use super::{GpuBackend, unbound};
use crate::error::Result;
use crate::estimators::split_paths::{Light, List, Look, SplitPaths, TREES_MAX};
use crate::packed::layout::PassInfo;
use crate::plan::strips::Strip;
use std::ops::Range;

/// The lists: of the strips, which are on the device in turn.
pub(super) struct SplitPathLists {
    whose: Option<SplitPaths>,
    lists: Vec<List>,
}

impl SplitPathLists {
    /// No pixel has trees.
    pub(super) fn none() -> Self {
        Self { whose: None, lists: Vec::new() }
    }

    /// Which pixels have trees.
    pub(super) fn whose(&self) -> Option<&SplitPaths> {
        self.whose.as_ref()
    }

    /// Passes of which one has a tree, in pixels that have one in some passes only.
    pub(super) fn turns(&self) -> u32 {
        self.whose.as_ref().map_or(1, SplitPaths::turns)
    }

    /// The list of a strip in parts that fit the buffer: one, but where trees crowd in a strip. Each begins at a multiple of the
    /// most trees that a pixel has.
    pub(super) fn parts(&self, strip: usize, buffer: Option<&wgpu::Buffer>) -> Vec<Range<u32>> {
        let end = self.lists.get(strip).map_or(0, |list| list.trees.len() as u32);
        let room = buffer.map_or(0, |b| (b.size() / 4) as u32).max(TREES_MAX) / TREES_MAX * TREES_MAX;
        (0..end.max(1)).step_by(room as usize).map(|first| first..(first + room).min(end)).collect()
    }

    /// What grows in a pass over a strip of a part of its list, cut so that the trees have room in a buffer with an entry for each
    /// of its pixels.
    pub(super) fn growths(
        &self,
        strip: usize,
        part: &Range<u32>,
        pass: &PassInfo,
    ) -> impl Iterator<Item = PassInfo> {
        let part = part.clone();
        self.lists.get(strip).into_iter().flat_map(move |list| {
            let room = (pass.held_rows * pass.width).max(TREES_MAX);
            let (start, end) = (part.start, part.end);
            let growths = list.growths(u64::from(pass.pass_index), room);
            let here = growths.map(move |g| g.start.max(start)..g.end.min(end)).filter(|g| !g.is_empty());
            here.map(move |g| PassInfo {
                glint_first: g.start - start,
                glint_count: g.end - g.start,
                ..*pass
            })
        })
    }
}

/// Record that the gather points learn the levels of the first so many entries of the list that is on the device.
pub(super) fn record_marks(recorder: &mut Recorder<'_>, steps: &PassGraph, count: u32, pass: &PassInfo) {
    if let Some(Glint { mark, .. }) = &steps.glint {
        let info = PassInfo { glint_first: 0, glint_count: count, ..*pass };
        let at = [("pass_info", recorder.ring.push(&info))];
        recorder.dispatch(mark, &at, count);
    }
}

/// What the pilot's trees saw in a pixel, as the kernel writes it.
pub(super) fn look(&[light, branched, square, squared_mean]: &[f32; 4]) -> Look {
    let light = match light {
        1.0 => Light::InPart,
        2.0 => Light::Everywhere,
        _ => Light::Nowhere,
    };
    Look { light, branched: branched > 0.0, square, squared_mean }
}

impl GpuBackend {
    /// From now on these have trees.
    pub(super) fn upload_glints(&mut self, glints: SplitPaths) -> Result<()> {
        let width = self.scene.size[0];
        let list = |strip: Strip| {
            glints.list(strip.first * width..(strip.first + strip.rows) * width, self.plan.settings.seed)
        };
        let lists: Vec<List> = self.strips.each().map(list).collect();
        self.glints = SplitPathLists { whose: Some(glints), lists };
        if self.strips.count() > 1 {
            // each strip is told when its turn comes
            return Ok(());
        }
        let count = self.glints.lists[0].trees.len() as u32;
        self.send_glints(0, &(0..count));
        let pass = self.pass_info(0, self.strips.strip(0));
        let steps = self.steps.as_ref().ok_or_else(unbound)?;
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        record_marks(&mut recorder, steps, count, &pass);
        recorder.submit(&self.context, &self.buffers["ring"]);
        Ok(())
    }

    /// Put a part of a strip's list on the device.
    pub(super) fn send_glints(&self, strip: usize, part: &Range<u32>) {
        if let Some(list) = self.glints.lists.get(strip) {
            let trees = &list.trees[part.start as usize..part.end as usize];
            self.context.queue.write_buffer(&self.buffers["glints"], 0, bytemuck::cast_slice(trees));
        }
    }
}
