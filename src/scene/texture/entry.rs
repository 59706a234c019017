//! Entry: what a scene file states of textures (docs/SCENE.md).

use super::stated::{COORDINATE_MOST, Source, StatedTexture};
use super::{Filter, Space, Wrap};
use crate::Result;
use crate::scene::mtl::At;
use crate::scene::table::{Table, TextOrTable};
use std::path::Path;

/// Keys of a table that say how a texture lies.
const KEYS: [&str; 7] = ["texture", "checkerboard", "scale", "offset", "wrap", "filter", "space"];

/// A texture in place of a colour or an opacity: `{ texture = "file.png" }`, or `{ checkerboard = [[r, g, b], [r, g, b]] }`; none
/// where the key says something else.
///
/// # Errors
/// Line and remedy where the table says something else.
pub(crate) fn texture(table: &Table, key: &str, path: &Path) -> Result<Option<StatedTexture>> {
    let Some(TextOrTable::Table(inner)) = table.named_or_table(key)? else { return Ok(None) };
    if !inner.has("texture") && !inner.has("checkerboard") {
        return Ok(None);
    }
    inner.allow(&KEYS)?;
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
    Ok(Some(stated))
}

/// One of some words.
fn word<T: Copy, const N: usize>(table: &Table, key: &str, known: [(&str, T); N]) -> Result<Option<T>> {
    let Some(At { value, line }) = table.optional_string(key)? else { return Ok(None) };
    match known.iter().find(|(name, _)| *name == value) {
        Some((_, meant)) => Ok(Some(*meant)),
        None => Err(table.unknown(line, key, &value, &known.map(|(name, _)| name))),
    }
}
