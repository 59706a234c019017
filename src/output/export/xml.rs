//! XML: numbers, colours and names as Mitsuba's scene files have them.

use super::colour::Colour;
use crate::spectrum::Bands;
use glam::DVec3;

/// Red, green and blue, or values over wavelength. Pictures are files, and written elsewhere.
pub(super) fn colour(name: &str, colour: &Colour) -> String {
    match colour {
        Colour::Bands(bands) => rgb(name, bands),
        Colour::Spectrum(values) => spectrum(name, values),
        Colour::Picture { factor, .. } => rgb(name, factor),
    }
}

fn spectrum(name: &str, values: &[[f64; 2]]) -> String {
    let pairs: Vec<String> = values.iter().map(|[lambda, value]| format!("{lambda}:{value}")).collect();
    format!("<spectrum name=\"{name}\" value=\"{}\"/>", pairs.join(", "))
}

/// A number.
pub(super) fn float(name: &str, value: impl std::fmt::Display) -> String {
    format!("<float name=\"{name}\" value=\"{value}\"/>")
}

/// Red, green and blue.
fn rgb(name: &str, bands: &Bands) -> String {
    format!("<rgb name=\"{name}\" value=\"{}\"/>", list(bands))
}

/// A place or a direction.
pub(super) fn triple(kind: &str, name: &str, v: DVec3) -> String {
    format!("<{kind} name=\"{name}\" x=\"{}\" y=\"{}\" z=\"{}\"/>", v.x, v.y, v.z)
}

/// Numbers with all their digits.
pub(super) fn list(values: &[impl std::fmt::Display]) -> String {
    values.iter().map(|v| v.to_string()).collect::<Vec<_>>().join(", ")
}

/// Text inside an attribute. Characters that XML does not allow at all become spaces; `$` would name a parameter.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '$' => out += "_",
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
