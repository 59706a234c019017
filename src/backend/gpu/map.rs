//! A joton map on the device: traced by lanes, made dense, sorted by bucket, ready to gather from.

use super::context::Context;
use super::device_buffers::Buffers;
use super::kernel::{BoundKernel, Kernel};
use super::recorder::Recorder;
use crate::error::Result;
use crate::estimators::maps::MapKind;
use crate::estimators::radii::{Schedule, shrink};
use crate::packed::PackedScene;
use crate::packed::layout::{MapInfo, ScanInfo, SortInfo};
use crate::plan::buffers::SCAN_BLOCK;
use crate::plan::grid::Grid;
use crate::plan::map_layout::{DIGIT_BITS, DeviceLimits, MapLayout};
use crate::sampling::rng::seed_at;

/// Counters of a digit.
const DIGITS: u32 = 1 << DIGIT_BITS;
/// Pipelines that both maps share.
pub(super) struct MapKernels {
    lane_counts: Kernel,
    scan_reduce: Kernel,
    scan_spine: Kernel,
    scan_apply: Kernel,
    keys: Kernel,
    radix_count: Kernel,
    radix_scatter: Kernel,
    starts: Kernel,
    reorder: Kernel,
}

impl MapKernels {
    /// Compile them.
    ///
    /// # Errors
    /// [`Error::Device`] where a kernel does not compile.
    pub(super) fn new(context: &Context) -> Result<Self> {
        let kernel = |path: &str, entry: &str| Kernel::new(context, path, entry, &[]);
        Ok(Self {
            lane_counts: kernel("passes/lane_counts.wgsl", "main")?,
            scan_reduce: kernel("passes/scan.wgsl", "reduce")?,
            scan_spine: kernel("passes/scan.wgsl", "spine")?,
            scan_apply: kernel("passes/scan.wgsl", "apply")?,
            keys: kernel("passes/map_keys.wgsl", "main")?,
            radix_count: kernel("passes/radix.wgsl", "count")?,
            radix_scatter: kernel("passes/radix.wgsl", "scatter")?,
            starts: kernel("passes/map_starts.wgsl", "main")?,
            reorder: kernel("passes/map_reorder.wgsl", "main")?,
        })
    }

    /// All of them, in the order in which they are first dispatched.
    pub(super) fn in_order_of_use(&self) -> Vec<&Kernel> {
        vec![
            &self.lane_counts,
            &self.scan_reduce,
            &self.scan_spine,
            &self.scan_apply,
            &self.keys,
            &self.radix_count,
            &self.radix_scatter,
            &self.starts,
            &self.reorder,
        ]
    }
}

/// One map: how it is cut, and the steps that fill it.
pub(super) struct Map {
    /// Which.
    pub kind: MapKind,
    /// How it is cut into lanes.
    pub shape: MapLayout,
    machine: DeviceLimits,
    trace: BoundKernel,
    lane_counts: BoundKernel,
    lane_scan: [BoundKernel; 3],
    keys: BoundKernel,
    digits: Vec<Digit>,
    starts: BoundKernel,
    reorder: BoundKernel,
}

/// Steps of one digit of the sort.
struct Digit {
    count: BoundKernel,
    scan: [BoundKernel; 3],
    scatter: BoundKernel,
}

impl Map {
    /// Bind a map's steps to the buffers; `sorted_names` are those of the sorted jotons and of their buckets.
    ///
    /// # Errors
    /// [`Error::Device`] where a buffer is missing.
    pub(super) fn new(
        context: &Context,
        kind: MapKind,
        shape: MapLayout,
        trace: &Kernel,
        kernels: &MapKernels,
        sorted_names: &[(&str, &'static str); 2],
        buffers: &Buffers,
    ) -> Result<Self> {
        let [tallies, info, emitters, warps] = match kind {
            MapKind::Caustic => {
                ["tallies_caustic", "scene_info_caustic", "emitters_caustic", "warps_caustic"]
            }
            MapKind::Diffuse => {
                ["tallies_diffuse", "scene_info_diffuse", "emitters_diffuse", "warps_diffuse"]
            }
        };
        let names = [("tallies", tallies), ("scene_info", info), ("emitters", emitters), ("warps", warps)];
        let scan = |values: &'static str| -> Result<[BoundKernel; 3]> {
            let names = [("values", values)];
            Ok([
                kernels.scan_reduce.bind(context, buffers, &names)?,
                kernels.scan_spine.bind(context, buffers, &names)?,
                kernels.scan_apply.bind(context, buffers, &names)?,
            ])
        };
        let ends = [["keys_a", "places_a"], ["keys_b", "places_b"]];
        let mut digits = Vec::new();
        for digit in 0..shape.digits() {
            let (from, to) = (ends[digit as usize % 2], ends[(digit as usize + 1) % 2]);
            let names =
                [("keys_in", from[0]), ("places_in", from[1]), ("keys_out", to[0]), ("places_out", to[1])];
            digits.push(Digit {
                count: kernels.radix_count.bind(context, buffers, &names)?,
                scan: scan("histogram")?,
                scatter: kernels.radix_scatter.bind(context, buffers, &names)?,
            });
        }
        let sorted = ends[digits.len() % 2];
        Ok(Self {
            kind,
            shape,
            machine: context.machine(),
            trace: trace.bind(context, buffers, &names)?,
            lane_counts: kernels.lane_counts.bind(context, buffers, &[])?,
            lane_scan: scan("lane_starts")?,
            keys: kernels.keys.bind(context, buffers, &[("keys", "keys_a"), ("places", "places_a")])?,
            digits,
            starts: kernels.starts.bind(context, buffers, &[sorted_names[1], ("keys", sorted[0])])?,
            reorder: kernels.reorder.bind(context, buffers, &[sorted_names[0], ("places", sorted[1])])?,
        })
    }

    /// The uniform of a pass. `random_pass` addresses the random numbers, of `planned` jotons a pass, `pass` the radius.
    pub(super) fn info(
        &self,
        scene: &PackedScene,
        schedule: &Schedule,
        pass: u64,
        random_pass: u32,
        planned: u32,
        seed: u32,
    ) -> MapInfo {
        let first = self.shape.indices(random_pass, planned).start;
        let high = (first >> 32) as u32;
        let radius = schedule.radius(pass) as f32;
        let Grid { origin, cells_per_unit, row_mask, columns } =
            Grid::new(scene.bounds, radius, self.shape.key_bits());
        MapInfo {
            grid_origin: origin,
            cells_per_unit,
            radius,
            shrink: shrink(schedule.alpha, pass) as f32,
            row_mask,
            columns,
            emitted: self.shape.emitted,
            lanes: self.shape.lanes,
            lane_capacity: self.shape.lane_capacity,
            first_joton: first as u32,
            seed: seed_at(seed, high),
            pass_index: random_pass,
            area_each: 0.0,
            area_cells_per_unit: 0.0,
            area_row_mask: 0,
            area_columns: 0,
            cells_marked_per_unit: 0.0,
            seed_wrapped: seed_at(seed, high.wrapping_add(1)),
        }
    }

    /// Record tracing and sorting. The lanes must be cleared.
    pub(super) fn record(&self, recorder: &mut Recorder<'_>, pass_info: u32, info: &MapInfo) {
        let map_info = recorder.ring.push(info);
        let at = [("pass_info", pass_info), ("map_info", map_info)];
        for _ in 0..self.shape.dispatches {
            recorder.dispatch(&self.trace, &at, self.shape.lanes);
        }
        recorder.dispatch(&self.lane_counts, &at, self.shape.lanes + 1);
        record_scan(recorder, &self.lane_scan, self.shape.lanes + 1);
        recorder.dispatch(&self.keys, &at, self.shape.lanes);
        let (chunk, chunks) = (self.shape.chunk(&self.machine), self.shape.chunks(&self.machine));
        for (i, digit) in self.digits.iter().enumerate() {
            let sort_info = recorder.ring.push(&SortInfo {
                shift: i as u32 * DIGIT_BITS,
                chunk,
                chunks,
                total_at: self.shape.lanes,
            });
            let at = [("sort_info", sort_info)];
            recorder.dispatch(&digit.count, &at, chunks);
            record_scan(recorder, &digit.scan, DIGITS * chunks);
            recorder.dispatch(&digit.scatter, &at, chunks);
        }
        recorder.dispatch(&self.starts, &at, info.row_mask + 2 + info.columns);
        recorder.dispatch(&self.reorder, &at, self.shape.max_stored() as u32);
    }
}

/// Record an exclusive scan in place.
fn record_scan(recorder: &mut Recorder<'_>, steps: &[BoundKernel; 3], count: u32) {
    let blocks = count.div_ceil(SCAN_BLOCK);
    let scan_info = recorder.ring.push(&ScanInfo { count, block: SCAN_BLOCK, blocks, pad: 0 });
    let at = [("scan_info", scan_info)];
    recorder.dispatch(&steps[0], &at, blocks);
    recorder.dispatch_groups(&steps[1], &at, [1, 1]);
    recorder.dispatch(&steps[2], &at, blocks);
}
