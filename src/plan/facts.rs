//! Facts of a scene that a plan is made from: what is there, and what light can never do.

use crate::optics::lights::shines_on;
use crate::packed::{MaterialFlags, PackedMaterial, PackedScene};
use glam::Vec3;

/// The materials of all triangles, with what of these is no glass.
fn materials(scene: &PackedScene) -> impl Iterator<Item = &PackedMaterial> {
    let all = scene.triangles.iter().map(|t| &scene.materials[t.material as usize]);
    all.flat_map(|m| std::iter::once(m).chain(m.rest().map(|rest| &scene.materials[rest])))
}

/// True where the material of some triangle is so.
pub(super) fn has(scene: &PackedScene, is: impl Fn(MaterialFlags) -> bool) -> bool {
    materials(scene).any(|m| is(m.flags()))
}

/// True where some surface is glass in part.
pub(super) fn has_mixtures(scene: &PackedScene) -> bool {
    scene.triangles.iter().any(|t| scene.materials[t.material as usize].rest().is_some())
}

/// True where some surface emits.
pub(super) fn has_emissive_surface(scene: &PackedScene) -> bool {
    scene.emitters.iter().any(|e| e.has_area())
}

/// True where some surface shines by a picture, or is dark by one.
pub(super) fn shines_by_pictures(scene: &PackedScene) -> bool {
    materials(scene).any(|m| m.emission_texture().is_some())
}

/// True where some surface can be a gather point.
pub(super) fn has_diffuse_surface(scene: &PackedScene) -> bool {
    scene.diffuse_area > 0.0
}

/// True where light samples may lie in a lobe that is followed.
pub(super) fn shows_lights_in_followed_lobes(scene: &PackedScene) -> bool {
    !scene.emitters.is_empty() && materials(scene).any(PackedMaterial::has_narrow_lobe)
}

/// True where a light without area can be seen in a lobe that is followed.
pub(super) fn shows_delta_lights(scene: &PackedScene) -> bool {
    scene.emitters.iter().any(|e| !e.has_area()) && shows_lights_in_followed_lobes(scene)
}

/// True where light of some emitter can meet a specular body before anything else: not where all emitters face away from
/// all bounding spheres.
pub(super) fn lights_reach_targets(scene: &PackedScene) -> bool {
    scene.emitters.iter().any(|e| scene.targets.iter().any(|t| shines_on(e, t)))
}

/// Surfaces nearer to a plane than this, in internal units, lie in it: 32 units in the last place of the largest coordinates.
const ONE_PLANE: f32 = 1.0 / 512.0;
/// Cosine of the angle to the plane from which on they do: what is small may be near it and stand on it.
const ALONG_PLANE: f32 = 0.999;

/// True where all surfaces that reflect lie in one plane: light that leaves one meets no other.
pub(super) fn reflects_in_one_plane(scene: &PackedScene) -> bool {
    let reflects = |m: MaterialFlags| m.stores() || m.has_delta();
    let mut reflecting =
        scene.triangles.iter().filter(|t| reflects(scene.materials[t.material as usize].flags()));
    let Some(widest) = reflecting.clone().max_by(|a, b| a.area().total_cmp(&b.area())) else { return true };
    let (normal, place): (Vec3, Vec3) = (widest.normal(), widest.v0);
    reflecting.all(|t| {
        t.normal().dot(normal).abs() > ALONG_PLANE
            && t.vertices().iter().all(|v| (*v - place).dot(normal).abs() < ONE_PLANE)
    })
}
