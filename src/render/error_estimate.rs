//! Error estimate: the passes of a render in two halves, and what these tell of its error without a reference [E16, E18].
//!
//! Noise shows in the difference of the halves. Blur shows in how the estimates change with their radius from pass to
//! pass: a line through them, pixel by pixel, against the radius; what it loses from here to radius 0 is bias. Its square
//! is the product of both halves' biases, so that their noise adds nothing to it on average.

use super::blur_line::{self, Line};
use super::lattice::Lattice;
use crate::film::tile_schedule::TileSchedule;
use crate::film::{Film, LAYERS, Layer, RELATIVE_OFFSET, SAMPLES_MAX, half};
use crate::resolve::{Resolved, SquaredError};
use crate::spectrum::{BANDS, BLACK, Bands, add};
use rayon::prelude::*;

/// Blocks across and down whose spread tells how sure the squared bias is.
const BLOCKS: usize = 8;

/// Factor on the squared noise: it is estimated, not known, and what is rare may not have shown yet.
const NOISE_SAFETY: f64 = 2.0;
/// Factor on the squared bias: beside an edge of light, radii that have shrunk past it leave a line no slope.
const BIAS_SAFETY: f64 = 1.5;

/// Up to so many passes the mean is taken for the pixel's brightness, and bias for noise; of more, less and less. A lamp
/// that fills a tenth of a pixel is often seen by one half alone, and a line through two passes goes anywhere.
const TRUSTING_PASSES: f64 = 8.0;

/// The passes of a render, and parts of them.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(crate) struct ErrorEstimator {
    /// All passes.
    film: Film,
    /// The pixels of `early` and `lines`.
    lattice: Lattice,
    /// Sums of the whole radiance over the first [`ErrorEstimator::early_passes`]. Empty before there are any.
    early: Vec<[f64; BANDS]>,
    /// The last power of two before the number of passes.
    early_passes: u64,
    /// Passes and error when `early` was renewed.
    before: Option<(u64, ErrorEstimate)>,
    lines: [Line; 2],
    /// Layers that are resolved: their own passes say nothing of the picture.
    resolves: Vec<Layer>,
    /// What they were like when they were resolved last.
    smooth: Option<Smooth>,
}

/// The resolved layers together in the pixels that tell the error.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
struct Smooth {
    /// After so many passes.
    passes: u64,
    radiance: Vec<Bands>,
    squared_error: Vec<SquaredError>,
}

/// Exponent of the passes with which the squared error of a resolved layer falls, until it is resolved again.
const SMOOTH_RATE: f64 = 0.7;
/// Factor on its variance: what was chosen is the least of some that are estimated.
const SMOOTH_NOISE_SAFETY: f64 = 3.6;
/// Passes that tell little of it: of so many it is doubled.
const SMOOTH_PASSES: f64 = 4.0;
/// Width of an image, pixels, that errors shared among neighbours hang together over.
const SMOOTH_WIDTH: f64 = 16.0;
/// Pixels that are told of by one another, and so by chance vary together: squares of 3 × 3 that overlap, (Σ (1 − |i|/3)²)².
const SMOOTH_BIAS_TOGETHER: f64 = 361.0 / 81.0;
/// Standard errors of it that are taken for chance: where light is even there is no bias, and the noise of single pixels must not be told as one.
const DOUBT: f64 = 2.0;
/// Factor on its squared bias: it is seen through the noise of single pixels.
const SMOOTH_SAFETY: f64 = 2.0;

/// Relative errors, root mean square over pixels and bands.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ErrorEstimate {
    /// A bound on all of it: √(2 noise² + 1.5 bias²), of the bias no more than there is noise: both fall alike.
    pub total: f64,
    /// What differs from seed to seed.
    pub noise: f64,
    /// What the radii blur, as far as it stands out of the noise.
    pub bias: f64,
}

impl ErrorEstimator {
    /// Nothing rendered yet.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        Self::with_film(Film::new(size[0], size[1]), SAMPLES_MAX)
    }

    /// Of the passes of a part of a render, which begins with pass `first`.
    pub(crate) fn of_part(size: [u32; 2], first: u64) -> Self {
        Self::with_film(Film::of_part(size[0], size[1], first), SAMPLES_MAX)
    }

    /// With at most so many pixels that tell the error.
    #[cfg(test)]
    fn with_samples(size: [u32; 2], most: u64) -> Self {
        Self::with_film(Film::new(size[0], size[1]), most)
    }

    fn with_film(film: Film, most: u64) -> Self {
        let lattice = Lattice::new(film.size(), most);
        Self {
            film,
            lattice,
            early: Vec::new(),
            early_passes: 0,
            before: None,
            lines: Default::default(),
            resolves: Vec::new(),
            smooth: None,
        }
    }

    /// Whether it is one of an image so large, where it was stored: of a part of a render or none.
    pub(crate) fn is_sound(&self, size: [u32; 2], is_part: bool) -> bool {
        if !self.film.is_sound(size, is_part) || self.lattice != Lattice::new(size, SAMPLES_MAX) {
            return false;
        }
        let pixels = self.lattice.len();
        let is_early = self.early_passes <= self.film.passes()
            && (self.early.len() == pixels || self.early.is_empty() && self.early_passes == 0);
        let is_smooth =
            |smooth: &Smooth| smooth.radiance.len() == pixels && smooth.squared_error.len() == pixels;
        is_early
            && self.lines.iter().all(|line| line.is_sound(pixels))
            && self.smooth.as_ref().is_none_or(is_smooth)
    }

    /// Add the sums of `passes` passes from pass `first` on, all of one [`run`]. `blur` is the mean over them of the maps'
    /// radius, relative to the first pass; 0 without maps.
    pub(crate) fn add(&mut self, first: u64, passes: u64, layers: &[Vec<[f32; BANDS]>; LAYERS], blur: f64) {
        if first.is_power_of_two() {
            self.before = self.error().map(|e| (self.film.passes(), e));
            self.divide_here();
        }
        if blur > 0.0 {
            let runs = self.film.tile_schedule().runs(first, passes);
            // what paths found of indirect light has no radius
            let maps = [Layer::Caustic, Layer::Diffuse];
            let maps = if self.resolves.contains(&Layer::Diffuse) { &maps[..1] } else { &maps };
            self.lines[half(first)].add(&self.lattice, passes, maps, layers, blur, &runs);
        }
        self.film.add(passes, layers);
    }

    /// Add the passes of the next part of the render. What this one's passes and those of the next tell of each other becomes the error
    /// estimate where they are more alike in number than the parts before.
    pub(crate) fn merge(&mut self, next: &Self) {
        let [before, after] = [&self.film, &next.film].map(Film::passes);
        let halves = |early: u64| early.abs_diff(before + after - early);
        if self.early.is_empty() || halves(before) <= halves(self.early_passes) {
            self.divide_here();
        }
        self.before = None;
        self.smooth = None;
        for (line, more) in self.lines.iter_mut().zip(&next.lines) {
            line.merge(more);
        }
        self.film.merge(&next.film);
    }

    /// The passes so far are the early ones.
    fn divide_here(&mut self) {
        let samples = (0..self.lattice.len()).into_par_iter();
        self.early = samples.map(|s| self.sum(self.lattice.pixel(s))).collect();
        self.early_passes = self.film.passes();
    }

    /// From here on these tiles rest.
    pub(crate) fn set_tile_schedule(&mut self, schedule: TileSchedule) {
        self.film.set_tile_schedule(schedule);
    }

    /// From the first pass on, these layers are resolved.
    pub(crate) fn set_resolves(&mut self, layers: &[Layer]) {
        self.resolves = layers.to_vec();
        self.film.keep_halves(layers);
    }

    /// Pixels across and down from one that tells the error to the next.
    pub(crate) fn step(&self) -> u32 {
        self.lattice.step as u32
    }

    /// Layers that are resolved.
    pub(crate) fn resolves(&self) -> &[Layer] {
        &self.resolves
    }

    /// The layers as they were resolved now.
    pub(crate) fn set_resolved(&mut self, resolved: &[(Layer, Resolved)]) {
        let pixels = || (0..self.lattice.len()).into_par_iter().map(|sample| self.lattice.pixel(sample));
        let sum =
            |of: &dyn Fn(&Resolved) -> Bands| resolved.iter().fold(BLACK, |sum, (_, r)| add(&sum, &of(r)));
        let errors = |sample: usize| {
            let each = resolved.iter().map(|(_, r)| r.squared_error[sample]);
            each.fold(SquaredError::default(), |a, b| SquaredError {
                variance: a.variance + b.variance,
                bias: a.bias + b.bias,
            })
        };
        self.smooth = Some(Smooth {
            passes: self.film.passes(),
            radiance: pixels().map(|p| sum(&|r| r.radiance[p])).collect(),
            squared_error: (0..self.lattice.len()).into_par_iter().map(errors).collect(),
        });
    }

    /// Passes when they were resolved last.
    pub(crate) fn resolved_at(&self) -> Option<u64> {
        self.smooth.as_ref().map(|smooth| smooth.passes)
    }

    /// Sum over the passes of the layers whose passes are compared.
    fn sum(&self, pixel: usize) -> [f64; BANDS] {
        let compared = Layer::ALL.into_iter().filter(|layer| !self.resolves.contains(layer));
        compared.fold([0.0; BANDS], |sum, layer| {
            let more = self.film.sum(layer as usize, pixel);
            std::array::from_fn(|b| sum[b] + more[b])
        })
    }

    /// All passes.
    pub(crate) fn film(&self) -> &Film {
        &self.film
    }

    /// All passes, and nothing else any more.
    pub(crate) fn into_film(self) -> Film {
        self.film
    }

    /// The error of the mean of all passes; none before there are two. While the later passes are less than half as many as
    /// the early ones, their difference says little, and noise falls from what it was.
    pub(crate) fn error(&self) -> Option<ErrorEstimate> {
        let passes = self.film.passes();
        let early = self.early_passes;
        if early == 0 || !self.resolves.is_empty() && self.smooth.is_none() {
            return None;
        }
        let found = match self.before {
            Some((n, before)) if 2 * (passes - early) < early && !self.is_fresh() => {
                let part = (n as f64 / passes as f64).sqrt();
                ErrorEstimate { total: before.total * part, noise: before.noise * part, bias: before.bias }
            }
            _ => self.measured_error(),
        };
        Some(found)
    }

    /// True where they were resolved after the last pass.
    fn is_fresh(&self) -> bool {
        self.resolved_at() == Some(self.film.passes())
    }

    /// What is added to squared radiances: [`RELATIVE_OFFSET`], or in a picture whose surfaces are darker than its root, the square of how
    /// bright they are, Σx² / Σx: black ones do not count. The unit of power then says nothing of how noisy a dim picture is.
    fn offset(&self) -> f64 {
        let film = &self.film;
        let values = (BANDS as u64 * film.passes()) as f64;
        let of_pixel = |sample: usize| -> f64 {
            let pixel = self.lattice.pixel(sample);
            let layers = Layer::ON_SURFACES.map(|layer| film.sum(layer as usize, pixel).iter().sum::<f64>());
            layers.iter().sum::<f64>().max(0.0) / values
        };
        // row by row, so that threads change no bit
        let [width, height] = self.lattice.size;
        let add =
            |[sum, squares]: [f64; 2], [more, more_squares]: [f64; 2]| [sum + more, squares + more_squares];
        let row = |y: usize| {
            let radiance = (y * width..(y + 1) * width).map(of_pixel);
            radiance.map(|x| [x, x * x]).fold([0.0; 2], add)
        };
        let rows: Vec<[f64; 2]> = (0..height).into_par_iter().map(row).collect();
        let [sum, squares] = rows.into_iter().fold([0.0; 2], add);
        if squares > 0.0 { RELATIVE_OFFSET.min((squares / sum).powi(2)) } else { RELATIVE_OFFSET }
    }

    fn measured_error(&self) -> ErrorEstimate {
        let all = self.film.passes() as f64;
        let (a, b) = (self.early_passes as f64, all - self.early_passes as f64);
        // Var(mean of all) = Var(difference of the parts' means) · ab/(a+b)²
        let share = a * b / (all * all);
        let of_blur = blur_line::squared_bias(&self.lines, &self.lattice, self.film.passes());
        let smooth_scale = self.smooth.as_ref().map_or(0.0, |s| (s.passes as f64 / all).powf(SMOOTH_RATE));
        let trust = (TRUSTING_PASSES / all).min(1.0);
        let offset = self.offset();
        let [width, height] = self.lattice.size;
        // of each row, squared biases by blocks across
        let rows: Vec<Row> = (0..height)
            .into_par_iter()
            .map(|y| {
                let mut row = Row::default();
                for x in 0..width {
                    let p = y * width + x;
                    let (early, sum) = (self.early[p], self.sum(self.lattice.pixel(p)));
                    let smooth = self.smooth.as_ref().map(|s| (s.radiance[p], s.squared_error[p]));
                    let (resolved, shared) = smooth.unwrap_or_default();
                    // errors are means over the bands, and as large in each as its light
                    let square_mean =
                        resolved.iter().map(|x| f64::from(*x).powi(2)).sum::<f64>() / BANDS as f64;
                    let mut of_sharing = 0.0;
                    for i in 0..BANDS {
                        let means = [early[i] / a, (sum[i] - early[i]) / b];
                        let with = f64::from(resolved[i]);
                        let square = (sum[i] / all + with).powi(2);
                        let common = common_square(means[0] + with, means[1] + with);
                        let weight = trust / (square + offset) + (1.0 - trust) / (common + offset);
                        row.noise += (means[0] - means[1]).powi(2) * share * weight;
                        let part = if square_mean > 0.0 { with * with / square_mean } else { 1.0 };
                        row.smooth_noise += smooth_scale * f64::from(shared.variance) * part * weight;
                        of_sharing += smooth_scale * f64::from(shared.bias) * part * weight;
                        if let Some(squares) = &of_blur {
                            row.bias[x * BLOCKS / width] += squares[p][i] * weight;
                        }
                    }
                    row.smooth_bias += of_sharing;
                    row.smooth_bias_variance += of_sharing * of_sharing;
                }
                row
            })
            .collect();
        let values = (width * height * BANDS) as f64;
        let mut blocks = [0.0; BLOCKS * BLOCKS];
        for (y, row) in rows.iter().enumerate() {
            let into = &mut blocks[y * BLOCKS / height * BLOCKS..][..BLOCKS];
            into.iter_mut().zip(row.bias).for_each(|(block, b)| *block += b);
        }
        let sum = |of: &dyn Fn(&Row) -> f64| rows.iter().map(of).sum::<f64>();
        let noise_squared = sum(&|row| row.noise) / values;
        let smooth_noise = sum(&|row| row.smooth_noise) / values;
        let bias_squared = credible(blocks.iter().sum(), spread(&blocks)) / values;
        let believed = (1.0 - trust) * bias_squared;
        let by_chance = SMOOTH_BIAS_TOGETHER * sum(&|row| row.smooth_bias_variance);
        let smooth_bias = beyond_chance(sum(&|row| row.smooth_bias), by_chance) / values;
        // shared errors hang together: small images have few that could make up for each other
        let few = 1.0 + SMOOTH_WIDTH / ((width * height) as f64).sqrt();
        let total = NOISE_SAFETY * noise_squared
            + BIAS_SAFETY * believed
            + SMOOTH_NOISE_SAFETY * few * (1.0 + SMOOTH_PASSES / all) * smooth_noise
            + SMOOTH_SAFETY * smooth_bias;
        ErrorEstimate {
            total: total.sqrt(),
            noise: (noise_squared + smooth_noise).sqrt(),
            bias: (bias_squared + smooth_bias).sqrt(),
        }
    }
}

/// Sums over a row of pixels of squared errors, relative to squared radiance.
#[derive(Debug, Clone, Copy, Default)]
struct Row {
    noise: f64,
    smooth_noise: f64,
    /// By blocks across.
    bias: [f64; BLOCKS],
    smooth_bias: f64,
    /// Of that sum, by chance, if pixels were independent.
    smooth_bias_variance: f64,
}

/// Passes from `pass` on, itself among them, that belong to one line; none reaches over a power of two.
pub(crate) fn run(pass: u64) -> u64 {
    let length = if pass < 2 { 1 } else { 1 << (pass.ilog2() - 1) };
    length - pass % length
}

/// The square of what both halves have seen: the harmonic mean of their squares. What only one has seen is an error of a
/// dark pixel, not a bright pixel.
fn common_square(a: f64, b: f64) -> f64 {
    let [a, b] = [a, b].map(|x| x.max(0.0).powi(2));
    if a + b > 0.0 { 2.0 * a * b / (a + b) } else { 0.0 }
}

/// A sum as far as it is credible: S · S²/(S² + its variance), 0 below 0.
fn credible(sum: f64, variance: f64) -> f64 {
    if sum <= 0.0 { 0.0 } else { sum * sum * sum / (sum * sum + variance) }
}

/// A sum as far as it stands out of [`DOUBT`] standard errors: S − D² Var / S, 0 where that is less.
fn beyond_chance(sum: f64, variance: f64) -> f64 {
    if sum <= 0.0 { 0.0 } else { (sum - DOUBT * DOUBT * variance / sum).max(0.0) }
}

/// Variance of the sum of parts that are alike, but for their noise.
fn spread(parts: &[f64]) -> f64 {
    let n = parts.len() as f64;
    let mean = parts.iter().sum::<f64>() / n;
    parts.iter().map(|p| (p - mean).powi(2)).sum::<f64>() * n / (n - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::place_in_half;
    use crate::sampling::rng::random4;

    const SIZE: [u32; 2] = [40, 40];
    const PIXELS: usize = 1600;

    /// The halves after `passes` passes in which each pixel of the diffuse layer has the radiance `at(pass, pixel)`.
    fn after(passes: u64, blur: impl Fn(u64) -> f64, at: impl Fn(u64, usize) -> f64) -> ErrorEstimator {
        sampled(ErrorEstimator::new(SIZE), passes, blur, at)
    }

    /// The same of halves that are given.
    fn sampled(
        mut estimator: ErrorEstimator,
        passes: u64,
        blur: impl Fn(u64) -> f64,
        at: impl Fn(u64, usize) -> f64,
    ) -> ErrorEstimator {
        for pass in 0..passes {
            let mut layers: [Vec<[f32; BANDS]>; LAYERS] = std::array::from_fn(|_| vec![[0.0; BANDS]; PIXELS]);
            for (p, value) in layers[Layer::Diffuse as usize].iter_mut().enumerate() {
                *value = [at(pass, p) as f32; BANDS];
            }
            estimator.add(pass, 1, &layers, blur(pass));
        }
        estimator
    }

    /// Uniform in −1 to 1: variance 1/3.
    fn uniform(pass: u64, pixel: usize) -> f64 {
        2.0 * f64::from(random4(5, pass as u32, pixel as u32, 0)[0]) - 1.0
    }

    /// Independent noise is told to 5 %, and bounded by √2 of it; no bias is seen in it.
    #[test]
    fn noise_of_the_mean_is_found() {
        for passes in [4, 5, 7, 16, 70, 100] {
            let e = after(passes, |_| 1.0, |n, p| 2.0 + 0.1 * uniform(n, p)).error().expect("two halves");
            let truth = 0.1 / (3.0 * passes as f64 * (4.0 + RELATIVE_OFFSET)).sqrt();
            assert!((e.noise / truth - 1.0).abs() < 0.05, "{passes} passes: {e:?}, truth {truth}");
            assert!((e.total / e.noise - NOISE_SAFETY.sqrt()).abs() < 1e-9, "{e:?}");
        }
    }

    /// The unit of power changes nothing: a picture that is dimmer by any factor has the same error, but that bright ones count what is below a
    /// tenth as dark.
    #[test]
    fn dim_pictures_have_the_same_error() {
        let at = |scale: f64| {
            let noisy = |n: u64, p: usize| scale * (2.0 + uniform(n, p));
            after(16, |_| 1.0, noisy).error().expect("two halves").noise
        };
        let dim = at(1e-3);
        for scale in [1e-2, 1e-5, 1e-10] {
            assert!((at(scale) / dim - 1.0).abs() < 1e-4, "{scale}: {} {dim}", at(scale));
        }
        // squares, and as much again where it is dim
        assert!((at(10.0) / dim / 2f64.sqrt() - 1.0).abs() < 0.05, "{} {dim}", at(10.0));
    }

    /// Large images tell their error by a lattice of pixels, each of which is at its place: a gradient across and down is seen as it
    /// is, noise to 15 % of a ninth of the pixels, and the picture is whole.
    #[test]
    fn some_pixels_tell_the_error_of_all() {
        let at = |n: u64, p: usize| 1.0 + p as f64 / 200.0 + 0.1 * uniform(n, p);
        for (most, step) in [(1600, 1), (1599, 2), (400, 2), (399, 3), (196, 3)] {
            let estimator = sampled(ErrorEstimator::with_samples(SIZE, most), 16, |_| 1.0, at);
            let lattice = estimator.lattice;
            assert_eq!((lattice.step, estimator.early.len()), (step, 40usize.div_ceil(step).pow(2)));
            for (sample, early) in estimator.early.iter().enumerate() {
                let mean = early[0] / estimator.early_passes as f64;
                let wanted = 1.0 + lattice.pixel(sample) as f64 / 200.0;
                assert!((mean - wanted).abs() < 0.11, "sample {sample}, step {step}: {mean}, {wanted}");
                let line = estimator.lines.iter().map(|l| l.radiance[sample][0]).sum::<f64>() / 16.0;
                assert!((line - wanted).abs() < 0.11, "sample {sample}, step {step}: {line}, {wanted}");
            }
            assert_eq!(
                estimator.film().picture().whole,
                sampled(ErrorEstimator::new(SIZE), 16, |_| 1.0, at).film().picture().whole
            );
            let even = |n: u64, p: usize| 2.0 + 0.1 * uniform(n, p);
            let estimator = sampled(ErrorEstimator::with_samples(SIZE, most), 16, |_| 1.0, even);
            let noise = estimator.error().expect("two halves").noise;
            let truth = 0.1 / (3.0 * 16.0 * (4.0 + RELATIVE_OFFSET)).sqrt();
            assert!((noise / truth - 1.0).abs() < 0.15, "{noise} {truth}");
        }
    }

    /// What grows with the radius is bias, to 5 % where it stands out of the noise.
    #[test]
    fn blur_is_found() {
        let blur = |pass: u64| ((pass + 1) as f64).powf(-1.0 / 3.0);
        let passes = 256;
        let mean_blur = (0..passes).map(blur).sum::<f64>() / passes as f64;
        for noise in [0.0, 0.1] {
            let estimator = after(passes, blur, |n, p| 2.0 - 0.3 * blur(n) + noise * uniform(n, p));
            let e = estimator.error().expect("two halves");
            let truth = 0.3 * mean_blur / (2.0 - 0.3 * mean_blur);
            assert!((e.bias / truth - 1.0).abs() < 0.05, "{e:?}, truth {truth}");
        }
        // drowned in noise it is not made up
        let e = after(passes, blur, |n, p| 2.0 + uniform(n, p)).error().expect("two halves");
        assert!(e.bias < 0.5 * e.noise, "{e:?}");
    }

    /// The radii of a render, relative to the first.
    fn radius(pass: u64) -> f64 {
        crate::estimators::radii::shrink(2.0 / 3.0, pass).sqrt()
    }

    /// An edge of light, blurred by discs that shrink, is told at no less than a tenth below what it is, nor above 1.3 times
    /// that; blur of smooth light, which grows with the squared radius, at two to three times.
    #[test]
    fn edges_and_smooth_light_are_told_as_blurred() {
        for passes in [16, 64, 256] {
            // rows alike, each with an edge in its middle; the part of a disc around x, of radius r, that lies beyond the edge
            let x = |p: usize| (p % 40) as f64 - 19.5;
            let beyond = |u: f64| {
                let u = u.clamp(-1.0, 1.0);
                (u.acos() - u * (1.0 - u * u).sqrt()) / std::f64::consts::PI
            };
            let blurred = |n: u64, p: usize| 1.0 + beyond(x(p) / (15.0 * radius(n)));
            let sharp = |p: usize| if x(p) < 0.0 { 2.0 } else { 1.0 };
            let mean = |at: &dyn Fn(u64) -> f64| (0..passes).map(at).sum::<f64>() / passes as f64;
            let error =
                |(truth, told): (f64, f64)| ((told - truth) / (told * told + RELATIVE_OFFSET).sqrt()).powi(2);
            let errors = (0..40).map(|p| error((sharp(p), mean(&|n| blurred(n, p)))));
            let truth = (errors.sum::<f64>() / 40.0).sqrt();
            // what is seen as noise is blur that changes: it counts with the rest
            let e = after(passes, radius, blurred).error().expect("two halves");
            let told = BIAS_SAFETY.sqrt() * e.bias / truth;
            assert!((0.9..1.3).contains(&told), "{passes} passes: {told} of {truth}, {e:?}");

            let smooth = |n: u64| 2.0 + 0.2 * radius(n).powi(2);
            let truth = error((2.0, mean(&smooth))).sqrt();
            let e = after(passes, radius, |n, _| smooth(n)).error().expect("two halves");
            let told = BIAS_SAFETY.sqrt() * e.bias / truth;
            assert!((2.0..3.1).contains(&told), "{passes} passes: {told} of {truth}, {e:?}");
        }
    }

    /// The bias of sharing counts as it is where all pixels have it, and not where chance alone makes products of both signs.
    #[test]
    fn the_bias_of_sharing_counts() {
        let (passes, radiance) = (16, 2.0);
        let total_squared = |bias: &dyn Fn(usize) -> f32| {
            let mut estimator = ErrorEstimator::new(SIZE);
            estimator.set_resolves(&[Layer::Diffuse]);
            let mut estimator = sampled(estimator, passes, |_| 0.0, |_, _| radiance);
            let squared_error = (0..PIXELS).map(|p| SquaredError { variance: 0.0, bias: bias(p) }).collect();
            let resolved = Resolved { radiance: vec![[radiance as f32; BANDS]; PIXELS], squared_error };
            estimator.set_resolved(&[(Layer::Diffuse, resolved)]);
            estimator.error().expect("it is resolved").total.powi(2)
        };
        let bias = 1e-3;
        let relative = bias / (radiance * radiance + RELATIVE_OFFSET);
        let even = total_squared(&|_| bias as f32);
        assert!((even / (SMOOTH_SAFETY * relative) - 1.0).abs() < 0.02, "{even}, {relative}");
        let by_chance = total_squared(&|p| if p % 2 == 0 { bias as f32 } else { -bias as f32 });
        assert_eq!(by_chance, 0.0);
        // a tenth of them more of one sign stands out of two standard errors of .053, but not much
        let uneven = total_squared(&|p| if p % 20 < 11 { bias as f32 } else { -bias as f32 });
        assert_eq!(uneven, 0.0);
        let uneven = total_squared(&|p| if p % 20 < 12 { bias as f32 } else { -bias as f32 });
        let hidden = 4.0 * SMOOTH_BIAS_TOGETHER / PIXELS as f64;
        let told = SMOOTH_SAFETY * relative * (0.2 - hidden / 0.2);
        assert!((uneven / told - 1.0).abs() < 0.01, "{uneven}, {told}");
        assert_eq!(total_squared(&|_| 0.0), 0.0);
    }

    /// One pixel in 1600, dark, that a single pass in 128 finds bright: the error of the mean is bounded, though the mean
    /// itself is bright. (Of unequal halves the larger one, seen alone, tells a little less.)
    #[test]
    fn what_one_pass_alone_has_seen_is_an_error() {
        let e = after(128, |_| 0.0, |n, p| if (n, p) == (37, 800) { 64.0 } else { 0.0 });
        let e = e.error().expect("two halves");
        let truth = (0.5f64.powi(2) / RELATIVE_OFFSET / PIXELS as f64).sqrt();
        assert!(e.total > truth && e.total < 3.0 * truth, "{e:?}, truth {truth}");
    }

    /// Halves are equally many at powers of two, and never more than twice as many as the other.
    #[test]
    fn halves_are_halves() {
        let mut counts = [0u64; 2];
        for pass in 0..4096u64 {
            assert_eq!(place_in_half(pass), counts[half(pass)], "{pass}");
            counts[half(pass)] += 1;
            assert!((pass..pass + run(pass)).all(|p| half(p) == half(pass)), "{pass}");
            assert_ne!(half(pass + run(pass)), half(pass), "{pass}");
            let n = pass + 1;
            if n.is_power_of_two() && n > 1 {
                assert_eq!(counts[0], counts[1], "{n}");
            }
            assert!(n < 2 || counts[0] <= 2 * counts[1], "{n}: {counts:?}");
        }
    }
}
