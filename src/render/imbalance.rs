//! Imbalance: what the batches tell of how well the light that was emitted adds up [E17].

use crate::backend::Tally;
use crate::spectrum::BANDS;

/// Sums over batches of passes of what they have emitted and what of it was neither absorbed nor escaped. They take the same memory
/// after any number of passes.
#[derive(Debug, Clone, Copy, Default, serde::Serialize, serde::Deserialize)]
pub(super) struct Imbalance {
    batches: f64,
    passes: f64,
    emitted: f64,
    /// Emitted − absorbed − escaped.
    difference: f64,
    /// Its square over the passes of each batch.
    squares: f64,
}

impl Imbalance {
    pub(super) fn add(&mut self, passes: u64, t: &Tally) {
        let total = |x: &[f64; BANDS]| x.iter().sum::<f64>();
        let (passes, emitted) = (passes as f64, total(&t.emitted));
        let difference = emitted - total(&t.absorbed) - total(&t.escaped);
        self.merge(&Self {
            batches: 1.0,
            passes,
            emitted,
            difference,
            squares: difference * difference / passes,
        });
    }

    /// Add the batches of another part of the render.
    pub(super) fn merge(&mut self, other: &Self) {
        self.batches += other.batches;
        self.passes += other.passes;
        self.emitted += other.emitted;
        self.difference += other.difference;
        self.squares += other.squares;
    }

    /// Standard error of the sum over the emitted flux.
    pub(super) fn relative_error(&self) -> Option<f64> {
        if self.batches < 2.0 || self.emitted <= 0.0 {
            return None;
        }
        // Σ (d − p m)² / p with the mean of a pass, m = Σ d / Σ p, which is small against its spread
        let spread = (self.squares - self.difference * self.difference / self.passes).max(0.0);
        let per_pass = spread / (self.batches - 1.0);
        Some((per_pass * self.passes).sqrt() / self.emitted)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Batches of one and of two passes: the standard error is that of their differences, worked out from all of them.
    #[test]
    fn the_spread_of_batches_is_told() {
        let batches = [(1, 0.3), (2, -0.5), (1, 0.1), (2, 0.9)];
        let mut sums = Imbalance::default();
        for (passes, difference) in batches {
            let tally =
                Tally { emitted: [10.0; BANDS], absorbed: [10.0 - difference; BANDS], ..Tally::default() };
            sums.add(passes, &tally);
        }
        let bands = BANDS as f64;
        let [all, sum] = batches.iter().fold([0.0; 2], |[p, d], b| [p + b.0 as f64, d + bands * b.1]);
        let mean = sum / all;
        let squares = batches.iter().map(|(p, d)| (bands * d - *p as f64 * mean).powi(2) / *p as f64);
        let expected = (squares.sum::<f64>() / 3.0 * all).sqrt() / (40.0 * bands);
        let told = sums.relative_error().expect("batches");
        assert!((told / expected - 1.0).abs() < 1e-12, "{told} {expected}");
    }
}
