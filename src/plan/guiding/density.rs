//! Densities: warps of a lamp's directions, learned from the jotons that were of use.

use super::Hit;
use crate::packed::{WARP_BINS, Warp};

/// Parts of a warp that are spread evenly, and times that its bins are smoothed: the pair that serves best is taken.
const EVEN: [f64; 3] = [0.05, 0.1, 0.2];
const SMOOTHINGS: [u32; 3] = [0, 1, 3];

/// The warp that lowers the second moment most, and to what part; none where it is not as low as `worth`. Each half of the hits
/// judges what is learned from the other.
pub(super) fn warp(hits: &[Hit], worth: f64) -> Option<(Warp, f64)> {
    let half = |parity: u32| move |h: &&Hit| h.number % 2 == parity;
    let candidates = SMOOTHINGS.iter().flat_map(|&s| EVEN.map(|e| (s, e)));
    let judged = candidates.map(|(smoothings, even)| {
        let part: f64 = (0..2)
            .map(|parity| {
                let density =
                    density(&smoothed(&moments(hits.iter().filter(half(1 - parity))), smoothings), even);
                let judges = || hits.iter().filter(half(parity));
                let after: f64 = judges().map(|h| h.moment / density[bin(h.towards)]).sum();
                0.5 * after / judges().map(|h| h.moment).sum::<f64>()
            })
            .sum();
        (part, smoothings, even)
    });
    let (part, smoothings, even) = judged.min_by(|a, b| a.0.total_cmp(&b.0))?;
    let density = density(&smoothed(&moments(hits.iter()), smoothings), even);
    (part < worth).then(|| (Warp::new(&density), part))
}

/// A warp toward the bins of these places of a square, each with one over the density by which it was drawn; none without places.
pub(super) fn guessed(places: impl Iterator<Item = ([f32; 2], f64)>) -> Option<Warp> {
    let mut bins = vec![0.0; WARP_BINS * WARP_BINS];
    places.for_each(|(place, weight)| bins[bin(place)] += weight);
    bins.iter().any(|b| *b > 0.0).then(|| Warp::new(&density(&smoothed(&bins, 1), EVEN[1])))
}

/// Bin of a place in the square.
fn bin(towards: [f32; 2]) -> usize {
    let [row, column] = towards.map(|x| (x * WARP_BINS as f32) as usize);
    row * WARP_BINS + column
}

/// Sum of the squared flux in each bin.
fn moments<'a>(hits: impl Iterator<Item = &'a Hit>) -> Vec<f64> {
    let mut bins = vec![0.0; WARP_BINS * WARP_BINS];
    for h in hits {
        bins[bin(h.towards)] += h.moment;
    }
    bins
}

/// Every bin shared with its neighbours, a few times: rows end at the square's edge, columns go round it, as azimuths do.
fn smoothed(bins: &[f64], times: u32) -> Vec<f64> {
    let n = WARP_BINS;
    let mut bins = bins.to_vec();
    for _ in 0..times {
        let at = |b: &[f64], row: usize, column: usize| b[row * n + column];
        let across: Vec<f64> = (0..n * n)
            .map(|i| {
                let (r, c) = (i / n, i % n);
                0.25 * (at(&bins, r, (c + n - 1) % n) + at(&bins, r, (c + 1) % n)) + 0.5 * at(&bins, r, c)
            })
            .collect();
        bins = (0..n * n)
            .map(|i| {
                let (r, c) = (i / n, i % n);
                let (before, after) = (r.saturating_sub(1), (r + 1).min(n - 1));
                0.25 * (at(&across, before, c) + at(&across, after, c)) + 0.5 * at(&across, r, c)
            })
            .collect();
    }
    bins
}

/// Density that serves bins with these second moments best: proportional to their roots, but for the part `even`.
fn density(moments: &[f64], even: f64) -> Vec<f64> {
    let mean = moments.iter().map(|m| m.sqrt()).sum::<f64>() / moments.len() as f64;
    moments.iter().map(|m| even + (1.0 - even) * m.sqrt() / mean.max(f64::MIN_POSITIVE)).collect()
}
