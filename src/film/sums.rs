//! Sums: light of the pixels of a layer over passes, in f64, or exact where parts of a render are put together.

use crate::spectrum::{BANDS, Bands};

/// Bits after the point of an exact sum: 1e-23 W/(m² sr) is told, and a sum is 2e15 at most.
const FRACTION_BITS: i32 = 76;
/// One over the unit of an exact sum.
const SCALE: f64 = (1u128 << FRACTION_BITS) as f64;

/// One sum for each pixel and band. Pixels that stay black take no memory.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
pub(super) enum Sums {
    /// 24 bytes a pixel; rounded each time that something is added.
    Rounded(Vec<[f64; BANDS]>),
    /// 48 bytes a pixel: multiples of 2^-76, so that the order in which passes are added changes no bit.
    Exact(Vec<[i128; BANDS]>),
}

/// Some of the pixels of [`Sums`], to be added to.
pub(super) enum SumsMut<'a> {
    Rounded(&'a mut [[f64; BANDS]]),
    Exact(&'a mut [[i128; BANDS]]),
}

impl Sums {
    /// So many black pixels.
    pub(super) fn new(pixels: usize, is_exact: bool) -> Self {
        if is_exact {
            Self::Exact(vec![[0; BANDS]; pixels])
        } else {
            Self::Rounded(vec![[0.0; BANDS]; pixels])
        }
    }

    /// Whether there are so many pixels, of that kind.
    pub(super) fn is_sound(&self, pixels: usize, is_exact: bool) -> bool {
        match self {
            Self::Rounded(sums) => !is_exact && sums.len() == pixels,
            Self::Exact(sums) => is_exact && sums.len() == pixels,
        }
    }

    /// The sum of a pixel.
    pub(super) fn at(&self, pixel: usize) -> [f64; BANDS] {
        match self {
            Self::Rounded(sums) => sums[pixel],
            Self::Exact(sums) => sums[pixel].map(|sum| sum as f64 / SCALE),
        }
    }

    /// The pixels in consecutive parts of so many.
    pub(super) fn chunks_mut(&mut self, pixels: usize) -> Vec<SumsMut<'_>> {
        match self {
            Self::Rounded(sums) => sums.chunks_mut(pixels).map(SumsMut::Rounded).collect(),
            Self::Exact(sums) => sums.chunks_mut(pixels).map(SumsMut::Exact).collect(),
        }
    }

    /// Add those of other passes. Both are exact: what is rounded would depend on the order.
    pub(super) fn merge(&mut self, other: &Self) {
        let (Self::Exact(sums), Self::Exact(more)) = (self, other) else {
            unreachable!("parts of a render have exact sums");
        };
        for (sum, more) in sums.iter_mut().flatten().zip(more.iter().flatten()) {
            if *more != 0 {
                *sum = sum.saturating_add(*more);
            }
        }
    }
}

impl SumsMut<'_> {
    /// Add samples from pixel `first` on that stand for so many passes each. Black samples are left alone: pages of zeros that are
    /// never written take no memory.
    pub(super) fn add(&mut self, first: usize, samples: &[Bands], weight: u64) {
        let lit = samples.iter().enumerate().filter(|(_, sample)| **sample != [0.0; BANDS]);
        match self {
            Self::Rounded(sums) => {
                let weight = weight as f64;
                for (i, sample) in lit {
                    let sum = &mut sums[first + i];
                    for b in 0..BANDS {
                        sum[b] += weight * f64::from(sample[b]);
                    }
                }
            }
            Self::Exact(sums) => {
                for (i, sample) in lit {
                    let sum = &mut sums[first + i];
                    for b in 0..BANDS {
                        let exact = (f64::from(sample[b]) * SCALE).round_ties_even() as i128;
                        sum[b] = sum[b].saturating_add(exact.saturating_mul(weight.into()));
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Added one by one.
    fn summed<'a>(samples: impl IntoIterator<Item = &'a Bands>) -> Sums {
        let mut sums = Sums::new(1, true);
        samples.into_iter().for_each(|sample| sums.chunks_mut(1)[0].add(0, &[*sample], 1));
        sums
    }

    proptest! {
        /// Whatever the samples, their order and the parts that they are added in, an exact sum has the same bits.
        #[test]
        fn exact_sums_know_no_order(
            samples in proptest::collection::vec([-1e9f32..1e9, 1e-9f32..1e-3, -1e3f32..1e6], 1..60),
            cut in 0usize..60,
        ) {
            let whole = summed(&samples);
            let (first, second) = samples.split_at(cut.min(samples.len()));
            let mut merged = summed(second.iter().rev());
            merged.merge(&summed(first));
            prop_assert_eq!(&merged, &whole);
        }
    }

    /// An exact sum is as good as one in f64, over 16 orders of magnitude.
    #[test]
    fn exact_sums_are_sums() {
        for scale in [1e-10f32, 1.0, 1e6] {
            let samples: Vec<Bands> = (0..1000).map(|i| [scale, scale * i as f32, -scale / 3.0]).collect();
            let found = summed(&samples).at(0);
            let wanted = [1000.0, 499_500.0, -1000.0 / 3.0].map(|x| x * f64::from(scale));
            for b in 0..BANDS {
                assert!((found[b] / wanted[b] - 1.0).abs() < 1e-6, "{scale}: {found:?}, {wanted:?}");
            }
        }
        // a weight counts, and what is too much stays at its bound
        let mut sums = Sums::new(2, true);
        sums.chunks_mut(2)[0].add(1, &[[0.5, 1e30, -1e30]], 8);
        let [half, most, least] = sums.at(1);
        assert_eq!((half, sums.at(0)), (4.0, [0.0; BANDS]));
        assert!(most > 1e15 && least == -most, "{most} {least}");
    }
}
