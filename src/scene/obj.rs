//! OBJ: reads Wavefront meshes and the material libraries that they name.
//!
//! reads   an OBJ file, cleaned by `clean.rs`, parsed by tobj
//! writes  triangles with flat or smooth normals, and for each the name of its material

use super::clean::{self, Clean};
use super::finder::Finder;
use super::mtl::{self, RawMaterial};
use super::transform::Transform;
use super::warnings::{Named, Warnings};
use super::{Mesh, Triangle, blender, polygon, text};
use crate::host::files;
use crate::{Error, Result};
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// A triangle whose area is below this share of its longest edge squared is a line to f64 rounding.
const DEGENERATE_SHARE: f64 = 1e-12;
/// Normals that differ from the geometric one by less (length of the difference) make a triangle flat.
const FLAT_TOLERANCE: f64 = 1e-6;
/// Largest coordinate, world units: squares of distances must stay finite in f32.
const MAX_COORDINATE: f64 = 1e15;

/// Bytes of memory that a face takes while it is read, at least: three corners and normals of the parser, and a triangle.
const MEMORY_PER_FACE: u64 = (6 * size_of::<u32>() + size_of::<Triangle>()) as u64;

/// A mesh file, read once; it may be placed several times.
#[derive(Debug)]
pub(crate) struct ObjFile {
    path: PathBuf,
    clean: Clean,
    parsed: Option<tobj::Mesh>,
    normals: Vec<DVec3>,
    /// Texture coordinates.
    uvs: Vec<[f32; 2]>,
    /// For each material of the file, in each part that was asked for, its place in `materials`.
    index_of: FxHashMap<(Option<usize>, usize), u32>,
    /// Materials in order of first use.
    pub(crate) materials: Vec<UsedMaterial>,
    /// All that the material libraries define.
    pub(crate) library: Vec<RawMaterial>,
    /// Objects and groups, where any were asked for.
    pub(crate) object_names: Vec<String>,
    /// The files that were read: the mesh and its material libraries.
    pub(crate) files: Vec<PathBuf>,
}

/// A material as faces use it.
#[derive(Debug, Clone)]
pub(crate) struct UsedMaterial {
    /// Its name; none before any `usemtl`.
    pub(crate) name: Option<String>,
    /// The object and the groups of these faces, those that were asked for.
    pub(crate) objects: Vec<String>,
    /// Line of the first of them.
    pub(crate) line: usize,
}

/// Reads an OBJ file and its libraries. Of its objects and groups those in `wanted` are told apart.
pub(crate) fn read(path: &Path, wanted: &HashSet<&str>, warnings: &mut Warnings) -> Result<ObjFile> {
    let source = text::read(path)?;
    let mut clean = clean::clean(&source, path, wanted, warnings)?;
    files::check_memory(path, clean.faces.len() as u64 * MEMORY_PER_FACE)?;
    let mut files = vec![path.to_owned()];
    let library = libraries(&clean, path, &mut files, warnings);
    let parsed = if clean.faces.is_empty() { None } else { Some(parse(&clean.text, path)?) };
    clean.text = String::new();
    let object_names = std::mem::take(&mut clean.object_names);
    let mut index_of: FxHashMap<_, u32> = FxHashMap::default();
    let mut materials: Vec<UsedMaterial> = Vec::new();
    for face in &clean.faces {
        index_of.entry((face.material, face.part)).or_insert_with(|| {
            materials.push(UsedMaterial {
                name: face.material.map(|m| clean.materials[m].clone()),
                objects: clean.parts[face.part].clone(),
                line: face.line,
            });
            materials.len() as u32 - 1
        });
    }
    let given = parsed.iter().flat_map(|p: &tobj::Mesh| p.normals.as_chunks::<3>().0);
    let normals = given.map(|&n| DVec3::from(n)).collect();
    let given = parsed.iter().flat_map(|p: &tobj::Mesh| p.texcoords.as_chunks::<2>().0);
    let uvs = given.map(|uv| uv.map(|x| x as f32)).collect();
    Ok(ObjFile {
        path: path.to_owned(),
        clean,
        parsed,
        normals,
        uvs,
        index_of,
        materials,
        library,
        object_names,
        files,
    })
}

impl ObjFile {
    /// The triangles where they stand; [`Triangle::material`] indexes `materials`.
    pub(crate) fn place(&self, transform: &Transform, warnings: &mut Warnings) -> Result<Mesh> {
        let path = &self.path;
        let mut builder = Builder { path, mesh: Mesh::default(), normal_of: FxHashMap::default(), warnings };
        let Some(parsed) = &self.parsed else { return Ok(builder.mesh) };
        files::check_memory(path, self.clean.faces.len() as u64 * size_of::<Triangle>() as u64)?;
        let placed = |&p: &[f64; 3]| transform.position(DVec3::from(p));
        builder.mesh.positions = parsed.positions.as_chunks::<3>().0.iter().map(placed).collect();
        if builder.mesh.positions.iter().any(|p| p.abs().max_element() > MAX_COORDINATE) {
            let remedy = "use a larger unit of length";
            return Err(Error::scene(
                path,
                None,
                format!("a coordinate is beyond {MAX_COORDINATE:e}"),
                remedy,
            ));
        }
        let normals: Vec<DVec3> = self.normals.iter().map(|n| transform.normal(*n)).collect();
        builder.mesh.uvs.clone_from(&self.uvs);
        let mirrors = transform.mirrors();
        let mut start = 0;
        // tobj leaves the arities out where all faces are triangles.
        let arities = parsed.face_arities.iter().copied().chain(std::iter::repeat(3));
        for (face, arity) in self.clean.faces.iter().zip(arities) {
            let end = start + arity as usize;
            let material = self.index_of[&(face.material, face.part)];
            let of_face = |indices: &'_ [u32]| -> Vec<u32> {
                let corners = indices.get(start..end).unwrap_or_default().iter().copied();
                if mirrors { corners.rev().collect() } else { corners.collect() }
            };
            let corners = Corners {
                vertices: of_face(&parsed.indices),
                normals: of_face(&parsed.normal_indices),
                uvs: if face.is_textured { of_face(&parsed.texcoord_indices) } else { Vec::new() },
            };
            builder.face(face.line, &corners, &normals, material);
            start = end;
        }
        Ok(builder.mesh)
    }
}

/// Parses cleaned text: a single model, polygons kept.
fn parse(text: &str, path: &Path) -> Result<tobj::Mesh> {
    let fault =
        |e: tobj::LoadError| Error::scene(path, None, e.to_string(), "report this file: it was checked");
    let options = tobj::LoadOptions::default();
    let (models, _) =
        tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| Ok(Default::default())).map_err(fault)?;
    models.into_iter().next().map(|model| model.mesh).ok_or_else(|| fault(tobj::LoadError::FaceParseError))
}

/// Reads the libraries that the file names, each once, in the order in which they are named last: of two definitions the
/// later counts. One that is missing or unreadable is a warning. Adds them to `read`.
fn libraries(
    clean: &Clean,
    path: &Path,
    read: &mut Vec<PathBuf>,
    warnings: &mut Warnings,
) -> Vec<RawMaterial> {
    let mut finder = Finder::new(path.parent().unwrap_or(Path::new("")).to_owned());
    let mut named: HashMap<&str, Vec<Result<PathBuf, String>>> = HashMap::new();
    // where each file is named first, and last
    let mut places: HashMap<PathBuf, [usize; 2]> = HashMap::new();
    for (place, (line, names)) in clean.libraries.iter().enumerate() {
        for found in named.entry(names).or_insert_with(|| finder.locate(names)) {
            match found {
                Ok(file) => match places.get_mut(file) {
                    Some([_, last]) => *last = place,
                    None => drop(places.insert(file.clone(), [place; 2])),
                },
                Err(name) => {
                    let kind = Named {
                        noun: ["material library", "material libraries"],
                        what: [" is not found", " are not found"],
                    };
                    warnings.add_named(path, Some(*line), kind, name, String::new);
                }
            }
        }
    }
    let mut files: Vec<(PathBuf, [usize; 2])> = places.into_iter().collect();
    files.sort_by(|(a, [_, p]), (b, [_, q])| p.cmp(q).then_with(|| a.cmp(b)));
    let mut library = Vec::new();
    read.extend(files.iter().map(|(file, _)| file.clone()));
    for (file, [first, _]) in files {
        match mtl::read(&file, warnings) {
            Ok(mut materials) => {
                read.extend(materials.iter_mut().flat_map(|m| std::mem::take(&mut m.read)));
                materials.iter_mut().filter(|m| m.is_of_blender).for_each(blender::restate);
                library.extend(materials);
            }
            Err(error) => warnings.add(path, Some(clean.libraries[first].0), error.to_string()),
        }
    }
    library
}

/// Indices of the corners of a face.
struct Corners {
    vertices: Vec<u32>,
    normals: Vec<u32>,
    /// None where the face has no texture coordinates.
    uvs: Vec<u32>,
}

struct Builder<'a> {
    path: &'a Path,
    mesh: Mesh,
    /// From a normal of the file, as it is or turned over, to one of the mesh.
    normal_of: FxHashMap<(u32, bool), u32>,
    warnings: &'a mut Warnings,
}

impl Builder<'_> {
    fn face(&mut self, line: usize, corners: &Corners, normals: &[DVec3], material: u32) {
        let Corners { vertices, normals: corner_normals, uvs } = corners;
        let places: Vec<DVec3> = vertices.iter().map(|&v| self.mesh.positions[v as usize]).collect();
        for triangle in polygon::triangulate(&places) {
            let [a, b, c] = triangle.map(|i| places[i]);
            let Some(geometric) = geometric_normal([a, b, c]) else {
                self.warnings.add(self.path, Some(line), "triangle without area is dropped");
                continue;
            };
            let corner_normals = triangle.map(|i| corner_normals[i]);
            let normal = self.normals(line, geometric, corner_normals, normals);
            let vertex = triangle.map(|i| vertices[i]);
            let uv = (!uvs.is_empty()).then(|| triangle.map(|i| uvs[i]));
            self.mesh.triangles.push(Triangle { vertex, normal, uv, material });
        }
    }

    /// Shading normals of a triangle: none where they are absent, unusable or all the geometric one.
    fn normals(
        &mut self,
        line: usize,
        geometric: DVec3,
        indices: [u32; 3],
        normals: &[DVec3],
    ) -> Option<[u32; 3]> {
        let given = indices.map(|i| normals[i as usize]);
        if given.iter().all(|n| *n == DVec3::ZERO) {
            return None; // the file gives none, or all zero
        }
        let units = given.map(|n| n.try_normalize());
        let [Some(a), Some(b), Some(c)] = units else {
            self.warnings.add(self.path, Some(line), "normal without length; the triangle is flat");
            return None;
        };
        let units = [a, b, c];
        let fronts = units.iter().filter(|n| n.dot(geometric) > 0.0).count();
        let turned = match fronts {
            3 => false,
            0 if units.iter().all(|n| n.dot(geometric) < 0.0) => true,
            _ => {
                let what = "normals lie on both sides of the triangle; it is flat";
                self.warnings.add(self.path, Some(line), what);
                return None;
            }
        };
        if turned {
            let what = "normals point to the back of the triangle and are turned over (its front is where its \
                        vertices run counter-clockwise)";
            self.warnings.add(self.path, Some(line), what);
        }
        let units = units.map(|n| if turned { -n } else { n });
        if units.iter().all(|n| (n - geometric).length() <= FLAT_TOLERANCE) {
            return None;
        }
        Some(std::array::from_fn(|i| {
            *self.normal_of.entry((indices[i], turned)).or_insert_with(|| {
                self.mesh.normals.push(units[i].as_vec3());
                self.mesh.normals.len() as u32 - 1
            })
        }))
    }
}

/// Unit normal on the side from which the corners run counter-clockwise, or none where they span no area.
pub(crate) fn geometric_normal([a, b, c]: [DVec3; 3]) -> Option<DVec3> {
    let cross = (b - a).cross(c - a);
    let longest = (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared());
    // Written so that a NaN is degenerate too.
    if cross.length() > DEGENERATE_SHARE * longest { cross.try_normalize() } else { None }
}
