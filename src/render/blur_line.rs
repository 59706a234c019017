//! Blur line: how the radiance of the maps changes, from pass to pass, with the radius of their estimates [E18].

use super::lattice::Lattice;
use crate::film::tile_schedule::{Run, TILE};
use crate::film::{LAYERS, Layer};
use crate::spectrum::BANDS;
use rayon::prelude::*;

/// Least spread of the blur over a half's passes, relative to its mean, that a line is put through.
const SPREAD_MIN: f64 = 1e-3;

/// Sums over the passes of one half for the line through the radiance of the maps against their blur.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Line {
    pub(super) passes: f64,
    /// Sums of the radiance of the maps, and of it times the blur.
    pub(super) radiance: Vec<[f64; BANDS]>,
    pub(super) blurred: Vec<[f64; BANDS]>,
    /// Sums over the passes of the blur and of its square.
    pub(super) moments: [f64; 2],
}

impl Line {
    pub(super) fn add(
        &mut self,
        lattice: &Lattice,
        passes: u64,
        maps: &[Layer],
        layers: &[Vec<[f32; BANDS]>; LAYERS],
        blur: f64,
        runs: &[Vec<Run>],
    ) {
        self.radiance.resize(lattice.len(), [0.0; BANDS]);
        self.blurred.resize(lattice.len(), [0.0; BANDS]);
        let [across, _] = lattice.size;
        for layer in maps.iter().map(|l| &layers[*l as usize]).filter(|layer| !layer.is_empty()) {
            let rows = self.radiance.par_chunks_mut(across).zip(self.blurred.par_chunks_mut(across));
            rows.enumerate().for_each(|(row, (sums, blurred))| {
                let y = row * lattice.step;
                for run in &runs[y / TILE as usize] {
                    let Some([samples, pixels]) = lattice.in_row(run, y) else { continue };
                    let weight = run.weight as f64;
                    let sums = sums[samples.clone()].iter_mut().zip(&mut blurred[samples]);
                    for ((sum, blurred), l) in sums.zip(layer[pixels].iter().step_by(lattice.step)) {
                        for b in 0..BANDS {
                            let radiance = weight * f64::from(l[b]);
                            sum[b] += radiance;
                            blurred[b] += blur * radiance;
                        }
                    }
                }
            });
        }
        let n = passes as f64;
        self.passes += n;
        self.moments[0] += n * blur;
        self.moments[1] += n * blur * blur;
    }

    /// Add the sums of other passes.
    pub(super) fn merge(&mut self, other: &Self) {
        self.radiance.resize(self.radiance.len().max(other.radiance.len()), [0.0; BANDS]);
        self.blurred.resize(self.radiance.len(), [0.0; BANDS]);
        let add = |sums: &mut [[f64; BANDS]], more: &[[f64; BANDS]]| {
            for (sum, more) in sums.iter_mut().flatten().zip(more.iter().flatten()) {
                *sum += more;
            }
        };
        add(&mut self.radiance, &other.radiance);
        add(&mut self.blurred, &other.blurred);
        self.passes += other.passes;
        self.moments = std::array::from_fn(|i| self.moments[i] + other.moments[i]);
    }

    /// Factors (p, q) such that p Σ bL − q Σ L is the slope of the line through radiance L against blur b; none where
    /// nothing is blurred or all passes alike.
    pub(super) fn slope(&self) -> Option<[f64; 2]> {
        let [b, bb] = self.moments;
        let spread = bb - b * b / self.passes;
        (b > 0.0 && spread > SPREAD_MIN * bb).then(|| [1.0 / spread, b / self.passes / spread])
    }
}
