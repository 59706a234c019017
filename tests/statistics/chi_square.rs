//! χ²: do samples follow a density? The tool, and what it must accept and reject itself.

use glam::DVec3;
use joton::film::stats::sidak;
use statrs::distribution::{ChiSquared, ContinuousCDF};
use std::f64::consts::TAU;

/// Probability that a set of claims fails by chance, over random seeds.
pub const SIGNIFICANCE: f64 = 1e-4;
/// Bins that expect fewer samples are put together: below, χ² is not χ²-distributed.
const EXPECTED_MIN: f64 = 5.0;
/// Bins across each parameter.
const BINS: usize = 16;
/// Points across a bin at which the density is integrated, each somewhere in its cell: an edge of the density that runs
/// through a bin, along the cells or not, is then found to 0.2 % of the bin.
const POINTS: usize = 48;

/// Seed of every test of this suite.
pub fn seed() -> u32 {
    std::env::var("JOTON_STATISTICS_SEED")
        .map_or(0, |s| s.parse().expect("JOTON_STATISTICS_SEED is a number"))
}

/// Probability that samples of these expectations scatter at least as much as these do.
pub fn p_value(observed: &[f64], expected: &[f64]) -> f64 {
    let total = |x: &[f64]| x.iter().sum::<f64>();
    let off = total(expected) / total(observed) - 1.0;
    assert!(off.abs() < 1e-3, "the density integrates to {}", 1.0 + off);
    // rare bins side by side, in lots that are large enough
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|&a, &b| expected[a].total_cmp(&expected[b]));
    let mut lots = vec![[0.0; 2]];
    for i in order {
        if lots[lots.len() - 1][1] >= EXPECTED_MIN {
            lots.push([0.0; 2]);
        }
        let last = lots.len() - 1;
        lots[last] = [lots[last][0] + observed[i], lots[last][1] + expected[i]];
    }
    let statistic: f64 = lots.iter().map(|[o, e]| (o - e).powi(2) / e).sum();
    upper_tail(statistic, lots.len() - 1)
}

/// Probability of a χ² of at least `statistic`.
pub fn upper_tail(statistic: f64, freedom: usize) -> f64 {
    if freedom == 0 {
        return 1.0;
    }
    ChiSquared::new(freedom as f64).expect("positive degrees of freedom").sf(statistic)
}

/// The same where samples that scatter too little are as wrong as those that scatter too much.
pub fn both_tails(upper: f64) -> f64 {
    2.0 * upper.min(1.0 - upper)
}

/// p-value of places in the unit square, none for those outside of it, against a density over the square that may
/// integrate to less than one.
pub fn in_square(samples: impl Iterator<Item = Option<[f64; 2]>>, density: impl Fn([f64; 2]) -> f64) -> f64 {
    let mut observed = vec![0.0; BINS * BINS + 1];
    let mut count = 0.0;
    for place in samples {
        let bin = place.map_or(BINS * BINS, |p| {
            let [x, y] = p.map(|x| ((x * BINS as f64) as usize).min(BINS - 1));
            y * BINS + x
        });
        observed[bin] += 1.0;
        count += 1.0;
    }
    let step = 1.0 / (BINS * POINTS) as f64;
    let mut expected = vec![0.0; BINS * BINS + 1];
    for y in 0..BINS * POINTS {
        for x in 0..BINS * POINTS {
            let [u, v, ..] = joton::sampling::rng::random4(0, x as u32, y as u32, 0);
            let p = [(x, u), (y, v)].map(|(i, u)| (i as f64 + f64::from(u)) * step);
            expected[y / POINTS * BINS + x / POINTS] += count * step * step * density(p);
        }
    }
    let inside: f64 = expected.iter().sum();
    expected[BINS * BINS] = (count - inside).max(0.0);
    p_value(&observed, &expected)
}

/// The directions about an axis up to 1 − cosθ = `extent` as a unit square: (√((1 − cosθ)/extent), φ/2π). Narrow lobes
/// get fine bins.
#[derive(Clone, Copy)]
pub struct Cap {
    frame: [DVec3; 3],
    extent: f64,
}

impl Cap {
    /// About a unit vector; 2 is the whole sphere.
    pub fn new(axis: DVec3, extent: f64) -> Self {
        let x = axis.any_orthonormal_vector();
        Self { frame: [x, axis.cross(x), axis], extent }
    }

    /// The place of a direction in the square.
    pub fn place(&self, w: DVec3) -> Option<[f64; 2]> {
        let w = w.normalize();
        let [x, y, z] = self.frame.map(|a| a.dot(w));
        // 1 − cosθ without cancellation
        let below = 0.5 * (w - self.frame[2]).length_squared();
        let t = (below / self.extent).sqrt();
        debug_assert!((1.0 - z - below).abs() < 1e-6);
        (t < 1.0).then(|| [t, (y.atan2(x) / TAU).rem_euclid(1.0)])
    }

    /// The direction of a place, and the solid angle per area of the square there.
    pub fn direction(&self, [t, v]: [f64; 2]) -> (DVec3, f64) {
        let below = self.extent * t * t;
        let r = (below * (2.0 - below)).max(0.0).sqrt();
        let (sin, cos) = (TAU * v).sin_cos();
        let [x, y, z] = self.frame;
        (x * (r * cos) + y * (r * sin) + z * (1.0 - below), 2.0 * self.extent * t * TAU)
    }

    /// p-value of directions, none where there was none, against a density per solid angle.
    pub fn test(&self, samples: impl Iterator<Item = Option<DVec3>>, density: impl Fn(DVec3) -> f64) -> f64 {
        in_square(samples.map(|w| w.and_then(|w| self.place(w))), |p| {
            let (w, solid_angle) = self.direction(p);
            density(w) * solid_angle
        })
    }

    /// Directions and weights that integrate over the cap.
    pub fn grid(&self) -> impl Iterator<Item = (DVec3, f64)> {
        const ACROSS: usize = 256;
        let cap = *self;
        (0..ACROSS * ACROSS).map(move |i| {
            let p = [i % ACROSS, i / ACROSS].map(|k| (k as f64 + 0.5) / ACROSS as f64);
            let (w, solid_angle) = cap.direction(p);
            (w, solid_angle / (ACROSS * ACROSS) as f64)
        })
    }
}

/// Claims that are tested together.
#[derive(Default)]
pub struct Claims {
    found: Vec<(String, f64)>,
}

impl Claims {
    /// Add a claim and the p-value that was found.
    pub fn add(&mut self, name: impl Into<String>, p: f64) {
        self.found.push((name.into(), p));
    }

    /// The least p-value, corrected for the number of claims, and its name.
    fn worst(&self) -> (f64, &str) {
        let (name, p) = self.found.iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("something is claimed");
        (sidak(*p, self.found.len()), name)
    }

    /// Fail where one of the claims is unlikely to hold.
    pub fn hold(&self) {
        let (p, name) = self.worst();
        println!("{} claims; p = {p:.3} of the least likely one: {name}", self.found.len());
        assert!(p >= SIGNIFICANCE, "{name}: p = {p:e} after correction for {} claims", self.found.len());
    }
}

/// Numbers in [0, 1) for samples, by address; another set for each `purpose`.
pub fn draws(purpose: u32, count: u32) -> impl Iterator<Item = [f32; 4]> {
    let seed = seed();
    (0..count).map(move |i| joton::sampling::rng::random4(seed, purpose, i, 0x57a7))
}

/// Samples of a density are accepted, of a density two per cent off in shape they are not; nor are samples outside of
/// it, nor samples too even to be independent.
#[test]
fn chi_square_accepts_what_is_right_and_rejects_the_rest() {
    const COUNT: u32 = 1 << 20;
    let samples = || draws(1, COUNT).map(|u| Some([f64::from(u[0]).sqrt(), f64::from(u[1])]));
    let linear = in_square(samples(), |p| 2.0 * p[0]);
    assert!(linear > SIGNIFICANCE, "{linear}");
    let bent = in_square(samples(), |p| 2.0 * p[0] * (1.0 + 0.02 * (TAU * p[1]).sin()));
    assert!(bent < SIGNIFICANCE, "{bent}");
    // one in a thousand where none may be
    let half = |p: [f64; 2]| if p[1] < 0.5 { 2.0 } else { 0.0 };
    let strays = draws(1, COUNT).map(|u| {
        let y = f64::from(u[1]) / 2.0;
        Some([f64::from(u[0]), if u[2] < 0.001 { 1.0 - y } else { y }])
    });
    let strayed = in_square(strays, half);
    assert!(strayed < SIGNIFICANCE, "{strayed}");
    let clean = in_square(draws(1, COUNT).map(|u| Some([f64::from(u[0]), f64::from(u[1]) / 2.0])), half);
    assert!(clean > SIGNIFICANCE, "{clean}");
    let even = (0..COUNT).map(|i| Some(joton::sampling::rng::sobol2(i, 1).map(f64::from)));
    let p = in_square(even, |_| 1.0);
    assert!(p > 0.999 && both_tails(p) < SIGNIFICANCE, "{p}");
}

/// The tail of χ² against its closed form for two degrees of freedom, e^(−x/2).
#[test]
fn tails_are_those_of_chi_square() {
    for x in [0.1, 1.0, 5.0, 30.0] {
        let wanted = (-x / 2.0f64).exp();
        assert!((upper_tail(x, 2) / wanted - 1.0).abs() < 1e-9, "{x}");
    }
}
