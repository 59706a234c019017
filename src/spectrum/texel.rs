//! Texels by wavelength: red, green and blue as weights of three smooth reflectances that add up to one \[E37\] (Mallett & Yuksel 2019).
//!
//! The bases are made by `scripts/spectral-tables.py`.

use super::table::published;
use super::{BANDS, Bands};

/// What texels of red, green and blue alone reflect in bands at these wavelengths, nm: a texel is their sum by its numbers.
pub fn bases_at(lambdas: [f64; BANDS]) -> [Bands; 3] {
    ["basis-r", "basis-g", "basis-b"].map(|name| {
        let basis = published(name);
        lambdas.map(|lambda| basis.at(lambda) as f32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spectrum::curve::Spectrum;
    use crate::spectrum::{LAMBDA_MAX, LAMBDA_MIN};

    /// The bases are red, green and blue in daylight, within 0 and 1, and add up to one at every wavelength.
    #[test]
    fn bases_are_the_primaries() {
        for (i, name) in ["basis-r", "basis-g", "basis-b"].into_iter().enumerate() {
            let basis = published(name);
            let pairs = (basis.lambdas().to_vec(), basis.values().to_vec());
            let rgb =
                Spectrum::reflectance_table(pairs.0, pairs.1).expect("from 0 to 1").reflectance_to_rgb();
            for (k, c) in rgb.into_iter().enumerate() {
                // between its published values daylight is interpolated otherwise here
                assert!((c - f64::from(u8::from(k == i))).abs() < 1e-4, "{name}: {rgb:?}");
            }
        }
        for lambda in LAMBDA_MIN as u32..=LAMBDA_MAX as u32 {
            let [r, g, b] = bases_at([f64::from(lambda); BANDS]).map(|basis| basis[0]);
            assert!((r + g + b - 1.0).abs() < 1e-6, "{lambda}: {r} {g} {b}");
        }
    }
}
