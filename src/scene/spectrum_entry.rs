//! What a scene file states by wavelength: reflectances, light and indices of refraction, in place of [r, g, b] or a number
//! (docs/SCENE.md). What is read comes with the bands that it makes in red, green and blue.

use super::mtl::At;
use super::spd;
use super::table::{Table, TextOrTable};
use crate::spectrum::cie::Illuminant;
use crate::spectrum::glass::Index;
use crate::spectrum::lamp::{Emission, Lamp, Line};
use crate::spectrum::{Bands, Spectrum, from_rgb};
use crate::{Error, Result};

/// A reflectance or a tint: bands, or `{ spectrum = [[nm, value], …] }`, or a file's name in place of pairs, as everywhere below.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(super) fn reflectance(table: &Table, key: &str) -> Result<(Option<At<Bands>>, Option<Spectrum>)> {
    let Some(TextOrTable::Table(inner)) = table.named_or_table(key)? else {
        return Ok((table.bands(key)?, None));
    };
    inner.allow(&["spectrum"])?;
    let At { value: pairs, line } =
        inner.spectrum("spectrum", 1.0)?.ok_or_else(|| inner.missing("spectrum"))?;
    let (lambdas, values) = apart(pairs);
    let spectrum = Spectrum::reflectance_table(lambdas, values).map_err(|what| {
        inner.fault(line, &what, "give [wavelength in nm, value from 0 to 1], in ascending order")
    })?;
    let rgb = spectrum.reflectance_to_rgb();
    let value = from_rgb(rgb.map(|c| c.clamp(0.0, 1.0) as f32));
    Ok((Some(At { value, line }), Some(spectrum)))
}

/// Light: bands, or one of `{ spectrum = [[nm, value], …] }`, `{ lines = [[nm, power], …] }`,
/// `{ blackbody = kelvin }`, `{ illuminant = "A" }`, `{ lamp = "sodium" }`, each times `power`. The last three have luminance 1.
///
/// # Errors
/// As of [`reflectance`].
pub(super) fn emission(table: &Table, key: &str) -> Result<(Option<At<Bands>>, Option<Emission>)> {
    let Some(TextOrTable::Table(inner)) = table.named_or_table(key)? else {
        return Ok((table.bands(key)?, None));
    };
    const SOURCES: [&str; 5] = ["spectrum", "lines", "blackbody", "illuminant", "lamp"];
    inner.allow(&[&["power"][..], &SOURCES].concat())?;
    let power = inner.number("power")?.map_or(1.0, |power| power.value);
    if power < 0.0 {
        return Err(inner.fault(inner.line(), "power is negative", "give a power of at least 0"));
    }
    let word = |key: &str, known: &[&str], found: &mut dyn FnMut(&str) -> bool| -> Result<bool> {
        let Some(At { value, line }) = inner.optional_string(key)? else { return Ok(false) };
        if found(&value) { Ok(true) } else { Err(inner.unknown(line, key, &value, known)) }
    };
    let mut light: Option<Emission> = None;
    word("illuminant", &Illuminant::ALL.map(Illuminant::name), &mut |name| {
        light = Illuminant::named(name).map(|i| Emission::continuous(Spectrum::Standard(i)));
        light.is_some()
    })?;
    word("lamp", &Lamp::names(), &mut |name| {
        light = Lamp::named(name).map(Lamp::emission);
        light.is_some()
    })?;
    if let Some(At { value: kelvin, line }) = inner.number("blackbody")? {
        let spectrum = Spectrum::blackbody(kelvin).map_err(|what| {
            inner.fault(line, &what, "give a temperature in kelvin: a lamp has 3000, daylight 6500")
        })?;
        light = Some(Emission::continuous(spectrum));
    }
    if let Some(At { value: pairs, line }) = inner.spectrum("spectrum", f64::INFINITY)? {
        let (lambdas, values) = apart(pairs);
        let spectrum = Spectrum::emission_table(lambdas, values)
            .map_err(|what| inner.fault(line, &what, "give [wavelength in nm, value], in ascending order"))?;
        light = Some(Emission::continuous(spectrum));
    }
    if let Some(At { value: pairs, line }) = inner.pairs("lines")? {
        let lines = pairs.into_iter().map(|[lambda, power]| Line { lambda, power }).collect();
        let lit = Emission::of_lines(lines)
            .map_err(|what| inner.fault(line, &what, "give [wavelength in nm, power], 360 to 830 nm"))?;
        light = Some(lit);
    }
    let stated = SOURCES.iter().filter(|key| inner.has(key)).count();
    let light = match (light, stated) {
        (Some(light), 1) => light.scaled(power),
        _ => {
            let what = format!("{key} is stated by {stated} of {}", SOURCES.join(", "));
            return Err(inner.fault(inner.line(), &what, "give one of them"));
        }
    };
    let value = spd::light_bands(&light);
    if value.iter().any(|x| !x.is_finite()) {
        return Err(inner.fault(
            inner.line(),
            &format!("{key} is too bright for a number"),
            "give less power",
        ));
    }
    Ok((Some(At { value, line: inner.line() }), Some(light)))
}

/// An index of refraction: a number, the name of a glass, or one of `{ glass = "BK7" }`, `{ nd = 1.5168, abbe = 64.2 }`,
/// `{ cauchy = [A, B] }` (B in µm²), `{ sellmeier = [B1, C1, B2, C2, B3, C3] }` (C in µm²), `{ spectrum = [[nm, index], …] }`. The
/// number that comes with it is that of the yellow d line.
///
/// # Errors
/// As of [`reflectance`].
pub(super) fn index(table: &Table, key: &str) -> Result<(Option<At<f32>>, Option<Index>)> {
    let by_name = |at: &Table, At { value: name, line }: At<String>| {
        let index = Index::named(&name)
            .ok_or_else(|| at.unknown(line, "glass", &name, &Index::names().collect::<Vec<_>>()))?;
        Ok::<_, Error>((index, line))
    };
    let (index, line) = match table.named_or_table(key)? {
        None => {
            let single = |v: At<f64>| At { value: v.value as f32, line: v.line };
            return Ok((table.number(key)?.map(single), None));
        }
        Some(TextOrTable::Text(name)) => by_name(table, name)?,
        Some(TextOrTable::Table(inner)) => {
            inner.allow(&["glass", "nd", "abbe", "cauchy", "sellmeier", "spectrum"])?;
            let fault = |line: usize, what: String| {
                inner.fault(line, &what, "give an index that is above 0 from 360 to 830 nm")
            };
            let shape = |line: usize, key: &str, expected: &str| {
                inner.fault(line, &format!("{key} has a wrong number of values"), &format!("give {expected}"))
            };
            if let Some(name) = inner.optional_string("glass")? {
                by_name(&inner, name)?
            } else if let Some(At { value, line }) = inner.list("cauchy")? {
                let [a, b] = value[..] else { return Err(shape(line, "cauchy", "[A, B in µm²]")) };
                (Index::Cauchy { a, b }.checked().map_err(|what| fault(line, what))?, line)
            } else if let Some(At { value, line }) = inner.list("sellmeier")? {
                let [b1, c1, b2, c2, b3, c3] = value[..] else {
                    return Err(shape(line, "sellmeier", "[B1, C1, B2, C2, B3, C3], C in µm²"));
                };
                (
                    Index::Sellmeier(vec![[b1, c1], [b2, c2], [b3, c3]])
                        .checked()
                        .map_err(|what| fault(line, what))?,
                    line,
                )
            } else if let Some(At { value, line }) = inner.spectrum("spectrum", f64::INFINITY)? {
                let (lambdas, values) = apart(value);
                (Index::table(lambdas, values).map_err(|what| fault(line, what))?, line)
            } else {
                let nd = inner.number("nd")?.ok_or_else(|| inner.missing("nd"))?;
                let abbe = inner.number("abbe")?.ok_or_else(|| inner.missing("abbe"))?;
                let line = nd.line;
                (Index::of_abbe(nd.value, abbe.value).map_err(|what| fault(line, what))?, line)
            }
        }
    };
    let value = index.at(crate::spectrum::glass::LINE_D) as f32;
    Ok((Some(At { value, line }), Some(index)))
}

/// Wavelengths and values.
fn apart(pairs: Vec<[f64; 2]>) -> (Vec<f64>, Vec<f64>) {
    pairs.into_iter().map(|[lambda, value]| (lambda, value)).unzip()
}
