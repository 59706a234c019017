//! Radius schedules: r_i² = r_1² ∏ (k+α)/(k+1) for k = 1 … i−1, always from the base radius (Knaus & Zwicker 2011) \[E10\].

use std::ops::Range;

/// Factor on the squared base radius in pass `pass`, counted from 0.
pub fn shrink(alpha: f64, pass: u64) -> f64 {
    // ∏_{k=1}^{n} (k+α)/(k+1) = Γ(n+1+α) / (Γ(1+α) Γ(n+2)): the product for the first passes, then the asymptotic
    // expansion of the ratio of gamma functions
    const DIRECT: u64 = 256;
    let product = |n: u64| (1..=n).map(|k| (k as f64 + alpha) / (k as f64 + 1.0)).product::<f64>();
    if pass <= DIRECT {
        return product(pass);
    }
    // Γ(x+α)/Γ(x+1) ≈ y^(α−1) with y = x + α/2 exact to O(y^-2), x = n + 1 (Tricomi & Erdélyi 1951)
    let tail = |n: u64| (n as f64 + 1.0 + alpha / 2.0).powf(alpha - 1.0);
    product(DIRECT) * tail(pass) / tail(DIRECT)
}

/// Most passes that share area points: the points' own error must average out, their cost must not show.
const AREA_PASSES: u64 = 16;

/// The passes that share area points with `pass`. Radii within a group differ by an eighth at most: points that are dense
/// enough for the smallest disc do not crowd the largest.
pub fn area_group(pass: u64) -> Range<u64> {
    if pass < 2 * AREA_PASSES {
        let first = if pass == 0 { 0 } else { 1 << pass.ilog2() };
        return first..(2 * first).max(1);
    }
    let first = pass / AREA_PASSES * AREA_PASSES;
    first..first + AREA_PASSES
}

/// A radius over the passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// Radius in the first pass, internal units.
    pub base: f64,
    /// 1 keeps the radius, smaller shrinks faster.
    pub alpha: f64,
}

impl Schedule {
    /// Radius in pass `pass`, counted from 0.
    pub fn radius(&self, pass: u64) -> f64 {
        self.base * shrink(self.alpha, pass).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every pass is in its own group; groups join without gaps.
    #[test]
    fn area_groups_cover_all_passes_with_like_radii() {
        let schedule = Schedule { base: 1.0, alpha: 2.0 / 3.0 };
        let mut next = 0;
        while next < 1000 {
            let group = area_group(next);
            assert_eq!(group.start, next);
            assert!(group.clone().all(|pass| area_group(pass) == group), "{group:?}");
            let ratio = schedule.radius(group.start) / schedule.radius(group.end - 1);
            assert!(ratio <= 1.125, "{group:?} {ratio}");
            next = group.end;
        }
    }

    /// The closed form continues the product; no reduced radius is ever reduced again.
    #[test]
    fn shrink_is_knaus_and_zwickers_product() {
        for alpha in [0.5, 2.0 / 3.0, 0.75, 0.9, 1.0] {
            let mut product = 1.0;
            for i in 0..100_000u64 {
                if i > 0 {
                    product *= (i as f64 + alpha) / (i as f64 + 1.0);
                }
                let got = shrink(alpha, i);
                assert!((got / product - 1.0).abs() < 1e-5, "α {alpha} pass {i}: {got} against {product}");
            }
        }
    }
}
