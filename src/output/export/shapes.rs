//! Shapes: the triangles, grouped by material and by whether they are smooth, as meshes of their own in f32.

use super::colour::Colour;
use super::subset::Look;
use super::{Fidelity, unsupported};
use crate::error::Result;
use crate::packed::without_copies;
use crate::scene::Scene;
use crate::spectrum::is_black;
use glam::{DVec3, Vec3};
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;
use std::path::Path;

/// Rounding to f32 may move a vertex by this part of the scene's size: a hundredth of a pixel of an image of 1000.
const ROUNDING: f64 = 1e-5;
/// Half a unit in the last place of an f32, relative.
const HALF_ULP: f64 = 0.5 * f32::EPSILON as f64;

/// A mesh of one material.
#[derive(Debug)]
pub(super) struct Shape<'a> {
    /// Name of the material.
    pub(super) material: &'a str,
    /// Index of the material in the scene.
    pub(super) material_index: u32,
    /// What it is made of.
    pub(super) look: Look,
    /// Radiance from the front, W/(m² sr), by wavelength W/(m² sr nm); none where it does not shine.
    pub(super) emission: Option<Colour>,
    /// World positions.
    pub(super) positions: Vec<Vec3>,
    /// Shading normals, one for each position; empty for a flat shape.
    pub(super) normals: Vec<Vec3>,
    /// Texture coordinates, one for each position; empty where no picture is written.
    pub(super) uvs: Vec<[f32; 2]>,
    /// Corners, counter-clockwise as seen from the front.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// All triangles but exact copies, which one ray may meet twice elsewhere.
pub(super) fn shapes<'a>(scene: &'a Scene, source: &Path, fidelity: Fidelity) -> Result<Vec<Shape<'a>>> {
    let corner = |v: u32| scene.mesh.positions[v as usize].as_vec3();
    let vertices: Vec<[Vec3; 3]> = scene.mesh.triangles.iter().map(|t| t.vertex.map(corner)).collect();
    let mut groups: BTreeMap<(u32, bool), Vec<u32>> = BTreeMap::new();
    for i in without_copies(scene, &vertices) {
        let t = &scene.mesh.triangles[i as usize];
        groups.entry((t.material, t.normal.is_some())).or_default().push(i);
    }
    groups
        .into_iter()
        .map(|((material, smooth), of)| {
            let looks = &scene.materials[material as usize];
            let look = Look::of(looks, scene.wavelengths.are_rendered, fidelity, source)?;
            shape(scene, source, look, material, smooth, &of)
        })
        .collect()
}

fn shape<'a>(
    scene: &'a Scene,
    source: &Path,
    look: Look,
    material_index: u32,
    smooth: bool,
    triangles: &[u32],
) -> Result<Shape<'a>> {
    let material = &scene.materials[material_index as usize];
    // others take the cosine of emission from the shading normal; on a black surface nothing else asks for it
    let emits = !is_black(&material.emission);
    let smooth = smooth && !(emits && look.is_black());
    if smooth && emits {
        return Err(unsupported(
            source,
            format!(
                "material \"{}\": emits, reflects and has smooth normals at once, which other renderers take \
                     for another emission",
                material.name
            ),
            "make it black (Kd 0) or its mesh flat (no vn)",
        ));
    }
    let stated = material.spectra.as_deref().filter(|_| scene.wavelengths.are_rendered);
    let stated = stated.and_then(|spectra| spectra.emission.as_ref());
    let is_textured = look.has_texture();
    let mut shape = Shape {
        material: &material.name,
        material_index,
        look,
        emission: emits.then(|| Colour::emission(&material.emission, stated)),
        positions: Vec::new(),
        normals: Vec::new(),
        uvs: Vec::new(),
        triangles: Vec::with_capacity(triangles.len()),
    };
    let mut index_of: FxHashMap<(u32, Option<u32>, Option<u32>), u32> = FxHashMap::default();
    for &i in triangles {
        let t = &scene.mesh.triangles[i as usize];
        let normals = t.normal.filter(|_| smooth);
        shape.triangles.push([0, 1, 2].map(|k| {
            let (vertex, normal) = (t.vertex[k], normals.map(|n| n[k]));
            let uv = t.uv.filter(|_| is_textured).map(|uv| uv[k]);
            *index_of.entry((vertex, normal, uv)).or_insert_with(|| {
                shape.positions.push(scene.mesh.positions[vertex as usize].as_vec3());
                shape.normals.extend(normal.map(|n| scene.mesh.normals[n as usize]));
                if is_textured {
                    shape.uvs.push(uv.map_or([0.0; 2], |uv| scene.mesh.uvs[uv as usize]));
                }
                shape.positions.len() as u32 - 1
            })
        }));
    }
    Ok(shape)
}

/// Longest side of the bounding box. Refuses a scene whose coordinates lose their digits in f32, which is what others
/// store.
pub(super) fn extent(scene: &Scene, source: &Path) -> Result<f64> {
    let used =
        || scene.mesh.triangles.iter().flat_map(|t| t.vertex).map(|v| scene.mesh.positions[v as usize]);
    let (low, high) = used().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let farthest = used().map(|p| p.abs().max_element()).fold(0.0, f64::max);
    let extent = (high - low).max_element();
    if farthest * HALF_ULP > ROUNDING * extent {
        return Err(unsupported(
            source,
            "the scene is so far from the origin that other renderers, which count in f32, would distort it",
            "move meshes (translate), camera and lights to the origin",
        ));
    }
    Ok(extent)
}
