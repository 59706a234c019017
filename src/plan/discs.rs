//! Discs: how much a device looks at to find what lies in the discs of an image, told from a few thousand gather points, jotons
//! and area points in the grid that it will have. It changes nothing in the image.

use super::Plan;
use super::grid::Grid;
use crate::optics::ray::{Ray, SurfaceInteraction};
use crate::packed::PackedScene;
use crate::packed::constants::{CLIP_LIFT, CLIP_RAYS, GATHER_NORMAL_COS, GATHER_PLANE_SHARE};
use crate::plan::CAUSTIC_FOOTPRINTS;
use crate::sampling::distributions::unit_circle;
use glam::Vec3;
use std::ops::Range;

/// Where a camera path ended.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Place {
    /// The place.
    pub position: Vec3,
    /// Width of a pixel there.
    pub footprint: f32,
    /// Whether jotons are weighed by a glossy lobe there.
    pub is_glossy: bool,
    /// Whether the disc of the diffuse map has to be measured, or else that of the caustic map: something is cut off it or stands in it,
    /// or it is seen through something specular.
    pub is_cut: bool,
}

/// What is looked at, by place: jotons or area points, each of which stands for so many.
pub(super) struct Looked {
    grid: Grid,
    counts: Vec<f64>,
}

impl Looked {
    /// So many things as `all`, of which `samples` are known.
    pub(super) fn new(grid: Grid, samples: &[Vec3], all: f64) -> Self {
        let mut counts = vec![0.0; grid.buckets()];
        let each = all / samples.len().max(1) as f64;
        for position in samples {
            counts[grid.bucket(*position) as usize] += each;
        }
        Self { grid, counts }
    }

    /// How many a sphere looks at.
    pub(super) fn tests(&self, center: Vec3, radius: f32) -> f64 {
        self.tests_at_most(center, radius, f64::INFINITY)
    }

    /// The same where it looks at no more than so many in each cell, in the mean over a row.
    pub(super) fn tests_at_most(&self, center: Vec3, radius: f32, most: f64) -> f64 {
        let runs = self.grid.runs(center, radius);
        let in_run =
            |run: Range<usize>| self.counts[run.start..run.end.min(self.counts.len())].iter().sum::<f64>();
        runs.map(|run| in_run(run.clone()).min(most * run.len() as f64)).sum()
    }
}

/// Largest radius of the caustic disc of a place in the first pass.
pub(super) fn caustic_radius_most(plan: &Plan, place: &Place) -> f32 {
    (CAUSTIC_FOOTPRINTS[1] * place.footprint).min(plan.caustic.base as f32)
}

/// Radius of the caustic disc of a place in the first pass, from what the largest looks at [E14].
pub(super) fn caustic_radius(plan: &Plan, place: &Place, looked: &Looked) -> f32 {
    let largest = caustic_radius_most(plan, place);
    let smallest = (CAUSTIC_FOOTPRINTS[0] * place.footprint).min(largest);
    // of what is looked at about half lies in the disc
    let found = (0.5 * looked.tests(place.position, largest)) as f32;
    (largest * (plan.caustic_wanted / found.max(f32::MIN_POSITIVE)).sqrt()).clamp(smallest, largest)
}

/// Rays from above onto a disc that all find it where it is whole.
const PROBES: u32 = 24;
/// Height of their origins, radii.
const PROBE_HEIGHT: f32 = 0.5;

/// Whether something is cut off the disc about a place, or stands in it.
pub(super) fn is_cut(scene: &PackedScene, s: &SurfaceInteraction, radius: f32) -> bool {
    let (x, y) = s.ng.any_orthonormal_pair();
    let around = |turn: f32| {
        let [c, s] = unit_circle(turn);
        x * c + y * s
    };
    let is_whole = (0..PROBES).all(|i| {
        // a spiral: even over the disc
        let r = radius * ((i as f32 + 0.5) / PROBES as f32).sqrt();
        let above = s.position + around((0.618_034 * i as f32).fract()) * r + s.ng * (PROBE_HEIGHT * radius);
        let below = SurfaceInteraction::hit(scene, &Ray::new(above, -s.ng));
        below.is_some_and(|hit| {
            (hit.distance - PROBE_HEIGHT * radius).abs() < GATHER_PLANE_SHARE * radius
                && hit.ng.dot(s.ng) > GATHER_NORMAL_COS
                && hit.flags().stores()
        })
    });
    let is_free = (0..CLIP_RAYS).all(|i| {
        let direction = around(i as f32 / CLIP_RAYS as f32);
        let origin = s.position + s.ng * (CLIP_LIFT * radius);
        SurfaceInteraction::hit(scene, &Ray::new(origin, direction)).is_none_or(|hit| hit.distance > radius)
    });
    !(is_whole && is_free)
}
