//! Clean: checks an OBJ file statement by statement and rewrites what a renderer needs of it.
//!
//! reads   any OBJ text
//! writes  the same surfaces as `v`, `vn`, `vt` and `f p/t/n` alone, with absolute indices, and, per face, its line and
//!         its material's name and the objects and groups that it is part of, where these are asked for
//!
//! The parser behind it then meets nothing that it refuses or misreads, and faults are named with file and line,
//! which it cannot do. Normal 1 of the output is the zero vector: faces without normals refer to it.

use super::text;
use super::texture::stated::COORDINATE_MOST;
use super::warnings::Warnings;
use crate::{Error, Result};
use std::collections::{HashMap, HashSet};
use std::fmt::Write;
use std::path::Path;

/// Index, from 1, of the zero normal that stands for "flat".
const NO_NORMAL: usize = 1;
/// Index, from 1, of the texture coordinates that stand for none.
const NO_UV: usize = 1;

/// Names of objects and groups that are remembered, to tell what else could be meant.
const OBJECT_NAMES: usize = 1000;

/// A checked OBJ file.
#[derive(Debug, Default)]
pub(crate) struct Clean {
    /// OBJ text of `v`, `vn` and `f` statements.
    pub(crate) text: String,
    /// The faces in order.
    pub(crate) faces: Vec<Face>,
    /// Names after `usemtl`, each once.
    pub(crate) materials: Vec<String>,
    /// Objects and groups that were asked for, as faces are parts of them: an object first, then the groups.
    pub(crate) parts: Vec<Vec<String>>,
    /// Objects and groups that are there, the first so many, where any were asked for.
    pub(crate) object_names: Vec<String>,
    /// `mtllib` statements: line and what follows.
    pub(crate) libraries: Vec<(usize, String)>,
}

/// Where a face comes from.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Face {
    /// Line of its statement, from 1.
    pub(crate) line: usize,
    /// Index into [`Clean::materials`], or none before the first `usemtl`.
    pub(crate) material: Option<usize>,
    /// Index into [`Clean::parts`].
    pub(crate) part: usize,
    /// Each of its corners has texture coordinates.
    pub(crate) is_textured: bool,
}

/// How many vertices, normals and texture coordinates there are: so far, and in the whole file (an index may point ahead).
#[derive(Default, Clone, Copy)]
struct Counts {
    positions: usize,
    normals: usize,
    uvs: usize,
}

/// Checks and rewrites an OBJ file. Of its objects and groups those in `wanted` are told.
pub(crate) fn clean(
    source: &str,
    path: &Path,
    wanted: &HashSet<&str>,
    warnings: &mut Warnings,
) -> Result<Clean> {
    let mut all = Counts::default();
    for statement in text::statements(source) {
        match statement.split().0 {
            "v" => all.positions += 1,
            "vn" => all.normals += 1,
            "vt" => all.uvs += 1,
            _ => {}
        }
    }
    let has_uvs = all.uvs > 0;
    let text = if has_uvs { "vn 0 0 0\nvt 0 0\n" } else { "vn 0 0 0\n" };
    let mut out = Clean { text: text.to_owned(), parts: vec![Vec::new()], ..Clean::default() };
    let mut so_far = Counts::default();
    let (mut material, mut part) = (None, 0);
    let mut index_of: HashMap<String, usize> = HashMap::new();
    let (mut object, mut groups): (Option<String>, Vec<String>) = Default::default();
    let mut part_of = HashMap::from([(Vec::new(), 0)]);
    let is_wanted = |name: &&str| wanted.contains(name);
    let mut ignored = |line, what: &str| warnings.add(path, Some(line), what);
    for statement in text::statements(source) {
        let line = statement.line;
        let (key, rest) = statement.split();
        match key {
            "v" => {
                so_far.positions += 1;
                position(&mut out.text, rest).map_err(|what| {
                    Error::scene(path, Some(line), what, "give three finite numbers: v x y z")
                })?;
                if words(rest).count() > 4 {
                    ignored(line, "vertex colours are ignored");
                }
            }
            "vn" => {
                so_far.normals += 1;
                let normal = floats::<3>(rest);
                if normal.is_none() {
                    ignored(line, "normal is not three finite numbers; its faces are flat");
                }
                let [x, y, z] = normal.unwrap_or_default();
                let _ = writeln!(out.text, "vn {x:?} {y:?} {z:?}"); // writing to a String cannot fail
            }
            "vt" => {
                so_far.uvs += 1;
                let uv = texture_coordinates(rest);
                if uv.is_none() {
                    ignored(line, "texture coordinates are not finite numbers up to 1e6; they count as 0");
                }
                let [u, v] = uv.unwrap_or_default();
                let _ = writeln!(out.text, "vt {u:?} {v:?}");
            }
            "f" | "fo" => match face(rest, so_far, all) {
                Ok(corners) if corners.len() < 3 => {
                    ignored(line, "face with fewer than three vertices is ignored")
                }
                Ok(corners) => {
                    if corners.iter().any(|c| c.normal == Given::OutOfRange) {
                        ignored(line, "face refers to normals that do not exist; it is flat");
                    }
                    if corners.iter().any(|c| c.uv == Given::OutOfRange) {
                        let what = "face refers to texture coordinates that do not exist; it has none";
                        ignored(line, what);
                    }
                    let is_textured = corners.iter().all(|c| matches!(c.uv, Given::At(_)));
                    write_face(&mut out.text, &corners, has_uvs, is_textured);
                    out.faces.push(Face { line, material, part, is_textured });
                }
                Err(fault) => {
                    let remedy = match all.positions {
                        0 => "the file has no v statements".to_owned(),
                        last => format!("indices run from 1 to {last}, or backwards from -1"),
                    };
                    return Err(Error::scene(path, Some(line), fault, remedy));
                }
            },
            "usemtl" => {
                material = Some(match index_of.get(rest) {
                    Some(&index) => index,
                    None => {
                        index_of.insert(rest.to_owned(), out.materials.len());
                        out.materials.push(rest.to_owned());
                        out.materials.len() - 1
                    }
                });
            }
            "o" | "g" if !wanted.is_empty() => {
                if out.object_names.len() < OBJECT_NAMES {
                    out.object_names.push(rest.to_owned());
                }
                if key == "o" {
                    object = Some(rest).filter(is_wanted).map(str::to_owned);
                } else {
                    // the whole may be one name with spaces
                    let names = words(rest).filter(|word| *word != rest).chain([rest]);
                    groups = names.filter(is_wanted).map(str::to_owned).collect();
                }
                let names: Vec<String> = object.iter().chain(&groups).cloned().collect();
                part = *part_of.entry(names.clone()).or_insert_with(|| {
                    out.parts.push(names);
                    out.parts.len() - 1
                });
            }
            "mtllib" => out.libraries.push((line, rest.to_owned())),
            "l" | "p" => ignored(line, "lines and points are ignored"),
            "curv" | "curv2" | "surf" => ignored(line, "free-form curves and surfaces are ignored"),
            _ => {} // o and g that nobody asked for, s, vt and whatever else has no bearing on light
        }
    }
    Ok(out)
}

fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}

/// The first `N` words as finite numbers.
fn floats<const N: usize>(rest: &str) -> Option<[f64; N]> {
    let mut values = [0.0; N];
    let mut words = words(rest);
    for value in &mut values {
        *value = words.next()?.parse().ok().filter(|v: &f64| v.is_finite())?;
    }
    Some(values)
}

/// Across and up; up may be missing.
fn texture_coordinates(rest: &str) -> Option<[f64; 2]> {
    let [u, v] = floats::<2>(rest)
        .or_else(|| floats::<1>(rest).filter(|_| words(rest).count() == 1).map(|[u]| [u, 0.0]))?;
    (u.abs().max(v.abs()) <= f64::from(COORDINATE_MOST)).then_some([u, v])
}

/// Writes a vertex. What follows the coordinates (w of a rational curve, a colour) is dropped.
fn position(out: &mut String, rest: &str) -> Result<(), String> {
    let words: Vec<&str> = words(rest).take(3).collect();
    for word in &words {
        match word.parse::<f64>() {
            Ok(value) if value.is_finite() => {}
            Ok(_) => return Err(format!("coordinate {word} is not finite")),
            Err(_) => return Err(format!("\"{word}\" is not a number")),
        }
    }
    match words[..] {
        [x, y, z] => {
            let _ = writeln!(out, "v {x} {y} {z}");
            Ok(())
        }
        _ => Err(format!("vertex with {} of 3 coordinates", words.len())),
    }
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Given {
    Absent,
    OutOfRange,
    /// Index from 1 in the source.
    At(usize),
}

#[derive(Clone, Copy)]
struct Corner {
    /// Index from 1.
    position: usize,
    normal: Given,
    uv: Given,
}

/// Reads the corners of a face: `p`, `p/t`, `p//n`, `p/t/n`.
fn face(rest: &str, so_far: Counts, all: Counts) -> Result<Vec<Corner>, String> {
    words(rest)
        .map(|word| {
            let mut indices = word.split('/');
            let position = indices.next().unwrap_or("");
            let relative: i64 = position.parse().map_err(|_| format!("\"{word}\" is not a vertex index"))?;
            let position = absolute(relative, so_far.positions, all.positions)
                .ok_or_else(|| format!("vertex index {relative} of {} vertices", so_far.positions))?;
            let given = |index: Option<&str>, so_far, all| match index.unwrap_or("") {
                "" => Given::Absent,
                index => index
                    .parse()
                    .ok()
                    .and_then(|relative| absolute(relative, so_far, all))
                    .map_or(Given::OutOfRange, Given::At),
            };
            let uv = given(indices.next(), so_far.uvs, all.uvs);
            let normal = given(indices.next(), so_far.normals, all.normals);
            Ok(Corner { position, normal, uv })
        })
        .collect()
}

/// Index from 1 of an index that may count backwards from what was stated last.
fn absolute(relative: i64, so_far: usize, all: usize) -> Option<usize> {
    let index = if relative < 0 {
        so_far.checked_sub(usize::try_from(relative.unsigned_abs()).ok()?)?.checked_add(1)?
    } else {
        usize::try_from(relative).ok()?
    };
    (1..=all).contains(&index).then_some(index)
}

/// A face has all of its normals or none, and likewise its texture coordinates; where no face has these, none is written.
fn write_face(out: &mut String, corners: &[Corner], has_uvs: bool, is_textured: bool) {
    let has_normals = corners.iter().all(|c| matches!(c.normal, Given::At(_)));
    out.push('f');
    for corner in corners {
        let at = |given: Given, has_all: bool, none: usize| match given {
            Given::At(index) if has_all => none + index,
            _ => none,
        };
        let normal = at(corner.normal, has_normals, NO_NORMAL);
        let _ = match has_uvs {
            true => write!(out, " {}/{}/{normal}", corner.position, at(corner.uv, is_textured, NO_UV)),
            false => write!(out, " {}//{normal}", corner.position),
        };
    }
    out.push('\n');
}
