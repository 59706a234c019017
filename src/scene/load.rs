//! Load: a scene file or a mesh file becomes a validated [`Scene`].

use super::glass::{self, Origin};
use super::mtl::RawMaterial;
use super::obj::{self, ObjFile};
use super::scene_file::{self, DEFAULT_SIZE, MeshEntry};
use super::warnings::{Named, Warnings, listed};
use super::{Camera, Light, Material, Mesh, Scene, frame, rule, text, validate};
use crate::host::files;
use crate::spectrum::BANDS;
use crate::{Error, Result};
use glam::DVec3;
use std::collections::hash_map::Entry;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// Names that an error lists.
const NAMES_TOLD: usize = 20;
/// Name of the material of faces that name none.
const UNNAMED: &str = "(none)";

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
    let mut files: HashMap<&Path, Opened> = HashMap::new();
    for entry in &description.meshes {
        let opened = match files.entry(&entry.file) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let file = read_mesh(entry, path, &mut warnings)?;
                new.insert(assembly.open(file, &entry.file, &mut warnings)?)
            }
        };
        let mesh = opened.file.place(entry.scale, entry.translate, &mut warnings)?;
        assembly.add(mesh, opened.first_material, &entry.file)?;
    }
    drop(files);
    assembly.check_overrides()?;
    let files = [vec![path.to_owned()], std::mem::take(&mut assembly.files)].concat();
    let (mesh, materials) = assembly.finish(&mut warnings);
    validate::surfaces(path, &mesh)?;
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
    Ok(Scene { camera, size, mesh, materials, lights: description.lights, warnings, files })
}

fn load_obj(path: &Path) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let mut assembly = Assembly::new(&[]);
    let opened = assembly.open(obj::read(path, &mut warnings)?, path, &mut warnings)?;
    let mesh = opened.file.place(1.0, DVec3::ZERO, &mut warnings)?;
    assembly.add(mesh, opened.first_material, path)?;
    let files = std::mem::take(&mut assembly.files);
    let (mesh, materials) = assembly.finish(&mut warnings);
    validate::surfaces(path, &mesh)?;
    let size = DEFAULT_SIZE;
    let camera = frame::frame(&mesh, &materials, &[], size);
    let mut lights = Vec::new();
    if !validate::any_emission(&mesh, &materials) {
        warnings.add(path, None, "no light; a point light is put at the camera");
        lights.push(headlight(&camera));
    }
    Ok(Scene { camera, size, mesh, materials, lights, warnings: warnings.into_lines(), files })
}

/// A light at the eye that shows a white surface at the target, seen face on, with radiance 1.
fn headlight(camera: &Camera) -> Light {
    let intensity = std::f64::consts::PI * (camera.target - camera.position).length_squared();
    Light::Point { position: camera.position, intensity: [intensity as f32; BANDS] }
}

fn read_mesh(entry: &MeshEntry, scene: &Path, warnings: &mut Warnings) -> Result<ObjFile> {
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
    obj::read(&entry.file, warnings)
}

/// A mesh file whose materials are looked up.
struct Opened {
    file: ObjFile,
    /// Where its materials begin.
    first_material: u32,
}

/// Meshes put together, with the materials that they use.
struct Assembly<'a> {
    mesh: Mesh,
    materials: Vec<Material>,
    /// For each material where it is used first.
    origins: Vec<Origin>,
    overrides: &'a [RawMaterial],
    /// Overrides by name, in their order.
    overrides_of: HashMap<&'a str, Vec<&'a RawMaterial>>,
    /// Names of materials that some face uses, each once.
    used: Vec<String>,
    is_used: HashSet<String>,
    /// Files that were read.
    files: Vec<PathBuf>,
}

impl<'a> Assembly<'a> {
    fn new(overrides: &'a [RawMaterial]) -> Self {
        let mut overrides_of: HashMap<&str, Vec<&RawMaterial>> = HashMap::new();
        for stated in overrides {
            overrides_of.entry(&stated.name).or_default().push(stated);
        }
        let (mesh, materials, origins, used, is_used, files) = Default::default();
        Self { mesh, materials, origins, overrides, overrides_of, used, is_used, files }
    }

    /// The whole, its glass settled.
    fn finish(mut self, warnings: &mut Warnings) -> (Mesh, Vec<Material>) {
        glass::settle(&mut self.mesh, &mut self.materials, &self.origins, warnings);
        (self.mesh, self.materials)
    }

    /// Looks up the materials of a file.
    fn open(&mut self, file: ObjFile, path: &Path, warnings: &mut Warnings) -> Result<Opened> {
        let mut index_of: HashMap<&str, &RawMaterial> = HashMap::new();
        for raw in &file.library {
            index_of.insert(&raw.name, raw);
            // A comment may follow the name.
            if let Some((name, _)) = raw.name.split_once(" #") {
                index_of.entry(name.trim()).or_insert(raw);
            }
        }
        let first_material = self.materials.len() as u32;
        for (name, line) in &file.materials {
            let (material, thin) = self.material(name.as_deref(), *line, &index_of, path, warnings)?;
            self.materials.push(material);
            self.origins.push(Origin { file: path.to_owned(), line: *line, thin });
        }
        self.files.extend(file.files.iter().cloned());
        Ok(Opened { file, first_material })
    }

    fn add(&mut self, mesh: Mesh, first_material: u32, path: &Path) -> Result<()> {
        let offset = |count: usize| {
            u32::try_from(count).map_err(|_| {
                Error::scene(path, None, "more than 4 294 967 295 vertices", "use fewer or smaller meshes")
            })
        };
        offset(self.mesh.positions.len() + mesh.positions.len())?;
        offset(self.mesh.normals.len() + mesh.normals.len())?;
        let first_vertex = offset(self.mesh.positions.len())?;
        let first_normal = offset(self.mesh.normals.len())?;
        self.mesh.positions.extend(mesh.positions);
        self.mesh.normals.extend(mesh.normals);
        self.mesh.triangles.extend(mesh.triangles.into_iter().map(|mut t| {
            t.vertex = t.vertex.map(|v| v + first_vertex);
            t.normal = t.normal.map(|n| n.map(|n| n + first_normal));
            t.material += first_material;
            t
        }));
        Ok(())
    }

    fn material(
        &mut self,
        name: Option<&str>,
        line: usize,
        library: &HashMap<&str, &RawMaterial>,
        path: &Path,
        warnings: &mut Warnings,
    ) -> Result<(Material, Option<bool>)> {
        let Some(name) = name else {
            warnings.add(path, Some(line), "faces without a material are matte grey 0.5");
            return Ok((Material::matte(UNNAMED, rule::GREY), None));
        };
        let name_alone = name.split_once(" #").map_or(name, |(name, _)| name.trim());
        let defined = library.get(name).or_else(|| library.get(name_alone)).copied();
        if self.is_used.insert(name.to_owned()) {
            self.used.push(name.to_owned());
        }
        let mut raw = defined.cloned();
        for &stated in self.overrides_of.get(name).into_iter().flatten() {
            raw = Some(match raw {
                Some(raw) if stated.kind.is_none() => raw.overridden_by(stated),
                _ => stated.clone(),
            });
        }
        match raw {
            Some(raw) => {
                let material = rule::material(&raw, warnings)?;
                if let Some(thin) = raw.thin.filter(|_| material.dielectric.is_none()) {
                    let what = format!("material \"{name}\": thin says nothing of what is no glass");
                    warnings.add(&raw.file, Some(thin.line), what);
                }
                Ok((material, raw.thin.map(|thin| thin.value)))
            }
            None => {
                let kind = Named {
                    noun: ["material", "materials"],
                    what: [
                        " is not defined; it is matte grey 0.5",
                        " are not defined; they are matte grey 0.5",
                    ],
                };
                let hint = || {
                    let near = text::did_you_mean(name, library.keys().copied());
                    near.map_or(String::new(), |near| format!(" (did you mean \"{near}\"?)"))
                };
                warnings.add_named(path, Some(line), kind, name, hint);
                Ok((Material::matte(name, rule::GREY), None))
            }
        }
    }

    /// An override that meets no material is a slip.
    fn check_overrides(&self) -> Result<()> {
        let Some(lost) = self.overrides.iter().find(|o| !self.is_used.contains(&o.name)) else {
            return Ok(());
        };
        let remedy = match text::did_you_mean(&lost.name, self.used.iter().map(String::as_str)) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => {
                let told = &self.used[..self.used.len().min(NAMES_TOLD)];
                format!("materials in use are {}", listed(told, self.used.len()))
            }
        };
        let what = format!("no mesh uses material \"{}\"", lost.name);
        Err(Error::scene(&lost.file, Some(lost.line), what, remedy))
    }
}

impl RawMaterial {
    /// This material with what another states in place of its own.
    fn overridden_by(self, other: &RawMaterial) -> RawMaterial {
        let textured = if other.kd.is_some() { None } else { self.map_kd };
        RawMaterial {
            file: other.file.clone(),
            line: other.line,
            thin: other.thin.or(self.thin),
            kd: other.kd.or(self.kd),
            ks: other.ks.or(self.ks),
            ke: other.ke.or(self.ke),
            tf: other.tf.or(self.tf),
            ni: other.ni.or(self.ni),
            // Either of exponent and roughness replaces both.
            ns: other.ns.or(if other.pr.is_some() { None } else { self.ns }),
            pr: other.pr.or(if other.ns.is_some() { None } else { self.pr }),
            map_kd: textured,
            ..self
        }
    }
}
