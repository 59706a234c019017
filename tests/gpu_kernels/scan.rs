//! scan.wgsl: exclusive prefix sums at the edges of blocks, workgroups and dispatches.

use crate::common::kernel;
use crate::device_or_return;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::sampling::rng::pcg4d;

/// As src/backend/gpu/map.rs has it.
const BLOCK: u32 = 256;
/// One more than one dimension of a dispatch holds, in workgroups of 64.
const FOLDED: u32 = 65_535 * 64 + 65;

fn values(count: u32) -> Vec<u32> {
    (0..count).map(|i| pcg4d([i, 1, 2, 3])[0] % 100).collect()
}

fn exclusive(values: &[u32]) -> Vec<u32> {
    values
        .iter()
        .scan(0u32, |sum, v| {
            let before = *sum;
            *sum = sum.wrapping_add(*v);
            Some(before)
        })
        .collect()
}

#[test]
fn sums_are_exclusive_prefix_sums() {
    let context = device_or_return!();
    let [reduce, spine, apply] =
        ["reduce", "spine", "apply"].map(|e| kernel(context, "passes/scan.wgsl", e, &[]));
    for block in [1, 7, BLOCK] {
        for count in [0u32, 1, 63, 64, 65, 255, 256, 257, 4095, 4096, 4097, 65_536, 70_001] {
            let blocks = count.div_ceil(block);
            // one invocation walks the sums of all blocks; drivers may end its loop at 65,535
            if blocks > 60_000 {
                continue;
            }
            let given = values(count);
            let guard = [PATTERN; 3];
            let mut harness = Harness::new(context);
            harness.storage("values", &[&given[..], &guard].concat());
            harness.storage("block_sums", &vec![PATTERN; blocks as usize + 1]);
            let info = [count, block, blocks, 0];
            let at: [(&str, &[u8]); 1] = [("scan_info", bytemuck::cast_slice(&info))];
            for (k, work) in [
                (&reduce, Work::Invocations(blocks)),
                (&spine, Work::Groups([1, 1])),
                (&apply, Work::Invocations(blocks)),
            ] {
                harness.run(k, &[], &at, work).unwrap_or_else(|e| panic!("{e}"));
            }
            let found: Vec<u32> = harness.read("values").unwrap_or_else(|e| panic!("{e}"));
            let (sums, after) = found.split_at(count as usize);
            assert!(sums == exclusive(&given), "{count} values in blocks of {block}");
            assert_eq!(after, guard, "{count} values in blocks of {block}: written past the end");
        }
    }
}

/// Blocks of one value past 65,535 workgroups: both steps that run wide reach every block.
#[test]
fn blocks_past_the_first_dimension_are_summed() {
    let context = device_or_return!();
    let given = values(FOLDED);
    let info = [FOLDED, 1, FOLDED, 0];
    let at: [(&str, &[u8]); 1] = [("scan_info", bytemuck::cast_slice(&info))];
    let mut harness = Harness::new(context);
    harness.storage("values", &given);
    harness.storage("block_sums", &vec![PATTERN; FOLDED as usize]);
    let reduce = kernel(context, "passes/scan.wgsl", "reduce", &[]);
    harness.run(&reduce, &[], &at, Work::Invocations(FOLDED)).unwrap_or_else(|e| panic!("{e}"));
    let sums: Vec<u32> = harness.read("block_sums").unwrap_or_else(|e| panic!("{e}"));
    assert!(sums == given, "sums of blocks of one are the values");
    let apply = kernel(context, "passes/scan.wgsl", "apply", &[]);
    let starts = exclusive(&given);
    harness.storage("block_sums", &starts);
    harness.run(&apply, &[], &at, Work::Invocations(FOLDED)).unwrap_or_else(|e| panic!("{e}"));
    let found: Vec<u32> = harness.read("values").unwrap_or_else(|e| panic!("{e}"));
    assert!(found == starts, "values of blocks of one are the blocks' starts");
}
