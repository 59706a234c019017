//! Visible points: the places on diffuse surfaces that the camera sees, directly or through mirrors and glass, as cells of space.

use crate::optics::ray::{Ray, SurfaceInteraction, lift};
use crate::optics::shading::roulette::{EventProbabilities, SCATTERED};
use crate::packed::{CameraRay, PackedScene, VisibleCells};
use crate::sampling::rng::purpose::{DIMENSION_SEEN, STREAM_SEEN};
use crate::sampling::rng::{random4, sequence_seed, sobol2};
use crate::spectrum::{BANDS, Bands};
use glam::Vec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

/// Camera paths: one for this many pixels, between these.
const PIXELS_PER_PATH: usize = 4;
const PATHS: [usize; 2] = [1 << 12, 1 << 14];
/// Longest specular chain that is followed.
pub(in crate::plan) const CHAIN: u32 = 12;
/// A cell is at least this many spacings of camera paths wide: surfaces seen at grazing angles have no holes.
const SPACINGS: f32 = 4.0;
/// Marked cells are at least this many of the widest spacings wide.
const GAP: f32 = 2.0;
/// A surface counts as facing along an axis from this cosine on; each faces along one at least.
const FACING: f32 = 0.5;

/// A place where a camera path meets its first diffuse surface.
pub(in crate::plan) struct VisiblePoint {
    /// The side that is seen.
    pub(in crate::plan) near: PlaceSide,
    /// The other one, where light is scattered through.
    pub(in crate::plan) far: Option<PlaceSide>,
    position: Vec3,
    geometric: Vec3,
    /// Length of the path.
    length: f32,
}

/// One side of a surface at a place.
#[derive(Debug, Clone, Copy)]
pub(in crate::plan) struct PlaceSide {
    /// The place, lifted off the surface.
    pub(in crate::plan) origin: Vec3,
    /// Shading normal.
    pub(in crate::plan) normal: Vec3,
}

impl VisiblePoint {
    /// The sides from which light is seen, in turn.
    pub(in crate::plan) fn side(&self, number: u32) -> PlaceSide {
        self.far.filter(|_| number % 2 == 1).unwrap_or(self.near)
    }
}

/// Where the camera looks.
pub(in crate::plan) struct VisiblePoints {
    cells: Cells,
    points: Vec<VisiblePoint>,
    /// Camera paths, that ended somewhere or not.
    paths: usize,
    /// Distance of camera paths at a distance of one.
    spacing: f32,
}

/// Cells in which gather points lie: level and place, and along which of the six axes surfaces face there.
pub(in crate::plan) struct Cells {
    cells: FxHashMap<[i32; 4], u8>,
    /// Levels in use; a cell of level k is 2^k internal units wide.
    levels: Vec<i32>,
}

impl Cells {
    /// Cells that are a few spacings of camera paths wide, doubled so many times, and their neighbours.
    fn about(points: &[VisiblePoint], spacing: f32, doublings: i32) -> Self {
        let mut cells: FxHashMap<[i32; 4], u8> = FxHashMap::default();
        for p in points {
            let least = (SPACINGS * spacing * p.length).max(f32::MIN_POSITIVE);
            let level = least.log2().ceil() as i32 + doublings;
            let half = 0.5 * (level as f32).exp2();
            // all cells that a cube of one cell's size about the point touches
            for corner in 0..8u32 {
                let sign = |bit: u32| if corner >> bit & 1 == 0 { -half } else { half };
                let at = cell(p.position + Vec3::new(sign(0), sign(1), sign(2)), level);
                let beyond = if p.far.is_some() { facing(-p.geometric) } else { 0 };
                *cells.entry(at).or_default() |= facing(p.geometric) | beyond;
            }
        }
        let mut levels: Vec<i32> = cells.keys().map(|c| c[0]).collect();
        levels.sort_unstable();
        levels.dedup();
        Self { cells, levels }
    }

    /// Width of the smallest cell about a place whose gather points face alike; none where there is no cell.
    pub(in crate::plan) fn width(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        let holds = |&&level: &&i32| {
            self.cells.get(&cell(position, level)).is_some_and(|bits| bits & facing(normal) != 0)
        };
        self.levels.iter().find(holds).map(|&level| (level as f32).exp2())
    }
}

/// Bits of the axes that a normal looks along.
fn facing(normal: Vec3) -> u8 {
    (0..6)
        .filter(|&i| {
            let along = normal[i / 2];
            (if i % 2 == 0 { along } else { -along }) > FACING
        })
        .fold(0, |bits, i| bits | 1 << i)
}

fn cell(position: Vec3, level: i32) -> [i32; 4] {
    let [x, y, z] = (position * (-level as f32).exp2()).floor().as_ivec3().to_array();
    [level, x, y, z]
}

impl VisiblePoints {
    /// Look at the scene through its camera.
    pub(in crate::plan) fn look(scene: &PackedScene, seed: u32) -> Self {
        let paths = (scene.pixels() / PIXELS_PER_PATH).clamp(PATHS[0], PATHS[1]);
        let spacing = scene.pixel_angle() * (scene.pixels() as f32 / paths as f32).sqrt();
        let points: Vec<VisiblePoint> =
            (0..paths as u32).into_par_iter().filter_map(|i| gather_point(scene, seed, i)).collect();
        Self { cells: Cells::about(&points, spacing, 0), points, paths, spacing }
    }

    /// Where the camera looks, and what lies about it: as far as cells reach that are doubled so many times.
    pub(in crate::plan) fn widened(&self, doublings: u32) -> Cells {
        Cells::about(&self.points, self.spacing, doublings as i32)
    }

    /// True where the camera sees nothing diffuse.
    pub(in crate::plan) fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// Where camera paths ended on diffuse surfaces.
    pub(in crate::plan) fn points(&self) -> &[VisiblePoint] {
        &self.points
    }

    /// The cells within `radius` of where the camera looks, or wider where its paths leave gaps.
    pub(in crate::plan) fn cells(&self, scene: &PackedScene, radius: f32) -> VisibleCells {
        let farthest = self.points.iter().map(|p| p.length).fold(0.0, f32::max);
        let gap = GAP * scene.pixel_angle() * (scene.pixels() as f32 / self.paths as f32).sqrt() * farthest;
        VisibleCells::new(scene.bounds[0], radius.max(gap), self.points.iter().map(|p| p.position))
    }

    /// Part of the image that sees a diffuse surface, directly or through specular ones.
    pub(in crate::plan) fn share(&self) -> f64 {
        self.points.len() as f64 / self.paths as f64
    }

    /// Width of the smallest cell about a place whose gather points face alike; none where the camera does not look.
    pub(in crate::plan) fn width(&self, position: Vec3, normal: Vec3) -> Option<f32> {
        self.cells.width(position, normal)
    }
}

/// Where camera path `number` ends.
fn gather_point(scene: &PackedScene, seed: u32, number: u32) -> Option<VisiblePoint> {
    let CameraRay { origin, direction, travelled: mut length } =
        scene.camera.ray(sobol2(number, sequence_seed(seed, 0, STREAM_SEEN)));
    let mut ray = Ray::new(origin, direction).within(scene.media.camera);
    for event in 0..CHAIN {
        let s = SurfaceInteraction::hit(scene, &ray)?;
        length += s.distance;
        if s.flags().has_diffuse() {
            return Some(VisiblePoint {
                near: PlaceSide { origin: lift(s.position, s.ng, s.triangle), normal: s.ns },
                far: s
                    .flags()
                    .is_translucent()
                    .then(|| PlaceSide { origin: lift(s.position, -s.ng, s.triangle), normal: -s.ns }),
                position: s.position,
                geometric: s.ng,
                length,
            });
        }
        let u = random4(seed, 0, number, DIMENSION_SEEN + event);
        ray = step(&s, &[1.0; BANDS], event, u).filter(|(is_d, _)| !is_d)?.1.0;
    }
    None
}

/// An event at a surface: whether it was a D event, the ray that goes on, and its flux. None where there is none.
pub(in crate::plan) fn step(
    s: &SurfaceInteraction,
    flux: &Bands,
    event: u32,
    [u_way, u0, u1, u_lobe]: [f32; 4],
) -> Option<(bool, (Ray, Bands))> {
    let flux = &s.through(flux);
    let probabilities = EventProbabilities::new(s, flux, event);
    let way = probabilities.choose(u_way)?;
    let leaving = probabilities.direction(way, u_lobe, [u0, u1])?;
    Some((way == SCATTERED, (s.leave(leaving), probabilities.carried(way, flux))))
}
