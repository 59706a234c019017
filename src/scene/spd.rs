//! SPD: reads a measured spectrum from a text file, a wavelength and a value on each line.
//!
//! As spectrometers and renderers write them: nm and a number, apart by spaces, tabs, commas or semicolons; `#` begins a comment;
//! lines in any order.

use super::text;
use crate::spectrum::lamp::Emission;
use crate::spectrum::{BANDS, Bands, Spectrum, from_rgb, is_black};
use crate::{Error, Result};
use std::path::Path;

/// What to do about a line that is no pair.
const REMEDY: &str = "give a wavelength in nm and a value on each line, like 550 0.25";

/// Wavelengths, nm, ascending, and values from 0 to `most`.
///
/// # Errors
/// [`Error::Io`] where the file cannot be read; [`Error::Scene`] with its line where it says something else.
pub(super) fn read(path: &Path, most: f64) -> Result<Vec<[f64; 2]>> {
    parse(&text::read(path)?, path, most)
}

/// What a file says of a reflectance, times `factor`: bands and spectrum.
///
/// # Errors
/// As of [`read`].
pub(super) fn reflectance(path: &Path, factor: f64) -> Result<(Bands, Spectrum)> {
    let pairs = read(path, 1.0)?.into_iter();
    let (lambdas, values) = pairs.map(|[lambda, value]| (lambda, (value * factor).clamp(0.0, 1.0))).unzip();
    let fault = |what: String| Error::scene(path, None, what, REMEDY);
    let spectrum = Spectrum::reflectance_table(lambdas, values).map_err(fault)?;
    let bands = from_rgb(spectrum.reflectance_to_rgb().map(|c| c.clamp(0.0, 1.0) as f32));
    Ok((bands, spectrum))
}

/// What a file says of light, times `factor`: bands and spectrum.
///
/// # Errors
/// As of [`read`].
pub(super) fn emission(path: &Path, factor: f64) -> Result<(Bands, Emission)> {
    let pairs = read(path, f64::INFINITY)?.into_iter();
    let (lambdas, values) = pairs.map(|[lambda, value]| (lambda, value * factor)).unzip();
    let fault = |what: String| Error::scene(path, None, what, REMEDY);
    let light = Emission::continuous(Spectrum::emission_table(lambdas, values).map_err(fault)?);
    Ok((light_bands(&light), light))
}

/// Bands of a light whose colour may be one that no red, green and blue make: none is negative, and light is never black.
pub(super) fn light_bands(light: &Emission) -> Bands {
    let bands = from_rgb(light.to_rgb().map(|c| c.max(0.0) as f32));
    if is_black(&bands) { [light.to_xyz()[1].max(0.0) as f32; BANDS] } else { bands }
}

fn parse(text: &str, path: &Path, most: f64) -> Result<Vec<[f64; 2]>> {
    let mut found: Vec<([f64; 2], usize)> = Vec::new();
    for (i, all) in text.replace("\r\n", "\n").split(['\n', '\r']).enumerate() {
        let line = i + 1;
        let fault = |what: String, remedy: &str| Error::scene(path, Some(line), what, remedy);
        let stated = all.split('#').next().unwrap_or_default();
        let is_between = |c: char| c.is_whitespace() || c.is_control() || matches!(c, ',' | ';');
        let words: Vec<&str> = stated.split(is_between).filter(|word| !word.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        let numbers: Option<Vec<f64>> =
            words.iter().map(|word| word.parse::<f64>().ok().filter(|x| x.is_finite())).collect();
        let Some([lambda, value]) = numbers.and_then(|numbers| <[f64; 2]>::try_from(numbers).ok()) else {
            return Err(fault("no wavelength and value".into(), REMEDY));
        };
        if lambda <= 0.0 {
            return Err(fault(format!("{lambda} is not a wavelength in nm"), REMEDY));
        }
        if !(0.0..=most).contains(&value) {
            let remedy = if most.is_finite() { "give values from 0 to 1, no percents" } else { REMEDY };
            let limits = if most.is_finite() { format!("from 0 to {most}") } else { "0 or more".into() };
            return Err(fault(format!("the value at {lambda} nm is {value}, but must be {limits}"), remedy));
        }
        found.push(([lambda, value], line));
    }
    found.sort_by(|([a, _], _), ([b, _], _)| a.total_cmp(b));
    if let Some(twice) = found.windows(2).find(|pair| pair[0].0[0] == pair[1].0[0]) {
        let what = format!("{} nm is on line {}, too", twice[0].0[0], twice[0].1);
        return Err(Error::scene(path, Some(twice[1].1), what, "give each wavelength once"));
    }
    if found.len() < 2 {
        let what = format!("a spectrum needs two wavelengths or more, this has {}", found.len());
        return Err(Error::scene(path, None, what, REMEDY));
    }
    Ok(found.into_iter().map(|(pair, _)| pair).collect())
}
