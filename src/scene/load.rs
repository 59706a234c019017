//! Load: a scene file or a mesh file becomes a validated [`Scene`].

use super::mtl::RawMaterial;
use super::obj::{self, ObjFile};
use super::scene_file::{self, CameraEntry, DEFAULT_SIZE, MeshEntry};
use super::warnings::Warnings;
use super::{Camera, Light, Material, Mesh, Scene, frame, rule, text, validate};
use crate::bands::{self, BANDS};
use crate::{Error, Result, input};
use glam::DVec3;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

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
    let extension = path.extension().and_then(|e| e.to_str()).map(str::to_lowercase);
    match extension.as_deref() {
        Some("toml") => load_scene_file(path),
        Some("obj") => load_obj(path),
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
    for entry in &description.meshes {
        assembly.add(read_mesh(entry, path, &mut warnings)?, &entry.file, &mut warnings)?;
    }
    assembly.check_overrides()?;
    let files = [vec![path.to_owned()], assembly.files].concat();
    let (mesh, materials) = (assembly.mesh, assembly.materials);
    validate::surfaces(path, &mesh)?;
    validate::light(path, &mesh, &materials, &description.lights)?;
    let size = description.size;
    let camera = match &description.camera {
        Some(entry) => camera(entry, size, path)?,
        None => frame::frame(&mesh, &materials, &description.lights, size),
    };
    let warnings = warnings.into_lines();
    Ok(Scene { camera, size, mesh, materials, lights: description.lights, warnings, files })
}

fn load_obj(path: &Path) -> Result<Scene> {
    let mut warnings = Warnings::default();
    let mut assembly = Assembly::new(&[]);
    assembly.add(obj::read(path, 1.0, DVec3::ZERO, &mut warnings)?, path, &mut warnings)?;
    let (mesh, materials, files) = (assembly.mesh, assembly.materials, assembly.files);
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
    if let Some(kind) = input::other_kind(&meta) {
        let what = format!("mesh file {} is a {kind}", entry.file.display());
        return Err(Error::scene(scene, Some(entry.line), what, "name a file"));
    }
    obj::read(&entry.file, entry.scale, entry.translate, warnings)
}

/// Turns the entry into a camera for an image of `size` pixels.
fn camera(entry: &CameraEntry, size: [u32; 2], path: &Path) -> Result<Camera> {
    let (degrees, across_width) = entry.fov;
    let tangent = (degrees.to_radians() / 2.0).tan();
    let [width, height] = size.map(f64::from);
    let tan_half_fov =
        if across_width { [tangent, tangent * height / width] } else { [tangent * width / height, tangent] };
    let camera = Camera { position: entry.position, target: entry.target, up: entry.up, tan_half_fov };
    validate::camera(path, Some(entry.line), &camera)?;
    Ok(camera)
}

/// Meshes put together, with the materials that they use.
struct Assembly<'a> {
    mesh: Mesh,
    materials: Vec<Material>,
    overrides: &'a [RawMaterial],
    /// Names of materials that some face uses.
    used: Vec<String>,
    /// Files that were read.
    files: Vec<PathBuf>,
}

impl<'a> Assembly<'a> {
    fn new(overrides: &'a [RawMaterial]) -> Self {
        Self { mesh: Mesh::default(), materials: Vec::new(), overrides, used: Vec::new(), files: Vec::new() }
    }

    fn add(&mut self, file: ObjFile, path: &Path, warnings: &mut Warnings) -> Result<()> {
        let offset = |count: usize| {
            u32::try_from(count).map_err(|_| {
                Error::scene(path, None, "more than 4 294 967 295 vertices", "use fewer or smaller meshes")
            })
        };
        offset(self.mesh.positions.len() + file.mesh.positions.len())?;
        offset(self.mesh.normals.len() + file.mesh.normals.len())?;
        let first_vertex = offset(self.mesh.positions.len())?;
        let first_normal = offset(self.mesh.normals.len())?;
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
            let material = self.material(name.as_deref(), *line, &index_of, path, warnings)?;
            self.materials.push(material);
        }
        self.files.extend(file.files);
        self.mesh.positions.extend(file.mesh.positions);
        self.mesh.normals.extend(file.mesh.normals);
        self.mesh.triangles.extend(file.mesh.triangles.into_iter().map(|mut t| {
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
    ) -> Result<Material> {
        let Some(name) = name else {
            warnings.add(path, Some(line), "faces without a material are matte grey 0.5");
            return Ok(Material::matte(UNNAMED, rule::GREY));
        };
        let name_alone = name.split_once(" #").map_or(name, |(name, _)| name.trim());
        let defined = library.get(name).or_else(|| library.get(name_alone)).copied();
        self.used.push(name.to_owned());
        let mut raw = defined.cloned();
        for stated in self.overrides.iter().filter(|o| o.name == name) {
            raw = Some(match raw {
                Some(raw) if stated.kind.is_none() => raw.overridden_by(stated),
                _ => stated.clone(),
            });
        }
        match raw {
            Some(raw) => rule::material(&raw, warnings),
            None => {
                let near = text::did_you_mean(name, library.keys().copied());
                let hint = near.map_or(String::new(), |near| format!(" (did you mean \"{near}\"?)"));
                let what = format!("material \"{name}\" is not defined{hint}; it is matte grey 0.5");
                warnings.add(path, Some(line), what);
                Ok(Material::matte(name, rule::GREY))
            }
        }
    }

    /// An override that meets no material is a slip.
    fn check_overrides(&self) -> Result<()> {
        let Some(lost) = self.overrides.iter().find(|o| !self.used.contains(&o.name)) else { return Ok(()) };
        let remedy = match text::did_you_mean(&lost.name, self.used.iter().map(String::as_str)) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("materials in use are {}", self.used.join(", ")),
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

/// Whether any band of any used material emits.
pub(crate) fn emits(material: &Material) -> bool {
    !bands::is_black(&material.emission)
}
