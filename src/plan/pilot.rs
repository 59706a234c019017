//! Pilot: a few thousand camera rays, traced on the host, that tell how large things are in the image.

use crate::packed::{CameraRay, Guide, PackedScene, SMOOTH};
use glam::Vec3;

/// What the camera sees, in internal units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pilot {
    /// Median over the image of a pixel's width where its ray meets a diffuse surface.
    pub footprint_median: f32,
    /// The same, exceeded by few pixels only.
    pub footprint_large: f32,
}

/// Rays across and down.
const RAYS: u32 = 64;
/// Longest specular chain that is followed.
const CHAIN: u32 = 12;
/// Quantile that [`Pilot::footprint_large`] is.
const LARGE: f32 = 0.97;

impl Pilot {
    /// Look at the scene through its camera.
    pub fn look(scene: &PackedScene) -> Self {
        let mut footprints: Vec<f32> = (0..RAYS * RAYS)
            .filter_map(|i| {
                let x = ((i % RAYS) as f32 + 0.5) / RAYS as f32;
                let y = ((i / RAYS) as f32 + 0.5) / RAYS as f32;
                path_length(scene, scene.camera.ray([x, y]))
            })
            .map(|length| length * scene.pixel_angle())
            .collect();
        if footprints.is_empty() {
            // nothing diffuse is in view: any size will do
            footprints.push((scene.bounds[1] - scene.bounds[0]).length() * scene.pixel_angle());
        }
        footprints.sort_by(f32::total_cmp);
        let quantile = |q: f32| footprints[((footprints.len() - 1) as f32 * q) as usize];
        Self { footprint_median: quantile(0.5), footprint_large: quantile(LARGE).min(quantile(0.5) * 8.0) }
    }
}

/// Length of the path from the eye to the first diffuse surface; always refracts where it can.
fn path_length(scene: &PackedScene, ray: CameraRay) -> Option<f32> {
    let CameraRay { mut origin, mut direction, travelled: mut length } = ray;
    for _ in 0..CHAIN {
        let hit = scene.bvh.closest(&scene.triangles, origin, direction, f32::INFINITY)?;
        length += hit.t;
        let t = &scene.triangles[hit.triangle as usize];
        let material = &scene.materials[t.material as usize];
        if material.flags().has_diffuse() {
            return Some(length);
        }
        if !material.flags().has_delta() {
            return None;
        }
        let n = if t.flags & SMOOTH != 0 {
            let [a, b, c] = scene.shading_normals[hit.triangle as usize];
            (a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v).normalize_or(t.normal())
        } else {
            t.normal()
        };
        // a thin pane bends nothing
        let ior = if material.flags().is_thin() { 1.0 } else { material.ior };
        let (facing, eta) = if direction.dot(n) < 0.0 { (n, 1.0 / ior) } else { (-n, ior) };
        let refracted =
            if material.flags().is_dielectric() { direction.refract(facing, eta) } else { Vec3::ZERO };
        let point = origin + direction * hit.t;
        direction = if refracted == Vec3::ZERO { direction.reflect(facing) } else { refracted.normalize() };
        origin = point + direction * (1e-4 * point.length().max(1.0));
    }
    None
}

/// True where more than half of the caustic jotons start outside every target: they are aimed.
pub(super) fn aimed(scene: &PackedScene, guide: &Guide) -> bool {
    let outside = |p: Vec3| scene.targets.iter().all(|t| (p - t.center).length() > t.radius);
    let emitters = guide.emitters(&scene.emitters).iter();
    emitters.filter(|e| outside(e.middle())).map(|e| e.pick).sum::<f32>() > 0.5
}
