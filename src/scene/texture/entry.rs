//! Entry: what a scene file states of textures (docs/SCENE.md).

use super::stated::{COORDINATE_MOST, Source, StatedTexture};
use super::{Channel, Filter, Space, Wrap};
use crate::Result;
use crate::scene::mtl::At;
use crate::scene::table::{Table, TextOrTable};
use std::path::Path;

/// Keys of a table that say how a texture lies.
const KEYS: [&str; 7] = ["texture", "checkerboard", "scale", "offset", "wrap", "filter", "space"];

/// … and of one of its numbers.
const KEYS_OF_A_NUMBER: [&str; 2] = ["channel", "factor"];

/// A texture in place of a number: `{ texture = "file.png", channel = "g", factor = 0.5 }`; none where the key says something else.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(crate) fn number(table: &Table, key: &str, path: &Path) -> Result<Option<StatedTexture>> {
    let Some((mut stated, inner)) = read(table, key, path, &KEYS_OF_A_NUMBER)? else { return Ok(None) };
    stated.channel = channel(&inner)?;
    stated.factor = match inner.number("factor")? {
        None => 1.0,
        Some(At { value, .. }) if (0.0..=1.0).contains(&value) => value as f32,
        Some(At { value, line }) => {
            return Err(inner.fault(line, &format!("factor {value} of {key}"), "give 0 to 1"));
        }
    };
    Ok(Some(stated))
}

/// A texture that shines: `{ texture = "file.png", power = 5 }`, and the radiance of its white; none where the key says something else.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(crate) fn emission(table: &Table, key: &str, path: &Path) -> Result<Option<(StatedTexture, At<f32>)>> {
    let Some((stated, inner)) = read(table, key, path, &["power"])? else { return Ok(None) };
    let power = match inner.number("power")? {
        None => At { value: 1.0, line: stated.line },
        Some(At { value, line }) if value < 0.0 => {
            return Err(inner.fault(line, "power is negative", "give a power of at least 0"));
        }
        Some(At { value, line }) => At { value: value as f32, line },
    };
    Ok(Some((stated, power)))
}

/// A picture of normals: `{ texture = "file.png", strength = 0.5 }`; none where nothing is said.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(crate) fn normals(table: &Table, path: &Path) -> Result<Option<StatedTexture>> {
    relief(table, "normal", path, &["strength"], "strength", 1.0)
}

/// A picture of heights: `{ texture = "file.png", height = 0.01, channel = "r" }`, scene units; none where nothing is said.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(crate) fn heights(table: &Table, path: &Path) -> Result<Option<StatedTexture>> {
    relief(table, "bump", path, &["height", "channel"], "height", f32::NAN)
}

fn relief(
    table: &Table,
    key: &str,
    path: &Path,
    more: &[&str],
    strength: &str,
    unstated: f32,
) -> Result<Option<StatedTexture>> {
    let Some(line) = table.line_of(key) else { return Ok(None) };
    let Some((mut stated, inner)) = read(table, key, path, more)? else {
        let what = format!("{key} is no picture");
        return Err(table.fault(line, &what, &format!("give {key} = {{ texture = \"{key}.png\" }}")));
    };
    if key == "normal" && stated.wrap == Wrap::Mirror {
        let remedy = "give \"repeat\" or \"clamp\", or heights: bump";
        return Err(inner.fault(inner.line(), "normals cannot be mirrored by wrap", remedy));
    }
    stated.channel = channel(&inner)?;
    stated.relief = match inner.number(strength)? {
        Some(At { value, line }) if value.abs() > f64::from(COORDINATE_MOST) => {
            let what = format!("{strength} is beyond {COORDINATE_MOST:e}");
            return Err(inner.fault(line, &what, "give a smaller one"));
        }
        Some(At { value, .. }) => value as f32,
        None if unstated.is_nan() => return Err(inner.missing(strength)),
        None => unstated,
    };
    Ok(Some(stated))
}

/// Which of a texel's numbers is meant: red where nothing is said.
fn channel(table: &Table) -> Result<Channel> {
    let channels = [("r", Channel::Red), ("g", Channel::Green), ("b", Channel::Blue), ("a", Channel::Alpha)];
    Ok(word(table, "channel", channels)?.unwrap_or(Channel::Red))
}

/// A texture in place of a colour or an opacity: `{ texture = "file.png" }`, or `{ checkerboard = [[r, g, b], [r, g, b]] }`; none
/// where the key says something else.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(crate) fn texture(table: &Table, key: &str, path: &Path) -> Result<Option<StatedTexture>> {
    Ok(read(table, key, path, &[])?.map(|(stated, _)| stated))
}

/// What all textures have, and the table that says so, which may have some more keys.
fn read<'a>(
    table: &Table<'a>,
    key: &str,
    path: &Path,
    more: &[&str],
) -> Result<Option<(StatedTexture, Table<'a>)>> {
    let Some(TextOrTable::Table(inner)) = table.named_or_table(key)? else { return Ok(None) };
    if !inner.has("texture") && !inner.has("checkerboard") {
        return Ok(None);
    }
    inner.allow(&[&KEYS[..], more].concat())?;
    let mut stated = match (inner.optional_string("texture")?, inner.colours("checkerboard")?) {
        (Some(At { value: name, line }), None) => {
            StatedTexture::of(Source::File(name), path.to_owned(), line)
        }
        (None, Some(At { value: colours, line })) => {
            let colours = colours.map(|c| c.map(|x| x as f32));
            if colours.as_flattened().iter().any(|x| !(0.0..=1.0).contains(x)) {
                let what = "a colour of checkerboard is not from 0 to 1";
                return Err(inner.fault(line, what, "give reflectances: [[0.8, 0.8, 0.8], [0.1, 0.1, 0.1]]"));
            }
            StatedTexture::of(Source::Board(colours), path.to_owned(), line)
        }
        _ => {
            let what = format!("{key} is both texture and checkerboard");
            return Err(inner.fault(inner.line(), &what, "give one of them"));
        }
    };
    stated.is_required = true;
    let pair = |key: &str, default: [f32; 2]| match inner.sides(key)? {
        None => Ok(default),
        Some(At { value, line }) if value.abs().max_element() > f64::from(COORDINATE_MOST) => {
            Err(inner.fault(line, &format!("{key} is beyond {COORDINATE_MOST:e}"), "give a smaller one"))
        }
        Some(At { value, .. }) => Ok([value.x as f32, value.y as f32]),
    };
    (stated.scale, stated.offset) = (pair("scale", [1.0; 2])?, pair("offset", [0.0; 2])?);
    let wraps = [("repeat", Wrap::Repeat), ("mirror", Wrap::Mirror), ("clamp", Wrap::Clamp)];
    stated.wrap = word(&inner, "wrap", wraps)?.unwrap_or(Wrap::Repeat);
    let is_board = matches!(stated.source, Source::Board(_));
    let filters = [("linear", Filter::Linear), ("nearest", Filter::Nearest)];
    let default = if is_board { Filter::Nearest } else { Filter::Linear };
    stated.filter = word(&inner, "filter", filters)?.unwrap_or(default);
    stated.space = word(&inner, "space", [("srgb", Space::Srgb), ("linear", Space::Linear)])?;
    Ok(Some((stated, inner)))
}

/// One of some words.
fn word<T: Copy, const N: usize>(table: &Table, key: &str, known: [(&str, T); N]) -> Result<Option<T>> {
    let Some(At { value, line }) = table.optional_string(key)? else { return Ok(None) };
    match known.iter().find(|(name, _)| *name == value) {
        Some((_, meant)) => Ok(Some(*meant)),
        None => Err(table.unknown(line, key, &value, &known.map(|(name, _)| name))),
    }
}
