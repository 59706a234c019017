// Validate: what must hold of a scene before anything is computed from it.

use super::{Camera, Light, Material, Mesh};
use crate::{Error, Result};
use std::path::Path;

/// Sine of the angle between view and up below which the picture has no upright.
const LEAST_SINE: f64 = 1e-6;

/// There is something to see.
pub(crate) fn surfaces(path: &Path, mesh: &Mesh) -> Result<()> {
    if mesh.triangles.is_empty() {
        return Err(Error::scene(path, None, "no triangles", "add faces (f statements) with an area"));
    }
    Ok(())
}

/// Most textures of all materials: their numbers have 16 bits.
const TEXTURES_MOST: usize = (1 << 16) - 1;

/// Textures can be told apart.
pub(crate) fn textures(path: &Path, materials: &[Material]) -> Result<()> {
    let plain = |m: &Material| m.opacity.as_ref().is_some_and(|o| o.texture.is_none());
    let count: usize = materials.iter().map(|m| m.textures().count() + usize::from(plain(m))).sum();
    if count > TEXTURES_MOST {
        let what = format!("{count} textures and opacities of materials");
        return Err(Error::scene(path, None, what, format!("give at most {TEXTURES_MOST}")));
    }
    Ok(())
}

/// Something shines.
pub(crate) fn light(path: &Path, mesh: &Mesh, materials: &[Material], lights: &[Light]) -> Result<()> {
    if lights.is_empty() && !any_emission(mesh, materials) {
        let remedy = "give a material Ke (radiance) or add a [[light]]";
        return Err(Error::scene(path, None, "no light: nothing emits", remedy));
    }
    Ok(())
}

/// Whether some triangle emits.
pub(crate) fn any_emission(mesh: &Mesh, materials: &[Material]) -> bool {
    mesh.triangles.iter().any(|t| materials[t.material as usize].emits())
}

/// The camera looks somewhere, upright.
pub(crate) fn camera(path: &Path, line: Option<usize>, camera: &Camera) -> Result<()> {
    let fail = |what: &str, remedy: &str| Err(Error::scene(path, line, what, remedy));
    let Some(forward) = (camera.target - camera.position).try_normalize() else {
        return fail("camera position and target are the same point", "move one of them");
    };
    let Some(up) = camera.up.try_normalize() else {
        return fail("camera up has no length", "give a vector that is not zero");
    };
    if forward.cross(up).length() < LEAST_SINE {
        return fail("camera up is parallel to the view", "give another up, such as [0, 0, 1]");
    }
    Ok(())
}
