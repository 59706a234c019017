//! Tile schedule: which tiles of the image take part in a pass, and how many passes they stand for when they do \[E21\].

use std::ops::Range;

/// Side of a tile, pixels; the kernels' workgroups are such tiles, too.
pub const TILE: u32 = 8;
/// A tile takes part in one of 2^k passes; k is at most this.
pub const EXPONENT_MAX: u32 = 4;

/// How often each tile takes part: in the passes that are multiples of 2^k, each of which stands for the 2^k passes that
/// it begins. Set between batches, from what earlier passes saw; k grows at powers of two of passes only.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct TileSchedule {
    size: [u32; 2],
    /// k of each tile, row by row.
    exponents: Vec<u8>,
    /// Pixels of the image in the tiles of each k.
    pixels: [u64; EXPONENT_MAX as usize + 1],
}

/// A piece of a row of tiles that are alike.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run {
    /// Rows of pixels.
    pub rows: Range<usize>,
    /// Columns of pixels.
    pub columns: Range<usize>,
    /// Passes that a sample stands for.
    pub weight: u64,
}

impl Run {
    /// The pixels, as ranges of one row each, of an image so wide.
    pub fn pixels(&self, width: usize) -> impl Iterator<Item = Range<usize>> {
        let columns = self.columns.clone();
        self.rows.clone().map(move |y| y * width + columns.start..y * width + columns.end)
    }
}

impl TileSchedule {
    /// Every tile takes part in every pass.
    pub fn none(size: [u32; 2]) -> Self {
        let [across, down] = size.map(|n| n.div_ceil(TILE) as usize);
        Self::new(size, vec![0; across * down])
    }

    /// With k of each tile, row by row; at most [`EXPONENT_MAX`] counts.
    pub fn new(size: [u32; 2], mut exponents: Vec<u8>) -> Self {
        let [across, down] = size.map(|n| n.div_ceil(TILE) as usize);
        exponents.resize(across * down, 0);
        let mut pixels = [0; EXPONENT_MAX as usize + 1];
        for (tile, k) in exponents.iter_mut().enumerate() {
            *k = (*k).min(EXPONENT_MAX as u8);
            pixels[*k as usize] += clipped(size, tile).iter().map(|side| side.len() as u64).product::<u64>();
        }
        Self { size, exponents, pixels }
    }

    /// Whether it is one of an image so large, where it was stored.
    pub(crate) fn is_sound(&self, size: [u32; 2]) -> bool {
        let tiles = size.map(|n| n.div_ceil(TILE) as usize).into_iter().product::<usize>();
        self.size == size && self.exponents.len() == tiles && *self == Self::new(size, self.exponents.clone())
    }

    /// Pixels of the image across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Tiles across and down.
    pub fn tiles(&self) -> [usize; 2] {
        self.size.map(|n| n.div_ceil(TILE) as usize)
    }

    /// k of each tile.
    pub fn exponents(&self) -> &[u8] {
        &self.exponents
    }

    /// True where every tile takes part in every pass.
    pub fn is_none(&self) -> bool {
        self.pixels[1..].iter().all(|n| *n == 0)
    }

    /// Whether a tile takes part in a pass.
    pub fn is_live(&self, tile: usize, pass: u64) -> bool {
        pass.is_multiple_of(1 << self.exponents[tile])
    }

    /// Times that a tile takes part in `passes` passes from `first` on.
    pub fn samples(&self, tile: usize, first: u64, passes: u64) -> u64 {
        let k = self.exponents[tile];
        (first + passes).div_ceil(1 << k) - first.div_ceil(1 << k)
    }

    /// The index in the sequences of its pixels that a tile uses in a pass: those of one power of two of passes follow each
    /// other, as even as all of them would be, and none is used twice.
    pub fn sequence_index(&self, tile: usize, pass: u32) -> u32 {
        let octave = pass.checked_ilog2().map_or(0, |log| 1 << log);
        octave + ((pass - octave) >> self.exponents[tile])
    }

    /// Pixels that do not take part in a pass.
    pub fn pixels_resting(&self, pass: u64) -> u64 {
        self.pixels.iter().enumerate().filter(|(k, _)| !pass.is_multiple_of(1 << k)).map(|(_, n)| n).sum()
    }

    /// Passes of the block of a tile of exponent `k` that are still to come after `passes` passes.
    pub fn pending(k: u8, passes: u64) -> u64 {
        let block = 1 << k;
        passes.next_multiple_of(block) - passes
    }

    /// Likewise of the tile of a pixel.
    pub fn pending_at(&self, pixel: usize, passes: u64) -> u64 {
        if self.is_none() {
            return 0;
        }
        Self::pending(self.exponents[self.tile_of(pixel)], passes)
    }

    /// True where a pixel's tile rests.
    pub fn is_resting(&self, pixel: usize) -> bool {
        !self.is_none() && self.exponents[self.tile_of(pixel)] > 0
    }

    fn tile_of(&self, pixel: usize) -> usize {
        let width = self.size[0] as usize;
        pixel / width / TILE as usize * self.tiles()[0] + pixel % width / TILE as usize
    }

    /// Pixels across and down of a tile, as ranges of columns and rows.
    pub fn tile(&self, tile: usize) -> [Range<usize>; 2] {
        clipped(self.size, tile)
    }

    /// Rows of pixels from the first to the last tile that takes part in some of `passes` passes from `first` on.
    pub fn rows(&self, first: u64, passes: u64) -> Range<usize> {
        let mut live = (0..self.exponents.len()).filter(|t| self.samples(*t, first, passes) > 0);
        let Some(top) = live.next() else { return 0..0 };
        let bottom = live.next_back().unwrap_or(top);
        self.tile(top)[1].start..self.tile(bottom)[1].end
    }

    /// The tiles that take part in some of `passes` passes from `first` on, in runs, for each row of tiles.
    pub fn runs(&self, first: u64, passes: u64) -> Vec<Vec<Run>> {
        let [across, down] = self.tiles();
        let row = |y: usize| {
            let mut runs: Vec<Run> = Vec::new();
            for x in 0..across {
                let tile = y * across + x;
                if self.samples(tile, first, passes) == 0 {
                    continue;
                }
                let [columns, rows] = self.tile(tile);
                let weight = 1 << self.exponents[tile];
                match runs.last_mut() {
                    Some(run) if run.columns.end == columns.start && run.weight == weight => {
                        run.columns.end = columns.end;
                    }
                    _ => runs.push(Run { rows, columns, weight }),
                }
            }
            runs
        };
        (0..down).map(row).collect()
    }
}

/// Columns and rows of a tile that lie in the image.
fn clipped([width, height]: [u32; 2], tile: usize) -> [Range<usize>; 2] {
    let (side, across) = (TILE as usize, width.div_ceil(TILE) as usize);
    let along = |at: usize, end: u32| at * side..((at + 1) * side).min(end as usize);
    [along(tile % across, width), along(tile / across, height)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20 × 12 pixels: tiles of 8, 8 and 4 columns, 8 and 4 rows.
    fn mixed() -> TileSchedule {
        TileSchedule::new([20, 12], vec![0, 2, 2, 4, 0, 0])
    }

    /// Whatever the tiles, every pass is stood for once: up to any pass the samples' weights less what is pending are the
    /// passes.
    #[test]
    fn every_pass_is_stood_for_once() {
        let schedule = mixed();
        for passes in 16..80u64 {
            for (tile, k) in schedule.exponents().iter().enumerate() {
                let weight = schedule.samples(tile, 0, passes) << k;
                assert_eq!(weight - TileSchedule::pending(*k, passes), passes, "tile {tile}");
                let live = (0..passes).filter(|p| schedule.is_live(tile, *p)).count() as u64;
                assert_eq!(
                    schedule.samples(tile, 0, 5) + schedule.samples(tile, 5, passes - 5),
                    live,
                    "tile {tile}"
                );
            }
        }
    }

    /// From one power of two to the next the samples use consecutive indices from it on; who never rests uses the pass.
    #[test]
    fn indices_follow_each_other_and_are_used_once() {
        let schedule = mixed();
        for (tile, k) in schedule.exponents().iter().enumerate() {
            for octave in [32u32, 64, 1024] {
                let live = (octave..2 * octave).filter(|p| schedule.is_live(tile, u64::from(*p)));
                let used: Vec<u32> = live.map(|p| schedule.sequence_index(tile, p)).collect();
                let wanted: Vec<u32> = (octave..octave + (octave >> k)).collect();
                assert_eq!(used, wanted, "tile {tile}");
            }
        }
        assert_eq!(schedule.sequence_index(0, 0), 0);
    }

    /// The runs of a pass are its live pixels, each once; the others rest.
    #[test]
    fn runs_are_the_live_pixels() {
        let schedule = mixed();
        let [width, height] = schedule.size().map(|n| n as usize);
        for (first, passes) in [(0, 1), (1, 1), (4, 1), (5, 3), (5, 4), (17, 16)] {
            let mut times = vec![0; width * height];
            for run in schedule.runs(first, passes).concat() {
                run.pixels(width).flatten().for_each(|p| times[p] += run.weight);
            }
            for (p, times) in times.iter().enumerate() {
                let tile = p / width / 8 * 3 + p % width / 8;
                let live = (first..first + passes).any(|pass| schedule.is_live(tile, pass));
                let wanted = if live { 1 << schedule.exponents()[tile] } else { 0 };
                assert_eq!(*times, wanted, "pixel {p} in {passes} passes from {first}");
            }
            let row = |at: usize| at / width;
            let live: Vec<usize> = (0..times.len()).filter(|p| times[*p] > 0).map(row).collect();
            assert_eq!(schedule.rows(first, passes), live[0]..live[live.len() - 1] + 1);
            if passes == 1 {
                let resting = times.iter().filter(|n| **n == 0).count() as u64;
                assert_eq!(resting, schedule.pixels_resting(first));
            }
        }
        assert_eq!(schedule.runs(1, 1).concat().len(), 2, "neighbours that are alike are one run");
        assert!(TileSchedule::none([20, 12]).is_none() && !schedule.is_none());
        assert_eq!(TileSchedule::new([20, 12], vec![1; 6]).rows(3, 1), 0..0);
        assert_eq!(TileSchedule::new([20, 12], vec![1, 1, 1, 1, 0, 1]).rows(3, 1), 8..12);
    }
}
