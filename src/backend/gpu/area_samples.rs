//! The area points' grid: scattered on the host, sorted into the same kind of hashed grid as the jotons.

use super::GpuBackend;
use super::device_buffers;
use super::scene_buffers::encode_area_point;
use crate::error::Result;
use crate::estimators::radii::area_group;
use crate::packed::layout::AreaPoint;
use crate::packed::{PackedScene, scatter_area_points};
use crate::plan::buffers::{AREA_KEY_BITS, AREA_STARTS, area_points, area_points_most, area_points_wanted};
use crate::plan::grid::Grid;
use crate::sampling::rng::purpose::STREAM_AREA;
use crate::sampling::rng::sequence_seed;
use glam::Vec3;
use std::ops::Range;

/// Area points in bucket order with the table of their grid.
pub(super) struct AreaGrid {
    /// The points.
    pub points: Vec<AreaPoint>,
    /// First point of each bucket, and one entry more.
    pub starts: Vec<u32>,
    /// Area of each point.
    pub each: f32,
    /// One over the width of a cell.
    pub cells_per_unit: f32,
    /// Hash mask of the rows.
    pub row_mask: u32,
    /// Columns of a row.
    pub columns: u32,
}

/// Scatter and sort about `count` points for discs of at most this radius.
pub(super) fn build(scene: &PackedScene, radius: f64, count: usize, seed: u32) -> AreaGrid {
    let (points, each) = scatter_area_points(scene, count, seed);
    let grid = Grid::new(scene.bounds, radius as f32, AREA_KEY_BITS);
    let Grid { cells_per_unit, row_mask, columns, .. } = grid;
    let mut starts = vec![0u32; AREA_STARTS];
    let keys: Vec<u32> = points.iter().map(|p| grid.bucket(p.position)).collect();
    for &k in &keys {
        starts[k as usize + 1] += 1;
    }
    for i in 1..starts.len() {
        starts[i] += starts[i - 1];
    }
    let mut next = starts.clone();
    let mut sorted = vec![AreaPoint { position: Vec3::ZERO, normal: 0 }; points.len()];
    for (p, &k) in points.iter().zip(&keys) {
        sorted[next[k as usize] as usize] = encode_area_point(p);
        next[k as usize] += 1;
    }
    AreaGrid { points: sorted, starts, each, cells_per_unit, row_mask, columns }
}

/// The area points that are on the device.
pub(super) struct AreaState {
    /// The passes that they are for.
    group: Range<u64>,
    pub(super) each: f32,
    pub(super) cells_per_unit: f32,
    pub(super) row_mask: u32,
    pub(super) columns: u32,
}

impl GpuBackend {
    /// Put on the device the area points of the group of passes that `pass` belongs to. They depend on the group and the
    /// seed, not on what was rendered before: passes stay independent.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where there is no memory for more points.
    pub(super) fn renew_area_points(&mut self, pass: u64) -> Result<()> {
        let group = area_group(pass);
        if self.area.as_ref().is_some_and(|a| a.group == group) {
            return Ok(());
        }
        // cells are as wide as the largest disc of the group, points as dense as its smallest wants them
        let [largest, smallest] = [group.start, group.end - 1].map(|pass| self.plan.diffuse.radius(pass));
        let most = area_points_most(self.plan.buffer_limit());
        let count = area_points_wanted(&self.scene, smallest, most);
        let seed = sequence_seed(self.plan.settings.seed, group.start as u32, STREAM_AREA);
        let grid = build(&self.scene, largest, count, seed);
        let bytes: &[u8] = bytemuck::cast_slice(&grid.points);
        if self.buffers["area_points"].size() < bytes.len() as u64 {
            let size = area_points(count, most).bytes;
            self.buffers.insert("area_points", device_buffers::storage(&self.context, "area_points", size)?);
            self.bind()?;
        }
        self.context.queue.write_buffer(&self.buffers["area_points"], 0, bytes);
        self.context.queue.write_buffer(&self.buffers["area_starts"], 0, bytemuck::cast_slice(&grid.starts));
        self.area = Some(AreaState {
            group,
            each: grid.each,
            cells_per_unit: grid.cells_per_unit,
            row_mask: grid.row_mask,
            columns: grid.columns,
        });
        Ok(())
    }
}
