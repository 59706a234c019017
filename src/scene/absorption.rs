//! Absorption: what a scene file says of the light that a transparent body takes along the way through it \[E44\]: by `absorption`, per
//! unit of length, or as glTF does by `attenuation_color`, which is left of white after `attenuation_distance`.

use super::mtl::At;
use super::spectrum_entry;
use super::table::{Table, TextOrTable};
use crate::Result;
use crate::spectrum::{Bands, Spectrum, from_rgb, max};

/// Of what is left of light less than this counts as none: so much is absorbed that nothing can be seen.
const LEAST_LEFT: f64 = 1e-6;
/// Wavelengths at which what is left is looked at, nm.
const LAMBDAS: [f64; 3] = [360.0, 830.0, 5.0];

/// Absorption per unit of length, in bands and, where it is stated so, by wavelength.
///
/// # Errors
/// Line and remedy where a statement is none, or one of a pair is missing.
pub(super) fn read(table: &Table) -> Result<(Option<At<Bands>>, Option<Spectrum>)> {
    const PAIR: [&str; 2] = ["attenuation_color", "attenuation_distance"];
    let [colour, distance] = PAIR.map(|key| table.line_of(key));
    let Some(line) = colour.or(distance) else { return by_length(table) };
    if let Some(line) = table.line_of("absorption") {
        let remedy = "give absorption, or attenuation_color and attenuation_distance";
        return Err(table.fault(line, "absorption is stated twice", remedy));
    }
    let (Some(colour_line), Some(At { value: distance, line: distance_line })) =
        (colour, table.number(PAIR[1])?)
    else {
        let [is, is_not] = if colour.is_some() { PAIR } else { [PAIR[1], PAIR[0]] };
        return Err(table.fault(
            line,
            &format!("{is} without {is_not}"),
            "give both: what is left, and where",
        ));
    };
    if distance <= 0.0 {
        let what = format!("attenuation_distance of {distance}");
        return Err(table.fault(distance_line, &what, "give the length after which the color is left"));
    }
    let (left, spectrum) = spectrum_entry::reflectance(table, PAIR[0])?;
    let left = left.ok_or_else(|| table.missing(PAIR[0]))?.value;
    if max(&left) > 1.0 {
        let what = format!("attenuation_color of {left:?}");
        return Err(table.fault(colour_line, &what, "give what is left of white, from 0 to 1"));
    }
    let absorbed = |left: f64| -left.max(LEAST_LEFT).ln() / distance;
    let value = left.map(|left| absorbed(f64::from(left)) as f32);
    let spectrum = spectrum.map(|s| tabulated(|lambda| absorbed(s.at(lambda))));
    Ok((Some(At { value: finite(value), line }), spectrum))
}

/// `absorption`: bands, or a spectrum.
fn by_length(table: &Table) -> Result<(Option<At<Bands>>, Option<Spectrum>)> {
    let Some(TextOrTable::Table(inner)) = table.named_or_table("absorption")? else {
        return Ok((table.bands("absorption")?, None));
    };
    inner.allow(&["spectrum"])?;
    let At { value: pairs, line } =
        inner.spectrum("spectrum", f64::INFINITY)?.ok_or_else(|| inner.missing("spectrum"))?;
    let most = pairs.iter().fold(0.0, |most, pair| f64::max(most, pair[1]));
    let factor = if most > 0.0 { most } else { 1.0 };
    let (lambdas, values) = pairs.into_iter().map(|[lambda, value]| (lambda, value / factor)).unzip();
    let spectrum = Spectrum::reflectance_table(lambdas, values).map_err(|what| {
        inner.fault(line, &what, "give [wavelength in nm, absorption per unit of length], in ascending order")
    })?;
    let spectrum = spectrum.scaled(factor);
    // what is left of white where the most is absorbed that is has a colour
    let left = tabulated(|lambda| (-spectrum.at(lambda) / factor).exp()).reflectance_to_rgb();
    let value = from_rgb(left.map(|left| (-left.clamp(LEAST_LEFT, 1.0).ln() * factor) as f32));
    Ok((Some(At { value: finite(value), line }), Some(spectrum)))
}

/// Bands that f32 holds.
fn finite(bands: Bands) -> Bands {
    bands.map(|x| x.clamp(0.0, f32::MAX))
}

/// A spectrum of what is told at wavelengths, of 0 or more.
fn tabulated(of: impl Fn(f64) -> f64) -> Spectrum {
    let [first, last, step] = LAMBDAS;
    let lambdas: Vec<f64> =
        (0..).map(|i| first + f64::from(i) * step).take_while(|lambda| *lambda <= last).collect();
    let values: Vec<f64> = lambdas.iter().map(|lambda| of(*lambda)).collect();
    let most = values.iter().fold(1.0, |most, x| f64::max(most, *x));
    let shares = values.iter().map(|x| x / most).collect();
    // ascending wavelengths and shares of at most one make a table
    Spectrum::reflectance_table(lambdas, shares).map_or(Spectrum::Constant(0.0), |s| s.scaled(most))
}
