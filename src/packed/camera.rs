//! The camera in internal units, and its rays, which keep their digits however far away it is. Twin:
//! shaders/camera/camera.wgsl.

use crate::packed::PackedScene;
use crate::packed::constants::SCENE_RADIUS;
use crate::packed::gpu_struct::gpu_struct;
use crate::sampling::rng::sequence2;
use crate::scene::Camera;
use glam::{DVec3, Vec3};

/// A pinhole: the ray through image coordinates (x, y) in [0, 1]², (0, 0) the top left, runs along
/// d = `forward + (2x − 1) right + (1 − 2y) up`. It starts at the eye or, where that is far away, where it crosses a plane
/// before the scene: there a ray that set out at the eye would have lost its digits.
#[derive(Debug, Clone, Copy)]
pub struct PackedCamera {
    /// Eye point.
    pub eye: Vec3,
    /// Where the middle ray starts: the eye, or that plane.
    pub start: Vec3,
    /// Distance from `eye` to `start` along `forward`; rays start at `eye` + `ahead` d.
    pub ahead: f32,
    /// Right, scaled by the tangent of half the field of view across.
    pub right: Vec3,
    /// Up, scaled likewise.
    pub up: Vec3,
    /// Unit view direction.
    pub forward: Vec3,
}

gpu_struct! {
    /// The camera as the kernels see it; see [`PackedCamera`].
    pub struct CameraInfo {
        /// Where the middle ray starts.
        pub start: Vec3,
        /// Distance from the eye to `start`.
        pub ahead: f32,
        /// Right, scaled by the tangent of half the field of view across.
        pub right: Vec3,
        /// Width of a pixel at unit distance.
        pub pixel_angle: f32,
        /// Up, scaled likewise.
        pub up: Vec3,
        /// Padding.
        pub pad0: u32,
        /// Unit view direction.
        pub forward: Vec3,
        /// Padding.
        pub pad1: u32,
    }
}

/// A ray of the camera.
#[derive(Debug, Clone, Copy)]
pub struct CameraRay {
    /// Where it starts.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Its length before that, from the eye.
    pub travelled: f32,
}

impl PackedScene {
    /// Width of a pixel at unit distance from the eye.
    pub fn pixel_angle(&self) -> f32 {
        2.0 * self.camera.right.length() / self.size[0] as f32
    }

    /// The camera as the kernels see it.
    pub fn camera_info(&self) -> CameraInfo {
        let PackedCamera { start, ahead, right, up, forward, .. } = self.camera;
        CameraInfo { start, ahead, right, pixel_angle: self.pixel_angle(), up, pad0: 0, forward, pad1: 0 }
    }

    /// Ray `number` of a pixel, drawn by a stream of random numbers; box filter one pixel wide.
    pub(crate) fn sample_camera(&self, pixel: u32, number: u64, seed: u32, stream: u32) -> CameraRay {
        let [width, height] = self.size;
        let [jx, jy] = sequence2(number, seed, pixel, stream);
        let x = ((pixel % width) as f32 + jx) / width as f32;
        let y = ((pixel / width) as f32 + jy) / height as f32;
        self.camera.ray([x, y])
    }
}

impl PackedCamera {
    /// A camera whose eye is at `eye`, internal units.
    pub(super) fn new(camera: &Camera, eye: DVec3) -> Self {
        let [right, up, forward] = camera.basis();
        let [tx, ty] = camera.tan_half_fov;
        // every surface lies beyond the plane forward·p = −SCENE_RADIUS
        let to_plane = -eye.dot(forward) - f64::from(SCENE_RADIUS);
        let ahead = if to_plane > f64::from(SCENE_RADIUS) { to_plane } else { 0.0 };
        Self {
            eye: eye.as_vec3(),
            start: (eye + forward * ahead).as_vec3(),
            ahead: ahead as f32,
            right: (right * tx).as_vec3(),
            up: (up * ty).as_vec3(),
            forward: forward.as_vec3(),
        }
    }

    /// The ray through image coordinates (x, y).
    pub fn ray(&self, [x, y]: [f32; 2]) -> CameraRay {
        let across = self.right * (2.0 * x - 1.0) + self.up * (1.0 - 2.0 * y);
        let along = self.forward + across;
        let length = along.length();
        CameraRay {
            origin: self.start + across * self.ahead,
            direction: along / length,
            travelled: self.ahead * length,
        }
    }

    /// The image coordinates of a place, whose ray passes through it; none where that lies behind the eye or outside of the image.
    pub(crate) fn image_of(&self, place: Vec3) -> Option<[f32; 2]> {
        let from_start = place - self.start;
        let depth = from_start.dot(self.forward) + self.ahead;
        let along = |axis: Vec3| from_start.dot(axis) / (axis.length_squared() * depth);
        let [x, y] = [0.5 + 0.5 * along(self.right), 0.5 - 0.5 * along(self.up)];
        let is_inside = depth > 0.0 && (0.0..1.0).contains(&x) && (0.0..1.0).contains(&y);
        is_inside.then_some([x, y])
    }
}
