//! Backend: what a device that renders passes must offer, and what it hands back.

use crate::bands::{BANDS, Bands};
use crate::error::Result;
use crate::film::LAYERS;

/// A device that renders passes of a plan. Passes are independent given their index: any order, any split into calls,
/// gives the same sums up to rounding.
pub trait Backend {
    /// One line: the device and how it is driven.
    fn describe(&self) -> String;

    /// From now on measure what each kernel takes (a little slower); nothing where the device cannot.
    fn measure_kernels(&mut self) {}

    /// Name, seconds and dispatches of each kernel since [`Backend::measure_kernels`].
    fn kernel_seconds(&self) -> Vec<(String, f64, u64)> {
        Vec::new()
    }

    /// How many passes one call should render from `first` on. It depends on the pass only, never on the clock: a call's
    /// passes are summed in f32, and another split would round otherwise.
    fn batch_passes(&self, first: u64) -> u32 {
        let _ = first;
        1
    }

    /// How much each layer is blurred in a pass: the squared radius of its estimates, relative to the first pass; 0 for
    /// layers without one.
    fn blur(&self, pass: u64) -> [f64; LAYERS] {
        let _ = pass;
        [0.0; LAYERS]
    }

    /// Render passes `first .. first + count`, numbered from 0.
    ///
    /// # Errors
    /// [`crate::Error::Device`] where the device fails, [`crate::Error::Capacity`] where a pass does not fit.
    fn render(&mut self, first: u64, count: u32) -> Result<Batch>;
}

/// The sums of a few passes.
#[derive(Debug, Clone)]
pub struct Batch {
    /// Radiance summed over the passes, W/(m² sr): one image for each layer, row by row from the top.
    pub layers: [Vec<Bands>; LAYERS],
    /// What was counted on the way.
    pub tally: Tally,
}

/// Counts and energies, summed over passes.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Tally {
    /// Rays traced, of all kinds.
    pub rays: u64,
    /// Jotons that started from an emitter.
    pub jotons_emitted: u64,
    /// Jotons stored, in both maps.
    pub jotons_stored: u64,
    /// Flux of the jotons that started for the diffuse map, internal W per band.
    pub emitted: [f64; BANDS],
    /// Flux that surfaces absorbed; the expected value at each meeting, not the roulette's outcome.
    pub absorbed: [f64; BANDS],
    /// Flux that left the scene.
    pub escaped: [f64; BANDS],
    /// Contributions that were not finite and were left out of the film.
    pub non_finite: u64,
    /// Paths cut at the hard limit of their length.
    pub truncated: u64,
}

impl std::ops::AddAssign for Tally {
    fn add_assign(&mut self, o: Self) {
        self.rays += o.rays;
        self.jotons_emitted += o.jotons_emitted;
        self.jotons_stored += o.jotons_stored;
        for b in 0..BANDS {
            self.emitted[b] += o.emitted[b];
            self.absorbed[b] += o.absorbed[b];
            self.escaped[b] += o.escaped[b];
        }
        self.non_finite += o.non_finite;
        self.truncated += o.truncated;
    }
}
