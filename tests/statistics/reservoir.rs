//! Reservoir: one of many by weight, in one look at each [E24], on both sides.

use crate::chi_square::{Claims, draws, p_value};
use crate::common::{Row, Snippet, device, row};
use joton::optics::lights::reservoir::Reservoir;

const COUNT: u32 = 1 << 17;
/// Bins across what is left of the number that chooses.
const LEFT_BINS: usize = 16;
/// The largest number that is drawn.
const LAST: f32 = 1.0 - 1.0 / 16_777_216.0;

/// Number of the one that is kept (all ones: none), what is left of the number that chose, and the sum of the weights.
type Kept = (u32, f32, f32);

fn on_host(weights: &[f32], u: f32) -> Kept {
    let mut reservoir = Reservoir::new(u);
    let mut kept = u32::MAX;
    for (i, &weight) in (0..).zip(weights) {
        if reservoir.takes(weight) {
            kept = i;
        }
    }
    (kept, reservoir.choice, reservoir.total)
}

/// None without a device.
fn on_device(weights: &[f32], numbers: &[f32]) -> Option<Vec<Kept>> {
    let context = device()?;
    let n = weights.len();
    let list = weights.iter().map(|w| format!("{w:?}")).collect::<Vec<_>>().join(", ");
    let code = format!(
        "var weights = array<f32, {n}>({list});
        var reservoir = Reservoir(0.0, in_f(0u).x);
        var kept = 0xffffffffu;
        for (var i = 0u; i < {n}u; i += 1u) {{ if takes(&reservoir, weights[i]) {{ kept = i; }} }}
        out_u(0u, vec4(kept, bitcast<u32>(reservoir.choice), bitcast<u32>(reservoir.total), 0u));"
    );
    let inputs: Vec<[Row; 1]> = numbers.iter().map(|&u| [row([u, 0.0, 0.0, 0.0])]).collect();
    let out: Vec<[Row; 1]> = Snippet::new(&["lights/reservoir.wgsl"], &code).run(context, &inputs);
    Some(out.iter().map(|[o]| (o[0], f32::from_bits(o[1]), f32::from_bits(o[2]))).collect())
}

/// The least part, 0.1 of 35, is still kept 23 times in each bin.
const WEIGHTS: [&[f32]; 6] = [
    &[2.0],
    &[1.0; 8],
    &[0.0, 3.0, 0.0, 1.0, 0.5, 0.0],
    &[0.1, 1.0, 30.0, 0.3],
    &[30.0, 1.0, 0.0, 0.1, 4.0],
    &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0],
];

/// Each is kept as often as its part of the weights says, one without weight never, and what is left of the number is
/// uniform in [0, 1), whatever is kept.
#[test]
fn one_is_kept_by_its_weight_and_the_number_stays_uniform() {
    let mut claims = Claims::default();
    for (k, weights) in (0..).zip(WEIGHTS) {
        let total: f64 = weights.iter().map(|w| f64::from(*w)).sum();
        let mut claim = |side: &str, kept: &[Kept]| {
            let mut counts = vec![0.0; weights.len() * LEFT_BINS];
            for &(i, left, sum) in kept {
                assert!(weights[i as usize] > 0.0, "{side}: number {i} of {weights:?} is kept");
                assert!((0.0..1.0).contains(&left), "{side}: {left} is left, {weights:?}");
                // eight additions
                assert!((f64::from(sum) / total - 1.0).abs() < 1e-6, "{side}: {weights:?} are {sum}");
                counts[i as usize * LEFT_BINS + (left * LEFT_BINS as f32) as usize] += 1.0;
            }
            let each = kept.len() as f64 / LEFT_BINS as f64;
            let expected: Vec<f64> =
                weights.iter().flat_map(|w| [each * f64::from(*w) / total; LEFT_BINS]).collect();
            claims.add(format!("{side}, {weights:?}"), p_value(&counts, &expected));
        };
        let numbers = |purpose| draws(purpose, COUNT).map(|u| u[0]).collect::<Vec<f32>>();
        let host: Vec<Kept> = numbers(50 + k).into_iter().map(|u| on_host(weights, u)).collect();
        claim("host", &host);
        if let Some(kept) = on_device(weights, &numbers(60 + k)) {
            claim("device", &kept);
        }
    }
    claims.hold();
}

/// The first and the last number that is drawn choose, too, and leave a number below one: here u − p and 1 − p round to the
/// same after the second, and the third is so much heavier that its part rounds to one.
#[test]
fn the_ends_of_the_interval_choose_too() {
    const HALF_STEP: f32 = 8_388_611.0;
    let weights = [33_554_432.0 - HALF_STEP - 1.0, HALF_STEP, 1e30];
    assert_eq!((weights[0] + weights[1], weights[1] / 33_554_432.0), (33_554_432.0, 0.250_000_1));
    let mut kept: Vec<Kept> = [0.0, LAST].map(|u| on_host(&weights, u)).to_vec();
    kept.extend(on_device(&weights, &[0.0, LAST]).into_iter().flatten());
    for (i, left, _) in kept {
        assert_eq!(i, 2, "{left} is left");
        assert!((0.0..1.0).contains(&left), "{left} is left");
    }
    // nothing to keep
    let none = on_device(&[0.0, 0.0], &[0.5]).into_iter().flatten().chain([on_host(&[0.0, 0.0], 0.5)]);
    assert!(none.into_iter().all(|kept| kept == (u32::MAX, 0.5, 0.0)));
}
