//! Scene: what is to be rendered; validated, free of any backend, in the user's world units (f64).

mod absorption;
mod assembly;
mod blender;
mod camera;
mod clean;
mod ears;
mod facets;
mod finder;
mod frame;
mod glass;
mod layers;
mod light;
mod load;
mod material;
mod mtl;
mod obj;
mod polygon;
mod rule;
mod scene_file;
mod shape;
mod spd;
mod spectra;
mod spectrum_entry;
mod table;
mod tessellation;
mod text;
pub mod texture;
mod transform;
mod validate;
mod warnings;
mod weld;

pub use camera::Camera;
pub use light::{Light, LightPlace};
pub use load::{check_format, load};
pub use material::{
    Anisotropy, Dielectric, FacetKind, Facets, Inner, Interior, Layers, Material, Metallic, Mixture,
    number_rests,
};
pub use spectra::{MaterialSpectra, WavelengthReason, Wavelengths};
pub(crate) use warnings::quoted;
pub(crate) use weld::Surface as GlassSurface;

use glam::{DVec3, Vec3};
use std::path::PathBuf;

/// A validated scene: every index is in range, every number finite, at least one light and one triangle.
#[derive(Debug, Clone)]
pub struct Scene {
    /// Where the camera stands.
    pub camera: Camera,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// All triangles of all meshes.
    pub mesh: Mesh,
    /// Materials, indexed by [`Triangle::material`].
    pub materials: Vec<Material>,
    /// Lights beside the emissive triangles.
    pub lights: Vec<Light>,
    /// What is said by wavelength beside the materials, and whether the scene is rendered so.
    pub wavelengths: Wavelengths,
    /// What was repaired or ignored on the way in, one line each ("box.obj:14: …").
    pub warnings: Vec<String>,
    /// The files that were read: the scene, its meshes, their material libraries.
    pub files: Vec<PathBuf>,
}

/// Triangles over shared vertices.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Vertex positions, world units.
    pub positions: Vec<DVec3>,
    /// Unit shading normals.
    pub normals: Vec<Vec3>,
    /// Texture coordinates: across, and up.
    pub uvs: Vec<[f32; 2]>,
    /// Triangles.
    pub triangles: Vec<Triangle>,
}

impl Mesh {
    /// Bytes of all of it.
    pub(crate) fn bytes(&self) -> u64 {
        let Self { positions, normals, uvs, triangles } = self;
        let vertices = size_of_val(&positions[..]) + size_of_val(&normals[..]) + size_of_val(&uvs[..]);
        (vertices + size_of_val(&triangles[..])) as u64
    }

    /// Its vertices alone.
    pub(crate) fn without_triangles(&self) -> Self {
        Self {
            positions: self.positions.clone(),
            normals: self.normals.clone(),
            uvs: self.uvs.clone(),
            triangles: Vec::new(),
        }
    }
}

/// A triangle; its front is where its vertices run counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub struct Triangle {
    /// Indices into [`Mesh::positions`].
    pub vertex: [u32; 3],
    /// Indices into [`Mesh::normals`], or none for a flat triangle.
    pub normal: Option<[u32; 3]>,
    /// Indices into [`Mesh::uvs`]; none where the triangle has no texture coordinates: they count as 0.
    pub uv: Option<[u32; 3]>,
    /// Index into [`Scene::materials`].
    pub material: u32,
}

/// The surfaces of glass of a scene.
pub(crate) fn glass_surfaces(scene: &Scene) -> Vec<GlassSurface> {
    weld::surfaces(&scene.mesh, &scene.materials)
}

impl Scene {
    /// Render at another size; the field of view across stays, and pixels are square.
    pub fn resize(&mut self, size: [u32; 2]) {
        self.size = size;
        let aspect = f64::from(size[0]) / f64::from(size[1]);
        let [x, y] = &mut self.camera.tan_half_fov;
        *y = *x / aspect;
    }
}
