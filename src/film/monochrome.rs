//! Monochrome: an image at one wavelength, for who measures.

use super::Image;
use crate::spectrum::{BANDS, Bands};

/// An image of the radiance at one wavelength, W/(m² sr nm)  \[E53\].
#[derive(Debug, Clone, PartialEq)]
pub struct Monochrome {
    /// The wavelength, nm.
    pub lambda: f64,
    /// Row by row, as many as the picture has that it stands beside.
    pub pixels: Vec<f32>,
}

impl Monochrome {
    /// What of a picture in these bands is at each of their wavelengths, nm: each once, in the order in which they are first. Where bands have
    /// the same it is their mean.
    pub fn of(picture: &Image, lambdas: [f64; BANDS]) -> Vec<Self> {
        let is_first = |band: &usize| !lambdas[..*band].contains(&lambdas[*band]);
        let at = |band: usize| {
            let lambda = lambdas[band];
            let same: Vec<usize> = (0..BANDS).filter(|&other| lambdas[other] == lambda).collect();
            let mean = |pixel: &Bands| {
                let sum: f64 = same.iter().map(|&band| f64::from(pixel[band])).sum();
                (sum / same.len() as f64) as f32
            };
            Self { lambda, pixels: picture.pixels.iter().map(mean).collect() }
        };
        (0..BANDS).filter(is_first).map(at).collect()
    }
}
