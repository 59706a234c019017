//! Imbalance: what the batches tell of how well the light that was emitted adds up [E17].

use crate::backend::Tally;
use crate::spectrum::BANDS;

/// Spread between batches of emitted − absorbed − escaped.
#[derive(Debug, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Imbalance {
    batches: Vec<(f64, f64)>,
    emitted: f64,
}

impl Imbalance {
    pub(super) fn add(&mut self, passes: u64, t: &Tally) {
        let total = |x: &[f64; BANDS]| x.iter().sum::<f64>();
        self.batches.push((passes as f64, total(&t.emitted) - total(&t.absorbed) - total(&t.escaped)));
        self.emitted += total(&t.emitted);
    }

    /// Add the batches of another part of the render.
    pub(super) fn merge(&mut self, other: &Self) {
        self.batches.extend(&other.batches);
        self.emitted += other.emitted;
    }

    /// Standard error of the sum over the emitted flux.
    pub(super) fn relative_error(&self) -> Option<f64> {
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
