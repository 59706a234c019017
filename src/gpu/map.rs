//! A joton map on the device: traced by lanes, made dense, sorted by bucket, ready to gather from.

use super::context::Context;
use super::kernel::{Buffers, Kernel, Step};
use super::recorder::Recorder;
use crate::error::{Error, Result};
use crate::layout::{CELLS_PER_RADIUS, Joton, Lane, LaneTally, MapInfo};
use crate::pack::PackedScene;
use crate::plan::Schedule;
use bytemuck::{Pod, Zeroable};

/// Uniform of the scan kernels.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ScanInfo {
    count: u32,
    block: u32,
    blocks: u32,
    pad: u32,
}

/// Uniform of the radix kernels.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct SortInfo {
    shift: u32,
    chunk: u32,
    chunks: u32,
    total_at: u32,
}

/// Items that one invocation of a scan adds up.
const SCAN_BLOCK: u32 = 256;
/// Bits of a radix digit.
const DIGIT_BITS: u32 = 8;
/// Counters of a digit.
const DIGITS: u32 = 1 << DIGIT_BITS;
/// Jotons up to which keys have 16 bits; beyond they have 20.
const SMALL_MAP: u64 = 1 << 19;
/// A cell is never narrower than this part of the scene: columns fit the table.
const COLUMNS_MAX: f32 = 30_000.0;

/// Which of the two maps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// L S+ D.
    Caustic,
    /// Everything that met a D before.
    Diffuse,
}

/// How a map's emission is cut into lanes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Shape {
    /// Jotons emitted a pass.
    pub emitted: u32,
    /// Invocations that trace them.
    pub lanes: u32,
    /// Jotons that a lane can store.
    pub lane_capacity: u32,
    /// Dispatches of the trace kernel in a pass.
    pub dispatches: u32,
}

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
            lane_counts: kernel("lane_counts.wgsl", "main")?,
            scan_reduce: kernel("scan.wgsl", "reduce")?,
            scan_spine: kernel("scan.wgsl", "spine")?,
            scan_apply: kernel("scan.wgsl", "apply")?,
            keys: kernel("map_keys.wgsl", "main")?,
            radix_count: kernel("radix.wgsl", "count")?,
            radix_scatter: kernel("radix.wgsl", "scatter")?,
            starts: kernel("map_starts.wgsl", "main")?,
            reorder: kernel("map_reorder.wgsl", "main")?,
        })
    }
}

impl MapKernels {
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

/// One map: its buffers' names, sizes and the steps that fill it.
pub(super) struct Map {
    /// Which.
    pub kind: Kind,
    /// How it is cut into lanes.
    pub shape: Shape,
    key_bits: u32,
    chunk: u32,
    trace: Step,
    lane_counts: Step,
    lane_scan: [Step; 3],
    keys: Step,
    digits: Vec<Digit>,
    starts: Step,
    reorder: Step,
}

/// Steps of one digit of the sort.
struct Digit {
    count: Step,
    scan: [Step; 3],
    scatter: Step,
}

/// Buffers that a map needs, by name; the two maps take turns on all but the tallies.
pub(super) fn buffer_sizes(shapes: &[Shape], is_software: bool) -> Vec<(&'static str, u64)> {
    let most = |f: &dyn Fn(&Shape) -> u64| shapes.iter().map(f).max().unwrap_or(1).max(1);
    let stored = most(&|s| s.max_stored());
    let histogram = most(&|s| u64::from(DIGITS * s.chunks(is_software)));
    let scanned = histogram.max(most(&|s| u64::from(s.lanes) + 1));
    vec![
        ("lanes", most(&|s| u64::from(s.lanes)) * size_of::<Lane>() as u64),
        ("tallies_caustic", most(&|s| u64::from(s.lanes)) * size_of::<LaneTally>() as u64),
        ("tallies_diffuse", most(&|s| u64::from(s.lanes)) * size_of::<LaneTally>() as u64),
        ("lane_starts", (most(&|s| u64::from(s.lanes)) + 1) * 4),
        ("jotons", stored * size_of::<Joton>() as u64),
        ("sorted_jotons", stored * size_of::<Joton>() as u64),
        ("keys_a", stored * 4),
        ("keys_b", stored * 4),
        ("places_a", stored * 4),
        ("places_b", stored * 4),
        ("histogram", histogram * 4),
        ("block_sums", scanned.div_ceil(u64::from(SCAN_BLOCK)) * 4),
        ("bucket_starts", most(&|s| bucket_table(s.key_bits())) * 4),
    ]
}

/// Entries of the bucket table: rows, columns and one more.
fn bucket_table(key_bits: u32) -> u64 {
    (1 << key_bits) + 2
}

impl Shape {
    /// Most jotons that are stored in a pass.
    pub(super) fn max_stored(&self) -> u64 {
        u64::from(self.lanes) * u64::from(self.lane_capacity)
    }

    fn key_bits(&self) -> u32 {
        if self.max_stored() <= SMALL_MAP { 16 } else { 20 }
    }

    /// Items that one invocation of the sort takes: long where lanes are few, short where a GPU has thousands.
    fn chunk(&self, is_software: bool) -> u32 {
        if is_software { 2048 } else { (self.max_stored() / 4096).clamp(64, 2048) as u32 }
    }

    fn chunks(&self, is_software: bool) -> u32 {
        self.max_stored().div_ceil(u64::from(self.chunk(is_software))) as u32
    }
}

impl Map {
    /// Bind a map's steps to the buffers.
    ///
    /// # Errors
    /// [`Error::Device`] where a buffer is missing.
    pub(super) fn new(
        context: &Context,
        kind: Kind,
        shape: Shape,
        trace: &Kernel,
        kernels: &MapKernels,
        buffers: &Buffers,
    ) -> Result<Self> {
        let [tallies, emitters, warps] = match kind {
            Kind::Caustic => ["tallies_caustic", "emitters_caustic", "warps_caustic"],
            Kind::Diffuse => ["tallies_diffuse", "emitters_diffuse", "warps_diffuse"],
        };
        let names = [("tallies", tallies), ("emitters", emitters), ("warps", warps)];
        let scan = |values: &'static str| -> Result<[Step; 3]> {
            let names = [("values", values)];
            Ok([
                kernels.scan_reduce.bind(context, buffers, &names)?,
                kernels.scan_spine.bind(context, buffers, &names)?,
                kernels.scan_apply.bind(context, buffers, &names)?,
            ])
        };
        let key_bits = shape.key_bits();
        let ends = [["keys_a", "places_a"], ["keys_b", "places_b"]];
        let mut digits = Vec::new();
        for digit in 0..key_bits.div_ceil(DIGIT_BITS) {
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
            key_bits,
            chunk: shape.chunk(context.is_software()),
            trace: trace.bind(context, buffers, &names)?,
            lane_counts: kernels.lane_counts.bind(context, buffers, &[])?,
            lane_scan: scan("lane_starts")?,
            keys: kernels.keys.bind(context, buffers, &[("keys", "keys_a"), ("places", "places_a")])?,
            digits,
            starts: kernels.starts.bind(context, buffers, &[("keys", sorted[0])])?,
            reorder: kernels.reorder.bind(context, buffers, &[("places", sorted[1])])?,
        })
    }

    /// The uniform of a pass. `random_pass` addresses the random numbers, `pass` the radius.
    pub(super) fn info(
        &self,
        scene: &PackedScene,
        schedule: &Schedule,
        pass: u64,
        random_pass: u32,
    ) -> MapInfo {
        let radius = schedule.radius(pass) as f32;
        let extent = scene.bounds[1] - scene.bounds[0];
        let cells_per_unit = (CELLS_PER_RADIUS / radius).min(COLUMNS_MAX / extent.max_element());
        let columns = (extent.x * cells_per_unit) as u32 + 1;
        let rows = (1u32 << self.key_bits) - columns;
        // the largest power of two that leaves room for the columns
        let row_mask = (1u32 << rows.ilog2()) - 1;
        MapInfo {
            grid_origin: scene.bounds[0],
            cells_per_unit,
            radius,
            shrink: crate::plan::shrink(schedule.alpha, pass) as f32,
            row_mask,
            columns,
            emitted: self.shape.emitted,
            lanes: self.shape.lanes,
            lane_capacity: self.shape.lane_capacity,
            first_joton: random_pass.wrapping_mul(self.shape.emitted),
            pass_index: random_pass,
            chunks: 0,
            area_each: 0.0,
            area_cells_per_unit: 0.0,
            area_row_mask: 0,
            area_columns: 0,
            marks_per_unit: 0.0,
            pad: 0,
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
        let chunks = self.shape.max_stored().div_ceil(u64::from(self.chunk)) as u32;
        for (i, digit) in self.digits.iter().enumerate() {
            let sort_info = recorder.ring.push(&SortInfo {
                shift: i as u32 * DIGIT_BITS,
                chunk: self.chunk,
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
fn record_scan(recorder: &mut Recorder<'_>, steps: &[Step; 3], count: u32) {
    let blocks = count.div_ceil(SCAN_BLOCK);
    let scan_info = recorder.ring.push(&ScanInfo { count, block: SCAN_BLOCK, blocks, pad: 0 });
    let at = [("scan_info", scan_info)];
    recorder.dispatch(&steps[0], &at, blocks);
    recorder.dispatch_groups(&steps[1], &at, [1, 1]);
    recorder.dispatch(&steps[2], &at, blocks);
}

/// Check that a map fits the device.
///
/// # Errors
/// [`Error::Capacity`] naming the buffer.
pub(super) fn check_capacity(context: &Context, sizes: &[(&'static str, u64)]) -> Result<()> {
    let limit = context.limits.max_storage_buffer_binding_size.min(context.limits.max_buffer_size);
    for &(buffer, need) in sizes {
        if need > limit {
            let remedy = "render a smaller image (--size) or use --device cpu".to_string();
            return Err(Error::Capacity { buffer, need, limit, remedy });
        }
    }
    Ok(())
}
