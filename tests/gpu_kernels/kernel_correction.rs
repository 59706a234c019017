//! boundary.wgsl: an even or linear field of jotons is seen as it is, at edges, in corners and next to walls.

use super::gather::{joton, point};
use crate::common::scenes::Builder;
use crate::common::{kernel, map_info, pass_info, path_filter};
use crate::device_or_return;
use bytemuck::Zeroable;
use glam::Vec3;
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::packed::constants::{EDGE_CUT, EDGE_OTHERS, PILOT_PASS};
use joton::packed::layout::{Clip, Fit, GatherPoint, Joton, MapInfo, PathState, status};
use joton::packed::{PackedMaterial, PackedScene};
use joton::scene::Material;
use std::f32::consts::PI;

const REFLECTANCE: f32 = 0.5;
/// Gather radius in world units.
const RADIUS: f32 = 0.3;
/// Scatterings of area points that are averaged: a render scatters them anew every few passes. One has 150 in a disc, and
/// gives an edge an error of 2 to 11 %, the nearer the point the larger.
const SCATTERINGS: u32 = 48;
/// In a free corner a quarter of a disc is left, 37 area points: the inverse of their noisy moments is 7 % too large in the
/// mean. The method's own error, which vanishes with more area points a disc.
const CORNER_TOLERANCE: f32 = 0.1;

/// A floor, 4 × 4, with a wall on its left side; free edges elsewhere.
fn scene() -> PackedScene {
    let mut b = Builder::new([0., 3., 3.], [0.; 3], [0., 1., 0.], 0.5, 8);
    let m = b.matte(REFLECTANCE);
    b.quad([-2., 0., -2.], [0., 0., 4.], [4., 0., 0.], m);
    b.quad([-2., 0., -2.], [0., 2., 0.], [0., 0., 4.], m);
    b.point_light([0., 1., 0.], 1.0);
    PackedScene::new(&b.scene)
}

/// Places on the floor, world x and z: whether the disc is whole.
const PLACES: [([f32; 2], bool); 10] = [
    ([0.0, 0.0], true),
    ([-0.31, 1.17], true),
    ([1.999, 0.3], false),
    ([1.95, -1.0], false),
    ([1.8, 0.7], false),
    ([0.4, -1.9], false),
    ([1.99, 1.99], false),
    ([1.85, -1.9], false),
    // next to the wall
    ([-1.99, 0.1], false),
    ([-1.9, 1.95], false),
];

struct Stage<'a> {
    context: &'a Context,
    scene: PackedScene,
    info: MapInfo,
    points: Vec<GatherPoint>,
    radius: f32,
}

impl<'a> Stage<'a> {
    fn new(context: &'a Context) -> Self {
        Self::of(context, scene(), &PLACES.map(|(place, _)| place))
    }

    fn of(context: &'a Context, scene: PackedScene, places: &[[f32; 2]]) -> Self {
        let radius = RADIUS / scene.world_scale as f32;
        let mut info = map_info();
        info.radius = radius;
        info.shrink = 1.0;
        info.grid_origin = scene.bounds[0];
        let extent = scene.bounds[1] - scene.bounds[0];
        info.cells_per_unit = 1.0 / radius;
        info.columns = (extent.x * info.cells_per_unit) as u32 + 1;
        let mut stage = Self { context, scene, info, points: Vec::new(), radius };
        stage.points = places.iter().map(|[x, z]| point(stage.internal(*x, 0.0, *z), Vec3::Y, 0)).collect();
        stage
    }

    fn internal(&self, x: f32, y: f32, z: f32) -> Vec3 {
        let world = glam::DVec3::new(f64::from(x), f64::from(y), f64::from(z));
        ((world - self.scene.world_center) / self.scene.world_scale).as_vec3()
    }

    /// Weights for one scattering, of the pilot, or of a pass with `edges`.
    fn fits(&self, seed: u32, edges: Option<&[u32]>) -> (Vec<Fit>, Vec<u32>) {
        let mut harness = Harness::new(self.context);
        let mut info = self.info;
        harness.area_points(&self.scene, f64::from(self.radius), seed, &mut info);
        harness.storage("gather_points", &self.points);
        harness.storage("clips", &vec![Clip::zeroed(); self.points.len()]);
        harness.storage("fits", &vec![[PATTERN; 4]; self.points.len()]);
        harness.storage("edges", edges.unwrap_or(&vec![PATTERN; self.points.len()]));
        harness.storage("status", &[0u32; status::SLOTS as usize]);
        let k = kernel(self.context, "passes/kernel_correction.wgsl", "main", &[]);
        let mut pass = pass_info();
        pass.pass_index = if edges.is_none() { PILOT_PASS } else { 0 };
        pass.set_image([self.points.len() as u32, 1]);
        let at: [(&str, &[u8]); 2] =
            [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&info))];
        harness.run(&k, &[], &at, Work::Tiles([pass.width, pass.height])).unwrap_or_else(|e| panic!("{e}"));
        let edges = harness.read("edges").unwrap_or_else(|e| panic!("{e}"));
        (harness.read("fits").unwrap_or_else(|e| panic!("{e}")), edges)
    }

    /// A lattice of jotons about each place, cells of which fill the floor, that carries this irradiance; and a bright wall.
    fn jotons(&self, irradiance: &dyn Fn(f32, f32) -> f32) -> Vec<Joton> {
        const ACROSS: i32 = 480;
        let step = 4.0 / ACROSS as f32;
        let area = (step / self.scene.world_scale as f32).powi(2);
        let reach = (1.1 * RADIUS / step) as i32;
        let mut cells = std::collections::BTreeSet::new();
        for ([x, z], _) in PLACES {
            let [i, k] = [x, z].map(|c| ((c + 2.0) / step) as i32);
            for i in (i - reach).max(0)..=(i + reach).min(ACROSS - 1) {
                cells.extend(((k - reach).max(0)..=(k + reach).min(ACROSS - 1)).map(|k| (i, k)));
            }
        }
        let on_floor = |&(i, k): &(i32, i32)| {
            let [x, z] = [i, k].map(|c| (c as f32 + 0.5) * step - 2.0);
            joton(self.internal(x, 0.0, z), Vec3::Y, irradiance(x, z) * area)
        };
        let mut jotons: Vec<Joton> = cells.iter().map(on_floor).collect();
        // the wall is ten times as bright: none of it may be taken for the floor's
        for i in 0..40 {
            for k in 0..300 {
                let (y, z) = (i as f32 * 0.01 + 0.001, k as f32 / 75.0 - 2.0);
                jotons.push(joton(self.internal(-2.0, y, z), Vec3::X, 10.0 * area));
            }
        }
        jotons
    }

    /// Radiance at each place over the mean of the scatterings' weights: the film is linear in them.
    fn radiance(&self, fits: &[Fit], jotons: &[Joton]) -> Vec<f32> {
        let mut info = self.info;
        info.lanes = jotons.len() as u32;
        info.lane_capacity = 1;
        info.row_mask = (1u32 << ((1u32 << 16) - info.columns).ilog2()) - 1;
        let mut harness = Harness::new(self.context);
        harness.storage(
            "lanes",
            &vec![PathState { stored: 1, status: 256, ..PathState::zeroed() }; jotons.len()],
        );
        harness.storage("jotons", jotons);
        harness.sort_map(&info).unwrap_or_else(|e| panic!("{e}"));
        harness.uniform("path_filter", &path_filter("L.*E"));
        harness.scene("materials", &[PackedMaterial::new(&Material::matte("m", [REFLECTANCE; 3]))]);
        harness.storage("gather_points", &self.points);
        harness.storage("clips", &vec![Clip::zeroed(); self.points.len()]);
        harness.storage("fits", fits);
        harness.storage("film", &vec![[0.0f32; 4]; self.points.len()]);
        let mut pass = pass_info();
        pass.set_image([self.points.len() as u32, 1]);
        let k = kernel(self.context, "passes/gather.wgsl", "main", &[("HAS_PATH_FILTER", 0.0)]);
        let at: [(&str, &[u8]); 2] =
            [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&info))];
        harness.run(&k, &[], &at, Work::Tiles([pass.width, pass.height])).unwrap_or_else(|e| panic!("{e}"));
        let film: Vec<[f32; 4]> = harness.read("film").unwrap_or_else(|e| panic!("{e}"));
        film.iter().map(|l| l[0]).collect()
    }

    fn mean_fits(&self) -> Vec<Fit> {
        let mut sum = vec![Fit::zeroed(); self.points.len()];
        let everywhere = vec![1; self.points.len()];
        for seed in 0..SCATTERINGS {
            for (s, f) in sum.iter_mut().zip(self.fits(seed, Some(&everywhere)).0) {
                s.c += f.c / SCATTERINGS as f32;
            }
        }
        sum
    }
}

/// Even light is even to the edge and beside a wall, within 2 %, where the plain disc loses up to three quarters.
#[test]
fn even_irradiance_is_seen_as_it_is() {
    let context = device_or_return!();
    let stage = Stage::new(context);
    let jotons = stage.jotons(&|_, _| 1.0);
    let wanted = REFLECTANCE / PI;
    for (([x, z], _), l) in PLACES.iter().zip(stage.radiance(&stage.mean_fits(), &jotons)) {
        let tolerance = if x.min(*z) > 1.95 { CORNER_TOLERANCE } else { 0.02 };
        assert!((l / wanted - 1.0).abs() < tolerance, "at {x} {z}: {} of what is there", l / wanted);
    }
    // and that the correction is what does it
    let disc = 1.0 / (PI * stage.radius * stage.radius);
    let plain = vec![Fit { c: glam::Vec4::new(disc, 0.0, 0.0, 0.0) }; PLACES.len()];
    let worst = stage.radiance(&plain, &jotons).into_iter().fold(1.0f32, |w, l| w.min(l / wanted));
    assert!(worst < 0.3, "uncorrected, the corner has {worst}");
}

/// A sloping field: the fit is local and linear, so the centroid that an edge shifts does not bend it.
#[test]
fn linear_irradiance_is_seen_as_it_is() {
    let context = device_or_return!();
    let stage = Stage::new(context);
    // up to 45 % over a radius
    let field = |x: f32, z: f32| 4.0 + 0.9 * x - 0.9 * z;
    let fits = stage.mean_fits();
    for (([x, z], _), l) in PLACES.iter().zip(stage.radiance(&fits, &stage.jotons(&field))) {
        let wanted = REFLECTANCE / PI * field(*x, *z);
        let tolerance = if x.min(*z) > 1.95 { CORNER_TOLERANCE } else { 0.02 };
        assert!((l / wanted - 1.0).abs() < tolerance, "at {x} {z}: {} of what is there", l / wanted);
    }
}

/// A sliver has no slope: on a strip a tenth as wide as the radius, at its end, too, the area alone is corrected. The
/// determinant of its moments is 0.0004, of a whole disc's 0.0625; the fit would weigh jotons up to 20 times, and negatively.
#[test]
fn a_sliver_has_no_slope() {
    let context = device_or_return!();
    let mut b = Builder::new([0., 3., 3.], [0.; 3], [0., 1., 0.], 0.5, 8);
    let m = b.matte(REFLECTANCE);
    let half = 0.05 * RADIUS;
    b.quad([-1., 0., f64::from(-half)], [0., 0., f64::from(2.0 * half)], [2., 0., 0.], m);
    b.point_light([0., 1., 0.], 1.0);
    let places = [[0.0, 0.0], [0.2, 0.9 * half], [0.99, -0.5 * half]];
    let stage = Stage::of(context, PackedScene::new(&b.scene), &places);
    // of the strip: a chord, and at the end half of one
    let chord = 4.0 * half * RADIUS;
    let areas = [chord, chord, chord / 2.0].map(|a| a / (stage.scene.world_scale as f32).powi(2));
    let mut found = [0.0; 3];
    for seed in 0..SCATTERINGS {
        let (fits, _) = stage.fits(seed, Some(&[1; 3]));
        for ((fit, area), found) in fits.iter().zip(areas).zip(&mut found) {
            assert_eq!([fit.c.y, fit.c.z], [0.0; 2], "{:?}", fit.c * area);
            *found += 1.0 / (fit.c.x * area * SCATTERINGS as f32);
        }
    }
    // a handful of area points each time
    assert!(found.iter().all(|f| (0.75..1.25).contains(f)), "{found:?} of the area");
}

/// The pilot marks the discs that are cut, and passes leave whole ones plain where no neighbour is marked.
#[test]
fn the_pilot_marks_what_is_cut() {
    let context = device_or_return!();
    let stage = Stage::new(context);
    let (_, edges) = stage.fits(0, None);
    for ((place, whole), edge) in PLACES.iter().zip(&edges) {
        // one scattering may take a whole disc for a cut one, never the other way round
        assert!(*edge <= EDGE_CUT | EDGE_OTHERS && (*whole || edge & EDGE_CUT != 0), "at {place:?}: {edge}");
    }
    let disc = 1.0 / (PI * stage.radius * stage.radius);
    let mut marked = vec![0; PLACES.len()];
    marked[8] = 1;
    let (fits, _) = stage.fits(1, Some(&marked));
    for (i, fit) in fits.iter().enumerate() {
        let plain = (fit.c.x / disc - 1.0).abs() < 1e-5 && fit.c.y == 0.0 && fit.c.z == 0.0;
        let near = (7..=9).contains(&i);
        assert_eq!(plain, !near, "pixel {i}, beside a mark: {near}: {:?}", fit.c / disc);
    }
}
