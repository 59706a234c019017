//! Shapes: the triangles, grouped by material and by whether they are smooth, as meshes of their own in f32.

use super::subset::Bsdf;
use super::unsupported;
use crate::error::Result;
use crate::packed::without_copies;
use crate::scene::Scene;
use crate::spectrum::{Bands, is_black};
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
    pub(super) bsdf: Bsdf,
    /// Radiance from the front, W/(m² sr).
    pub(super) emission: Bands,
    /// World positions.
    pub(super) positions: Vec<Vec3>,
    /// Shading normals, one for each position; empty for a flat shape.
    pub(super) normals: Vec<Vec3>,
    /// Corners, counter-clockwise as seen from the front.
    pub(super) triangles: Vec<[u32; 3]>,
}

/// All triangles but exact copies, which one ray may meet twice elsewhere.
pub(super) fn shapes<'a>(scene: &'a Scene, source: &Path) -> Result<Vec<Shape<'a>>> {
    let corner = |v: u32| scene.mesh.positions[v as usize].as_vec3();
    let vertices: Vec<[Vec3; 3]> = scene.mesh.triangles.iter().map(|t| t.vertex.map(corner)).collect();
    let mut groups: BTreeMap<(u32, bool), Vec<u32>> = BTreeMap::new();
    for i in without_copies(scene, &vertices) {
        let t = &scene.mesh.triangles[i as usize];
        groups.entry((t.material, t.normal.is_some())).or_default().push(i);
    }
    groups.into_iter().map(|((material, smooth), of)| shape(scene, source, material, smooth, &of)).collect()
}

fn shape<'a>(
    scene: &'a Scene,
    source: &Path,
    material_index: u32,
    smooth: bool,
    triangles: &[u32],
) -> Result<Shape<'a>> {
    let material = &scene.materials[material_index as usize];
    let bsdf = Bsdf::of(material, source)?;
    // others take the cosine of emission from the shading normal; on a black surface nothing else asks for it
    let emits = !is_black(&material.emission);
    let smooth = smooth && !(emits && bsdf.is_black());
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
    let mut shape = Shape {
        material: &material.name,
        material_index,
        bsdf,
        emission: material.emission,
        positions: Vec::new(),
        normals: Vec::new(),
        triangles: Vec::with_capacity(triangles.len()),
    };
    let mut index_of: FxHashMap<(u32, Option<u32>), u32> = FxHashMap::default();
    for &i in triangles {
        let t = &scene.mesh.triangles[i as usize];
        let normals = t.normal.filter(|_| smooth);
        shape.triangles.push([0, 1, 2].map(|k| {
            let (vertex, normal) = (t.vertex[k], normals.map(|n| n[k]));
            *index_of.entry((vertex, normal)).or_insert_with(|| {
                shape.positions.push(scene.mesh.positions[vertex as usize].as_vec3());
                shape.normals.extend(normal.map(|n| scene.mesh.normals[n as usize]));
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
