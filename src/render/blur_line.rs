//! Blur line: how the radiance of the maps changes, from pass to pass, with the radius of their estimates [E18].

use super::lattice::Lattice;
use crate::film::neighbours::around;
use crate::film::tile_schedule::{Run, TILE};
use crate::film::{LAYERS, Layer};
use crate::spectrum::BANDS;
use rayon::prelude::*;

/// Least spread of the blur over a half's passes, relative to its mean, that a line is put through.
const SPREAD_MIN: f64 = 1e-3;

/// Sums over the passes of one half for the line through the radiance of the maps against their blur.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Line {
    passes: f64,
    /// Sums of the radiance of the maps, and of it times the blur.
    pub(super) radiance: Vec<[f64; BANDS]>,
    blurred: Vec<[f64; BANDS]>,
    /// Sums over the passes of the blur and of its square.
    moments: [f64; 2],
}

impl Line {
    /// Whether it is one of so many pixels, where it was stored: none before anything was blurred.
    pub(super) fn is_sound(&self, pixels: usize) -> bool {
        let lengths = [self.radiance.len(), self.blurred.len()];
        lengths == [pixels; 2] || lengths == [0; 2] && self.moments == [0.0; 2]
    }

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

    /// What each pixel has too much because of a blur of this mean, W/(m² sr): the slope of the line through its radiance
    /// against blur, times that; none where nothing is blurred or all passes alike.
    fn bias(&self, mean_blur: f64) -> Option<Vec<[f64; BANDS]>> {
        let [b, bb] = self.moments;
        let spread = bb - b * b / self.passes;
        if b <= 0.0 || spread <= SPREAD_MIN * bb {
            return None;
        }
        let bias = |(blurred, radiance): (&[f64; BANDS], &[f64; BANDS])| {
            std::array::from_fn(|i| (blurred[i] - b / self.passes * radiance[i]) / spread * mean_blur)
        };
        Some(self.blurred.par_iter().zip(&self.radiance).map(bias).collect())
    }
}

/// The squared bias of each pixel of the lattice, (W/(m² sr))², without noise in its mean: the product of what both halves of
/// `passes` passes tell, each a mean over 3 × 3 pixels. None where no half tells.
pub(super) fn squared_bias(lines: &[Line; 2], lattice: &Lattice, passes: u64) -> Option<Vec<[f64; BANDS]>> {
    let mean_blur = lines.iter().map(|l| l.moments[0]).sum::<f64>() / passes as f64;
    let [first, second] = lines.each_ref().map(|line| line.bias(mean_blur));
    let (first, second) = (first?, second?);
    let size = lattice.size.map(|n| n as u32);
    let product = |p: usize| {
        let (mut sums, mut pixels) = ([[0.0; BANDS]; 2], 0.0);
        for near in around(p as u32, size) {
            pixels += 1.0;
            for i in 0..BANDS {
                sums[0][i] += first[near][i];
                sums[1][i] += second[near][i];
            }
        }
        std::array::from_fn(|i| sums[0][i] * sums[1][i] / (pixels * pixels))
    };
    Some((0..lattice.len()).into_par_iter().map(product).collect())
}
