//! Pack: a [`Scene`] as plain arrays that both backends read, in internal units.
//!
//! Internal units: the scene is moved so that its bounding box is centred on the origin (in f64, so a scene far from
//! the origin loses no digits) and scaled by a power of two to a radius in [512, 1024) (so that a scene in nanometres
//! or in light years meets the same rounding). Radiance does not change under scaling; flux is in internal W:
//! world flux = internal flux × `world_scale`².

mod area_points;
mod emitters;
mod guide;
mod marks;
mod reach;
mod surfaces;
mod targets;
mod winding;

pub use area_points::{AreaPoint, scatter as scatter_area_points};
pub use emitters::{EmitterKind, PackedEmitter};
pub use guide::{Guide, MAX_WARPS, WARP_BINS, WARP_WORDS, Warp};
pub use marks::{MARK_FACTORS, MARK_WORDS, Marks};
pub(crate) use surfaces::without_copies;
pub use surfaces::{MaterialFlags, NO_EMITTER, PackedMaterial, PackedTriangle, SMOOTH, first_corner};
pub use targets::{MAX_TARGETS, Target};

use crate::bvh::Bvh;
use crate::scene::{Scene, Triangle};
use glam::{DVec3, Vec3};
use serde::Serialize;

/// Exponent of the internal radius: scenes are scaled to a bounding radius in [2^9, 2^10).
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
    pub bvh: Bvh,
    /// Triangles in leaf order.
    pub triangles: Vec<PackedTriangle>,
    /// Unit shading normals at the vertices, one entry a triangle; empty where every triangle is flat.
    pub shading_normals: Vec<[Vec3; 3]>,
    /// Materials, indexed by [`PackedTriangle::material`].
    pub materials: Vec<PackedMaterial>,
    /// Everything that emits, with cumulative probabilities proportional to flux.
    pub emitters: Vec<PackedEmitter>,
    /// Flux of all emitters together, internal W per band.
    pub total_flux: [f64; crate::bands::BANDS],
    /// Bounding spheres of the connected specular bodies: where caustic jotons must go first.
    pub targets: Vec<Target>,
    /// Corners of the bounding box.
    pub bounds: [Vec3; 2],
    /// Area of all surfaces that have a diffuse or glossy lobe (one side).
    pub diffuse_area: f64,
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

/// A pinhole: the ray through image coordinates (x, y) in [0, 1]², (0, 0) the top left, runs along
/// `forward + (2x − 1) right + (1 − 2y) up`.
#[derive(Debug, Clone, Copy)]
pub struct PackedCamera {
    /// Eye point.
    pub eye: Vec3,
    /// Right, scaled by the tangent of half the field of view across.
    pub right: Vec3,
    /// Up, scaled likewise.
    pub up: Vec3,
    /// Unit view direction.
    pub forward: Vec3,
}

impl PackedCamera {
    /// Unit direction through image coordinates (x, y).
    pub fn direction(&self, [x, y]: [f32; 2]) -> Vec3 {
        (self.forward + self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y)).normalize()
    }
}

impl PackedScene {
    /// Pack what can be reached from the scene's camera.
    pub fn new(scene: &Scene) -> Self {
        let (whole, order) = Self::pack(scene);
        let Some(rest) = reach::within_reach(scene, &whole, &order) else { return whole };
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
        let to_internal = |p: DVec3| ((p - world_center) / world_scale).as_vec3();

        let turned = winding::turned(scene);
        let internal = |(t, turned): (&Triangle, &bool)| {
            let vertex = |k| t.vertex[winding::corner(*turned, k)] as usize;
            [0, 1, 2].map(|k| to_internal(scene.mesh.positions[vertex(k)]))
        };
        let vertices: Vec<[Vec3; 3]> = scene.mesh.triangles.iter().zip(&turned).map(internal).collect();
        let kept = without_copies(scene, &vertices);
        let corners: Vec<[Vec3; 3]> = kept.iter().map(|&i| vertices[i as usize]).collect();
        let (bvh, order) = Bvh::build(&corners);
        let order: Vec<u32> = order.into_iter().map(|i| kept[i as usize]).collect();
        let materials: Vec<PackedMaterial> = scene.materials.iter().map(PackedMaterial::new).collect();
        let (mut triangles, shading_normals) = surfaces::pack(scene, &vertices, &turned, &order);
        let internal_bounds = [to_internal(lo), to_internal(hi)];
        let emitters = emitters::pack(scene, &mut triangles, world_scale, to_internal, internal_bounds);
        let total_flux = std::array::from_fn(|b| emitters.iter().map(|e| f64::from(e.flux[b])).sum::<f64>());
        let diffuse_area = triangles
            .iter()
            .filter(|t| materials[t.material as usize].flags().has_diffuse())
            .map(|t| f64::from(t.area()))
            .sum();
        let targets = targets::find(&triangles, &materials);
        let [right, up, forward] = scene.camera.basis();
        let [tx, ty] = scene.camera.tan_half_fov;
        let packed = Self {
            world_scale,
            world_center,
            camera: PackedCamera {
                eye: to_internal(scene.camera.position),
                right: (right * tx).as_vec3(),
                up: (up * ty).as_vec3(),
                forward: forward.as_vec3(),
            },
            size: scene.size,
            bvh,
            triangles,
            shading_normals,
            materials,
            emitters,
            total_flux,
            targets,
            bounds: internal_bounds,
            diffuse_area,
            out_of_reach: OutOfReach::default(),
        };
        (packed, order)
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
