//! sampling/rng.wgsl against src/sampling/rng.rs: integers and 24-bit fractions, so equal bit for bit.

use crate::common::{Row, Snippet, floats};
use crate::device_or_return;
use joton::sampling::rng;

const IMPORTS: &[&str] = &["sampling/rng.wgsl"];

/// Random words and the words at which carries, shifts and roundings change.
fn words(count: usize) -> Vec<[Row; 1]> {
    let edges = [0, 1, 2, 0xff, 0x100, 0xffff, 0x10000, 0x7fff_ffff, 0x8000_0000, 0xffff_fffe, u32::MAX];
    let mut inputs: Vec<[Row; 1]> = Vec::new();
    for a in edges {
        for b in edges {
            inputs.push([[a, b, b, a]]);
            inputs.push([[b, 0, a, u32::MAX]]);
        }
    }
    let random = (0..count as u32).map(|i| [rng::pcg4d([i, 11, 22, 33])]);
    inputs.extend(random);
    inputs
}

#[test]
fn pcg4d_is_rusts() {
    let context = device_or_return!();
    let inputs = words(4096);
    let out: Vec<[Row; 1]> = Snippet::new(IMPORTS, "out_u(0u, pcg4d(in_u(0u)));").run(context, &inputs);
    for ([i], [o]) in inputs.iter().zip(out) {
        assert_eq!(o, rng::pcg4d(*i), "{i:x?}");
    }
}

#[test]
fn integer_mappings_are_rusts() {
    let context = device_or_return!();
    let inputs = words(4096);
    let code = "let i = in_u(0u);
        out_u(0u, vec4(owen(i.x, i.y), sobol_second(i.x), sequence_seed(i.x, i.y, i.z), bitcast<u32>(unit(i.x))));";
    let out: Vec<[Row; 1]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([i], [o]) in inputs.iter().zip(out) {
        let expected = [
            rng::owen(i[0], i[1]),
            rng::sobol_second(i[0]),
            rng::sequence_seed(i[0], i[1], i[2]),
            rng::unit(i[0]).to_bits(),
        ];
        assert_eq!(o, expected, "{i:x?}");
        assert!(f32::from_bits(o[3]) < 1.0);
    }
}

/// Indices of 64 bits: sums, products and the seeds of high words are those of Rust's own u64.
#[test]
fn wide_indices_are_rusts() {
    let context = device_or_return!();
    let inputs = words(4096);
    let code = "let i = in_u(0u);
        out_u(0u, vec4(wide_sum(i.xy, i.z), wide_product(i.x, i.w >> 16u)));
        out_u(1u, vec4(seed_at(i.x, i.y), 0u, 0u, 0u));";
    let out: Vec<[Row; 2]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    let split = |x: u64| [x as u32, (x >> 32) as u32];
    for ([i], [o, seed]) in inputs.iter().zip(out) {
        let [x, y, z, w] = i.map(u64::from);
        assert_eq!(o[..2], split((y << 32 | x).wrapping_add(z)), "{i:x?}");
        assert_eq!(o[2..], split(x * (w >> 16)), "{i:x?}");
        assert_eq!(seed[0], rng::seed_at(i[0], i[1]), "{i:x?}");
    }
}

#[test]
fn numbers_are_rusts_and_below_one() {
    let context = device_or_return!();
    let inputs = words(4096);
    let code = "let i = in_u(0u);
        out_f(0u, random4(i.x, i.y, i.z, i.w));
        out_f(1u, vec4(sobol2(i.x, i.y), sobol2(i.z, i.w)));";
    let out: Vec<[Row; 2]> = Snippet::new(IMPORTS, code).run(context, &inputs);
    for ([i], [random, pairs]) in inputs.iter().zip(out) {
        assert_eq!(floats(random), rng::random4(i[0], i[1], i[2], i[3]), "{i:x?}");
        let (a, b) = (rng::sobol2(i[0], i[1]), rng::sobol2(i[2], i[3]));
        assert_eq!(floats(pairs), [a[0], a[1], b[0], b[1]], "{i:x?}");
        assert!(floats(random).iter().chain(&floats(pairs)).all(|x| (0.0..1.0).contains(x)));
    }
}
