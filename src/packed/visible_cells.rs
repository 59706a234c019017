//! Visible cells: the cells of space near which the camera looks, as bits that both backends read.

use glam::{IVec3, Vec3};

/// Bits of the table. Cells are hashed to it: where two share a bit, one is marked needlessly.
const VISIBLE_CELL_BITS: u32 = 1 << 18;
/// Words of the table.
pub const VISIBLE_CELL_WORDS: usize = VISIBLE_CELL_BITS as usize / 32;
/// Factors of the hash (Teschner et al. 2003).
pub const VISIBLE_CELL_FACTORS: [u32; 3] = [73_856_093, 19_349_663, 83_492_791];

/// Cells near which gather points lie.
#[derive(Debug, Clone, PartialEq)]
pub struct VisibleCells {
    /// Lower corner of the grid.
    origin: Vec3,
    /// One over the width of a cell.
    pub per_unit: f32,
    words: Vec<u32>,
}

impl VisibleCells {
    /// Mark the cells about `points`, and their neighbours: everything within `width` of a point.
    pub fn new(origin: Vec3, width: f32, points: impl Iterator<Item = Vec3>) -> Self {
        let mut visible_cells = Self { origin, per_unit: 1.0 / width, words: vec![0; VISIBLE_CELL_WORDS] };
        for p in points {
            let cell = visible_cells.cell(p);
            for i in 0..27 {
                let bit = bit(cell + IVec3::new(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1));
                visible_cells.words[bit as usize / 32] |= 1 << (bit % 32);
            }
        }
        visible_cells
    }

    /// True for every place near a point, and by chance for some others.
    pub fn holds(&self, p: Vec3) -> bool {
        let bit = bit(self.cell(p));
        self.words[bit as usize / 32] >> (bit % 32) & 1 == 1
    }

    /// The bits.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    fn cell(&self, p: Vec3) -> IVec3 {
        ((p - self.origin) * self.per_unit).floor().as_ivec3()
    }
}

/// Bit of a cell. Twin: shaders/maps/visible_cells.wgsl.
fn bit(cell: IVec3) -> u32 {
    let [x, y, z] = cell.to_array().map(|c| c as u32);
    let [fx, fy, fz] = VISIBLE_CELL_FACTORS;
    (x.wrapping_mul(fx) ^ y.wrapping_mul(fy) ^ z.wrapping_mul(fz)) & (VISIBLE_CELL_BITS - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All that is near a point is marked, and hardly anything that is far.
    #[test]
    fn what_is_near_is_marked() {
        let points: Vec<Vec3> = (0..100).map(|i| Vec3::new(i as f32, 10.0, 0.5 * i as f32)).collect();
        let visible_cells = VisibleCells::new(Vec3::new(-100.0, -50.0, -100.0), 2.0, points.iter().copied());
        let at = |i: u32| Vec3::from_slice(&crate::sampling::rng::random4(1, 0, i, 0)[..3]);
        let (mut near, mut far) = (0, 0);
        for (i, p) in (0..10_000).map(|i| (i, points[i % 100])) {
            assert!(visible_cells.holds(p + (at(i as u32) * 2.0 - 1.0) * 2.0), "near {p}");
            near += 1;
            far += u32::from(visible_cells.holds(at(i as u32) * 90.0 + Vec3::new(0.0, 20.0, 0.0)));
        }
        assert!(near == 10_000 && far < 100, "{far}");
    }
}
