//! Run: render with each seed and look at the picture at every step of a ladder of times.

use super::{Row, Summary};
use crate::Result;
use crate::backend::Backend;
use crate::bands::BANDS;
use crate::film::Image;
use crate::output::compare::{OFFSET, compare};
use crate::render::{Progress, Stop, render};

/// What is measured: a scene on a device.
pub struct Subject<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// The device as it was asked for.
    pub device: &'a str,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// What the picture should be.
    pub reference: Option<&'a Image>,
    /// Steps of the ladder, seconds of rendering, ascending and above 0.
    pub times: &'a [f64],
    /// Seeds 0, 1, … below this.
    pub seeds: u32,
}

/// Measure a subject. `open` sets a device up for a seed; `see` is shown each row as it is found, and returns false to
/// stop. Set-up, comparing and `see` are not part of any time.
///
/// # Errors
/// What opening or rendering reports.
pub fn measure(
    subject: &Subject<'_>,
    mut open: impl FnMut(u32) -> Result<Box<dyn Backend>>,
    mut see: impl FnMut(&Row) -> bool,
) -> Result<(Vec<Row>, Vec<Summary>)> {
    let mut rows: Vec<Row> = Vec::new();
    let mut spreads: Vec<Spread> = subject.times.iter().map(|_| Spread::new(subject.size)).collect();
    for seed in 0..subject.seeds {
        let mut backend = open(seed)?;
        let device_name = backend.describe();
        let stop = Stop { seconds: subject.times.last().copied(), ..Stop::default() };
        let (mut steps_done, mut go_on, mut failure) = (0, true, None);
        render(backend.as_mut(), subject.size, stop, |progress| {
            // a slow pass may skip steps: its picture belongs to the last one that it reached
            let reached = subject.times.partition_point(|t| *t <= progress.seconds);
            if reached == steps_done {
                return true;
            }
            steps_done = reached;
            let step = reached - 1;
            match row(subject, seed, &device_name, step, progress, &mut spreads[step]) {
                Ok(row) => {
                    go_on = see(&row);
                    rows.push(row);
                }
                Err(e) => failure = Some(e),
            }
            go_on && failure.is_none()
        })?;
        if let Some(e) = failure {
            return Err(e);
        }
        if !go_on {
            break;
        }
    }
    let summaries = subject.times.iter().zip(&spreads).filter_map(|(&step, spread)| {
        let of_step: Vec<&Row> = rows.iter().filter(|r| r.step == step).collect();
        (!of_step.is_empty()).then(|| summary(subject, step, &of_step, spread))
    });
    Ok((rows.clone(), summaries.collect()))
}

fn row(
    subject: &Subject<'_>,
    seed: u32,
    device_name: &str,
    step: usize,
    progress: &Progress<'_>,
    spread: &mut Spread,
) -> Result<Row> {
    let image = progress.picture().whole;
    spread.add(&image);
    Ok(Row {
        scene: subject.scene.into(),
        device: subject.device.into(),
        device_name: device_name.into(),
        seed,
        step: subject.times[step],
        seconds: progress.seconds,
        cpu_seconds: progress.cpu_seconds,
        passes: progress.passes,
        rays: progress.tally.rays,
        jotons: progress.tally.jotons_emitted,
        error_estimate: progress.error.map(|e| e.total),
        comparison: subject.reference.map(|r| compare(&image, r)).transpose()?,
    })
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
                let scale = 1.0 / (truth * truth + OFFSET);
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

    /// Pictures 1.1 and 1.3 of a truth of 1: variance 0.02, and bias² 0.2² less half the variance; over 1² + OFFSET.
    #[test]
    fn bias_and_variance_are_told_apart() {
        let mut spread = Spread::new([2, 1]);
        spread.add(&image(1.1));
        assert_eq!(spread.bias_and_variance(None), None);
        spread.add(&image(1.3));
        let (bias, variance) = spread.bias_and_variance(Some(&image(1.0))).expect("two seeds");
        let scale = 1.0 / (1.0 + OFFSET);
        assert!((variance - 0.02 * scale).abs() < 1e-6, "{variance}");
        assert!((bias.expect("a reference") - (0.04 - 0.01) * scale).abs() < 1e-6, "{bias:?}");
        let mean_error = (0.01 + 0.09) / 2.0 * scale;
        assert!((bias.unwrap_or(0.0) + variance - mean_error).abs() < 1e-6, "their sum is the mean error");
    }
}
