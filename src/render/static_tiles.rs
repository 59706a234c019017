//! Static tiles: which tiles have seen one and the same radiance in every pixel of every pass, as their neighbours have, and
//! when these rest [E21].

use crate::estimators::split_paths::SplitPaths;
use crate::film::LAYERS;
use crate::film::tile_schedule::{EXPONENT_MAX, TileSchedule};
use crate::spectrum::{BANDS, Bands};
use rayon::prelude::*;

/// Passes that are watched before a tile rests: a quiet tile and its eight neighbours have seen 2304 samples by then.
const WATCHED: u64 = 4;
/// Largest relative difference between equal radiances: sums of up to 16 of them in f32, each rounded to 2^-24.
const ROUNDING: f32 = 1e-6;

/// What a tile has seen.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
enum Seen {
    Nothing,
    /// This radiance alone, by layer.
    One([Bands; LAYERS]),
    Several,
}

/// Watches the passes, and says who rests.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct StaticTiles {
    seen: Vec<Seen>,
    schedule: TileSchedule,
}

impl StaticTiles {
    /// Nothing was seen yet.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let schedule = TileSchedule::none(size);
        Self { seen: vec![Seen::Nothing; schedule.exponents().len()], schedule }
    }

    /// Whether it is of an image so large, where it was stored.
    pub(crate) fn is_sound(&self, size: [u32; 2]) -> bool {
        self.schedule.is_sound(size) && self.seen.len() == self.schedule.exponents().len()
    }

    /// Look at the sums of `passes` passes from `first` on; a layer without pixels is black.
    pub(crate) fn watch(&mut self, first: u64, passes: u64, layers: &[Vec<Bands>; LAYERS]) {
        let width = self.schedule.size()[0] as usize;
        let schedule = &self.schedule;
        self.seen.par_iter_mut().enumerate().for_each(|(tile, seen)| {
            let samples = schedule.samples(tile, first, passes);
            if samples == 0 || *seen == Seen::Several {
                return;
            }
            let mean = |pixel: usize| -> [Bands; LAYERS] {
                std::array::from_fn(|l| {
                    layers[l].get(pixel).map_or([0.0; BANDS], |sum| sum.map(|x| x / samples as f32))
                })
            };
            let [columns, rows] = schedule.tile(tile);
            let wanted = match seen {
                Seen::One(radiance) => *radiance,
                _ => mean(rows.start * width + columns.start),
            };
            let alike = rows.flat_map(|y| columns.clone().map(move |x| y * width + x));
            let alike = alike.map(mean).all(|radiance| is_same(&radiance, &wanted));
            *seen = if alike { Seen::One(wanted) } else { Seen::Several };
        });
    }

    /// Who rests after `passes` passes, where that changes: tiles go to rest at powers of two, 2^k then being half of the
    /// passes, and wake at the end of any block in which they or a neighbour saw something else. Where `glints` has trees it
    /// is not known what they will see.
    pub(crate) fn renew(&mut self, passes: u64, glints: Option<&SplitPaths>) -> Option<&TileSchedule> {
        let to_rest = passes >= WATCHED && passes.is_power_of_two();
        let is_quiet =
            |tile: usize| self.is_quiet(tile) && glints.is_none_or(|g| !g.any(&self.schedule.tile(tile)));
        let exponents: Vec<u8> = (0..self.seen.len())
            .map(|tile| match self.schedule.exponents()[tile] {
                k if TileSchedule::pending(k, passes) > 0 => k,
                _ if to_rest && is_quiet(tile) => (passes.ilog2() - 1).min(EXPONENT_MAX) as u8,
                0 => 0,
                k if !to_rest && is_quiet(tile) => k,
                _ => 0,
            })
            .collect();
        if exponents == self.schedule.exponents() {
            return None;
        }
        self.schedule = TileSchedule::new(self.schedule.size(), exponents);
        Some(&self.schedule)
    }

    /// One radiance in the tile and in those around it.
    fn is_quiet(&self, tile: usize) -> bool {
        let Seen::One(radiance) = &self.seen[tile] else { return false };
        let [across, down] = self.schedule.tiles();
        let around = |at: usize, end: usize| at.saturating_sub(1)..(at + 2).min(end);
        let mut tiles = around(tile / across, down)
            .flat_map(|y| around(tile % across, across).map(move |x| y * across + x));
        tiles.all(|t| matches!(&self.seen[t], Seen::One(other) if is_same(other, radiance)))
    }
}

/// Equal but for rounding.
fn is_same(a: &[Bands; LAYERS], b: &[Bands; LAYERS]) -> bool {
    let mut pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.all(|(a, b)| (a - b).abs() <= ROUNDING * b.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [u32; 2] = [40, 24];
    const WIDTH: usize = 40;
    /// Pixels of the middle tile of 5 × 3.
    const MIDDLE: usize = 7;

    /// A lamp of one radiance, but for `speck` at a pixel in some passes.
    fn seen(passes: std::ops::Range<u64>, speck: impl Fn(u64) -> Option<usize>) -> StaticTiles {
        let mut static_tiles = StaticTiles::new(SIZE);
        for pass in passes {
            let mut layers: [Vec<Bands>; LAYERS] = Default::default();
            layers[0] = vec![[3.3; BANDS]; WIDTH * 24];
            if let Some(pixel) = speck(pass) {
                layers[0][pixel] = [3.4; BANDS];
            }
            static_tiles.watch(pass, 1, &layers);
            static_tiles.renew(pass + 1, None);
        }
        static_tiles
    }

    /// Half of the passes are slept through at first, at last all but one of sixteen.
    #[test]
    fn quiet_tiles_rest_more_and_more() {
        for (passes, k) in [(1, 0), (3, 0), (4, 1), (7, 1), (8, 2), (16, 3), (31, 3), (32, 4), (300, 4)] {
            let static_tiles = seen(0..passes, |_| None);
            assert_eq!(static_tiles.schedule.exponents(), [k; 15], "{passes} passes");
        }
    }

    /// A speck in a tile keeps it and its neighbours awake, whenever it was seen; tiles farther off rest.
    #[test]
    fn what_is_seen_once_keeps_the_neighbours_awake() {
        let speck = 12 * WIDTH + 20;
        for pass in 0..4 {
            let static_tiles = seen(0..4, |p| (p == pass).then_some(speck));
            assert_eq!(static_tiles.schedule.exponents(), [1, 0, 0, 0, 1].repeat(3), "seen in pass {pass}");
        }
    }

    /// A tile that sees something while it rests is awake from the end of the block on, with its neighbours, and stays so.
    #[test]
    fn tiles_wake_at_the_end_of_a_block() {
        let speck = 12 * WIDTH + 20;
        let at = |passes| seen(0..passes, |p| (p == 48).then_some(speck)).schedule.exponents()[MIDDLE];
        assert_eq!([48, 49, 63].map(at), [4, 4, 4]);
        assert_eq!([64, 65, 128, 500].map(at), [0, 0, 0, 0]);
        let corner = seen(0..64, |p| (p == 48).then_some(speck)).schedule.exponents()[0];
        assert_eq!(corner, 4);
        // in the first of two blocks before a power of two
        let at = |passes| seen(0..passes, |p| (p == 32).then_some(speck)).schedule.exponents()[MIDDLE];
        assert_eq!([47, 48, 63, 64].map(at), [4, 0, 0, 0]);
    }

    /// Sums of several passes, rounded in f32, are still one radiance; a thousandth more is not.
    #[test]
    fn sums_are_compared_by_their_means() {
        let sum = (0..16).fold(0.0f32, |s, _| s + 0.1);
        for (last, k) in [(sum, 1), (sum * 1.001, 0)] {
            let mut static_tiles = StaticTiles::new([8, 8]);
            for (first, passes, value) in [(0, 1, 0.1f32), (1, 1, 0.1), (2, 16, last)] {
                let layers = std::array::from_fn(|_| vec![[value; BANDS]; 64]);
                static_tiles.watch(first, passes, &layers);
            }
            static_tiles.renew(4, None);
            assert_eq!(static_tiles.schedule.exponents(), [k]);
        }
    }
}
