//! Ladder: the pictures that were seen at the steps of a ladder of times, compared, and summed up over the seeds.

use super::subject::Subject;
use super::{Row, Summary};
use crate::Result;
use crate::film::{Image, RELATIVE_OFFSET};
use crate::output::compare::compare;
use crate::spectrum::BANDS;

/// How a picture came about.
pub(super) struct PictureRun {
    /// The device's or renderer's own words.
    pub(super) device_name: String,
    /// Seed of the random numbers.
    pub(super) seed: u32,
    /// Seconds of rendering.
    pub(super) seconds: f64,
    /// Processor seconds of all threads.
    pub(super) cpu_seconds: f64,
    /// Passes, or samples a pixel.
    pub(super) passes: u64,
    /// Rays, where they are counted.
    pub(super) rays: Option<u64>,
    /// Jotons, where there are any.
    pub(super) jotons: Option<u64>,
    /// Bytes of the device's buffers, where there are any.
    pub(super) device_bytes: Option<u64>,
    /// The renderer's own estimate of its relative error, root mean square.
    pub(super) error_estimate: Option<f64>,
}

/// All pictures of a subject.
pub(super) struct Ladder<'a> {
    subject: &'a Subject<'a>,
    rows: Vec<Row>,
    /// One for each step.
    spreads: Vec<Spread>,
}

impl<'a> Ladder<'a> {
    pub(super) fn new(subject: &'a Subject<'a>) -> Self {
        let spreads = subject.times.iter().map(|_| Spread::new(subject.size)).collect();
        Self { subject, rows: Vec::new(), spreads }
    }

    /// Add the picture of the step with this index; its row.
    pub(super) fn add(&mut self, step: usize, seen: PictureRun, image: &Image) -> Result<&Row> {
        let comparison = self.subject.reference.map(|r| compare(image, r)).transpose()?;
        self.spreads[step].add(image);
        self.rows.push(Row {
            scene: self.subject.scene.into(),
            device: self.subject.device.into(),
            device_name: seen.device_name,
            seed: seen.seed,
            step: self.subject.times[step],
            seconds: seen.seconds,
            cpu_seconds: seen.cpu_seconds,
            passes: seen.passes,
            rays: seen.rays,
            jotons: seen.jotons,
            device_bytes: seen.device_bytes,
            error_estimate: seen.error_estimate,
            comparison,
        });
        Ok(&self.rows[self.rows.len() - 1])
    }

    /// The rows, and a summary for each step that was reached.
    pub(super) fn finish(self) -> (Vec<Row>, Vec<Summary>) {
        let steps = self.subject.times.iter().zip(&self.spreads);
        let summaries = steps.filter_map(|(&step, spread)| {
            let of_step: Vec<&Row> = self.rows.iter().filter(|r| r.step == step).collect();
            (!of_step.is_empty()).then(|| summary(self.subject, step, &of_step, spread))
        });
        let summaries = summaries.collect();
        (self.rows, summaries)
    }
}

fn summary(subject: &Subject<'_>, step: f64, rows: &[&Row], spread: &Spread) -> Summary {
    let mean = |f: &dyn Fn(&Row) -> f64| rows.iter().map(|r| f(r)).sum::<f64>() / rows.len() as f64;
    let known = |f: &dyn Fn(&Row) -> Option<f64>| -> Option<f64> {
        rows.iter().map(|r| f(r)).sum::<Option<f64>>().map(|sum| sum / rows.len() as f64)
    };
    let parts = spread.bias_and_variance(subject.reference);
    Summary {
        scene: subject.scene.into(),
        device: subject.device.into(),
        device_name: rows.first().map_or(String::new(), |r| r.device_name.clone()),
        step,
        seeds: rows.len() as u32,
        seconds: mean(&|r| r.seconds),
        cpu_seconds: mean(&|r| r.cpu_seconds),
        passes: mean(&|r| r.passes as f64),
        rel_mse: known(&|r| r.comparison.as_ref().map(|c| c.rel_mse)),
        estimated_rel_mse: known(&|r| r.error_estimate.map(|e| e * e)),
        rel_bias_squared: parts.and_then(|p| p.0),
        rel_variance: parts.map(|p| p.1),
    }
}

/// Mean and spread of each pixel over the seeds (Welford 1962).
struct Spread {
    count: f64,
    mean: Vec<[f64; BANDS]>,
    /// Sum of squared distances from the mean.
    squares: Vec<[f64; BANDS]>,
}

impl Spread {
    fn new(size: [u32; 2]) -> Self {
        let empty = vec![[0.0; BANDS]; size[0] as usize * size[1] as usize];
        Self { count: 0.0, mean: empty.clone(), squares: empty }
    }

    fn add(&mut self, image: &Image) {
        self.count += 1.0;
        for ((mean, squares), pixel) in self.mean.iter_mut().zip(&mut self.squares).zip(&image.pixels) {
            for b in 0..BANDS {
                let x = f64::from(pixel[b]);
                let before = x - mean[b];
                mean[b] += before / self.count;
                squares[b] += before * (x - mean[b]);
            }
        }
    }

    /// Squared bias (where there is a reference) and variance of one seed's picture, both relative; their sum is the
    /// expected relMSE. None below two seeds.
    fn bias_and_variance(&self, reference: Option<&Image>) -> Option<(Option<f64>, f64)> {
        if self.count < 2.0 {
            return None;
        }
        let values = (self.mean.len() * BANDS) as f64;
        let (mut bias, mut variance) = (0.0, 0.0);
        for (p, (mean, squares)) in self.mean.iter().zip(&self.squares).enumerate() {
            for b in 0..BANDS {
                let of_seed = squares[b] / (self.count - 1.0);
                let truth = reference.map_or(mean[b], |r| f64::from(r.pixels[p][b]));
                // as in `compare`: what the reference does not know is no error
                if !truth.is_finite() {
                    continue;
                }
                let scale = 1.0 / (truth * truth + RELATIVE_OFFSET);
                variance += of_seed * scale / values;
                bias += ((mean[b] - truth).powi(2) - of_seed / self.count) * scale / values;
            }
        }
        Some((reference.map(|_| bias), variance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image(value: f32) -> Image {
        Image { width: 2, height: 1, pixels: vec![[value; BANDS]; 2] }
    }

    /// Pictures 1.1 and 1.3 of a truth of 1: variance 0.02, and bias² 0.2² less half the variance; over 1² + RELATIVE_OFFSET.
    #[test]
    fn bias_and_variance_are_told_apart() {
        let mut spread = Spread::new([2, 1]);
        spread.add(&image(1.1));
        assert_eq!(spread.bias_and_variance(None), None);
        spread.add(&image(1.3));
        let (bias, variance) = spread.bias_and_variance(Some(&image(1.0))).expect("two seeds");
        let scale = 1.0 / (1.0 + RELATIVE_OFFSET);
        assert!((variance - 0.02 * scale).abs() < 1e-6, "{variance}");
        assert!((bias.expect("a reference") - (0.04 - 0.01) * scale).abs() < 1e-6, "{bias:?}");
        let mean_error = (0.01 + 0.09) / 2.0 * scale;
        assert!((bias.unwrap_or(0.0) + variance - mean_error).abs() < 1e-6, "their sum is the mean error");
    }
}
