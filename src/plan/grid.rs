//! Grid: the hashed grid in which a device sorts jotons and area points, and which of its buckets a disc looks through.
//! Twin: shaders/maps/grid.wgsl.

use crate::packed::constants::{CELLS_PER_RADIUS, row_bucket};
use glam::Vec3;
use std::ops::Range;

/// A cell is never narrower than this part of the scene: columns fit the table.
const COLUMNS_MAX: f32 = 30_000.0;
/// Rows of cells that a disc touches, each way, at most.
const ROWS_TOUCHED: i32 = 4;

/// How space is cut into cells and cells into buckets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Lower corner.
    pub origin: Vec3,
    /// One over the width of a cell.
    pub cells_per_unit: f32,
    /// Rows (y, z) are hashed to this many less one (a mask of ones).
    pub row_mask: u32,
    /// Cells along x.
    pub columns: u32,
}

impl Grid {
    /// For discs of at most this radius, in a table of 2^key_bits buckets.
    pub fn new(bounds: [Vec3; 2], radius: f32, key_bits: u32) -> Self {
        let extent = bounds[1] - bounds[0];
        let cells_per_unit = (CELLS_PER_RADIUS / radius).min(COLUMNS_MAX / extent.max_element());
        let columns = (extent.x * cells_per_unit) as u32 + 1;
        // the largest power of two that leaves room for the columns
        let row_mask = (1u32 << ((1u32 << key_bits) - columns).ilog2()) - 1;
        Self { origin: bounds[0], cells_per_unit, row_mask, columns }
    }

    /// The bucket of a place.
    pub fn bucket(&self, position: Vec3) -> u32 {
        // the same arithmetic as the kernels'
        let cell = ((position - self.origin) * self.cells_per_unit).floor().as_ivec3();
        row_bucket(cell.y, cell.z, self.row_mask) + self.column(cell.x)
    }

    /// Buckets, and one more.
    pub fn buckets(&self) -> usize {
        self.row_mask as usize + 2 + self.columns as usize
    }

    /// The buckets that a sphere of this radius, no wider than two cells, looks through, in runs.
    pub fn runs(&self, center: Vec3, radius: f32) -> impl Iterator<Item = Range<usize>> + use<> {
        let grid = *self;
        let at = (center - self.origin) * self.cells_per_unit;
        let reach = radius * self.cells_per_unit;
        let [low, high] = [at - reach, at + reach].map(|corner| corner.floor().as_ivec3());
        let end = move |axis: usize| high[axis].min(low[axis] + ROWS_TOUCHED - 1);
        (low.z..=end(2)).flat_map(move |z| (low.y..=end(1)).map(move |y| [y, z])).filter_map(move |[y, z]| {
            let off = |cell: i32, at: f32| (cell as f32 - at).max(at - cell as f32 - 1.0).max(0.0);
            let left = reach * reach - off(y, at.y).powi(2) - off(z, at.z).powi(2);
            let half = (left >= 0.0).then(|| left.sqrt())?;
            let row = row_bucket(y, z, grid.row_mask);
            let [first, last] = [at.x - half, at.x + half].map(|x| grid.column(x.floor() as i32));
            Some((row + first) as usize..(row + last) as usize + 1)
        })
    }

    fn column(&self, x: i32) -> u32 {
        x.clamp(0, self.columns as i32 - 1) as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::rng::random4;

    /// What lies in a sphere lies in one of the buckets that are looked through, and in one run only.
    #[test]
    fn a_sphere_is_looked_through_once() {
        let bounds = [Vec3::splat(-3.0), Vec3::new(5.0, 2.0, 4.0)];
        let place = |i: u32, k: u32| {
            bounds[0] + (bounds[1] - bounds[0]) * Vec3::from_slice(&random4(1, k, i, 0)[..3])
        };
        for (radius, largest) in [(0.2, 0.2), (0.05, 0.2), (1.5, 1.5)] {
            let grid = Grid::new(bounds, largest, 12);
            for i in 0..200 {
                let center = place(i, 0);
                for k in 1..40 {
                    let offset = Vec3::from_slice(&random4(2, k, i, 0)[..3]) * 2.0 - 1.0;
                    let near = (center + offset * radius).clamp(bounds[0], bounds[1]);
                    let bucket = grid.bucket(near) as usize;
                    let times = grid.runs(center, radius).filter(|run| run.contains(&bucket)).count();
                    let is_inside = near.distance(center) < 0.999 * radius;
                    assert!(times <= 1 && (times == 1 || !is_inside), "{center} {near} in {times} runs");
                }
            }
        }
    }
}
