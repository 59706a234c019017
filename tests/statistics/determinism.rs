//! Determinism: one seed and device give one image, bit for bit, whatever the threads, the order of the passes and the
//! batches they come in.

use crate::renders::{EVERYTHING, Side, file, open, plan};
use joton::backend::Batch;
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::render::{RenderState, Rendered, Stop};
use std::sync::Arc;

/// Passes beyond the first group of area points (16 passes).
const PASSES: u64 = 18;

fn scene() -> Arc<PackedScene> {
    Arc::new(PackedScene::new(&file("spheres.toml", 16)))
}

fn bits(batch: &Batch) -> Vec<u32> {
    batch.layers.iter().flatten().flatten().map(|x| x.to_bits()).collect()
}

/// Each pass alone, in this order.
fn singly(side: Side, scene: &Arc<PackedScene>, order: impl Iterator<Item = u64>) -> Vec<(u64, Batch)> {
    let mut backend = open(side, scene, plan(scene, EVERYTHING, 3));
    order.map(|p| (p, backend.render(p, 1).unwrap_or_else(|e| panic!("{e}")))).collect()
}

/// The sums of passes in f32, one after the other, as a batch takes them.
fn summed(passes: &[(u64, Batch)]) -> Batch {
    let mut sum = passes[0].1.clone();
    for (_, batch) in &passes[1..] {
        let more = batch.layers.iter().flatten().flatten();
        sum.layers.iter_mut().flatten().flatten().zip(more).for_each(|(s, x)| *s += x);
    }
    sum
}

/// Largest difference between two batches' emission, relative to the larger.
fn emission_apart(a: &Batch, b: &Batch) -> f32 {
    let emission = |batch: &Batch| batch.layers[Layer::Emission as usize].concat();
    let apart = |(a, b): (f32, f32)| (a - b).abs() / a.max(b).max(f32::MIN_POSITIVE);
    emission(a).into_iter().zip(emission(b)).map(apart).fold(0.0, f32::max)
}

fn sides() -> impl Iterator<Item = Side> {
    let device = crate::common::device().map(|_| Side::Device);
    [Side::Host, Side::PathTracer].into_iter().chain(device)
}

/// A pass has the same bits whatever was rendered before it, and each time it is rendered.
#[test]
fn passes_do_not_depend_on_what_came_before() {
    let scene = scene();
    for side in sides() {
        let forward = singly(side, &scene, 0..PASSES);
        // every pass, out of order, from the last group on, and some once more
        let jumping = singly(side, &scene, (1..=PASSES).map(|i| (i * 7 + 10) % PASSES).chain([5, 5, 0]));
        assert_ne!(bits(&forward[0].1), bits(&forward[1].1), "{side:?}: passes differ");
        for (pass, batch) in &jumping {
            let (_, first) = &forward[*pass as usize];
            assert!(bits(batch) == bits(first), "{side:?}: pass {pass} has other bits");
            assert_eq!(batch.tally, first.tally, "{side:?}: pass {pass}");
        }
    }
}

/// A batch is the sum of its passes, one after the other in f32: bit for bit, however the passes are split. Only emission
/// on the device, where an eye path's and the trees' are added apart, rounds otherwise.
#[test]
fn batches_are_sums_of_passes() {
    let scene = scene();
    for side in sides() {
        let passes = singly(side, &scene, 0..PASSES);
        let mut backend = open(side, &scene, plan(&scene, EVERYTHING, 3));
        for (first, count) in [(0usize, 5usize), (5, 1), (6, 12), (0, 18)] {
            let mut batch = backend.render(first as u64, count as u32).unwrap_or_else(|e| panic!("{e}"));
            let mut wanted = summed(&passes[first..first + count]);
            if side == Side::Device {
                // two roundings a pass instead of one
                let apart = emission_apart(&batch, &wanted);
                assert!(apart <= count as f32 * f32::EPSILON, "passes {first} on: emission is {apart} off");
                for b in [&mut batch, &mut wanted] {
                    b.layers[Layer::Emission as usize].clear();
                }
            }
            assert!(bits(&batch) == bits(&wanted), "{side:?}: passes {first} to {}", first + count);
        }
    }
}

/// One thread, a few, more than there are processors: the same bits.
#[test]
fn threads_do_not_change_a_bit() {
    let scene = scene();
    for side in [Side::Host, Side::PathTracer] {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let render = || open(side, &scene, plan(&scene, EVERYTHING, 3)).render(0, 3);
            pool.install(render).unwrap_or_else(|e| panic!("{e}"))
        };
        let one = on(1);
        for threads in [2, 3, 7, 16] {
            let more = on(threads);
            assert!(bits(&one) == bits(&more), "{side:?}: {threads} threads");
            assert_eq!(one.tally, more.tally, "{side:?}: {threads} threads");
        }
    }
}

/// All that a render needs to go on is in its state: written down after 8 passes, read back and continued on a device that is
/// opened anew, it has the bits of one that was never interrupted.
#[test]
fn a_state_that_is_written_down_goes_on_bit_for_bit() {
    let scene = scene();
    let until = |passes| Stop { passes: Some(passes), ..Stop::default() };
    for side in sides() {
        let go_on = |state: &mut RenderState, passes| {
            let mut backend = open(side, &scene, plan(&scene, EVERYTHING, 3));
            state.go_on(backend.as_mut(), until(passes), |_| true).unwrap_or_else(|e| panic!("{side:?}: {e}"))
        };
        let mut whole = RenderState::new(scene.size);
        let mut first = RenderState::new(scene.size);
        go_on(&mut whole, PASSES);
        go_on(&mut first, 8);
        let written = postcard::to_stdvec(&first).expect("a state can be written");
        let mut second: RenderState = postcard::from_bytes(&written).expect("and read");
        let reason = go_on(&mut second, PASSES);
        let (whole, second) = (whole.finish(reason), second.finish(reason));
        assert_eq!((second.passes, second.tally), (PASSES, whole.tally), "{side:?}");
        let bits = |rendered: &Rendered| -> Vec<u32> {
            rendered.picture.whole.pixels.iter().flatten().map(|x| x.to_bits()).collect()
        };
        assert!(bits(&second) == bits(&whole), "{side:?}");
        assert_eq!(second.error_estimate, whole.error_estimate, "{side:?}");
    }
}
