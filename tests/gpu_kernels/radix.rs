//! radix.wgsl: one digit of a stable sort.

use crate::common::kernel;
use crate::device_or_return;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::sampling::rng::pcg4d;

const DIGITS: u32 = 256;
const SIZES: [u32; 11] = [0, 1, 63, 64, 65, 127, 4095, 4096, 4097, 8191, 10_000];

/// Sort by one digit on the device, the scan between done here; (keys, places).
fn sort_digit(
    context: &joton::backend::gpu::Context,
    keys: &[u32],
    shift: u32,
    chunk: u32,
) -> (Vec<u32>, Vec<u32>) {
    let [count, scatter] = ["count", "scatter"].map(|e| kernel(context, "passes/radix.wgsl", e, &[]));
    let n = keys.len() as u32;
    // more chunks than needed, as a map has that is not full
    let chunks = n.div_ceil(chunk) + 2;
    let mut harness = Harness::new(context);
    harness.storage("lane_starts", &[7, 7, n]);
    harness.storage("keys_in", &[keys, &[PATTERN; 5]].concat());
    harness.storage("places_in", &(0..n + 5).collect::<Vec<_>>());
    harness.storage("histogram", &vec![PATTERN; (DIGITS * chunks) as usize]);
    harness.storage("keys_out", &vec![PATTERN; keys.len() + 5]);
    harness.storage("places_out", &vec![PATTERN; keys.len() + 5]);
    let info = [shift, chunk, chunks, 2];
    let at: [(&str, &[u8]); 1] = [("sort_info", bytemuck::cast_slice(&info))];
    harness.run(&count, &[], &at, Work::Invocations(chunks)).unwrap_or_else(|e| panic!("{e}"));
    let histogram: Vec<u32> = harness.read("histogram").unwrap_or_else(|e| panic!("{e}"));
    for (i, &found) in histogram.iter().enumerate() {
        let (digit, column) = (i as u32 / chunks, i as u32 % chunks);
        let of = keys.chunks(chunk as usize).nth(column as usize).unwrap_or(&[]);
        let wanted = of.iter().filter(|&&k| (k >> shift) % DIGITS == digit).count() as u32;
        assert_eq!(found, wanted, "digit {digit} of chunk {column}, {n} keys");
    }
    let mut next = 0;
    let starts: Vec<u32> = histogram
        .iter()
        .map(|h| {
            next += h;
            next - h
        })
        .collect();
    harness.storage("histogram", &starts);
    harness.run(&scatter, &[], &at, Work::Invocations(chunks)).unwrap_or_else(|e| panic!("{e}"));
    let read = |name| -> Vec<u32> {
        let mut all: Vec<u32> = harness.read(name).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(all.split_off(keys.len()), [PATTERN; 5], "{name}: written past the end");
        all
    };
    (read("keys_out"), read("places_out"))
}

/// Keys come in the order of their digit, equal digits in the order in which they were: places say so.
fn check(context: &joton::backend::gpu::Context, keys: &[u32], shift: u32, chunk: u32) {
    let (sorted, places) = sort_digit(context, keys, shift, chunk);
    let mut wanted: Vec<(u32, u32)> = keys.iter().copied().zip(0..).collect();
    wanted.sort_by_key(|(k, _)| (k >> shift) % DIGITS);
    let (wanted_keys, wanted_places): (Vec<u32>, Vec<u32>) = wanted.into_iter().unzip();
    assert!(sorted == wanted_keys, "{} keys, shift {shift}, chunk {chunk}", keys.len());
    assert!(places == wanted_places, "not stable: {} keys, shift {shift}, chunk {chunk}", keys.len());
}

#[test]
fn a_digit_is_sorted_and_equals_keep_their_order() {
    let context = device_or_return!();
    for n in SIZES {
        let keys: Vec<u32> = (0..n).map(|i| pcg4d([i, n, 4, 5])[0]).collect();
        for (shift, chunk) in [(0, 64), (8, 2048), (16, 17)] {
            check(context, &keys, shift, chunk);
        }
    }
}

#[test]
fn equal_keys_stay_where_they_are() {
    let context = device_or_return!();
    for key in [0, 0xff, 0xab_cdef, u32::MAX] {
        check(context, &vec![key; 4097], 8, 64);
    }
}
