//! lights/pick.wgsl and lights/spot.wgsl: picking over the edges of the table, and the spot's falloff.

use crate::common::{Row, Snippet, floats, random, row};
use crate::device_or_return;
use joton::backend::gpu::harness::Harness;
use joton::packed::PackedEmitter;

const BELOW_ONE: f32 = 1.0 - 1.0 / 16_777_216.0;

/// A table as src/packed/emitters.rs makes it: sums in f64, picks as differences of the rounded sums.
fn table(weights: &[f64]) -> Vec<PackedEmitter> {
    let total: f64 = weights.iter().sum();
    let (mut before, mut running) = (0.0f32, 0.0f64);
    let mut all: Vec<PackedEmitter> = weights
        .iter()
        .map(|w| {
            running += w / total;
            let cumulative = running as f32;
            let pick = cumulative - before;
            before = cumulative;
            PackedEmitter { cumulative, pick, ..bytemuck::Zeroable::zeroed() }
        })
        .collect();
    if let Some(last) = all.last_mut() {
        last.pick += 1.0 - last.cumulative;
        last.cumulative = 1.0;
    }
    all
}

fn check(weights: &[f64]) {
    let context = device_or_return!();
    let emitters = table(weights);
    let mut numbers = vec![0.0f32, f32::MIN_POSITIVE, 1.0 / 16_777_216.0, 0.5, BELOW_ONE];
    for e in emitters.iter().step_by(emitters.len().div_ceil(500)) {
        let c = e.cumulative;
        numbers.extend([c.next_down(), c, c.next_up()].map(|u| u.clamp(0.0, BELOW_ONE)));
    }
    numbers.extend((0..2000).map(|i| random(30, i)[0]));
    let inputs: Vec<[Row; 1]> = numbers.iter().map(|&u| [row([u, 0.0, 0.0, 0.0])]).collect();
    let code = format!(
        "let p = pick_emitter(in_f(0u).x, {}u); out_u(0u, vec4(p.emitter, bitcast<u32>(p.rest), 0u, 0u));",
        emitters.len()
    );
    let snippet = Snippet {
        imports: &["lights/pick.wgsl", "lights/spot.wgsl"],
        declarations: "",
        code: &code,
        overrides: &[],
    };
    let mut harness = Harness::new(context);
    harness.scene("emitters", &emitters);
    let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &[], &inputs);
    for (&u, [o]) in numbers.iter().zip(out) {
        let i = o[0] as usize;
        let rest = f32::from_bits(o[1]);
        let wanted = emitters.iter().position(|e| u < e.cumulative).unwrap_or(emitters.len() - 1);
        assert_eq!(i, wanted, "u = {u:?} of {} emitters", emitters.len());
        assert!(emitters[i].pick > 0.0, "u = {u:?} picked an emitter without light");
        assert!((0.0..1.0).contains(&rest), "u = {u:?}: rest {rest:?}");
        let before = f64::from(emitters[i].cumulative) - f64::from(emitters[i].pick);
        let place = (f64::from(u) - before) / f64::from(emitters[i].pick);
        // what u has below its emitter's share of 2^-24 is lost
        let tolerance = 1e-6 + 2.0 / 16_777_216.0 / f64::from(emitters[i].pick);
        assert!((f64::from(rest) - place).abs() < tolerance, "u = {u:?}: rest {rest} against {place}");
    }
}

#[test]
fn one_emitter_is_always_picked() {
    check(&[3.0]);
}

#[test]
fn emitters_without_light_are_never_picked() {
    check(&[0.0, 1.0, 0.0, 0.0, 2.0, 0.0]);
    check(&[1.0, 0.0]);
}

#[test]
fn shares_of_all_sizes_are_kept() {
    check(&[1.0, 1.0]);
    check(&[1e-9, 1.0, 1e-3, 1e5, 1e-9]);
    check(&(1..1000).map(|i| f64::from(i % 17) + 0.1).collect::<Vec<_>>());
}

/// A million: shares of 1e-6 are a few steps of f32 near one, and the sums must not drift.
#[test]
fn a_million_emitters_are_picked_evenly() {
    check(&(0..1_000_000).map(|i| 1.0 + f64::from(i % 3)).collect::<Vec<_>>());
}

#[test]
fn spots_fall_off_as_a_smoothstep() {
    let context = device_or_return!();
    let mut inputs: Vec<[Row; 1]> = Vec::new();
    // 1 − cos; the last are those of .01° and .001°
    for (inner, outer) in
        [(0.1f32, 0.2f32), (0.01, 0.5), (0.2, 0.2), (0.0, 1.0), (1e-8, 1.5e-8), (1e-10, 1.5e-10)]
    {
        let edges = [outer, 1.001 * outer, inner, 0.999 * inner, 0.0, 2.0, 0.5 * (inner + outer)];
        let all = edges.into_iter().chain((0..300).map(|i| random(31, i)[0] * (2.0 * outer).min(2.0)));
        inputs.extend(all.map(|at| [row([at, inner, outer, 0.0])]));
    }
    let code = "let i = in_f(0u); out_f(0u, vec4(spot_falloff(i.x, i.y, i.z), 0.0, 0.0, 0.0));";
    let snippet = Snippet {
        imports: &["lights/pick.wgsl", "lights/spot.wgsl"],
        declarations: "",
        code,
        overrides: &[],
    };
    let mut harness = Harness::new(context);
    harness.scene("emitters", &table(&[1.0]));
    let out: Vec<[Row; 1]> = snippet.run_in(context, &mut harness, &[], &inputs);
    for ([i], [o]) in inputs.iter().zip(out) {
        let [at, inner, outer, _] = floats(*i).map(f64::from);
        let x = ((outer - at) / (outer - inner).max(1e-30)).clamp(0.0, 1.0);
        let want = if at <= inner { 1.0 } else { x * x * (3.0 - 2.0 * x) };
        let got = f64::from(floats(o)[0]);
        assert!((got - want).abs() < 1e-5, "1 − cos {at} between {inner} and {outer}: {got} for {want}");
        if at >= outer && outer > inner {
            assert_eq!(got, 0.0);
        }
        if at <= inner {
            assert_eq!(got, 1.0);
        }
    }
}
