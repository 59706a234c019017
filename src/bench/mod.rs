//! Bench: error over time of each device on each scene, with bias and variance apart where several seeds ran.
//!
//! `run` renders and measures, `versus` lets other renderers do so, `ladder` collects what they saw, `csv` and `plot`
//! write it.

mod csv;
mod ladder;
mod plot;
mod run;
mod subject;
pub mod versus;

pub use csv::{kernels_csv, runs_csv, summary_csv};
pub use plot::error_plot;
pub use run::{Measured, measure};
pub use subject::{Clock, Subject};

use crate::output::compare::Comparison;

/// One picture on the way: a scene on a device with a seed, after some time.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Name of the scene.
    pub scene: String,
    /// The device as it was asked for: gpu, cpu, cpu-reference or a part of a name; or another renderer and its
    /// algorithm (mitsuba-path).
    pub device: String,
    /// The device's own words.
    pub device_name: String,
    /// Seed of the random numbers.
    pub seed: u32,
    /// The step of the ladder that was reached, seconds.
    pub step: f64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Processor seconds of all threads.
    pub cpu_seconds: f64,
    /// Passes in the picture; samples a pixel of other renderers.
    pub passes: u64,
    /// Rays of all kinds, where they are counted.
    pub rays: Option<u64>,
    /// Jotons emitted; none in other renderers.
    pub jotons: Option<u64>,
    /// Bytes of the device's buffers, where there are any.
    pub device_bytes: Option<u64>,
    /// The renderer's own estimate of its relative error, root mean square.
    pub error_estimate: Option<f64>,
    /// Against the reference, where there is one.
    pub comparison: Option<Comparison>,
}

/// What a kernel took in all passes of one seed.
#[derive(Debug, Clone, PartialEq)]
pub struct KernelRow {
    /// Name of the scene.
    pub scene: String,
    /// The device as it was asked for.
    pub device: String,
    /// Seed of the random numbers.
    pub seed: u32,
    /// Passes in which it was measured.
    pub passes: u64,
    /// File and entry point.
    pub kernel: String,
    /// Seconds on the device.
    pub seconds: f64,
    /// Times it ran.
    pub dispatches: u64,
}

/// All seeds of a scene on a device at one step of the ladder.
#[derive(Debug, Clone, PartialEq)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// The device as it was asked for.
    pub device: String,
    /// The device's own words.
    pub device_name: String,
    /// The step of the ladder, seconds.
    pub step: f64,
    /// Seeds that got there.
    pub seeds: u32,
    /// Mean seconds of rendering.
    pub seconds: f64,
    /// Mean processor seconds.
    pub cpu_seconds: f64,
    /// Mean number of passes.
    pub passes: f64,
    /// Mean over the seeds of the relative mean square error against the reference.
    pub rel_mse: Option<f64>,
    /// Mean square of the renderer's own error estimates; several bands and pixels, relative.
    pub estimated_rel_mse: Option<f64>,
    /// The part of `rel_mse` that more passes with other seeds would not remove: (mean over seeds − reference)², less
    /// the noise of that mean; may come out below zero where it is nothing but noise. None below two seeds.
    pub rel_bias_squared: Option<f64>,
    /// The part of `rel_mse` that differs from seed to seed. Over the reference, or over the mean where there is no
    /// reference. None below two seeds.
    pub rel_variance: Option<f64>,
}

impl Summary {
    /// What is plotted: the error against the reference, else its estimate.
    pub fn error(&self) -> Option<f64> {
        self.rel_mse.or(self.estimated_rel_mse)
    }
}
