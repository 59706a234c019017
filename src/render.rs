//! Render: pass after pass on a backend until the picture is good enough, the time is up or the user stops it.

use crate::backend::{Backend, PASSES_MAX, Tally};
use crate::bands::BANDS;
use crate::error::Result;
use crate::film::{Layer, Picture};
use crate::glints;
pub use crate::halves::ErrorEstimate;
use crate::halves::{self, Halves};
use crate::quiet::Quiet;
use crate::rest::Rest;
use std::time::Instant;

/// When to stop; the first that is met. None at all: until the error estimate is [`DEFAULT_ERROR`], at most
/// [`DEFAULT_SECONDS`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stop {
    /// After this many passes; after [`PASSES_MAX`] in any case.
    pub passes: Option<u64>,
    /// After this many seconds of rendering.
    pub seconds: Option<f64>,
    /// When the error estimate (relative, root mean square) is at most this.
    pub error: Option<f64>,
}

/// Error estimate at which a render stops where nothing else is asked for.
pub const DEFAULT_ERROR: f64 = 0.02;
/// Seconds after which a render stops where nothing else is asked for.
pub const DEFAULT_SECONDS: f64 = 60.0;

/// Why a render stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reason {
    /// All passes are done.
    Passes,
    /// The time is up.
    Time,
    /// The error estimate is small enough.
    Error,
    /// The user stopped it.
    Interrupted,
}

/// How far a render is.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Passes done.
    pub passes: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Estimate of the error; none before there are passes enough.
    pub error: Option<ErrorEstimate>,
    /// Part of the work that is done, 0 to 1, as far as it can be told.
    pub done: f64,
    /// Processor seconds of all threads while rendering.
    pub cpu_seconds: f64,
    /// Sums of all counts so far.
    pub tally: &'a Tally,
    halves: &'a Halves,
}

impl Progress<'_> {
    /// The mean of the passes so far. Computed for who asks; the time that takes is not counted as rendering.
    pub fn picture(&self) -> Picture {
        self.halves.picture()
    }
}

/// Seconds of rendering, without what the watcher does in between.
struct Clock {
    since: Instant,
    cpu_since: cpu_time::ProcessTime,
    before: [f64; 2],
}

impl Clock {
    fn start() -> Self {
        Self { since: Instant::now(), cpu_since: cpu_time::ProcessTime::now(), before: [0.0; 2] }
    }

    /// Seconds, and processor seconds of all threads.
    fn read(&self) -> [f64; 2] {
        let now = [self.since.elapsed(), self.cpu_since.elapsed()].map(|d| d.as_secs_f64());
        [self.before[0] + now[0], self.before[1] + now[1]]
    }

    /// Go on from an earlier reading.
    fn go_on_from(&mut self, reading: [f64; 2]) {
        *self = Self { before: reading, ..Self::start() };
    }
}

/// A finished render.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The mean of the passes.
    pub picture: Picture,
    /// Passes in it.
    pub passes: u64,
    /// Seconds of rendering, without set-up.
    pub seconds: f64,
    /// Processor seconds of all threads while rendering.
    pub cpu_seconds: f64,
    /// Sums of all counts.
    pub tally: Tally,
    /// Standard error of (emitted − absorbed − escaped) / emitted, from the spread between batches.
    pub energy_error: Option<f64>,
    /// Estimate of the error.
    pub error_estimate: Option<ErrorEstimate>,
    /// Why it stopped.
    pub reason: Reason,
}

/// Passes before an error estimate is trusted.
const ERROR_PASSES: u64 = 4;

/// Render until `stop`; `watch` sees every batch and returns false to stop.
///
/// # Errors
/// What the backend reports.
pub fn render(
    backend: &mut dyn Backend,
    size: [u32; 2],
    stop: Stop,
    mut watch: impl FnMut(&Progress<'_>) -> bool,
) -> Result<Rendered> {
    let stop = if stop == Stop::default() {
        Stop { error: Some(DEFAULT_ERROR), seconds: Some(DEFAULT_SECONDS), passes: None }
    } else {
        stop
    };
    let most = stop.passes.unwrap_or(PASSES_MAX).min(PASSES_MAX);
    let mut sums = Halves::new(size);
    let mut quiet = backend.rest(&Rest::none(size)).then(|| Quiet::new(size));
    let mut glimpses = glints::Watch::new(size);
    let mut tally = Tally::default();
    let mut imbalance = Imbalance::default();
    let mut passes = 0u64;
    let mut error = None;
    let mut clock = Clock::start();
    loop {
        let count = batch(passes, backend.batch_passes(passes), most);
        let mut batch = backend.render(passes, count as u32)?;
        // black layers are not summed
        for layer in Layer::ALL.into_iter().filter(|l| !backend.traces(*l)) {
            batch.layers[layer as usize] = Vec::new();
        }
        sums.add(passes, count, &batch.layers, mean_blur(backend, passes, count));
        tally += batch.tally;
        imbalance.add(count, &batch.tally);
        passes += count;
        if let Some(glints) = backend.glints() {
            glimpses.watch(count, &batch.layers[Layer::Emission as usize], glints);
            if passes > 1 && passes.is_power_of_two() {
                let grown = glimpses.grown(glints, sums.film());
                backend.set_glints(grown)?;
            }
        }
        if let Some(quiet) = &mut quiet {
            quiet.watch(passes - count, count, &batch.layers);
            if let Some(rest) = quiet.renew(passes, backend.glints()) {
                backend.rest(rest);
                sums.set_rest(rest.clone());
            }
        }
        if is_estimated(passes) {
            error = sums.error();
        }
        let reading = clock.read();
        let [seconds, cpu_seconds] = reading;

        let reached =
            |value: Option<f64>, limit: Option<f64>| matches!((value, limit), (Some(v), Some(l)) if v <= l);
        let part = |value: f64, limit: Option<f64>| limit.map_or(0.0, |l| value / l);
        let total = error.map(|e| e.total);
        let by_error = match (total, stop.error) {
            (Some(e), Some(l)) => (l / e).powi(2),
            _ => 0.0,
        };
        let done =
            part(passes as f64, stop.passes.map(|p| p as f64)).max(part(seconds, stop.seconds)).max(by_error);
        let done = done.min(1.0);
        let go_on =
            watch(&Progress { passes, seconds, error, done, cpu_seconds, tally: &tally, halves: &sums });
        clock.go_on_from(reading);
        let reason = if passes >= most {
            Some(Reason::Passes)
        } else if reached(total, stop.error) {
            Some(Reason::Error)
        } else if !go_on {
            Some(Reason::Interrupted)
        } else if stop.seconds.is_some_and(|most| seconds >= most) {
            Some(Reason::Time)
        } else {
            None
        };
        if let Some(reason) = reason {
            // the picture takes its place
            drop(batch);
            return Ok(Rendered {
                picture: sums.picture(),
                passes,
                seconds,
                cpu_seconds,
                tally,
                energy_error: imbalance.relative_error(),
                error_estimate: if passes < ERROR_PASSES || is_estimated(passes) {
                    error
                } else {
                    sums.error()
                },
                reason,
            });
        }
    }
}

/// Passes of the batch from pass `first` on, where the backend would like so many, of `most` in all: powers of two, which blocks
/// of resting tiles are whole parts of, or whole multiples.
fn batch(first: u64, wanted: u32, most: u64) -> u64 {
    1 << u64::from(wanted).min(halves::run(first)).min(most - first).ilog2()
}

/// Whether the error is estimated after so many passes: after each one first, later after every sixteenth part of them, so
/// that it costs nothing.
fn is_estimated(passes: u64) -> bool {
    passes >= ERROR_PASSES && passes.is_multiple_of(1 << passes.ilog2().saturating_sub(4))
}

/// Mean of the maps' blur over `count` passes.
fn mean_blur(backend: &dyn Backend, first: u64, count: u64) -> f64 {
    (first..first + count).map(|pass| backend.blur(pass)).sum::<f64>() / count as f64
}

/// Spread between batches of emitted − absorbed − escaped.
#[derive(Default)]
struct Imbalance {
    batches: Vec<(f64, f64)>,
    emitted: f64,
}

impl Imbalance {
    fn add(&mut self, passes: u64, t: &Tally) {
        let total = |x: &[f64; BANDS]| x.iter().sum::<f64>();
        self.batches.push((passes as f64, total(&t.emitted) - total(&t.absorbed) - total(&t.escaped)));
        self.emitted += total(&t.emitted);
    }

    /// Standard error of the sum over the emitted flux.
    fn relative_error(&self) -> Option<f64> {
        let n = self.batches.len() as f64;
        if n < 2.0 || self.emitted <= 0.0 {
            return None;
        }
        let passes: f64 = self.batches.iter().map(|b| b.0).sum();
        let mean: f64 = self.batches.iter().map(|b| b.1).sum::<f64>() / passes;
        let per_pass = self.batches.iter().map(|(p, d)| (d - p * mean).powi(2) / p).sum::<f64>() / (n - 1.0);
        Some((per_pass * passes).sqrt() / self.emitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::backend::Batch;
    use std::time::Duration;

    /// One pixel that is as bright as the number of its pass.
    struct Counter;

    impl Backend for Counter {
        fn describe(&self) -> String {
            "counter".into()
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            let sum: f32 = (first..first + u64::from(count)).map(|pass| pass as f32).sum();
            Ok(Batch { layers: std::array::from_fn(|_| vec![[sum; BANDS]]), tally: Tally::default() })
        }
    }

    /// A render ends before its passes have numbers of more than 32 bits, or the pilot's.
    #[test]
    fn passes_end_before_their_numbers_do() {
        let mut passes = 0;
        while passes < PASSES_MAX {
            passes += batch(passes, u32::MAX, PASSES_MAX);
        }
        assert_eq!(passes - 1, u64::from(u32::MAX) - 1);
        let last = u64::from(crate::layout::PILOT_PASS);
        assert_eq!(PASSES_MAX, last, "the pilot's pass comes after all others");
    }

    /// A watcher sees the picture so far, layers summed, and its own time is not counted as rendering.
    #[test]
    fn watching_is_free_and_sees_the_picture() {
        let nap = Duration::from_millis(40);
        let mut seen = Vec::new();
        let stop = Stop { passes: Some(4), ..Stop::default() };
        let rendered = render(&mut Counter, [1, 1], stop, |p| {
            seen.push((p.passes, p.picture().whole.pixels[0][0]));
            std::thread::sleep(nap);
            true
        })
        .expect("a picture");
        // means of 0, 0 1, 0 1 2, 0 1 2 3, in each of four layers
        assert_eq!(seen, [(1, 0.0), (2, 2.0), (3, 4.0), (4, 6.0)]);
        assert_eq!(rendered.picture.whole.pixels[0][0], 6.0);
        assert!(rendered.seconds < nap.as_secs_f64(), "{} s for nothing but naps", rendered.seconds);
    }
}
