//! Report: what a render did, as JSON.

use crate::backend::{HostSeconds, NonFinite};
use crate::packed::PackedScene;
use crate::plan::{Plan, Skip};
use crate::render::{Failure, Reason, Rendered};
use crate::spectrum::BANDS;
use serde::Serialize;

/// Everything that `--report` writes. Lengths and powers are in the user's world units.
#[derive(Debug, Serialize)]
pub struct Report {
    /// The device and its driver.
    pub device: String,
    /// Passes rendered.
    pub passes: u64,
    /// Seconds of rendering, set-up left out.
    pub seconds: f64,
    /// Seconds from the start of the program to the first pass.
    pub setup_seconds: f64,
    /// Processor seconds of all threads while rendering.
    pub cpu_seconds: f64,
    /// Why it stopped.
    pub stopped_by: Reason,
    /// Devices that failed before, and how many passes there were then; the others were rendered by those that followed.
    pub device_failures: Vec<Failure>,
    /// Rays of all kinds.
    pub rays: u64,
    /// Jotons that started.
    pub jotons_emitted: u64,
    /// Jotons stored in the maps.
    pub jotons_stored: u64,
    /// Where the light went.
    pub energy: Energy,
    /// What was not done, and why.
    pub skipped: Vec<Skip>,
    /// What was saved inside passes.
    pub saved: Saved,
    /// Radii of the maps.
    pub radius: Radius,
    /// Largest resident memory of the process; none where the system does not tell.
    pub peak_memory_bytes: Option<u64>,
    /// Estimated relative error, root mean square, noise and bias; none where there were too few passes.
    pub error_estimate: Option<f64>,
    /// What part of it is noise …
    pub error_noise: Option<f64>,
    /// … and what bias: the blur of the radii.
    pub error_bias: Option<f64>,
    /// Contributions that were not finite and were left out, by cause.
    #[serde(serialize_with = "NonFinite::by_cause")]
    pub non_finite: NonFinite,
    /// Paths cut at the hard limit of their length.
    pub truncated: u64,
    /// Seconds and dispatches of each kernel, where they were measured (--timings).
    pub kernels: Vec<KernelTime>,
    /// Where the seconds of rendering went: `device` is the kernels, the rest work of the host that a device waits for.
    #[serde(serialize_with = "HostSeconds::as_object")]
    pub host: HostSeconds,
    /// Where the seconds of set-up went, by name.
    #[serde(serialize_with = "as_object")]
    pub setup: Vec<(&'static str, f64)>,
    /// What was repaired or ignored in the scene.
    pub warnings: Vec<String>,
    /// Renders of bands for who measures, beside that of red, green and blue, which the rest tells.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub bands: Vec<BandsRender>,
}

/// A render of bands for who measures  \[E53\].
#[derive(Debug, Clone, Serialize)]
pub struct BandsRender {
    /// Wavelengths, nm.
    pub wavelengths: Vec<f64>,
    /// The device and its driver.
    pub device: String,
    /// Passes rendered.
    pub passes: u64,
    /// Seconds of rendering, set-up left out.
    pub seconds: f64,
    /// Seconds before the first pass.
    pub setup_seconds: f64,
    /// Why it stopped.
    pub stopped_by: Reason,
    /// Devices that failed before.
    pub device_failures: Vec<Failure>,
    /// Rays of all kinds.
    pub rays: u64,
    /// Estimated relative error of these bands.
    pub error_estimate: Option<f64>,
    /// Contributions that were not finite and were left out, by cause.
    #[serde(serialize_with = "NonFinite::by_cause")]
    pub non_finite: NonFinite,
}

/// Pairs as an object.
fn as_object<S: serde::Serializer>(pairs: &[(&'static str, f64)], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().copied())
}

/// What was saved inside passes: work that would not have changed the expected image.
#[derive(Debug, Serialize)]
pub struct Saved {
    /// Pixels of all passes that were not traced, since they rested.
    pub pixels_rested: u64,
    /// Jotons that were not stored, since the camera does not look where they are.
    pub jotons_not_stored: u64,
    /// Shadow rays that were not traced, since another one stood for them.
    pub shadow_rays_not_traced: u64,
}

/// What a kernel took.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct KernelTime {
    /// File and entry point.
    pub name: String,
    /// Seconds on the device.
    pub seconds: f64,
    /// Times it ran.
    pub dispatches: u64,
}

/// Flux, W per band, of a mean pass, and how well it balances.
#[derive(Debug, Serialize)]
pub struct Energy {
    /// Flux that started.
    pub emitted: [f64; BANDS],
    /// Flux that surfaces absorbed.
    pub absorbed: [f64; BANDS],
    /// Flux that left the scene.
    pub escaped: [f64; BANDS],
    /// (emitted − absorbed − escaped) / emitted, all bands together.
    pub imbalance: Option<f64>,
    /// Standard error of the imbalance: the roulette's own.
    pub standard_error: Option<f64>,
}

/// Gather radii, world units.
#[derive(Debug, Serialize)]
pub struct Radius {
    /// Largest of the caustic map, first and last pass; none where it is skipped.
    pub caustic: Option<[f64; 2]>,
    /// Of the diffuse map.
    pub diffuse: Option<[f64; 2]>,
}

/// What the command line measured around the render.
#[derive(Debug, Clone)]
pub struct Circumstances {
    /// The device and its driver.
    pub device: String,
    /// Seconds before the first pass.
    pub setup_seconds: f64,
    /// Where they went, by name.
    pub setup: Vec<(&'static str, f64)>,
    /// What each kernel took.
    pub kernels: Vec<KernelTime>,
    /// What was repaired or ignored in the scene.
    pub warnings: Vec<String>,
}

impl Report {
    /// Gather the report of a render.
    pub fn new(rendered: &Rendered, scene: &PackedScene, plan: &Plan, around: Circumstances) -> Self {
        let t = &rendered.tally;
        let passes = rendered.passes.max(1) as f64;
        let world = |flux: &[f64; BANDS]| flux.map(|f| f * scene.world_scale * scene.world_scale / passes);
        let total = |flux: &[f64; BANDS]| flux.iter().sum::<f64>();
        let emitted = total(&t.emitted);
        let radius = |jotons: u32, schedule: &crate::estimators::radii::Schedule| {
            let at = |pass| schedule.radius(pass) * scene.world_scale;
            (jotons > 0).then(|| [at(0), at(rendered.passes.saturating_sub(1))])
        };
        Self {
            device: around.device,
            passes: rendered.passes,
            seconds: rendered.seconds,
            setup_seconds: around.setup_seconds,
            cpu_seconds: rendered.cpu_seconds,
            stopped_by: rendered.reason,
            device_failures: rendered.failures.clone(),
            rays: t.rays,
            jotons_emitted: t.jotons_emitted,
            jotons_stored: t.jotons_stored,
            saved: Saved {
                pixels_rested: t.pixels_rested,
                jotons_not_stored: t.jotons_not_stored,
                shadow_rays_not_traced: t.shadow_rays_saved,
            },
            energy: Energy {
                emitted: world(&t.emitted),
                absorbed: world(&t.absorbed),
                escaped: world(&t.escaped),
                imbalance: (emitted > 0.0)
                    .then(|| (emitted - total(&t.absorbed) - total(&t.escaped)) / emitted),
                standard_error: rendered.energy_error,
            },
            skipped: plan.skipped.clone(),
            radius: Radius {
                caustic: radius(plan.caustic_jotons, &plan.caustic),
                diffuse: radius(plan.diffuse_jotons, &plan.diffuse),
            },
            peak_memory_bytes: crate::host::memory::peak(),
            error_estimate: rendered.error_estimate.map(|e| e.total),
            error_noise: rendered.error_estimate.map(|e| e.noise),
            error_bias: rendered.error_estimate.map(|e| e.bias),
            non_finite: t.non_finite,
            truncated: t.truncated,
            kernels: around.kernels,
            host: rendered.host,
            setup: around.setup,
            warnings: around.warnings,
            bands: Vec::new(),
        }
    }
}
