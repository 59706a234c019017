//! The test for equality of noisy images accepts what is equal and rejects what is not.

use joton::film::Image;
use joton::film::stats::{Estimate, Outcome, sidak, test_equal, two_sided_p};

const SIZE: u32 = 64;
/// Standard deviation of each pixel over its mean, as after some hundred samples.
const NOISE: f64 = 0.1;
/// Chance that a test of this file rejects equal images, were the seeds random.
const SIGNIFICANCE: f64 = 1e-3;

/// Uniform in (0, 1), addressed by a counter (SplitMix64).
fn uniform(counter: u64) -> f64 {
    let mut z = counter.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (((z ^ (z >> 31)) >> 11) as f64 + 0.5) / (1_u64 << 53) as f64
}

/// Normal by Box and Muller.
fn normal(counter: u64) -> f64 {
    let [u, v] = [uniform(2 * counter), uniform(2 * counter + 1)];
    (-2.0 * u.ln()).sqrt() * (std::f64::consts::TAU * v).cos()
}

/// Independent noisy renders of a scene whose mean is `level` at each pixel and band.
fn renders(count: u64, seed: u64, level: impl Fn(usize, usize) -> f64) -> Vec<Image> {
    let render = |r: u64| {
        let mut image = Image::new(SIZE, SIZE);
        for (p, pixel) in image.pixels.iter_mut().enumerate() {
            for (b, value) in pixel.iter_mut().enumerate() {
                let counter = ((seed * 1000 + r) << 20) + (p * 3 + b) as u64;
                *value = (level(p, b) * (1.0 + NOISE * normal(counter))) as f32;
            }
        }
        image
    };
    (0..count).map(render).collect()
}

fn scene(p: usize, b: usize) -> f64 {
    0.2 + 0.3 * b as f64 + (p % 64) as f64 / 64.0
}

fn test(a: &[Image], b: &[Image], block: u32) -> Outcome {
    let [a, b] = [a, b].map(|renders| Estimate::from_renders(renders, block).expect("estimate"));
    test_equal(&a, &b).expect("tested")
}

/// Equal means pass, per pixel and per block, with as few renders as four.
#[test]
fn equal_means_are_accepted() {
    for count in [4, 16] {
        let (a, b) = (renders(count, 1, scene), renders(count, 2, scene));
        for block in [1, 5, 16, 64] {
            let outcome = test(&a, &b, block);
            assert!(outcome.accepts(SIGNIFICANCE), "{count} renders, block {block}: {outcome:?}");
        }
    }
}

/// One per cent more light everywhere fails at blocks of 16 pixels: their standard error is 0.2 %.
#[test]
fn one_per_cent_is_rejected() {
    let a = renders(16, 1, scene);
    let b = renders(16, 2, |p, band| 1.01 * scene(p, band));
    for block in [16, 64] {
        let outcome = test(&a, &b, block);
        assert!(!outcome.accepts(SIGNIFICANCE) && outcome.worst_score < 0.0, "block {block}: {outcome:?}");
    }
}

/// A single wrong pixel fails where each pixel is tested, and is named.
#[test]
fn one_pixel_is_rejected_and_named() {
    let wrong = |p: usize, b: usize| if (p, b) == (64 * 20 + 7, 1) { 2.0 * scene(p, b) } else { scene(p, b) };
    let outcome = test(&renders(16, 1, scene), &renders(16, 2, wrong), 1);
    assert!(!outcome.accepts(SIGNIFICANCE), "{outcome:?}");
    assert_eq!(outcome.worst_at, ([7, 20], 1));
    assert_eq!(outcome.tests, 64 * 64 * 3);
}

/// Over many trials with equal means, the p-value is at most 0.05 in about 5 % of them: neither deaf nor nervous.
/// Of 400 trials 20 are expected; 5 … 39 leave out 4.4 standard deviations on either side.
#[test]
fn false_alarms_are_as_rare_as_stated() {
    let trials = 400;
    let tiny = |seed: u64| -> Vec<Image> {
        let crop = |full: Image| Image { width: 4, height: 4, pixels: full.pixels[..16].to_vec() };
        renders(5, seed, scene).into_iter().map(crop).collect()
    };
    let alarms =
        (0..trials).filter(|&t| !test(&tiny(10 + 2 * t), &tiny(11 + 2 * t), 1).accepts(0.05)).count();
    // Welch's degrees of freedom err on the safe side with so few renders: fewer alarms are no fault.
    assert!((1..40).contains(&alarms), "{alarms} of {trials}");
}

/// Against a reference without noise, and with variances known: the same verdicts.
#[test]
fn known_variances_give_a_z_test() {
    let count = 16.0;
    let mut exact = Image::new(SIZE, SIZE);
    let mut variance = Image::new(SIZE, SIZE);
    for p in 0..exact.pixels.len() {
        exact.pixels[p] = std::array::from_fn(|b| scene(p, b) as f32);
        variance.pixels[p] = std::array::from_fn(|b| ((NOISE * scene(p, b)).powi(2) / count) as f32);
    }
    for (factor, accepted) in [(1.0, true), (1.01, false)] {
        let set = renders(16, 1, |p, b| factor * scene(p, b));
        let mut mean = Image::new(SIZE, SIZE);
        for p in 0..mean.pixels.len() {
            mean.pixels[p] = std::array::from_fn(|b| {
                (set.iter().map(|i| f64::from(i.pixels[p][b])).sum::<f64>() / count) as f32
            });
        }
        let sides = [Estimate::from_moments(&mean, &variance, 16), Estimate::exact(&exact, 16)];
        let [a, b] = sides.map(|e| e.expect("estimate"));
        let outcome = test_equal(&a, &b).expect("tested");
        assert_eq!(outcome.accepts(SIGNIFICANCE), accepted, "{factor}: {outcome:?}");
    }
}

/// Images without any noise are equal within rounding and not beyond; NaN equals nothing.
#[test]
fn images_without_noise_are_compared_too() {
    let constant = |level: f32| Image { width: 4, height: 4, pixels: vec![[level; 3]; 16] };
    let exact = |level| Estimate::exact(&constant(level), 1).expect("estimate");
    assert!(test_equal(&exact(15.0), &exact(15.0)).expect("tested").accepts(0.5));
    assert!(test_equal(&exact(0.0), &exact(0.0)).expect("tested").accepts(0.5));
    assert!(
        test_equal(&exact(15.0), &exact(15.000_01)).expect("tested").accepts(0.5),
        "the last digits of f32"
    );
    assert!(!test_equal(&exact(15.0), &exact(15.01)).expect("tested").accepts(SIGNIFICANCE));
    assert!(
        !test_equal(&exact(0.0), &exact(1e-9)).expect("tested").accepts(SIGNIFICANCE),
        "light where none is"
    );
    for bad in [f32::NAN, f32::INFINITY] {
        assert!(!test_equal(&exact(bad), &exact(bad)).expect("tested").accepts(0.0_f64.next_up()));
    }
}

/// One render, or renders or blocks that do not fit, are errors.
#[test]
fn unusable_input_is_an_error() {
    let image = Image::new(4, 4);
    Estimate::from_renders(std::slice::from_ref(&image), 1).expect_err("one render");
    Estimate::from_renders(&[image.clone(), Image::new(4, 5)], 1).expect_err("sizes");
    Estimate::exact(&image, 0).expect_err("no block");
    Estimate::exact(&Image::new(0, 0), 1).expect_err("no pixels");
    let [a, b] = [1, 2].map(|block| Estimate::exact(&image, block).expect("estimate"));
    test_equal(&a, &b).expect_err("blocks");
}

/// Tail probabilities of tables: normal, and Student's with 1, 2, 10 and 30 degrees of freedom.
#[test]
fn tails_are_those_of_the_tables() {
    for (freedom, score, p) in [
        (f64::INFINITY, 1.959_964, 0.05),
        (f64::INFINITY, 3.290_527, 0.001),
        (1.0, 12.706_205, 0.05),
        (2.0, 4.302_653, 0.05),
        (10.0, 2.228_139, 0.05),
        (10.0, 4.586_894, 0.001),
        (30.0, 2.042_272, 0.05),
        (30.0, 0.0, 1.0),
    ] {
        let found = two_sided_p(score, freedom);
        assert!((found / p - 1.0).abs() < 1e-5, "{freedom} {score}: {found}");
        assert_eq!(found, two_sided_p(-score, freedom));
    }
    // Closed form for two degrees of freedom, far out: 1 − t/√(2 + t²).
    let t: f64 = 1000.0;
    assert!((two_sided_p(t, 2.0) / (1.0 - t / (2.0 + t * t).sqrt()) - 1.0).abs() < 1e-6);
    // Student's becomes the normal one.
    assert!((two_sided_p(3.0, 999_999.0) / two_sided_p(3.0, 1_000_001.0) - 1.0).abs() < 1e-4);
    assert!((sidak(0.01, 2) - 0.0199).abs() < 1e-12);
    assert!((sidak(1e-18, 1_000_000) / 1e-12 - 1.0).abs() < 1e-6, "no digits lost near zero");
}
