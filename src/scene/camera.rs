//! The camera: a pinhole.

use crate::error::Result;
use crate::scene::mtl::At;
use crate::scene::table::Table;
use glam::DVec3;

/// Field of view across the width where a file gives none, degrees.
pub(crate) const DEFAULT_FOV_X: f64 = 40.0;

/// A pinhole camera; right-handed world, image right = cross(forward, up), row 0 is the top.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Camera {
    /// Eye point, world units.
    pub position: DVec3,
    /// A point that is seen in the middle of the image.
    pub target: DVec3,
    /// What is up in the image; not parallel to the view.
    pub up: DVec3,
    /// Tangents of half the field of view across the width and the height.
    pub tan_half_fov: [f64; 2],
}

impl Camera {
    /// A pinhole at `position` that looks at `target`.
    pub fn pinhole(position: DVec3, target: DVec3, up: DVec3, tan_half_fov: [f64; 2]) -> Self {
        Self { position, target, up, tan_half_fov }
    }

    /// Unit vectors right, up, forward in the world.
    pub fn basis(&self) -> [DVec3; 3] {
        let forward = (self.target - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        [right, right.cross(forward), forward]
    }
}

/// `[camera]`
#[derive(Debug)]
pub(crate) struct CameraEntry {
    /// Line of its header.
    pub(crate) line: usize,
    /// Eye point, world units.
    pub(crate) position: DVec3,
    /// Middle of the image.
    pub(crate) target: DVec3,
    /// Up.
    pub(crate) up: DVec3,
    /// Full angle in degrees, and whether it is across the width.
    pub(crate) fov: (f64, bool),
}

impl CameraEntry {
    /// Read a table.
    ///
    /// # Errors
    /// Line and remedy where the table says something else.
    pub(super) fn read(table: Table) -> Result<Self> {
        table.allow(&["position", "target", "up", "fov_x", "fov_y"])?;
        let position = table.vector("position")?;
        let target = table.vector("target")?;
        let up = table.optional_vector("up")?.unwrap_or(DVec3::Y);
        let fov = match (table.number("fov_x")?, table.number("fov_y")?) {
            (Some(_), Some(y)) => {
                return Err(table.fault(y.line, "both fov_x and fov_y", "give one of them"));
            }
            (Some(x), None) => (x, true),
            (None, Some(y)) => (y, false),
            (None, None) => (At { value: DEFAULT_FOV_X, line: table.line() }, true),
        };
        if !(fov.0.value > 0.0 && fov.0.value < 180.0) {
            let what = format!("field of view of {} degrees", fov.0.value);
            return Err(table.fault(fov.0.line, &what, "give an angle between 0 and 180"));
        }
        Ok(Self {
            line: table.line(),
            position: position.value,
            target: target.value,
            up,
            fov: (fov.0.value, fov.1),
        })
    }

    /// The camera of an image of this size.
    pub(super) fn camera(&self, size: [u32; 2]) -> Camera {
        let (degrees, across_width) = self.fov;
        let tangent = (degrees.to_radians() / 2.0).tan();
        let [width, height] = size.map(f64::from);
        let tan_half_fov = if across_width {
            [tangent, tangent * height / width]
        } else {
            [tangent * width / height, tangent]
        };
        Camera::pinhole(self.position, self.target, self.up, tan_half_fov)
    }
}
