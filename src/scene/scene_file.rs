//! Scene file: reads the TOML that names meshes, camera, film, lights and materials (docs/SCENE.md).
//!
//! reads   TOML text
//! writes  a [`Description`]: typed, every key known, not yet looked up or put together

use super::camera::CameraEntry;
use super::light::{self, Light};
use super::mtl::{At, Kind, RawMaterial};
use super::table::{Table, parse};
use super::text::{self, Lines};
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
    /// Lights in order.
    pub(crate) lights: Vec<Light>,
    /// Materials that override or define.
    pub(crate) materials: Vec<RawMaterial>,
}

/// `[[mesh]]`
#[derive(Debug)]
pub(crate) struct MeshEntry {
    /// Line of its file name.
    pub(crate) line: usize,
    /// The file.
    pub(crate) file: PathBuf,
    /// Factor on positions.
    pub(crate) scale: f64,
    /// Added after scaling, world units.
    pub(crate) translate: DVec3,
}

/// Reads a scene file.
pub(crate) fn read(path: &Path) -> Result<Description> {
    let source = text::read(path)?;
    let root = parse(&source, path)?;
    let lines = Lines::of(&source);
    let root = Table::new(path, &lines, "the scene", root.get_ref(), root.span());
    root.allow(&["camera", "film", "mesh", "light", "material"])?;
    let camera = root.table("camera")?.map(CameraEntry::read).transpose()?;
    let size = root.table("film")?.map(film).transpose()?.unwrap_or(DEFAULT_SIZE);
    let meshes = root.tables("mesh")?.into_iter().map(|t| mesh(t, path)).collect::<Result<Vec<_>>>()?;
    let lights = root.tables("light")?.into_iter().map(light::read).collect::<Result<Vec<_>>>()?;
    let materials =
        root.tables("material")?.into_iter().map(|t| material(t, path)).collect::<Result<Vec<_>>>()?;
    if meshes.is_empty() {
        return Err(Error::scene(path, None, "no [[mesh]]", "add one: [[mesh]] with file = \"name.obj\""));
    }
    Ok(Description { camera, size, meshes, lights, materials })
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
    table.allow(&["file", "scale", "translate"])?;
    let file = table.string("file")?;
    let scale = table.number("scale")?.unwrap_or(At { value: 1.0, line: table.line() });
    if scale.value <= 0.0 {
        return Err(table.fault(scale.line, &format!("scale {}", scale.value), "give a number above 0"));
    }
    let directory = path.parent().unwrap_or(Path::new(""));
    Ok(MeshEntry {
        line: file.line,
        file: directory.join(file.value),
        scale: scale.value,
        translate: table.optional_vector("translate")?.unwrap_or(DVec3::ZERO),
    })
}

/// Without `type`, what is stated replaces statements of the MTL; with it, the material is defined from scratch.
fn material(table: Table, path: &Path) -> Result<RawMaterial> {
    table.allow(&["name", "type", "kd", "ks", "ke", "ior", "tint", "exponent", "roughness", "thin"])?;
    let kind = table.optional_string("type")?;
    let kind = match kind.as_ref().map(|k| (k.value.as_str(), k.line)) {
        None => None,
        Some(("matte", _)) => Some(Kind::Matte),
        Some(("mirror", _)) => Some(Kind::Mirror),
        Some(("glass", _)) => Some(Kind::Glass),
        Some(("glossy", _)) => Some(Kind::Glossy),
        Some((other, line)) => {
            return Err(table.unknown(
                line,
                "type of material",
                other,
                &["matte", "mirror", "glass", "glossy"],
            ));
        }
    };
    let single = |value: Option<At<f64>>| value.map(|v| At { value: v.value as f32, line: v.line });
    Ok(RawMaterial {
        name: table.string("name")?.value,
        file: path.to_owned(),
        line: table.line(),
        kind,
        thin: table.boolean("thin")?,
        kd: table.bands("kd")?,
        ks: table.bands("ks")?,
        ke: table.bands("ke")?,
        tf: table.bands("tint")?,
        ni: single(table.number("ior")?),
        ns: single(table.number("exponent")?),
        pr: single(table.number("roughness")?),
        ..Default::default()
    })
}
