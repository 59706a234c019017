//! Patch: a part of a pixel that lies on one surface, and how alike the places of two are.

use crate::spectrum::{Bands, add};
use glam::Vec3;

/// Cosine between normals at which likeness ends.
const LEAST_COS: f32 = 0.8;
/// Difference between clearances at which it ends.
const CLEARANCE_RANGE: f32 = 1.6;
/// Heights over the place's plane at which it ends, in widths of a pixel: at the place, and more per pixel of distance.
const HEIGHT: [f32; 2] = [0.5, 0.15];
/// Clearances from here on are alike.
pub(super) const CLEARANCE_MOST: f32 = 5.0;
/// Cosine between the normals of points that may be of one patch.
const PATCH_COS: f32 = 0.95;
/// Their distance from each other's plane, in widths of a pixel.
const PATCH_HEIGHT: f32 = 1.0;

/// A place on a surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Internal units.
    pub(super) position: Vec3,
    /// Unit shading normal toward the eye.
    pub(super) normal: Vec3,
    /// Width of a pixel there.
    pub(super) footprint: f32,
    /// Places of other kinds have nothing in common: other ways through mirrors and glass, other lobes that depend on directions.
    pub(super) kind: u32,
    /// Distance to the nearest surface in view that rises over this one, log2 of widths of a pixel.
    pub(super) clearance: f32,
}

/// A part of a pixel that shows one surface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// Its middle.
    pub(super) place: Place,
    /// The pixel's radiance per irradiance: throughput times albedo, in the mean over all of the pixel.
    pub(super) weight: Bands,
    /// Part of the pixel.
    pub(super) share: f32,
    /// Seen through mirrors or glass.
    pub(super) is_through: bool,
    /// Its albedo varies over it.
    pub(super) is_textured: bool,
}

impl Place {
    /// The mean of `count` places and one more; the normal is their sum.
    pub(super) fn join(&mut self, count: f32, other: &Place, others: f32) {
        let all = count + others;
        let (mine, theirs) = (count / all, others / all);
        self.position = self.position * mine + other.position * theirs;
        self.normal = self.normal * mine + other.normal * theirs;
        self.footprint = self.footprint * mine + other.footprint * theirs;
        self.clearance = self.clearance * mine + other.clearance * theirs;
    }

    /// Weight of what lies at another place, so many pixels away in the image, for this one: 1 on the same plane, 0 on another surface.
    #[inline]
    pub(super) fn likeness(&self, other: &Place, pixels: f32) -> f32 {
        if self.kind != other.kind {
            return 0.0;
        }
        let clear = 1.0 - (self.clearance - other.clearance).abs() * (1.0 / CLEARANCE_RANGE);
        let facing = (self.normal.dot(other.normal) - LEAST_COS) * (1.0 / (1.0 - LEAST_COS));
        if clear <= 0.0 || facing <= 0.0 {
            return 0.0;
        }
        let height = (other.position - self.position).dot(self.normal).abs();
        let relative = height / (self.footprint * (HEIGHT[0] + HEIGHT[1] * pixels));
        clear * facing * (1.0 - relative).max(0.0)
    }
}

impl Patch {
    /// True for patches of one surface, so many pixels apart.
    pub(super) fn goes_with(&self, other: &Patch, pixels: f32) -> bool {
        let (mine, theirs) = (&self.place, &other.place);
        let d = theirs.position - mine.position;
        mine.kind == theirs.kind
            && mine.normal.normalize().dot(theirs.normal) > PATCH_COS
            && d.dot(theirs.normal).abs() < PATCH_HEIGHT * pixels * theirs.footprint
    }

    /// One place more.
    pub(super) fn take(&mut self, other: &Patch) {
        self.place.join(self.share, &other.place, other.share);
        self.weight = add(&self.weight, &other.weight);
        self.share += other.share;
    }
}
