//! Scene file: reads the TOML that names meshes, shapes, camera, film, lights and materials (docs/SCENE.md).
//!
//! reads   TOML text
//! writes  a [`Description`]: typed, every key known, not yet looked up or put together

use super::absorption;
use super::camera::CameraEntry;
use super::layers;
use super::light::{self, Light};
use super::mtl::{At, Kind, RawMaterial, RawSpectra};
use super::shape::Shape;
use super::spectrum_entry;
use super::table::{Source, Table, TextOrTable, parse};
use super::text;
use super::texture::entry;
use super::texture::stated::StatedTexture;
use super::transform::Transform;
use crate::spectrum::BANDS;
use crate::spectrum::lamp::Emission;
use crate::spectrum::metal::Metal;
use crate::{Error, Result};
use glam::DVec3;
use std::path::{Path, PathBuf};

/// Image size where a file gives none, pixels.
pub(crate) const DEFAULT_SIZE: [u32; 2] = [512, 512];
/// Largest image side, pixels: what a 2D texture may measure on most devices, and a typing error beyond.
const MAX_SIDE: u32 = 16_384;

/// What a scene file says.
#[derive(Debug)]
pub(crate) struct Description {
    /// The camera, if there is one.
    pub(crate) camera: Option<CameraEntry>,
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    /// Mesh files in order.
    pub(crate) meshes: Vec<MeshEntry>,
    /// Shapes in order.
    pub(crate) shapes: Vec<ShapeEntry>,
    /// Lights in order.
    pub(crate) lights: Vec<Light>,
    /// Their spectra, where they are stated by wavelength.
    pub(crate) light_spectra: Vec<Option<Emission>>,
    /// Materials that override or define.
    pub(crate) materials: Vec<MaterialEntry>,
    /// Files that were read for it: spectra.
    pub(crate) files: Vec<PathBuf>,
}

/// `[[material]]`
#[derive(Debug)]
pub(crate) struct MaterialEntry {
    /// Whose: what a mesh calls so.
    pub(crate) of: Called,
    /// What is stated. Its name is that of `of`.
    pub(crate) raw: RawMaterial,
}

/// What a mesh file gives a name to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) enum Called {
    /// A material.
    Material,
    /// An object, or a group of faces.
    Object,
}

/// What a mesh as a whole or a shape is made of.
#[derive(Debug)]
pub(crate) enum MadeOf {
    /// What the file says; a shape is matte grey.
    Nothing,
    /// A `[[material]]`.
    Named(At<String>),
    /// Stated where it is used.
    Own(Box<RawMaterial>),
}

/// `[[mesh]]`
#[derive(Debug)]
pub(crate) struct MeshEntry {
    /// Line of its file name.
    pub(crate) line: usize,
    /// The file.
    pub(crate) file: PathBuf,
    /// Where it stands.
    pub(crate) transform: Transform,
    /// One material for all of its faces.
    pub(crate) material: MadeOf,
}

/// `[[shape]]`
#[derive(Debug)]
pub(crate) struct ShapeEntry {
    /// Line of its header.
    pub(crate) line: usize,
    /// What it is.
    pub(crate) shape: Shape,
    /// Where its centre is before it is placed, world units.
    pub(crate) center: DVec3,
    /// Where that stands.
    pub(crate) transform: Transform,
    /// What it is made of.
    pub(crate) material: MadeOf,
}

/// Reads a scene file.
pub(crate) fn read(path: &Path) -> Result<Description> {
    let text = text::read(path)?;
    let root = parse(&text, path)?;
    let source = Source::of(&text);
    let root = Table::new(path, &source, "the scene", root.get_ref(), root.span());
    root.allow(&["camera", "film", "mesh", "shape", "light", "material"])?;
    let camera = root.table("camera")?.map(CameraEntry::read).transpose()?;
    let size = root.table("film")?.map(film).transpose()?.unwrap_or(DEFAULT_SIZE);
    let meshes = root.tables("mesh")?.into_iter().map(|t| mesh(t, path)).collect::<Result<Vec<_>>>()?;
    let shapes = root.tables("shape")?.into_iter().map(|t| shape(t, path)).collect::<Result<Vec<_>>>()?;
    let lights = root.tables("light")?.into_iter().map(light::read).collect::<Result<Vec<_>>>()?;
    let (lights, light_spectra) = lights.into_iter().unzip();
    let materials =
        root.tables("material")?.into_iter().map(|t| material_entry(t, path)).collect::<Result<Vec<_>>>()?;
    if meshes.is_empty() && shapes.is_empty() {
        let remedy = "add one: [[mesh]] with file = \"name.obj\", or [[shape]] with kind = \"sphere\"";
        return Err(Error::scene(path, None, "no [[mesh]] and no [[shape]]", remedy));
    }
    Ok(Description {
        camera,
        size,
        meshes,
        shapes,
        lights,
        light_spectra,
        materials,
        files: source.into_read(),
    })
}

fn film(table: Table) -> Result<[u32; 2]> {
    table.allow(&["width", "height"])?;
    let mut size = DEFAULT_SIZE;
    for (side, key) in size.iter_mut().zip(["width", "height"]) {
        let Some(At { value, line }) = table.integer(key)? else { continue };
        *side = u32::try_from(value).ok().filter(|s| (1..=MAX_SIDE).contains(s)).ok_or_else(|| {
            table.fault(line, &format!("{key} of {value} pixels"), &format!("give 1 to {MAX_SIDE}"))
        })?;
    }
    Ok(size)
}

fn mesh(table: Table, path: &Path) -> Result<MeshEntry> {
    table.allow(&[&["file", "material"][..], &Transform::KEYS].concat())?;
    let file = table.string("file")?;
    let directory = path.parent().unwrap_or(Path::new(""));
    let name = Path::new(&file.value).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(MeshEntry {
        line: file.line,
        file: directory.join(file.value),
        transform: Transform::read(&table)?,
        material: made_of(&table, path, &name)?,
    })
}

fn shape(table: Table, path: &Path) -> Result<ShapeEntry> {
    let (shape, center) = Shape::read(&table, &[&["material"][..], &Transform::KEYS].concat())?;
    Ok(ShapeEntry {
        line: table.line(),
        shape,
        center,
        transform: Transform::read(&table)?,
        material: made_of(&table, path, &table.string("kind")?.value)?,
    })
}

/// `material` of something: the name of one, or a table. What is stated in a table has the name of what it is for.
fn made_of(table: &Table, path: &Path, name: &str) -> Result<MadeOf> {
    Ok(match table.text_or_table("material")? {
        None => MadeOf::Nothing,
        Some(TextOrTable::Text(name)) => MadeOf::Named(name),
        Some(TextOrTable::Table(own)) => {
            own.allow(&MATERIAL_KEYS)?;
            MadeOf::Own(Box::new(material(&own, path, name.to_owned())?))
        }
    })
}

fn material_entry(table: Table, path: &Path) -> Result<MaterialEntry> {
    table.allow(&[&["name", "object"][..], &MATERIAL_KEYS].concat())?;
    let (of, name) = match (table.optional_string("name")?, table.optional_string("object")?) {
        (Some(_), Some(object)) => {
            return Err(table.fault(object.line, "both name and object", "give one of them"));
        }
        (None, Some(object)) => (Called::Object, object.value),
        _ => (Called::Material, table.string("name")?.value),
    };
    Ok(MaterialEntry { of, raw: material(&table, path, name)? })
}

/// What may be said of a material.
const MATERIAL_KEYS: [&str; 32] = [
    "type",
    "kd",
    "ks",
    "ke",
    "ior",
    "tint",
    "exponent",
    "roughness",
    "thin",
    "alpha",
    "metal",
    "eta",
    "k",
    "metallic",
    "saturated",
    "opacity",
    "absorption",
    "attenuation_color",
    "attenuation_distance",
    "priority",
    "normal",
    "bump",
    "transmit",
    "anisotropy",
    "anisotropy_rotation",
    layers::KEYS[0],
    layers::KEYS[1],
    layers::KEYS[2],
    layers::KEYS[3],
    layers::KEYS[4],
    layers::KEYS[5],
    layers::KEYS[6],
];

/// Keys that some kinds of material alone read.
const KEYS_OF_KINDS: [(&str, &[Kind]); 5] = [
    ("metal", &[Kind::Metal]),
    ("eta", &[Kind::Metal]),
    ("k", &[Kind::Metal]),
    ("metallic", &[Kind::Principled]),
    ("saturated", &[Kind::Plastic]),
];

/// Kinds, and the words of scene files for them.
const KINDS: [(&str, Kind); 7] = [
    ("matte", Kind::Matte),
    ("mirror", Kind::Mirror),
    ("glass", Kind::Glass),
    ("glossy", Kind::Glossy),
    ("metal", Kind::Metal),
    ("plastic", Kind::Plastic),
    ("principled", Kind::Principled),
];

/// Kinds as a scene file writes them.
fn words_of(kinds: &[Kind]) -> String {
    let words = KINDS.iter().filter(|(_, kind)| kinds.contains(kind)).map(|(word, _)| format!("\"{word}\""));
    words.collect::<Vec<_>>().join(" or ")
}

/// Without `type`, what is stated replaces statements of the MTL; with it, the material is defined from scratch.
fn material(table: &Table, path: &Path, name: String) -> Result<RawMaterial> {
    let kind = match table.optional_string("type")? {
        None => None,
        Some(At { value, line }) => {
            let known = KINDS.into_iter().find(|(word, _)| *word == value);
            let unknown = || table.unknown(line, "type of material", &value, &KINDS.map(|(word, _)| word));
            Some(known.ok_or_else(unknown)?.1)
        }
    };
    let of_layers = layers::KEYS.map(|key| (key, &[Kind::Principled][..]));
    for (key, kinds) in KEYS_OF_KINDS.into_iter().chain(of_layers) {
        let Some(line) = table.line_of(key) else { continue };
        if !kind.is_some_and(|kind| kinds.contains(&kind)) {
            let what = format!("{key} in a material that is not of its kind");
            return Err(table.fault(line, &what, &format!("give type = {}", words_of(kinds))));
        }
    }
    let single = |value: Option<At<f64>>| value.map(|v| At { value: v.value as f32, line: v.line });
    let map_kd = entry::texture(table, "kd", path)?;
    let map_d = entry::texture(table, "opacity", path)?;
    let number = |key: &str| entry::number(table, key, path);
    let (map_pr, map_pm, map_transmission) =
        (number("roughness")?, number("metallic")?, number("transmission")?);
    let (norm, bump) = (entry::normals(table, path)?, entry::heights(table, path)?);
    if let (Some(_), Some(StatedTexture { line, .. })) = (&norm, &bump) {
        return Err(table.fault(*line, "both normal and bump", "give one of them"));
    }
    let plain = |key: &str, map: &Option<StatedTexture>| match map {
        Some(_) => Ok(None),
        None => Ok::<_, Error>(single(table.number(key)?)),
    };
    let opacity = if map_d.is_some() { None } else { opacity(table)? };
    let [(kd, kd_spectrum), (ks, ks_spectrum), (tf, tf_spectrum), (transmit, transmit_spectrum)] = [
        if map_kd.is_some() { (None, None) } else { spectrum_entry::reflectance(table, "kd")? },
        spectrum_entry::reflectance(table, "ks")?,
        spectrum_entry::reflectance(table, "tint")?,
        spectrum_entry::reflectance(table, "transmit")?,
    ];
    let (map_ke, (ke, ke_spectrum)) = match entry::emission(table, "ke", path)? {
        Some((stated, At { value, line })) => {
            (Some(stated), (Some(At { value: [value; BANDS], line }), None))
        }
        None => (None, spectrum_entry::emission(table, "ke")?),
    };
    let (ni, index) = spectrum_entry::index(table, "ior")?;
    let (absorption, absorption_spectrum) = absorption::read(table)?;
    let metal = match table.optional_string("metal")? {
        None => None,
        Some(At { value, line }) => {
            let metal = Metal::named(&value);
            Some(metal.ok_or_else(|| table.unknown(line, "metal", &value, &Metal::names()))?)
        }
    };
    let (eta, k) = (table.bands("eta")?, table.bands("k")?);
    if let (Some(At { line, .. }), None) | (None, Some(At { line, .. })) = (eta, k) {
        return Err(table.fault(
            line,
            "an index with one of its parts",
            "give eta and k, or the name of a metal",
        ));
    }
    Ok(RawMaterial {
        name,
        file: path.to_owned(),
        line: table.line(),
        kind,
        thin: table.boolean("thin")?,
        kd,
        ks,
        ke,
        tf,
        transmit,
        ni,
        absorption,
        priority: table.integer("priority")?,
        spectra: RawSpectra {
            kd: kd_spectrum,
            ks: ks_spectrum,
            tf: tf_spectrum,
            transmit: transmit_spectrum,
            ke: ke_spectrum,
            absorption: absorption_spectrum,
            ni: index,
        },
        ns: single(table.number("exponent")?),
        pr: plain("roughness", &map_pr)?,
        map_kd,
        map_d,
        opacity,
        pm: plain("metallic", &map_pm)?,
        map_pr,
        map_pm,
        map_ke,
        norm,
        bump,
        aniso: single(table.number("anisotropy")?),
        // degrees
        anisor: single(
            table.number("anisotropy_rotation")?.map(|turn| At { value: turn.value / 360.0, ..turn }),
        ),
        alpha: single(table.number("alpha")?),
        metal,
        eta,
        k,
        saturated: table.boolean("saturated")?,
        layers: layers::read(table, map_transmission.is_some())?,
        map_transmission,
        ..Default::default()
    })
}

/// How much of a surface is there, as a number.
fn opacity(table: &Table) -> Result<Option<At<f32>>> {
    match table.number("opacity")? {
        None => Ok(None),
        Some(At { value, line }) if (0.0..=1.0).contains(&value) => {
            Ok(Some(At { value: value as f32, line }))
        }
        Some(At { value, line }) => {
            Err(table.fault(line, &format!("opacity {value}"), "give 0 (not there) to 1 (opaque)"))
        }
    }
}
