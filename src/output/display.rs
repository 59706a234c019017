//! Display: linear radiance → the values of an sRGB screen, 0 to 1.
//!
//! exposure (one factor for the image) → transform (per pixel) → sRGB. Only what looks at a picture uses this;
//! no comparison does.

use crate::error::{Error, Result};
use crate::film::Image;
use crate::spectrum::{self, Bands, to_rgb};
use std::str::FromStr;

/// Rec. 709 luminance of linear r, g, b. The display may assume three bands.
const LUMINANCE: [f32; 3] = [0.2126, 0.7152, 0.0722];

/// Where automatic exposure puts the brightest surfaces that are no lights, linear: white paper just below the top.
const WHITE: f32 = 0.9;
/// The share of the lit surfaces that is at most [`WHITE`].
const WHITE_SHARE: f64 = 0.95;
/// The share of the pixels with any light that is at most as bright as the level which lights are told apart by.
const TYPICAL_SHARE: f64 = 0.75;
/// What is this many times brighter than the typical level is a light or its mirror image, and may blow out.
const LIGHT: f32 = 8.0;
/// What is this many times darker than the typical level is background.
const BACKGROUND: f32 = 1e-3;

/// Shown where a pixel is not finite: it must be seen, not hidden.
const NOT_FINITE: [f32; 3] = [1.0, 0.0, 1.0];

/// How bright the image is shown.
#[derive(Debug, Clone, Copy, PartialEq, Default, serde::Serialize, serde::Deserialize)]
pub enum Exposure {
    /// From the image: bright surfaces become bright, lights and black backgrounds do not count.
    #[default]
    Auto,
    /// Radiance times 2^stops; at 0 stops, 1 W/(m² sr) is white.
    Stops(f32),
}

/// How exposed radiance becomes a screen value.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, serde::Serialize, serde::Deserialize)]
pub enum Transform {
    /// As it is; what is brighter than white is clipped.
    #[default]
    Srgb,
    /// A film-like shoulder and toe per channel: Narkowicz, "ACES Filmic Tone Mapping Curve" (2015).
    Filmic,
    /// Brightness as the logarithm of the photon count, b = log N: a screen value of
    /// log(1 + L/L0) / log(1 + Lmax/L0) for luminance L. Nothing is clipped, hue stays.
    Perception,
}

impl FromStr for Exposure {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self> {
        match s.parse::<f32>() {
            _ if s.eq_ignore_ascii_case("auto") => Ok(Exposure::Auto),
            Ok(stops) if stops.is_finite() => Ok(Exposure::Stops(stops)),
            _ => Err(Error::usage(format!("\"{s}\" is no exposure"), "give auto or a number of stops")),
        }
    }
}

impl FromStr for Transform {
    type Err = Error;

    fn from_str(s: &str) -> Result<Self> {
        match s {
            "srgb" => Ok(Transform::Srgb),
            "filmic" => Ok(Transform::Filmic),
            "perception" => Ok(Transform::Perception),
            _ => Err(Error::usage(format!("\"{s}\" is no transform"), "give srgb, filmic or perception")),
        }
    }
}

/// How an image is shown.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Display {
    /// How bright.
    pub exposure: Exposure,
    /// With which curve.
    pub transform: Transform,
}

impl Display {
    /// The factor by which radiance is multiplied before the transform, 1/(W/(m² sr)).
    pub fn scale(&self, image: &Image) -> f32 {
        match self.exposure {
            Exposure::Auto => auto_scale(image),
            Exposure::Stops(stops) => stops.exp2(),
        }
    }

    /// The image as sRGB-encoded screen values, 0 to 1; magenta where a pixel is not finite.
    pub fn apply(&self, image: &Image) -> Vec<[f32; 3]> {
        let scale = self.scale(image);
        let brightest = match self.transform {
            Transform::Perception => {
                image.pixels.iter().filter_map(|p| luminance(&to_rgb(p))).fold(0.0, f32::max) * scale
            }
            _ => 1.0,
        };
        let show = |pixel: &Bands| {
            if pixel.iter().any(|x| !x.is_finite()) {
                return NOT_FINITE;
            }
            let exposed = to_rgb(pixel).map(|x| (x * scale).clamp(0.0, f32::MAX));
            match self.transform {
                Transform::Srgb => exposed.map(srgb_from_linear),
                Transform::Filmic => exposed.map(|x| srgb_from_linear(filmic(x))),
                Transform::Perception => perceived(exposed, brightest).map(srgb_from_linear),
            }
        };
        image.pixels.iter().map(show).collect()
    }
}

/// Luminance of a pixel, where it is finite.
fn luminance(pixel: &[f32; 3]) -> Option<f32> {
    let l = pixel.iter().zip(LUMINANCE).map(|(x, w)| x * w).sum::<f32>();
    l.is_finite().then_some(l)
}

/// The value that `share` of the sorted values are at most.
fn percentile(sorted: &[f32], share: f64) -> f32 {
    sorted[((sorted.len() - 1) as f64 * share).round() as usize]
}

/// Bright surfaces to [`WHITE`]. Percentiles of what is lit: neither the size of a light nor that of a black
/// background changes them, as an average would. Of the brightest band, not of luminance: a white wall in warm
/// light would lose its red first, and turn yellow.
fn auto_scale(image: &Image) -> f32 {
    let brightest = image.pixels.iter().map(spectrum::max);
    let mut lit: Vec<f32> = brightest.filter(|&l| l > 0.0 && l.is_finite()).collect();
    if lit.is_empty() {
        return 1.0;
    }
    lit.sort_by(f32::total_cmp);
    let typical = percentile(&lit, TYPICAL_SHARE);
    lit.retain(|l| (typical * BACKGROUND..=typical * LIGHT).contains(l));
    let scale = WHITE / percentile(&lit, WHITE_SHARE);
    scale.clamp(f32::MIN_POSITIVE, f32::MAX)
}

/// The sRGB transfer function, IEC 61966-2-1, clipped to 0 … 1.
pub fn srgb_from_linear(x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The inverse of [`srgb_from_linear`].
pub fn linear_from_srgb(v: f32) -> f32 {
    let v = v.clamp(0.0, 1.0);
    if v <= 0.040_45 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Narkowicz 2015, with the 0.6 that he found to bring the curve's exposure to that of ACES.
fn filmic(x: f32) -> f32 {
    // Beyond this the curve is flat, and its squares would overflow.
    let x = (0.6 * x).min(1e4);
    ((x * (2.51 * x + 0.03)) / (x * (2.43 * x + 0.59) + 0.14)).min(1.0)
}

/// L0 of the perception curve: luminance, white being 1, below which the eye's response is taken as linear. A
/// hundredth is the contrast that one adaptation of the eye, and a printed page, spans.
const THRESHOLD: f32 = 0.01;

/// Scale a colour so that its screen value grows with the logarithm of its luminance; `brightest` maps to white.
fn perceived(rgb: [f32; 3], brightest: f32) -> [f32; 3] {
    let l = luminance(&rgb).unwrap_or(f32::MAX);
    if l <= 0.0 || brightest <= 0.0 {
        return [0.0; 3];
    }
    let brightness = (l / THRESHOLD).ln_1p() / (brightest / THRESHOLD).ln_1p();
    // The screen's transfer function is close to the eye's: the code value is the brightness that is seen.
    let target = linear_from_srgb(brightness);
    let scaled = rgb.map(|x| x / l * target);
    // A saturated colour as bright as asked may lie outside the screen: toward the grey of its own luminance until
    // it fits, which keeps hue and brightness.
    let top = scaled.iter().copied().fold(0.0, f32::max);
    if top <= 1.0 {
        return scaled;
    }
    let keep = ((1.0 - target) / (top - target)).clamp(0.0, 1.0);
    scaled.map(|x| target + (x - target) * keep)
}
