//! Are two noisy images the same? Welch's t-test for each block of pixels and band, Šidák-corrected over all.
//!
//! t = (a − b) / √(va + vb), v the variance of each mean; with known variances a z-test. The images differ where
//! the smallest p-value is too small for the best of that many tests. Blocks of one pixel find what is local;
//! larger ones find a shift that drowns in the noise of each pixel. As Mitsuba 3's render tests, with Student's
//! distribution instead of the normal one, since a handful of renders is all that a test can afford.

use crate::error::{Error, Result};
use crate::film::Image;
use crate::spectrum::BANDS;

/// Standard error added to every difference, relative to the mean: two ways of summing in f32 may differ so
/// much without either being wrong, and where nothing is noisy (a light seen directly) nothing else forgives it.
const ROUNDING: f64 = 1e-5;

/// Mean of each block, how sure it is, and from how much that is known.
#[derive(Debug, Clone)]
pub struct Estimate {
    /// Blocks across and down.
    pub blocks: [u32; 2],
    /// Edge of a block, pixels; the last ones may be smaller.
    pub block: u32,
    /// Mean radiance of each block, W/(m² sr), row by row.
    pub mean: Vec<[f64; BANDS]>,
    /// Variance of that mean, (W/(m² sr))².
    pub variance: Vec<[f64; BANDS]>,
    /// Degrees of freedom of the variance; infinite where it is known and not estimated.
    pub freedom: f64,
}

impl Estimate {
    /// From at least two renders that are independent and of one kind. The variance is that between the renders'
    /// blocks, so pixels may be correlated (a joton reaches many).
    pub fn from_renders(renders: &[Image], block: u32) -> Result<Self> {
        let [first, _, ..] = renders else {
            return Err(Error::usage(
                "one render tells no variance",
                "give at least two with different seeds",
            ));
        };
        let count = renders.len() as f64;
        let means: Vec<_> = renders.iter().map(|r| block_means(r, first, block)).collect::<Result<_>>()?;
        let mean = |i: usize, b: usize| means.iter().map(|m| m[i][b]).sum::<f64>() / count;
        let variance = |i: usize, b: usize| {
            let centre = mean(i, b);
            means.iter().map(|m| (m[i][b] - centre).powi(2)).sum::<f64>() / (count - 1.0) / count
        };
        let all = |f: &dyn Fn(usize, usize) -> f64| {
            (0..means[0].len()).map(|i| std::array::from_fn(|b| f(i, b))).collect()
        };
        let blocks = blocks(first, block);
        Ok(Self { blocks, block, mean: all(&mean), variance: all(&variance), freedom: count - 1.0 })
    }

    /// From a mean and the variance of that mean in each pixel, taken as known. In blocks of more than one pixel
    /// the pixels are taken as independent.
    pub fn from_moments(mean: &Image, variance_of_mean: &Image, block: u32) -> Result<Self> {
        let means = block_means(mean, mean, block)?;
        let mut variance = block_means(variance_of_mean, mean, block)?;
        let [across, _] = blocks(mean, block);
        for (i, v) in (0u32..).zip(&mut variance) {
            let pixels = pixels_in(mean, block, i % across, i / across).count() as f64;
            *v = v.map(|x| x / pixels);
        }
        Ok(Self { blocks: blocks(mean, block), block, mean: means, variance, freedom: f64::INFINITY })
    }

    /// From an image without noise: an analytic solution, or a reference so good that its noise is nothing.
    pub fn exact(image: &Image, block: u32) -> Result<Self> {
        Self::from_moments(image, &Image::new(image.width, image.height), block)
    }
}

/// What a test of two estimates finds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Outcome {
    /// Probability that estimates of equal things differ somewhere at least as much as these do.
    pub p_value: f64,
    /// Difference in standard errors, a − b, where it is least likely.
    pub worst_score: f64,
    /// Block (column, row) and band of it.
    pub worst_at: ([u32; 2], usize),
    /// Number of tests that [`Outcome::p_value`] is corrected for: blocks times bands.
    pub tests: usize,
}

impl Outcome {
    /// Whether the two may be equal, at a probability `significance` of saying no where they are. A value that is
    /// not finite is never equal to anything.
    pub fn accepts(&self, significance: f64) -> bool {
        self.p_value >= significance
    }
}

/// Test whether two estimates, of the same blocks, are of equal images.
pub fn test_equal(a: &Estimate, b: &Estimate) -> Result<Outcome> {
    if (a.blocks, a.block) != (b.blocks, b.block) {
        return Err(Error::usage("the estimates have different blocks", "use images and blocks of one size"));
    }
    let tests = a.mean.len() * BANDS;
    let mut worst = (2.0, 0.0, ([0, 0], 0));
    for i in 0..a.mean.len() {
        for band in 0..BANDS {
            let sides = [a, b].map(|e| (e.mean[i][band], e.variance[i][band], e.freedom));
            let (score, p) = welch(sides);
            if p < worst.0 {
                let i = i as u32;
                worst = (p, score, ([i % a.blocks[0], i / a.blocks[0]], band));
            }
        }
    }
    let (p, worst_score, worst_at) = worst;
    Ok(Outcome { p_value: sidak(p, tests), worst_score, worst_at, tests })
}

/// Score and two-sided p-value of one difference, each side (mean, variance of the mean, degrees of freedom).
fn welch([a, b]: [(f64, f64, f64); 2]) -> (f64, f64) {
    let rounding = ROUNDING * a.0.abs().max(b.0.abs());
    let variance = a.1 + b.1 + rounding * rounding;
    let difference = a.0 - b.0;
    if !difference.is_finite() || !variance.is_finite() {
        return (f64::NAN, 0.0);
    }
    if difference == 0.0 {
        return (0.0, 1.0);
    }
    let score = difference / variance.sqrt();
    // Welch and Satterthwaite: the degrees of freedom of a sum of variances that are known differently well.
    let share = |(_, v, freedom): (f64, f64, f64)| (v / variance).powi(2) / freedom;
    (score, two_sided_p(score, 1.0 / (share(a) + share(b))))
}

/// Probability that the best of `tests` independent tests has a p-value of at most `p`: 1 − (1 − p)^tests.
pub fn sidak(p: f64, tests: usize) -> f64 {
    -f64::exp_m1(tests as f64 * f64::ln_1p(-p.min(1.0)))
}

/// Probability that a value of Student's distribution lies at least |score| from zero; infinite `freedom` is the
/// normal distribution.
pub fn two_sided_p(score: f64, freedom: f64) -> f64 {
    // From here on both distributions agree to three digits far into the tails that tests ask for.
    const NORMAL_FROM: f64 = 1e6;
    if freedom >= NORMAL_FROM {
        return libm::erfc(score.abs() * std::f64::consts::FRAC_1_SQRT_2);
    }
    incomplete_beta(freedom / (freedom + score * score), freedom / 2.0, 0.5)
}

/// Regularised incomplete beta function I_x(a, b) by Lentz's continued fraction (DLMF 8.17.22).
fn incomplete_beta(x: f64, a: f64, b: f64) -> f64 {
    const TERMS_MAX: u32 = 10_000;
    const TINY: f64 = 1e-300;
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    // The fraction converges fast below the mean of the distribution; above it, the other tail does.
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - incomplete_beta(1.0 - x, b, a);
    }
    let front =
        (libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * x.ln() + b * (-x).ln_1p()).exp() / a;
    let away_from_zero = |v: f64| if v.abs() < TINY { TINY } else { v };
    let (mut c, mut d) = (1.0, 1.0 / away_from_zero(1.0 - (a + b) * x / (a + 1.0)));
    let mut fraction = d;
    for m in (1..TERMS_MAX).map(f64::from) {
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        let mut change = 1.0;
        for term in [even, odd] {
            d = 1.0 / away_from_zero(1.0 + term * d);
            c = away_from_zero(1.0 + term / c);
            change = c * d;
            fraction *= change;
        }
        if (change - 1.0).abs() < f64::EPSILON {
            break;
        }
    }
    front * fraction
}

fn blocks(image: &Image, block: u32) -> [u32; 2] {
    [image.width, image.height].map(|size| size.div_ceil(block.max(1)))
}

/// Indices of the pixels of one block.
fn pixels_in(image: &Image, block: u32, column: u32, row: u32) -> impl Iterator<Item = usize> {
    let range = |i: u32, size: u32| i * block..(i * block).saturating_add(block).min(size);
    let (width, columns) = (image.width as usize, range(column, image.width));
    range(row, image.height).flat_map(move |y| columns.clone().map(move |x| y as usize * width + x as usize))
}

/// Mean of each block, row by row; `like` is what the image has to be as large as.
fn block_means(image: &Image, like: &Image, block: u32) -> Result<Vec<[f64; BANDS]>> {
    if block == 0 || image.pixels.is_empty() {
        return Err(Error::usage(
            "there are no pixels to test",
            "use images and blocks of at least one pixel",
        ));
    }
    if (image.width, image.height) != (like.width, like.height) {
        return Err(Error::usage("the renders differ in size", "render them all alike"));
    }
    let [across, down] = blocks(image, block);
    let mean = |i: u32| {
        let mut sum = [0.0; BANDS];
        let mut pixels = 0.0;
        for p in pixels_in(image, block, i % across, i / across) {
            pixels += 1.0;
            for (s, x) in sum.iter_mut().zip(&image.pixels[p]) {
                *s += f64::from(*x);
            }
        }
        sum.map(|s| s / pixels)
    };
    Ok((0..across * down).map(mean).collect())
}
