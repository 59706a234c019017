//! Backend: what a device that renders passes must offer, and what it hands back.

pub mod cpu;
pub mod gpu;
mod host_seconds;

use crate::error::Result;
use crate::estimators::split_paths::SplitPaths;
use crate::film::tile_schedule::TileSchedule;
use crate::film::{LAYERS, Layer};
pub use crate::host::guard::{guarded, is_guarded};
use crate::resolve::Resolver;
use crate::spectrum::{BANDS, BLACK, Bands};
pub use host_seconds::{HostSeconds, HostWork};
use rayon::prelude::*;
use std::ops::Range;
use std::sync::Arc;

/// Most passes of a render: random numbers know a pass by 32 bits, and the last of them is the pilot's.
pub const PASSES_MAX: u64 = u32::MAX as u64;

/// Passes of a batch, at most, a power of two: they are summed in f32.
pub const BATCH_PASSES_MAX: u32 = 16;

/// A device that renders passes of a plan. Passes are independent given their index: any order, any split into calls,
/// gives the same sums up to rounding.
pub trait Backend {
    /// One line: the device and how it is driven.
    fn describe(&self) -> String;

    /// From now on measure what each kernel takes (a little slower); nothing where the device cannot.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails.
    fn measure_kernels(&mut self) -> Result<()> {
        Ok(())
    }

    /// Name, seconds and dispatches of each kernel since [`Backend::measure_kernels`].
    fn kernel_seconds(&self) -> Vec<(String, f64, u64)> {
        Vec::new()
    }

    /// What the host spent on this device's behalf since this was asked last; but for [`HostWork::Device`], which who calls can tell.
    fn take_host_seconds(&mut self) -> HostSeconds {
        HostSeconds::default()
    }

    /// Bytes of the device's buffers; none where the backend has none of its own.
    fn device_bytes(&self) -> Option<u64> {
        None
    }

    /// How many passes one call should render from `first` on, at most [`BATCH_PASSES_MAX`]. It depends on the pass only, never on the clock: a call's
    /// passes are summed in f32, and another split would round otherwise.
    fn batch_passes(&self, first: u64) -> u32 {
        let _ = first;
        1
    }

    /// How much the maps are blurred in a pass: the radius of their estimates, relative to the first pass; 0 without maps.
    fn blur(&self, pass: u64) -> f64 {
        let _ = pass;
        0.0
    }

    /// Whether a layer can hold light at all: the others are black in every batch.
    fn traces(&self, layer: Layer) -> bool {
        let _ = layer;
        true
    }

    /// Smooths the indirect light of a picture; none where it is not to be smoothed.
    fn resolver(&self) -> Option<Arc<Resolver>> {
        None
    }

    /// From now on tiles rest as told: a batch holds the sums of the passes that each takes part in. False where the backend
    /// does not do that; then it renders everything.
    fn set_tile_schedule(&mut self, schedule: &TileSchedule) -> bool {
        let _ = schedule;
        false
    }

    /// The pixels in which trees look for emission, from the first batch on; none where that is not done.
    fn split_paths(&self) -> Option<&SplitPaths> {
        None
    }

    /// From now on grow so many trees: more than before, between two powers of two of passes.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails.
    fn set_split_paths(&mut self, glints: SplitPaths) -> Result<()> {
        let _ = glints;
        Ok(())
    }

    /// Whether it pays to [`Backend::begin`]: the host's work is not in the way of the device's.
    fn works_beside_host(&self) -> bool {
        false
    }

    /// Begin with passes that [`Backend::render`] will be asked for, in the order in which this was called, while the host is busy with
    /// those before. Where something else is asked for, what has begun is for nothing. A backend need not.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails.
    fn begin(&mut self, first: u64, count: u32) -> Result<()> {
        let _ = (first, count);
        Ok(())
    }

    /// Render passes `first .. first + count`, numbered from 0, below [`PASSES_MAX`].
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails, [`crate::Error::Capacity`] where a pass does not fit.
    fn render(&mut self, first: u64, count: u32) -> Result<Batch>;

    /// Take a batch back that nobody needs any more: the next one has its memory.
    fn reuse(&mut self, batch: Batch) {
        drop(batch);
    }
}

/// The sums of a few passes.
#[derive(Debug, Clone, Default)]
pub struct Batch {
    /// Radiance summed over the passes, W/(m² sr): one image for each layer, row by row from the top.
    pub layers: [Vec<Bands>; LAYERS],
    /// What was counted on the way.
    pub tally: Tally,
}

/// Memory for the layers of a batch: pages that are there already cost nothing.
#[derive(Debug, Default)]
struct Spare([Vec<Bands>; LAYERS]);

impl Spare {
    /// Black layers, but for what will be written: in `written` anything may stand. Zeros of new memory that are never touched take
    /// none.
    fn black_but(&mut self, pixels: usize, written: Range<usize>) -> [Vec<Bands>; LAYERS] {
        let mut layers = std::mem::take(&mut self.0);
        for layer in &mut layers {
            if layer.len() == pixels {
                for kept in [0..written.start, written.end..pixels] {
                    layer[kept].par_chunks_mut(PIXELS_AT_ONCE).for_each(|pixels| pixels.fill(BLACK));
                }
            } else {
                *layer = vec![BLACK; pixels];
            }
        }
        layers
    }
}

/// Pixels that a thread of the host takes at once.
const PIXELS_AT_ONCE: usize = 1 << 12;

/// Counts and energies, summed over passes.
#[derive(Debug, Clone, Copy, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Tally {
    /// Rays traced, of all kinds.
    pub rays: u64,
    /// Jotons that started from an emitter.
    pub jotons_emitted: u64,
    /// Jotons stored, in both maps.
    pub jotons_stored: u64,
    /// Jotons that were not stored, since the camera does not look where they are.
    pub jotons_not_stored: u64,
    /// Light samples that got no shadow ray, since another one stood for them.
    pub shadow_rays_saved: u64,
    /// Flux of the jotons that started for the diffuse map, internal W per band.
    pub emitted: [f64; BANDS],
    /// Flux that surfaces absorbed; the expected value at each meeting, not the roulette's outcome.
    pub absorbed: [f64; BANDS],
    /// Flux that left the scene.
    pub escaped: [f64; BANDS],
    /// Contributions that were not finite and were left out of the film.
    pub non_finite: NonFinite,
    /// Paths cut at the hard limit of their length.
    pub truncated: u64,
    /// Pixels of all passes that rested.
    pub pixels_rested: u64,
}

/// Where a value that is not finite was met. It is left out there and counted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Cause {
    /// Flux of a joton that was to be stored (CPU backend).
    Joton,
    /// Radiance of one layer of a pixel in one pass (CPU backend).
    Pixel,
    /// Radiance of one layer of a pixel, summed over a batch, as it was read back (GPU backend).
    ReadBack,
    /// Light found by a path (path tracer).
    Path,
}

/// Number of causes.
const CAUSES: usize = 4;

impl Cause {
    /// All causes, in the order in which they are counted.
    pub const ALL: [Cause; CAUSES] = [Cause::Joton, Cause::Pixel, Cause::ReadBack, Cause::Path];

    /// Name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            Cause::Joton => "joton",
            Cause::Pixel => "pixel",
            Cause::ReadBack => "read_back",
            Cause::Path => "path",
        }
    }
}

/// How often a value was not finite, by cause.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct NonFinite([u64; CAUSES]);

impl NonFinite {
    /// Count one more.
    pub fn count(&mut self, cause: Cause) {
        self.add(cause, 1);
    }

    /// Count so many more.
    pub fn add(&mut self, cause: Cause, count: u64) {
        self.0[cause as usize] += count;
    }

    /// How often for this cause.
    pub fn of(&self, cause: Cause) -> u64 {
        self.0[cause as usize]
    }

    /// How often in all.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// As an object: `total`, then each cause by its name.
    ///
    /// # Errors
    /// What the serializer reports.
    pub fn by_cause<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        let causes = Cause::ALL.map(|cause| (cause.name(), self.of(cause)));
        serializer.collect_map([("total", self.total())].into_iter().chain(causes))
    }
}

impl std::ops::AddAssign for NonFinite {
    fn add_assign(&mut self, o: Self) {
        self.0.iter_mut().zip(o.0).for_each(|(sum, more)| *sum += more);
    }
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, o: Self) {
        self.rays += o.rays;
        self.jotons_emitted += o.jotons_emitted;
        self.jotons_stored += o.jotons_stored;
        self.jotons_not_stored += o.jotons_not_stored;
        self.shadow_rays_saved += o.shadow_rays_saved;
        for b in 0..BANDS {
            self.emitted[b] += o.emitted[b];
            self.absorbed[b] += o.absorbed[b];
            self.escaped[b] += o.escaped[b];
        }
        self.non_finite += o.non_finite;
        self.truncated += o.truncated;
        self.pixels_rested += o.pixels_rested;
    }
}
