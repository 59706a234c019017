//! Pack: a [`Scene`] as plain arrays that both backends read, in internal units.
//!
//! Internal units: the scene is moved so that its bounding box is centred on the origin (in f64, so a scene far from
//! the origin loses no digits) and scaled by a power of two to a radius in [512, 1024) (so that a scene in nanometres
//! or in light years meets the same rounding). Radiance does not change under scaling; flux is in internal W:
//! world flux = internal flux × `world_scale`².

#[doc(hidden)]
pub mod accel;
mod area_points;
mod bodies;
mod brush;
mod camera;
#[doc(hidden)]
pub mod constants;
mod contacts;
mod doubts;
mod emitters;
mod enclosure_culling;
#[doc(hidden)]
pub mod gpu_struct;
mod guide;
#[doc(hidden)]
pub mod heap;
#[doc(hidden)]
pub mod layout;
mod material_flags;
mod media;
mod spectra;
mod surfaces;
mod targets;
mod textures;
mod visible_cells;
#[doc(hidden)]
pub mod wgsl;
mod winding;

pub use area_points::{AreaPoint, scatter as scatter_area_points};
pub use brush::Brush;
pub use camera::{CameraInfo, CameraRay, PackedCamera};
pub use doubts::doubts;
pub use emitters::{EmitterKind, FAR, PackedEmitter};
pub use guide::{Guide, MAX_WARPS, WARP_BINS, WARP_WORDS, Warp};
pub use heap::{HEAP_WORD, HeapCounts, HeapLayout, PackedNormals, SceneInfo};
pub use material_flags::MaterialFlags;
pub use media::{BODIES_MOST, Body, Inside, Media, NESTED_MOST};
pub use spectra::{PassBands, Spectra};
pub use surfaces::{
    BODY_SHIFT, CLEAR, CUT, LAMP, NESTED, NO_EMITTER, PackedMaterial, PackedTriangle, SMOOTH, TEXTURED,
    first_corner,
};
pub(crate) use surfaces::{SAME_INDEX, rank, without_copies};
pub use targets::{MAX_TARGETS, Target};
pub use textures::{PackedTexture, PackedUvs, TextureFlags, Textures};
pub use visible_cells::{VISIBLE_CELL_FACTORS, VISIBLE_CELL_WORDS, VisibleCells};

use crate::error::{Error, Result};
use crate::packed::accel::Bvh;
use crate::scene::texture::fit;
use crate::scene::{Scene, Triangle};
use crate::spectrum::Bands;
use glam::{DVec3, Vec3};
use serde::Serialize;
use std::sync::Arc;

/// Bytes of memory that packing a triangle takes: measured with one and with five million of them, hierarchy included.
const BYTES_PER_TRIANGLE: u64 = 362;

/// Refuse a scene that cannot be packed in the memory that is left, before any of it is taken.
///
/// # Errors
/// [`Error::Capacity`] with need and limit.
pub fn check_memory(scene: &Scene) -> Result<()> {
    let need = scene.mesh.triangles.len() as u64 * BYTES_PER_TRIANGLE;
    check_left(need.saturating_add(textures::bytes_of(scene)), crate::host::memory::allowed())
}

/// Make pictures of a scene smaller that cannot be packed in the memory that the user allows.
pub fn fit_pictures(scene: &mut Scene) {
    let mesh = scene.mesh.bytes() + scene.mesh.triangles.len() as u64 * BYTES_PER_TRIANGLE;
    if let Some(most) = fit::room(mesh) {
        scene.shrink_pictures(most);
    }
}

fn check_left(need: u64, left: Option<u64>) -> Result<()> {
    match left {
        Some(limit) if need > limit => {
            let remedy =
                "use fewer triangles or smaller textures, free memory or allow more (--memory)".to_string();
            Err(Error::Capacity { buffer: "the scene", need, limit, remedy })
        }
        _ => Ok(()),
    }
}

/// Exponent of the internal radius: scenes are scaled to a bounding radius in [2^9, 2^10), below [`SCENE_RADIUS`].
const RADIUS_EXPONENT: i32 = 9;

/// A scene as plain arrays, in internal units.
#[derive(Debug, Clone)]
pub struct PackedScene {
    /// World length of one internal unit; a power of two.
    pub world_scale: f64,
    /// World position of the internal origin.
    pub world_center: DVec3,
    /// The camera.
    pub camera: PackedCamera,
    /// Image width and height, pixels.
    pub size: [u32; 2],
    /// The hierarchy over `triangles`.
    pub bvh: Arc<Bvh>,
    /// Triangles in leaf order.
    pub triangles: Arc<Vec<PackedTriangle>>,
    /// Unit shading normals at the vertices, one entry a triangle; empty where every triangle is flat.
    pub shading_normals: Arc<Vec<[Vec3; 3]>>,
    /// Textures of the materials.
    pub textures: Arc<Textures>,
    /// Materials, indexed by [`PackedTriangle::material`].
    pub materials: Vec<PackedMaterial>,
    /// Everything that emits, with cumulative probabilities proportional to flux.
    pub emitters: Vec<PackedEmitter>,
    /// Flux of all emitters together, internal W per band.
    pub total_flux: [f64; crate::spectrum::BANDS],
    /// Bounding spheres of the connected specular bodies: where caustic jotons must go first.
    pub targets: Vec<Target>,
    /// Corners of the bounding box.
    pub bounds: [Vec3; 2],
    /// Area of all surfaces that have a diffuse or glossy lobe (one side).
    pub diffuse_area: f64,
    /// Some faces may lie in one place: which of them a ray meets is to be asked \[E27\].
    pub has_contacts: bool,
    /// Bodies whose inside matters, and what is in them.
    pub media: Arc<Media>,
    /// What a texel of red, green or blue alone reflects in the bands of a pass; none where these are red, green and blue.
    pub of_texel: Option<[Bands; 3]>,
    /// The scene by wavelength, where it is rendered so; its bands are red, green and blue else.
    pub spectra: Option<Arc<Spectra>>,
    /// What the scene has beside this.
    pub out_of_reach: OutOfReach,
}

/// How much of a scene is left out, since no path from its camera ever comes there.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct OutOfReach {
    /// Triangles.
    pub triangles: usize,
    /// Lights beside the emissive triangles.
    pub lights: usize,
}

impl OutOfReach {
    /// True where nothing is left out.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

impl PackedScene {
    /// Pack what can be reached from the scene's camera.
    pub fn new(scene: &Scene) -> Self {
        let (whole, order) = Self::pack(scene);
        let Some(rest) = enclosure_culling::within_reach(scene, &whole, &order) else { return whole };
        let out_of_reach = OutOfReach {
            triangles: scene.mesh.triangles.len() - rest.mesh.triangles.len(),
            lights: scene.lights.len() - rest.lights.len(),
        };
        Self { out_of_reach, ..Self::pack(&rest).0 }
    }

    /// Pack a scene with everything in it.
    pub fn whole(scene: &Scene) -> Self {
        Self::pack(scene).0
    }

    /// The scene, and for each leaf slot the number of its triangle.
    fn pack(scene: &Scene) -> (Self, Vec<u32>) {
        let (lo, hi) = bounds(scene);
        let world_center = 0.5 * (lo + hi);
        let radius = (0.5 * (hi - lo).length()).max(f64::MIN_POSITIVE);
        let world_scale = 2f64.powi(radius.log2().floor() as i32 - RADIUS_EXPONENT);
        let internal = |p: DVec3| (p - world_center) / world_scale;
        let to_internal = |p: DVec3| internal(p).as_vec3();

        let turned = winding::turned(scene);
        let vertices_of = |(t, turned): (&Triangle, &bool)| {
            let vertex = |k| t.vertex[winding::corner(*turned, k)] as usize;
            [0, 1, 2].map(|k| to_internal(scene.mesh.positions[vertex(k)]))
        };
        let vertices: Vec<[Vec3; 3]> = scene.mesh.triangles.iter().zip(&turned).map(vertices_of).collect();
        let kept = without_copies(scene, &vertices);
        let corners: Vec<[Vec3; 3]> = kept.iter().map(|&i| vertices[i as usize]).collect();
        let (bvh, order) = Bvh::build(&corners);
        let order: Vec<u32> = order.into_iter().map(|i| kept[i as usize]).collect();
        let mut materials: Vec<PackedMaterial> = scene.materials.iter().map(PackedMaterial::new).collect();
        surfaces::join_rests(&mut materials);
        let media = Media::of(scene, &mut materials, world_scale);
        let (mut triangles, shading_normals) = surfaces::pack(scene, &vertices, &turned, &order);
        media.mark(&mut triangles, &materials);
        let first = |i: u32| first_corner(vertices[i as usize]);
        let textures = Textures::pack(scene, &mut materials, &turned, &order, world_scale, first);
        let internal_bounds = [to_internal(lo), to_internal(hi)];
        let (emitters, sources) = emitters::pack(
            scene,
            &mut triangles,
            (&materials, &textures.uvs),
            world_scale,
            internal,
            internal_bounds,
        );
        let total_flux = std::array::from_fn(|b| emitters.iter().map(|e| f64::from(e.flux[b])).sum::<f64>());
        let diffuse_area = triangles
            .iter()
            .filter(|t| materials[t.material as usize].flags().stores())
            .map(|t| f64::from(t.area()))
            .sum();
        let spectra = scene
            .wavelengths
            .are_rendered
            .then(|| Arc::new(Spectra::new(scene, &materials, &emitters, sources, world_scale)));
        let targets = targets::find(&triangles, &materials);
        let has_contacts = contacts::any(&bvh, &triangles);
        let eye = internal(scene.camera.position);
        let look = media::Look { bvh: &bvh, triangles: &triangles, materials: &materials };
        let media = media.with_starts(&look, eye.as_vec3(), &emitters);
        let packed = Self {
            world_scale,
            world_center,
            camera: PackedCamera::new(&scene.camera, eye),
            size: scene.size,
            bvh: Arc::new(bvh),
            triangles: Arc::new(triangles),
            shading_normals: Arc::new(shading_normals),
            textures: Arc::new(textures),
            materials,
            emitters,
            total_flux,
            targets,
            bounds: internal_bounds,
            diffuse_area,
            has_contacts,
            media: Arc::new(media),
            of_texel: None,
            spectra,
            out_of_reach: OutOfReach::default(),
        };
        (packed, order)
    }

    /// Bytes of triangles, textures, lights and hierarchy.
    pub fn bytes(&self) -> u64 {
        let bytes = size_of_val(&self.triangles[..])
            + size_of_val(&self.shading_normals[..])
            + self.textures.bytes()
            + size_of_val(&self.emitters[..])
            + size_of_val(self.bvh.nodes());
        bytes as u64
    }

    /// Pixels in the image.
    pub fn pixels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }
}

/// Corners of the bounding box of the triangles that are used, world units.
fn bounds(scene: &Scene) -> (DVec3, DVec3) {
    let used = scene.mesh.triangles.iter().flat_map(|t| t.vertex);
    used.map(|v| scene.mesh.positions[v as usize])
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What fits to the byte is packed; a triangle more is refused, with need and limit. Where nothing is known of the memory,
    /// nothing is refused.
    #[test]
    fn memory_for_packing_is_kept() {
        let left = 1000 * BYTES_PER_TRIANGLE;
        assert!(check_left(left, Some(left)).is_ok() && check_left(u64::MAX, None).is_ok());
        let e = check_left(left + BYTES_PER_TRIANGLE, Some(left)).expect_err("refused").to_string();
        assert!(e.contains(&(left + BYTES_PER_TRIANGLE).to_string()) && e.contains(&left.to_string()), "{e}");
    }
}
