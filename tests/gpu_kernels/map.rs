//! lane_counts, map_keys, map_starts, map_reorder and the sort between, through the host code that a render uses.

use crate::common::{kernel, map_info};
use crate::device_or_return;
use bytemuck::Zeroable;
use glam::Vec3;
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::packed::constants::row_bucket;
use joton::packed::layout::{Joton, MapInfo, PathState, status};
use joton::sampling::rng::{pcg4d, random4};

/// PathState.status of a lane that has traced all.
const DONE: u32 = 256;

/// What the lanes have stored, and where.
struct Given {
    lanes: Vec<PathState>,
    jotons: Vec<Joton>,
    info: MapInfo,
}

/// Lanes that store up to `capacity` jotons each, as `stored` says; jotons in cells exactly as `place` says.
fn given(
    lanes: u32,
    capacity: u32,
    key_bits: u32,
    stored: impl Fn(u32) -> u32,
    place: impl Fn(u32) -> Vec3,
) -> Given {
    let mut info = map_info();
    // powers of two: cells are exact
    info.cells_per_unit = 0.25;
    info.grid_origin = Vec3::new(-64.0, -64.0, -64.0);
    info.columns = 32;
    info.row_mask = (1 << (key_bits - 1)) - 1;
    info.lanes = lanes;
    info.lane_capacity = capacity;
    let lane = |i| PathState { stored: stored(i), status: DONE, ..PathState::zeroed() };
    let joton = |i: u32| Joton { position: place(i), wi: i, ..Joton::zeroed() };
    Given { lanes: (0..lanes).map(lane).collect(), jotons: (0..lanes * capacity).map(joton).collect(), info }
}

/// Positions all over the grid and a little outside.
fn anywhere(i: u32) -> Vec3 {
    let [x, y, z, _] = random4(1, 2, i, 3);
    (Vec3::new(x, y, z) - 0.5) * 136.0
}

fn bucket(info: &MapInfo, p: Vec3) -> u32 {
    let cell = ((p - info.grid_origin) * info.cells_per_unit).floor().as_ivec3();
    row_bucket(cell.y, cell.z, info.row_mask) + cell.x.clamp(0, info.columns as i32 - 1) as u32
}

/// Sort on the device; hold the jotons' order and the table of buckets against a stable sort. Returns the status words.
fn check(context: &Context, name: &str, g: &Given) -> Vec<u32> {
    let mut harness = Harness::new(context);
    harness.storage("lanes", &g.lanes);
    harness.storage("jotons", &g.jotons);
    harness.sort_map(&g.info).unwrap_or_else(|e| panic!("{name}: {e}"));
    let capacity = g.info.lane_capacity as usize;
    let mut wanted: Vec<(u32, Joton)> = g
        .lanes
        .iter()
        .enumerate()
        .flat_map(|(l, lane)| &g.jotons[l * capacity..l * capacity + (lane.stored as usize).min(capacity)])
        .map(|j| (bucket(&g.info, j.position), *j))
        .collect();
    wanted.sort_by_key(|w| w.0);
    let starts: Vec<u32> = harness.read("bucket_starts").unwrap_or_else(|e| panic!("{e}"));
    let buckets = g.info.row_mask + 1 + g.info.columns;
    for b in 0..=buckets {
        let first = wanted.partition_point(|w| w.0 < b) as u32;
        assert_eq!(starts[b as usize], first, "{name}: bucket {b}");
    }
    let sorted: Vec<[u32; 8]> = harness.read("sorted_jotons").unwrap_or_else(|e| panic!("{e}"));
    let expected: Vec<[u32; 8]> = wanted.iter().map(|w| bytemuck::cast(w.1)).collect();
    assert!(
        sorted[..expected.len()] == expected,
        "{name}: the jotons are not in bucket order, or not stable"
    );
    assert!(sorted[expected.len()..].iter().flatten().all(|&w| w == PATTERN), "{name}: written past the end");
    let totals: Vec<u32> = harness.read("lane_starts").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(totals[g.lanes.len()] as usize, expected.len(), "{name}");
    harness.read("status").unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn maps_of_any_size_are_sorted() {
    let context = device_or_return!();
    for lanes in [1, 63, 64, 65, 4095, 4096, 4097] {
        let g = given(lanes, 3, 16, |i| pcg4d([i, lanes, 0, 0])[0] % 4, anywhere);
        assert_eq!(check(context, &format!("{lanes} lanes"), &g), [0; status::SLOTS as usize]);
        let full = given(lanes, 1, 16, |_| 1, anywhere);
        assert_eq!(check(context, &format!("{lanes} full lanes"), &full), [0; status::SLOTS as usize]);
    }
}

#[test]
fn an_empty_map_is_empty() {
    let context = device_or_return!();
    for lanes in [1, 64, 4097] {
        check(context, "empty", &given(lanes, 3, 16, |_| 0, anywhere));
    }
}

#[test]
fn jotons_of_one_cell_keep_their_order() {
    let context = device_or_return!();
    let g = given(4097, 3, 16, |_| 3, |i| Vec3::new(17.0, 21.0, -33.0) + (i % 8) as f32 * 0.25);
    check(context, "one cell", &g);
}

/// Positions on the far faces of the grid belong to the cell beyond: the column is clamped into the row, the row is hashed.
#[test]
fn jotons_on_the_boundary_are_in_the_table() {
    let context = device_or_return!();
    let corner = |i: u32| {
        Vec3::new(if i & 1 == 0 { -64.0 } else { 64.0 }, if i & 2 == 0 { -64.0 } else { 64.0 }, 64.0)
    };
    check(context, "boundary", &given(65, 4, 16, |_| 4, corner));
}

/// Above 2^19 slots the keys have 20 bits: three digits, so that the sorted list ends in the other buffer.
#[test]
fn large_maps_have_three_digits() {
    let context = device_or_return!();
    let g = given(4097, 130, 20, |i| pcg4d([i, 9, 0, 0])[0] % 131, anywhere);
    assert!(u64::from(g.info.lanes) * u64::from(g.info.lane_capacity) > 1 << 19);
    assert_eq!(check(context, "three digits", &g), [0; status::SLOTS as usize]);
}

/// What a lane could not store, and lanes that are not done, are told and not read.
#[test]
fn overflow_is_reported() {
    let context = device_or_return!();
    let mut g = given(100, 3, 16, |i| i % 7, anywhere);
    for lane in g.lanes.iter_mut().step_by(10) {
        lane.status = 0;
    }
    let found = check(context, "overflow", &g);
    assert_eq!(found[status::LANE_STORED_MAX as usize], 6);
    assert_eq!(found[status::UNFINISHED as usize], 10);
}

/// A table past 65,535 workgroups is written to its last entry.
#[test]
fn starts_past_the_first_dimension_are_written() {
    let context = device_or_return!();
    let mut info = map_info();
    info.row_mask = (1 << 22) - 1;
    info.columns = 65;
    info.lanes = 1;
    let buckets = info.row_mask + 2 + info.columns;
    assert!(buckets > 65_535 * 64);
    let keys = [5, 5, 1 << 21, (1 << 22) + 64];
    let mut harness = Harness::new(context);
    harness.storage("lane_starts", &[0, keys.len() as u32]);
    harness.storage("keys", &keys);
    harness.storage("bucket_starts", &vec![PATTERN; buckets as usize]);
    let starts = kernel(context, "passes/map_starts.wgsl", "main", &[]);
    harness
        .run(&starts, &[], &[("map_info", bytemuck::bytes_of(&info))], Work::Invocations(buckets))
        .unwrap_or_else(|e| panic!("{e}"));
    let found: Vec<u32> = harness.read("bucket_starts").unwrap_or_else(|e| panic!("{e}"));
    let wrong =
        found.iter().zip(0u32..).position(|(&f, b)| f != keys.iter().filter(|&&k| k < b).count() as u32);
    assert_eq!(wrong, None);
}
