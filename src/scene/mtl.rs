//! MTL: reads Wavefront material libraries into what they literally say.
//!
//! Tolerant, because files in the wild are: any case of keys, tabs, comments after values, nameless materials,
//! paths with backslashes or the wrong case. What the statements mean for light is the rule in `rule.rs`.

use super::finder::Finder;
use super::spd;
use super::text;
use super::texture::stated::StatedTexture;
use super::warnings::Warnings;
use crate::spectrum::glass::Index;
use crate::spectrum::lamp::Emission;
use crate::spectrum::metal::Metal;
use crate::spectrum::{BANDS, Bands, Spectrum, from_rgb};
use crate::{Error, Result};
use std::path::{Path, PathBuf};

/// A value and the line that it stands on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct At<T> {
    /// What was read.
    pub(crate) value: T,
    /// Line, from 1.
    pub(crate) line: usize,
}

/// What a scene file's `type` asks for, instead of what `illum` suggests.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Kd alone.
    Matte,
    /// Ks mirrors, Kd is matte.
    Mirror,
    /// A transparent body.
    Glass,
    /// Kd is matte, Ks is a lobe.
    Glossy,
    /// Metal, by its index or its colour.
    Metal,
    /// Kd is matte under a clear coat.
    Plastic,
    /// Kd is a base colour, of metal and of plastic in parts.
    Principled,
}

/// What of a material is stated by wavelength, beside the bands that it makes.
#[derive(Debug, Clone, Default)]
pub(crate) struct RawSpectra {
    /// Of `kd`.
    pub(crate) kd: Option<Spectrum>,
    /// Of `ks`.
    pub(crate) ks: Option<Spectrum>,
    /// Of `tf`.
    pub(crate) tf: Option<Spectrum>,
    /// Of `transmit`.
    pub(crate) transmit: Option<Spectrum>,
    /// Of `ke`.
    pub(crate) ke: Option<Emission>,
    /// Of `absorption`.
    pub(crate) absorption: Option<Spectrum>,
    /// Of `ni`.
    pub(crate) ni: Option<Index>,
}

/// A texture that is read in no library, or in Blender's alone.
#[derive(Debug, Clone)]
pub(crate) struct OtherMap {
    /// As the file calls it, in small letters.
    pub(crate) key: String,
    pub(crate) line: usize,
    /// None where it makes no sense.
    pub(crate) stated: Option<StatedTexture>,
}

/// What is stated of the layers of a principled material.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RawLayers {
    /// How much of a clear coat is there: `Pc`.
    pub(crate) clear_coat: Option<At<f32>>,
    /// Its roughness: `Pcr`.
    pub(crate) clear_coat_roughness: Option<At<f32>>,
    /// Colour of sheen: `Ps`.
    pub(crate) sheen: Option<At<Bands>>,
    /// Set by a scene file: its roughness.
    pub(crate) sheen_roughness: Option<At<f32>>,
    /// Set by a scene file: factor on what the dielectric part reflects …
    pub(crate) specular: Option<At<f32>>,
    /// … and on what it reflects head on.
    pub(crate) specular_colour: Option<At<Bands>>,
    /// Set by a scene file: part of the light that is let through.
    pub(crate) transmission: Option<At<f32>>,
}

/// One material as the file states it; absent means not stated.
#[derive(Debug, Clone, Default)]
pub(crate) struct RawMaterial {
    /// `newmtl` name; empty where the file gives none.
    pub(crate) name: String,
    /// File that defines it.
    pub(crate) file: PathBuf,
    /// Line of `newmtl`.
    pub(crate) line: usize,
    /// Whether Blender's exporter wrote the library, as its first line says.
    pub(crate) is_of_blender: bool,
    /// Set by a scene file.
    pub(crate) kind: Option<Kind>,
    /// Set by a scene file: whether glass is a pane without thickness.
    pub(crate) thin: Option<At<bool>>,
    /// Ambient reflectance: of no meaning but to `blender.rs`.
    pub(crate) ka: Option<At<Bands>>,
    /// Diffuse reflectance.
    pub(crate) kd: Option<At<Bands>>,
    /// Specular or glossy reflectance.
    pub(crate) ks: Option<At<Bands>>,
    /// Emitted radiance, W/(m² sr).
    pub(crate) ke: Option<At<Bands>>,
    /// Transmission filter.
    pub(crate) tf: Option<At<Bands>>,
    /// Set by a scene file: what is scattered through to the other side.
    pub(crate) transmit: Option<At<Bands>>,
    /// Transmission colour, in no specification.
    pub(crate) kt: Option<At<Bands>>,
    /// Index of refraction.
    pub(crate) ni: Option<At<f32>>,
    /// Phong exponent.
    pub(crate) ns: Option<At<f32>>,
    /// Roughness of the PBR extension.
    pub(crate) pr: Option<At<f32>>,
    /// Metallic part of the PBR extension.
    pub(crate) pm: Option<At<f32>>,
    /// Set by a scene file: roughness α of GGX, instead of `pr`.
    pub(crate) alpha: Option<At<f32>>,
    /// Strength of the anisotropy …
    pub(crate) aniso: Option<At<f32>>,
    /// … and its way, turns.
    pub(crate) anisor: Option<At<f32>>,
    /// Set by a scene file: a metal by its name.
    pub(crate) metal: Option<Metal>,
    /// Set by a scene file: the real part of a metal's index.
    pub(crate) eta: Option<At<Bands>>,
    /// Set by a scene file: the imaginary part.
    pub(crate) k: Option<At<Bands>>,
    /// Set by a scene file: light takes on more of a base's colour with each turn under its coat.
    pub(crate) saturated: Option<At<bool>>,
    /// Set by a scene file: what a transparent body absorbs, per unit of length.
    pub(crate) absorption: Option<At<Bands>>,
    /// Set by a scene file: which of several transparent bodies in one place counts.
    pub(crate) priority: Option<At<i64>>,
    /// Opacity.
    pub(crate) d: Option<At<f32>>,
    /// Transparency, or opacity in old files.
    pub(crate) tr: Option<At<f32>>,
    /// Illumination model.
    pub(crate) illum: Option<At<f32>>,
    /// What is stated by wavelength.
    pub(crate) spectra: RawSpectra,
    /// Files of spectra that were read for it.
    pub(crate) read: Vec<PathBuf>,
    /// Texture of the diffuse reflectance.
    pub(crate) map_kd: Option<StatedTexture>,
    /// Texture of the roughness `pr`.
    pub(crate) map_pr: Option<StatedTexture>,
    /// Texture of the metallic part `pm`.
    pub(crate) map_pm: Option<StatedTexture>,
    /// Set by a scene file: texture of the transmission.
    pub(crate) map_transmission: Option<StatedTexture>,
    /// Texture of the emitted radiance.
    pub(crate) map_ke: Option<StatedTexture>,
    /// Texture of normals.
    pub(crate) norm: Option<StatedTexture>,
    /// Texture of heights, in libraries perhaps of normals.
    pub(crate) bump: Option<StatedTexture>,
    /// Texture of the opacity.
    pub(crate) map_d: Option<StatedTexture>,
    /// Other textures; those that are still here in the end are not read.
    pub(crate) other_maps: Vec<OtherMap>,
    /// Set by a scene file: how much of the surface is there.
    pub(crate) opacity: Option<At<f32>>,
    /// Set by `blender.rs`: what is multiplied by `map_kd`.
    pub(crate) textured: Option<Bands>,
    /// What lies over its base.
    pub(crate) layers: RawLayers,
}

/// Reads a material library; later definitions of a name come later in the list.
pub(crate) fn read(path: &Path, warnings: &mut Warnings) -> Result<Vec<RawMaterial>> {
    Ok(parse(&text::read(path)?, path, warnings))
}

/// Reads a material library from its text; statements that cannot be read are left out with a warning.
pub(crate) fn parse(text: &str, path: &Path, warnings: &mut Warnings) -> Vec<RawMaterial> {
    let mut materials: Vec<RawMaterial> = Vec::new();
    let mut finder = Finder::new(path.parent().unwrap_or(Path::new("")).to_owned());
    for statement in text::statements(text) {
        let line = statement.line;
        let (key, rest) = statement.split();
        if key.eq_ignore_ascii_case("newmtl") {
            materials.push(RawMaterial {
                name: rest.to_owned(),
                file: path.to_owned(),
                line,
                ..Default::default()
            });
            continue;
        }
        // What stands before the first newmtl belongs to no material.
        let Some(material) = materials.last_mut() else { continue };
        let small = key.to_ascii_lowercase();
        let done = match rest.strip_prefix("spectral").filter(|rest| rest.starts_with(char::is_whitespace)) {
            Some(rest) => apply_spectrum(material, &small, rest, line, &mut finder),
            None => apply(material, &small, rest, line).map_err(str::to_owned),
        };
        if let Err(what) = done {
            warnings.add(path, Some(line), format!("{key}: {what}; the statement is ignored"));
        }
    }
    let is_of_blender = text.trim_start_matches('\u{feff}').starts_with("# Blender");
    materials.iter_mut().for_each(|material| material.is_of_blender = is_of_blender);
    materials
}

/// Applies one statement; keys that mean nothing here (sharpness, …) are passed over.
fn apply(material: &mut RawMaterial, key: &str, rest: &str, line: usize) -> Result<(), &'static str> {
    let at = |value| Some(At { value, line });
    let file = material.file.clone();
    let mut other = || {
        let stated = StatedTexture::parse(rest, file.clone(), line).ok();
        material.other_maps.push(OtherMap { key: key.to_owned(), line, stated });
    };
    match key {
        "ka" => material.ka = at_bands(rest, line)?,
        "pm" => material.pm = at(number(rest)?),
        // of two statements the later counts
        "kd" => (material.kd, material.spectra.kd) = (at_bands(rest, line)?, None),
        "ks" => (material.ks, material.spectra.ks) = (at_bands(rest, line)?, None),
        "ke" => (material.ke, material.spectra.ke) = (at_bands(rest, line)?, None),
        "tf" => (material.tf, material.spectra.tf) = (at_bands(rest, line)?, None),
        "kt" => material.kt = at_bands(rest, line)?,
        "ni" => material.ni = at(number(rest)?),
        "ns" => material.ns = at(number(rest)?),
        "pr" => material.pr = at(number(rest)?),
        "aniso" => material.aniso = at(number(rest)?),
        "anisor" => material.anisor = at(number(rest)?),
        "pc" => material.layers.clear_coat = at(number(rest)?),
        "pcr" => material.layers.clear_coat_roughness = at(number(rest)?),
        "ps" => material.layers.sheen = at_bands(rest, line)?,
        "d" => material.d = at(number(rest.strip_prefix("-halo").unwrap_or(rest))?),
        "tr" => material.tr = at(number(rest)?),
        "illum" => material.illum = at(number(rest)?),
        "map_kd" => material.map_kd = Some(StatedTexture::parse(rest, file, line)?),
        "map_pr" => material.map_pr = Some(StatedTexture::parse(rest, file, line)?),
        "map_pm" => material.map_pm = Some(StatedTexture::parse(rest, file, line)?),
        "map_d" => material.map_d = Some(StatedTexture::parse(rest, file, line)?),
        "map_ke" => material.map_ke = Some(StatedTexture::parse(rest, file, line)?),
        "norm" | "map_norm" | "map_kn" => material.norm = Some(StatedTexture::parse(rest, file, line)?),
        "bump" | "map_bump" => material.bump = Some(StatedTexture::parse(rest, file, line)?),
        "refl" | "disp" | "decal" => other(),
        _ if key.starts_with("map_") && key != "map_ka" => other(),
        _ => {}
    }
    Ok(())
}

/// Applies a statement whose value is a file of a spectrum, and a factor that it is multiplied by, if there is one.
fn apply_spectrum(
    material: &mut RawMaterial,
    key: &str,
    rest: &str,
    line: usize,
    finder: &mut Finder,
) -> Result<(), String> {
    let rest = rest.split(" #").next().unwrap_or_default().trim();
    let (name, factor) = match rest.rsplit_once(char::is_whitespace) {
        Some((name, last)) if last.parse::<f64>().is_ok_and(|factor| factor >= 0.0 && factor.is_finite()) => {
            (name, last.parse().unwrap_or(1.0))
        }
        _ => (rest, 1.0),
    };
    let path = finder.find(name).ok_or_else(|| format!("there is no file {name}"))?;
    let fault = |error: Error| error.to_string();
    let spectra = &mut material.spectra;
    let (lobe, curve) = match key {
        "kd" => (&mut material.kd, &mut spectra.kd),
        "ks" => (&mut material.ks, &mut spectra.ks),
        "tf" => (&mut material.tf, &mut spectra.tf),
        "ke" => {
            let (value, light) = spd::emission(&path, factor).map_err(fault)?;
            (material.ke, spectra.ke) = (Some(At { value, line }), Some(light));
            material.read.push(path);
            return Ok(());
        }
        _ => return Err("only Kd, Ks, Ke and Tf can have a spectrum".into()),
    };
    let (value, spectrum) = spd::reflectance(&path, factor).map_err(fault)?;
    (*lobe, *curve) = (Some(At { value, line }), Some(spectrum));
    material.read.push(path);
    Ok(())
}

fn words(rest: &str) -> impl Iterator<Item = &str> {
    rest.split_whitespace().take_while(|word| !word.starts_with('#'))
}

fn number(rest: &str) -> Result<f32, &'static str> {
    let word = words(rest).next().ok_or("no number")?;
    word.parse().map_err(|_| "not a number")
}

/// One value stands for all bands.
fn at_bands(rest: &str, line: usize) -> Result<Option<At<Bands>>, &'static str> {
    let mut numbers = Vec::new();
    for word in words(rest) {
        if word == "spectral" || word == "xyz" {
            return Err("only RGB values are supported");
        }
        numbers.push(word.parse::<f32>().map_err(|_| "not a number")?);
    }
    let value = match numbers[..] {
        [] => return Err("no number"),
        [all] => [all; BANDS],
        [r, g, b, ..] => from_rgb([r, g, b]),
        [..] => return Err("three numbers expected"),
    };
    Ok(Some(At { value, line }))
}
