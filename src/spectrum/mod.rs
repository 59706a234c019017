//! Spectra: what light carries, in bands and by wavelength.
//!
//! [`bands`] is what the renderer calculates with: one value per band, at whatever wavelengths the bands of a pass have. The
//! other files are the mathematics of wavelengths, in f64 and without any part of the renderer: the observer and colours
//! ([`cie`]), spectra ([`curve`]) and those that are found for a colour ([`upsample`]), lamps with lines ([`lamp`]), indices
//! of refraction ([`glass`], [`metal`]), texels ([`texel`]), which wavelengths a pass has ([`wavelengths`]), how they go together ([`courses`])
//! and what is seen of them ([`pick`]), and lists of them that someone measures at ([`list`]).
//!
//! Wavelengths are in nm, in air or vacuum as their sources have them: they differ by 0.03 %.

pub mod bands;
pub mod cie;
pub mod courses;
pub mod curve;
pub mod glass;
pub mod lamp;
pub mod list;
pub mod metal;
pub mod pick;
pub mod table;
pub mod texel;
pub mod upsample;
pub mod wavelengths;

pub use bands::{BANDS, BLACK, Bands, NAMES, add, from_rgb, is_black, max, mul, scale, sum, to_rgb, wgsl};
pub use curve::Spectrum;

/// Shortest wavelength that is carried, nm: the first of the CIE's observer.
pub const LAMBDA_MIN: f64 = 360.0;

/// Longest wavelength that is carried, nm: the last of the CIE's observer.
pub const LAMBDA_MAX: f64 = 830.0;
