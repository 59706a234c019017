//! Load: a scene file or a mesh file becomes a validated [`Scene`].

use super::assembly::Assembly;
use super::obj::{self, ObjFile};
use super::scene_file::{self, DEFAULT_SIZE, MeshEntry, ShapeEntry};
use super::transform::Transform;
use super::warnings::Warnings;
use super::{Camera, Light, Scene, Wavelengths, frame, tessellation, validate};
use crate::host::files;
use crate::spectrum::BANDS;
use crate::{Error, Result};
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::path::Path;

/// Reads a scene: a `.toml` scene file, or an `.obj` alone, whose camera is then framed automatically.
///
/// Positions come back in the file's world units (metres by convention), y up, right-handed. What was repaired or
/// ignored is in [`Scene::warnings`].
///
/// # Errors
/// [`Error::Io`] where a file cannot be read; [`Error::Scene`], with file and line where known, where the scene
/// cannot be used; [`Error::Usage`] for a format without a reader. No input makes it panic.
pub fn load(path: &Path) -> Result<Scene> {
    reader(path)?(path)
}

/// Finds out by its name whether a scene can be read at all.
///
/// # Errors
/// [`Error::Usage`] for a format without a reader.
pub fn check_format(path: &Path) -> Result<()> {
    reader(path).map(|_| ())
}

fn reader(path: &Path) -> Result<fn(&Path) -> Result<Scene>> {
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    match extension.as_deref() {
        Some("toml") => Ok(load_scene_file),
        Some("obj") => Ok(load_obj),
        _ => {
            let what = format!("{}: not a scene format that can be read", path.display());
            Err(Error::usage(what, "known formats are .toml (scene file) and .obj"))
        }
    }
}

fn load_scene_file(path: &Path) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let description = scene_file::read(path)?;
    let mut assembly = Assembly::new(&description.materials);
    // a file that is placed many times is read once
    let mut files: HashMap<&Path, ObjFile> = HashMap::new();
    for entry in &description.meshes {
        let file = match files.entry(&entry.file) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(read_mesh(entry, path, &assembly.objects(), &mut warnings)?),
        };
        let mut mesh = file.place(&entry.transform, &mut warnings)?;
        let first_material = match assembly.made_of(&entry.material, path, entry.line, &mut warnings)? {
            Some(material) => {
                mesh.triangles.iter_mut().for_each(|t| t.material = 0);
                material
            }
            None => assembly.materials_of(file, &entry.file, &mut warnings)?,
        };
        assembly.add(mesh, first_material, &entry.file)?;
    }
    for entry in &description.shapes {
        let material = assembly.made_of(&entry.material, path, entry.line, &mut warnings)?;
        let material = material.unwrap_or_else(|| assembly.push_grey(None, path, entry.line));
        check_memory(entry, path)?;
        let mut mesh = entry.shape.mesh();
        let around = entry.shape.axis().and_then(|axis| Some((axis, assembly.around(material)?)));
        let material = around.map_or(material, |(_, material)| material);
        if let Some((axis, _)) = around {
            tessellation::set_around(&mut mesh, axis);
        }
        mesh.positions.iter_mut().for_each(|p| *p += entry.center);
        assembly.add(entry.transform.mesh(mesh), material, path)?;
    }
    assembly.check_overrides(files.values())?;
    let read = files.into_values().flat_map(|file| file.files).chain(description.files);
    let pictures = assembly.pictures().to_vec();
    let files = std::iter::once(path.to_owned()).chain(read).chain(pictures).collect();
    let (mesh, materials) = assembly.finish(&mut warnings);
    validate::surfaces(path, &mesh)?;
    validate::textures(path, &materials)?;
    validate::light(path, &mesh, &materials, &description.lights)?;
    let size = description.size;
    let camera = match &description.camera {
        Some(entry) => {
            let camera = entry.camera(size);
            validate::camera(path, Some(entry.line), &camera)?;
            camera
        }
        None => frame::frame(&mesh, &materials, &description.lights, size),
    };
    let warnings = warnings.into_lines();
    let wavelengths = Wavelengths { lights: description.light_spectra, are_rendered: false };
    let lights = description.lights;
    let mut scene = Scene { camera, size, mesh, materials, lights, wavelengths, warnings, files };
    scene.wavelengths.are_rendered = scene.asks_for_wavelengths().is_some();
    Ok(scene)
}

fn load_obj(path: &Path) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let mut assembly = Assembly::new(&[]);
    let file = obj::read(path, &HashSet::new(), &mut warnings)?;
    let mesh = file.place(&Transform::identity(), &mut warnings)?;
    let first_material = assembly.materials_of(&file, path, &mut warnings)?;
    assembly.add(mesh, first_material, path)?;
    let files = file.files.into_iter().chain(assembly.pictures().to_vec()).collect();
    let (mesh, materials) = assembly.finish(&mut warnings);
    validate::surfaces(path, &mesh)?;
    validate::textures(path, &materials)?;
    let size = DEFAULT_SIZE;
    let camera = frame::frame(&mesh, &materials, &[], size);
    let mut lights = Vec::new();
    if !validate::any_emission(&mesh, &materials) {
        warnings.add(path, None, "no light; a point light is put at the camera");
        lights.push(headlight(&camera));
    }
    let (wavelengths, warnings) = (Wavelengths::default(), warnings.into_lines());
    let mut scene = Scene { camera, size, mesh, materials, lights, wavelengths, warnings, files };
    scene.wavelengths.are_rendered = scene.asks_for_wavelengths().is_some();
    Ok(scene)
}

/// Bytes of memory that a triangle of a shape takes while it is made, at least: its own, and its share of corners and normals, twice.
const MEMORY_PER_TRIANGLE: u64 = 128;

/// Refuse a shape that does not fit the memory that is left, before any of it is taken.
fn check_memory(entry: &ShapeEntry, path: &Path) -> Result<()> {
    let triangles = entry.shape.triangles();
    files::check_memory(path, triangles * MEMORY_PER_TRIANGLE).map_err(|_| {
        let what = format!("the shape has {triangles} triangles, which do not fit the memory that is left");
        Error::scene(path, Some(entry.line), what, "give a larger tolerance, or free some")
    })
}

/// A light at the eye that shows a white surface at the target, seen face on, with radiance 1.
fn headlight(camera: &Camera) -> Light {
    let intensity = std::f64::consts::PI * (camera.target - camera.position).length_squared();
    Light::Point { position: camera.position, intensity: [intensity as f32; BANDS] }
}

fn read_mesh(
    entry: &MeshEntry,
    scene: &Path,
    objects: &HashSet<&str>,
    warnings: &mut Warnings,
) -> Result<ObjFile> {
    let extension = entry.file.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    if extension.as_deref() != Some("obj") {
        let what = format!("mesh file {} is not of a known format", entry.file.display());
        return Err(Error::scene(scene, Some(entry.line), what, "give an .obj file"));
    }
    let Ok(meta) = entry.file.metadata() else {
        let what = format!("mesh file {} does not exist", entry.file.display());
        return Err(Error::scene(scene, Some(entry.line), what, "paths are relative to the scene file"));
    };
    if let Some(kind) = files::other_kind(&meta) {
        let what = format!("mesh file {} is a {kind}", entry.file.display());
        return Err(Error::scene(scene, Some(entry.line), what, "name a file"));
    }
    obj::read(&entry.file, objects, warnings)
}
