//! Lattice: the pixels of an image that tell its error.

use crate::film::tile_schedule::Run;
use std::ops::Range;

/// The pixels that tell the error: all, or a lattice of a large image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub(super) struct Lattice {
    /// Pixels of the image across.
    width: usize,
    /// Pixels from one to the next, across and down.
    pub(super) step: usize,
    /// Pixels of the lattice across and down.
    pub(super) size: [usize; 2],
}

impl Lattice {
    /// The finest of at most `most` pixels.
    pub(super) fn new(size: [u32; 2], most: u64) -> Self {
        let [width, height] = size.map(|n| n as usize);
        let of = |step: usize| [width.div_ceil(step), height.div_ceil(step)];
        let mut step = 1;
        while of(step).iter().map(|n| *n as u64).product::<u64>() > most.max(1) {
            step += 1;
        }
        Self { width, step, size: of(step) }
    }

    pub(super) fn len(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// The pixel of the image.
    pub(super) fn pixel(&self, sample: usize) -> usize {
        let [across, _] = self.size;
        sample / across * self.step * self.width + sample % across * self.step
    }

    /// Those of a run in a row of the image: the range of them in their row, and of the pixels in the image from the first on.
    pub(super) fn in_row(&self, run: &Run, y: usize) -> Option<[Range<usize>; 2]> {
        let first = run.columns.start.next_multiple_of(self.step);
        let pixels = y * self.width + first..y * self.width + run.columns.end;
        let samples = first / self.step..run.columns.end.div_ceil(self.step);
        (first < run.columns.end).then_some([samples, pixels])
    }
}
