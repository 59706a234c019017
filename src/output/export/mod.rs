//! Export: a scene as other renderers read it, so that they can be compared on the same scene.
//!
//! `subset` decides what each material and light is there, or refuses what has no counterpart, and `colour` what they are by
//! band, wavelength or place; `shapes` groups the triangles; `ply`, `pfm`, `bsdf` and `mitsuba` write them.

mod bsdf;
mod colour;
mod mitsuba;
mod pfm;
mod ply;
mod shapes;
mod subset;
mod xml;

use crate::error::{Error, Result};
use crate::output;
use crate::scene::{Light, Scene};
use std::path::{Path, PathBuf};

/// What is written of what others define a little differently.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fidelity {
    /// Nothing: it is refused.
    Exact,
    /// The nearest that there is.
    Near,
}

/// What was written, and what a renderer may want to know beforehand.
#[derive(Debug, Clone)]
pub struct Exported {
    /// The meshes, pictures of textures, then the scene file.
    pub files: Vec<PathBuf>,
    /// Longest side of the bounding box, world units.
    pub extent: f64,
    /// Whether some surface mirrors or refracts.
    pub specular: bool,
    /// Whether there is a spot.
    pub spots: bool,
}

/// Write a scene as Mitsuba 3 XML at `out`, for its rgb variants, or its spectral ones where the scene is rendered by wavelength, and
/// its meshes as PLY and pictures as PFM beside it: all files are replaced, or none is. `source` is what errors name.
///
/// # Errors
/// [`Error::Scene`] where something has no exact counterpart, [`Error::Io`] where a file cannot be written, [`Error::Usage`] where
/// one of them is a file that the scene was read from.
pub fn write_mitsuba(scene: &Scene, source: &Path, out: &Path, fidelity: Fidelity) -> Result<Exported> {
    let stem = out.file_stem().unwrap_or_default().to_string_lossy();
    if stem.contains('$') {
        let what = format!("{}: Mitsuba takes what follows $ for the name of a parameter", out.display());
        return Err(Error::usage(what, "give a name without $"));
    }
    let extent = shapes::extent(scene, source)?;
    let shapes = shapes::shapes(scene, source, fidelity)?;
    let lights = subset::check_lights(scene, source)?;
    let names: Vec<String> = (0..shapes.len()).map(|i| format!("{stem}.{i}.ply")).collect();
    let no_counterpart =
        |i| unsupported(source, format!("light {i} has no counterpart in other renderers"), "remove it");
    let emitters = (1..)
        .zip(lights)
        .map(|(i, light)| mitsuba::emitter(scene, i - 1, light).ok_or_else(|| no_counterpart(i)))
        .collect::<Result<Vec<String>>>()?;
    let (text, pictures) = mitsuba::text(scene, &stem, &shapes, &names, &emitters);
    let pictured = pictures.iter().map(|picture| &picture.name);
    let mut files: Vec<PathBuf> = names.iter().chain(pictured).map(|name| out.with_file_name(name)).collect();
    files.push(out.to_owned());
    output::check_not_read(&files, &scene.files)?;
    let mut parts: Vec<output::Part<'_>> = Vec::new();
    for (file, shape) in files.iter().zip(&shapes) {
        parts.push((file.clone(), Box::new(move || ply::bytes(shape))));
    }
    for (file, picture) in files[shapes.len()..].iter().zip(&pictures) {
        parts.push((file.clone(), Box::new(move || picture.bytes())));
    }
    parts.push((out.to_owned(), Box::new(|| text.into_bytes())));
    output::write_set(parts)?;
    let specular = shapes.iter().any(|s| s.look.is_specular());
    let spots = lights.iter().any(|l| matches!(l, Light::Spot { .. }));
    Ok(Exported { files, extent, specular, spots })
}

/// What other renderers cannot be told exactly: where, what, and what to do.
fn unsupported(source: &Path, what: impl Into<String>, remedy: &str) -> Error {
    Error::scene(source, None, what, remedy)
}
