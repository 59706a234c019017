//! Glints on the device: the lists of pixels that have trees, strip by strip, and the dispatches that grow them.

use super::GpuBackend;
use super::pipelines::{Glint, Steps};
use super::recorder::Recorder;
use crate::error::Result;
use crate::glints::{Glints, Light, List, Look, TREES_MAX};
use crate::layout::PassInfo;
use crate::plan::shape::Strip;

/// The lists, one behind the other on the device.
pub(super) struct GlintLists {
    whose: Option<Glints>,
    /// For each strip where its list begins, and the list.
    lists: Vec<(u32, List)>,
}

impl GlintLists {
    /// No pixel has trees.
    pub(super) fn none() -> Self {
        Self { whose: None, lists: Vec::new() }
    }

    /// Which pixels have trees.
    pub(super) fn whose(&self) -> Option<&Glints> {
        self.whose.as_ref()
    }

    /// Passes of which one has a tree, in pixels that have one now and then.
    pub(super) fn turns(&self) -> u32 {
        self.whose.as_ref().map_or(1, Glints::turns)
    }

    /// What grows in a pass over a strip, in parts whose trees have room in a buffer with an entry for each of its pixels.
    pub(super) fn growths(&self, strip: usize, pass: &PassInfo) -> impl Iterator<Item = PassInfo> {
        self.lists.get(strip).into_iter().flat_map(move |(start, list)| {
            let room = (pass.held_rows * pass.width).max(TREES_MAX);
            let growths = list.growths(u64::from(pass.pass_index), room);
            growths.map(move |g| PassInfo {
                glint_first: start + g.start,
                glint_count: g.end - g.start,
                ..*pass
            })
        })
    }

    /// Record that the gather points of a strip learn their levels.
    pub(super) fn record_marks(
        &self,
        recorder: &mut Recorder<'_>,
        steps: &Steps,
        strip: usize,
        pass: &PassInfo,
    ) {
        if let (Some((start, list)), Some(Glint { mark, .. })) = (self.lists.get(strip), &steps.glint) {
            let glint_count = list.trees.len() as u32;
            let info = PassInfo { glint_first: *start, glint_count, ..*pass };
            let at = [("pass_info", recorder.ring.push(&info))];
            recorder.dispatch(mark, &at, glint_count);
        }
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
    /// Write who has trees to the device.
    pub(super) fn upload_glints(&mut self, glints: Glints) -> Result<()> {
        let mut start = 0;
        let width = self.scene.size[0];
        let list = |strip: Strip| {
            let list =
                glints.list(strip.first * width..(strip.first + strip.rows) * width, self.plan.settings.seed);
            let at = start;
            start += list.trees.len() as u32;
            (at, list)
        };
        let lists: Vec<(u32, List)> = self.strips.each().map(list).collect();
        for (start, list) in &lists {
            let bytes = bytemuck::cast_slice(&list.trees);
            self.context.queue.write_buffer(&self.buffers["glints"], u64::from(*start) * 4, bytes);
        }
        self.glints = GlintLists { whose: Some(glints), lists };
        if self.strips.count() > 1 {
            // each strip is told when its turn comes
            return Ok(());
        }
        let pass = self.pass_info(0, self.strips.strip(0));
        let Some(steps) = &self.steps else { return Ok(()) };
        let mut recorder = Recorder::new(&self.context, &mut self.ring, None);
        self.glints.record_marks(&mut recorder, steps, 0, &pass);
        recorder.submit(&self.context, &self.buffers["ring"]);
        Ok(())
    }
}
