//! gather.wgsl: jotons placed by hand, sorted by the code of a render, against L = Σ f Φ K.

use crate::common::scenes::mirror;
use crate::common::{frame, map_info, normal24, pass_info, path_filter, random, random_direction};
use crate::device_or_return;
use bytemuck::Zeroable;
use glam::Vec3;
use joton::backend::gpu::harness::{Harness, Work, encode_direction};
use joton::backend::gpu::{Context, Kernel, Variant, link};
use joton::packed::PackedMaterial;
use joton::packed::constants::row_bucket;
use joton::packed::layout::{Clip, Fit, GatherPoint, Joton, MapInfo, PathState, status};
use joton::scene::Material;
use std::f64::consts::{PI, TAU};

const RADIUS: f32 = 2.0;
const MATTE: u32 = 0;
const GLOSSY: u32 = 1;
const REFLECTANCE: f32 = 0.5;

fn materials() -> Vec<PackedMaterial> {
    let glossy = Material {
        glossy: [0.3, 0.2, 0.1],
        glossy_exponent: 8.0,
        ..Material::matte("glossy", [0.1, 0.2, 0.4])
    };
    [Material::matte("matte", [REFLECTANCE; 3]), glossy, mirror(0.9)]
        .iter()
        .map(PackedMaterial::new)
        .collect()
}

/// The uniform of a map whose cells are as wide as the radius, in a box of ±100.
pub(crate) fn info(jotons: usize) -> MapInfo {
    let mut info = map_info();
    info.radius = RADIUS;
    info.cells_per_unit = 1.0 / RADIUS;
    info.grid_origin = Vec3::splat(-100.0);
    info.columns = 101;
    info.row_mask = (1 << 15) - 1;
    info.shrink = 1.0;
    info.lanes = jotons.max(1) as u32;
    info.lane_capacity = 1;
    info
}

/// A map of jotons in a harness.
pub(crate) fn map<'a>(context: &'a Context, jotons: &[Joton], info: &MapInfo) -> Harness<'a> {
    let mut harness = Harness::new(context);
    // a lane for each joton, and one that is empty where there are none
    let stored = if jotons.is_empty() { 0 } else { 1 };
    harness.storage(
        "lanes",
        &vec![PathState { stored, status: 256, ..PathState::zeroed() }; jotons.len().max(1)],
    );
    let nothing = [Joton::zeroed()];
    harness.storage("jotons", if jotons.is_empty() { &nothing } else { jotons });
    harness.sort_map(info).unwrap_or_else(|e| panic!("{e}"));
    harness
}

/// What a gather is asked.
struct Question<'a> {
    jotons: &'a [Joton],
    points: &'a [GatherPoint],
    /// Weights (diffuse map), or one over the area and the radius (caustic map), of each point.
    fits: &'a [Fit],
    /// Walls of each point, as seen from there; empty where there are none.
    walls: &'a [Clip],
    caustic: bool,
    paths: &'a str,
}

impl Question<'_> {
    /// Radiance of each point, and the status words: the same bits whether lanes share loads or not.
    fn ask(&self, context: &Context) -> (Vec<[f32; 4]>, Vec<u32>) {
        let alone = self.ask_variant(context, Variant::default());
        if context.has_subgroups() {
            let together = self.ask_variant(context, Variant { subgroups: true, ..Variant::default() });
            // where a driver ends loops early, it does so at another joton
            let is_cut = |words: &[u32]| words[status::LOOP_CUT as usize] > 0;
            assert_eq!(is_cut(&together.1), is_cut(&alone.1));
            assert!(
                is_cut(&alone.1) || together == alone,
                "{together:?} of subgroups, {alone:?} of single lanes"
            );
        }
        alone
    }

    fn ask_variant(&self, context: &Context, variant: Variant) -> (Vec<[f32; 4]>, Vec<u32>) {
        let info = info(self.jotons.len());
        let mut harness = map(context, self.jotons, &info);
        harness.uniform("path_filter", &path_filter(self.paths));
        harness.scene("materials", &materials());
        harness.storage("gather_points", self.points);
        let none = vec![Clip::zeroed(); self.points.len()];
        harness.storage("clips", if self.walls.is_empty() { &none } else { self.walls });
        harness.storage("fits", self.fits);
        harness.storage("film", &vec![[0.0f32; 4]; self.points.len()]);
        let mut pass = pass_info();
        pass.set_image([self.points.len() as u32, 1]);
        let flag = |on: bool| if on { 1.0 } else { 0.0 };
        let overrides = [("CAUSTIC", flag(self.caustic)), ("HAS_PATH_FILTER", flag(self.paths != "L.*E"))];
        let linked = link("passes/gather.wgsl", variant).unwrap_or_else(|e| panic!("{e}"));
        let gather = Kernel::from_source(context, "passes/gather.wgsl", &linked, "main", &overrides)
            .unwrap_or_else(|e| panic!("{e}"));
        let at: [(&str, &[u8]); 2] =
            [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&info))];
        harness
            .run(&gather, &[], &at, Work::Tiles([pass.width, pass.height]))
            .unwrap_or_else(|e| panic!("{e}"));
        let read = |name| harness.read(name).unwrap_or_else(|e| panic!("{e}"));
        (read("film"), harness.read("status").unwrap_or_else(|e| panic!("{e}")))
    }
}

pub(crate) fn point(position: Vec3, normal: Vec3, material: u32) -> GatherPoint {
    GatherPoint {
        position,
        surface: material,
        throughput: [1.0; 3],
        normal: encode_direction(normal),
        shading_normal: encode_direction(normal),
        wo: encode_direction(normal),
        ..GatherPoint::zeroed()
    }
}

pub(crate) fn joton(position: Vec3, normal: Vec3, flux: f32) -> Joton {
    Joton { position, normal_state: normal24(normal), flux: [flux; 3], wi: encode_direction(normal), pad: [] }
}

/// Weights of a whole disc.
fn plain() -> Fit {
    Fit { c: glam::Vec4::new(1.0 / (std::f32::consts::PI * RADIUS * RADIUS), 0.0, 0.0, 0.0) }
}

/// A disc of the caustic map, of this part of a circle.
fn disc(radius: f32, part: f32) -> Fit {
    Fit { c: glam::Vec4::new(1.0 / (part * std::f32::consts::PI * radius * radius), 0.0, 0.0, radius) }
}

/// Radiance that one joton alone gives one point, both maps, first band.
fn alone(context: &Context, p: &GatherPoint, j: Joton) -> f64 {
    let ask = |caustic: bool, fit: Fit| {
        let q = Question { jotons: &[j], points: &[*p], fits: &[fit], walls: &[], caustic, paths: "L.*E" };
        q.ask(context).0[0]
    };
    let (diffuse, caustic) = (ask(false, plain()), ask(true, disc(RADIUS, 1.0)));
    assert!((diffuse[0] - caustic[0]).abs() <= 1e-6 * diffuse[0], "{diffuse:?} {caustic:?}");
    f64::from(diffuse[0])
}

/// L = ρ/π Φ / (π r²) for a joton inside the disc, whatever its distance; 0 outside.
#[test]
fn a_joton_in_the_disc_counts_its_share() {
    let context = device_or_return!();
    let flux = 3.0;
    let full = f64::from(REFLECTANCE) / PI * flux / (PI * f64::from(RADIUS).powi(2));
    let (at, n) = (Vec3::new(10.3, -20.7, 30.1), Vec3::new(0.36, 0.48, 0.8));
    let [x, _] = frame(n);
    let p = point(at, n, MATTE);
    for (distance, counts) in
        [(0.0, true), (0.5, true), (0.99, true), (1.01, false), (1.5, false), (3.0, false)]
    {
        let l = alone(context, &p, joton(at + x * (distance * RADIUS), n, flux as f32));
        let wanted = if counts { full } else { 0.0 };
        assert!((l - wanted).abs() < 1e-5 * full, "at {distance} radii: {l} against {wanted}");
    }
}

/// Jotons of the back, of a perpendicular wall, of a sheet in front or behind: not ours. The limits are in the layout.
#[test]
fn jotons_of_other_surfaces_are_rejected() {
    let context = device_or_return!();
    let (at, n) = (Vec3::new(1.0, 2.0, 3.0), Vec3::Y);
    let p = point(at, n, MATTE);
    let tilted = |degrees: f32| Vec3::new(degrees.to_radians().sin(), degrees.to_radians().cos(), 0.0);
    for (degrees, counts) in [(0.0, true), (40.0, true), (50.0, false), (90.0, false), (180.0, false)] {
        let l = alone(context, &p, joton(at + Vec3::X * 0.3, tilted(degrees), 1.0));
        assert_eq!(l > 0.0, counts, "a normal {degrees}° away");
    }
    for (height, counts) in [(0.19, true), (0.21, false), (-0.19, true), (-0.21, false), (0.9, false)] {
        let l = alone(context, &p, joton(at + n * (height * RADIUS), n, 1.0));
        assert_eq!(l > 0.0, counts, "{height} radii off the plane");
    }
}

/// Points without throughput (nothing seen) stay black.
#[test]
fn pixels_without_a_gather_point_stay_black() {
    let context = device_or_return!();
    let mut p = point(Vec3::ZERO, Vec3::Y, MATTE);
    p.throughput = [0.0; 3];
    assert_eq!(alone(context, &p, joton(Vec3::ZERO, Vec3::Y, 1.0)), 0.0);
}

#[test]
fn an_empty_map_is_black() {
    let context = device_or_return!();
    let q = Question {
        jotons: &[],
        points: &[point(Vec3::ZERO, Vec3::Y, MATTE); 65],
        fits: &[plain(); 65],
        walls: &[],
        caustic: false,
        paths: "L.*E",
    };
    let (film, status) = q.ask(context);
    assert!(film.iter().all(|l| *l == [0.0; 4]));
    assert_eq!(status, [0; status::SLOTS as usize]);
}

/// What a search over all jotons finds, per band; none where a joton is so near a limit that rounding decides.
fn search(q: &Question<'_>, i: usize) -> Option<[f64; 3]> {
    let (p, fit) = (&q.points[i], q.fits[i].c);
    let materials = materials();
    let m = &materials[p.surface as usize];
    let n = decode(p.normal);
    let r = if q.caustic { fit.w } else { RADIUS };
    let r64 = f64::from(r);
    let [x, y] = frame(n).map(|v| v.as_dvec3());
    let n = n.as_dvec3();
    let mut sum = [0.0; 3];
    for j in q.jotons {
        let d = (j.position - p.position).as_dvec3();
        let b = j.normal_state.to_le_bytes();
        let normal =
            glam::DVec3::new(f64::from(b[0] as i8), f64::from(b[1] as i8), f64::from(b[2] as i8)) / 127.0;
        // a caustic disc is measured face by face: the joton's plane is what is near
        let height = d.dot(if q.caustic { normal } else { n }).abs();
        let before = |plane: glam::Vec4| {
            let plane = plane.as_dvec4();
            if plane.truncate() == glam::DVec3::ZERO { 1.0 } else { d.dot(plane.truncate()) - plane.w }
        };
        let [first, second] = q.walls.get(i).map_or([1.0; 2], |w| [w.first, w.second].map(before));
        let tests = [r64 - d.length(), 0.2 * r64 - height, normal.dot(n) - 0.7, first, second];
        if d.length() < 1.1 * r64 && tests.iter().any(|t| t.abs() < 1e-4) {
            return None;
        }
        if tests.iter().any(|&t| t < 0.0) {
            continue;
        }
        let fit = fit.as_dvec4();
        let weight = if q.caustic { fit.x } else { fit.x + (fit.y * d.dot(x) + fit.z * d.dot(y)) / r64 };
        let (wi, wo) = (decode(j.wi).as_dvec3(), decode(p.wo).as_dvec3());
        let e = f64::from(m.glossy_exponent);
        let lobe = if p.surface == GLOSSY {
            (e + 2.0) / TAU * (2.0 * wi.dot(n) * n - wi).dot(wo).max(0.0).powf(e)
        } else {
            0.0
        };
        for (k, s) in sum.iter_mut().enumerate() {
            let brdf = f64::from(m.diffuse[k]) / PI + f64::from(m.glossy[k]) * lobe;
            *s += brdf * f64::from(j.flux[k]) * weight * f64::from(p.throughput[k]);
        }
    }
    Some(sum)
}

fn decode(code: u32) -> Vec3 {
    let part = |w: u32| (f32::from(w as u16 as i16) / 32_767.0).max(-1.0);
    let (x, y) = (part(code), part(code >> 16));
    let z = 1.0 - x.abs() - y.abs();
    let t = (-z).max(0.0);
    Vec3::new(x - t.copysign(x), y - t.copysign(y), z).normalize()
}

fn check(context: &Context, name: &str, q: &Question<'_>, least: usize) {
    let (film, status) = q.ask(context);
    assert_eq!(status[joton::packed::layout::status::LOOP_CUT as usize], 0);
    let mut lit = 0;
    for (i, l) in film.iter().enumerate() {
        let Some(wanted) = search(q, i) else { continue };
        lit += usize::from(wanted[0] != 0.0);
        for b in 0..3 {
            let got = f64::from(l[b]);
            assert!(
                (got - wanted[b]).abs() < 1e-4 * wanted[b].abs() + 1e-6,
                "{name}, point {i}: {l:?} against {wanted:?}"
            );
        }
    }
    assert!(lit >= least, "{name}: {lit} of {} points found jotons", film.len());
}

/// Jotons and points on three walls of a corner, both maps, both materials, weights of any slope.
#[test]
fn sums_are_those_of_a_search_over_all() {
    let context = device_or_return!();
    let walls = [Vec3::X, Vec3::Y, Vec3::Z];
    let on_wall = |stream: u32, i: usize, size: f32| {
        let [x, y, h, _] = random(stream, i);
        let n = walls[i % 3];
        let [u, v] = frame(n);
        // the planes are a little rough, and cut through the grid's middle
        ((u * x.abs() + v * y) * size + n * ((h - 0.5) * 0.6), n)
    };
    let jotons: Vec<Joton> = (0..6000)
        .map(|i| {
            let (p, n) = on_wall(50, i, 20.0);
            let wi = (n + 0.9 * random_direction(51, i)).normalize();
            let normal = (n + 0.5 * random_direction(52, i)).normalize();
            let [r, g, b, _] = random(53, i);
            Joton {
                position: p,
                normal_state: normal24(normal),
                flux: [r, g, b],
                wi: encode_direction(wi),
                pad: [],
            }
        })
        .collect();
    let points: Vec<GatherPoint> = (0..300)
        .map(|i| {
            let (p, n) = on_wall(54, i, 20.0);
            let mut g = point(p, n, if i % 2 == 0 { MATTE } else { GLOSSY });
            g.wo = encode_direction((n + 0.9 * random_direction(55, i)).normalize());
            g.throughput = [1.0, 0.5, 2.0];
            g
        })
        .collect();
    let fits: Vec<Fit> = (0..points.len())
        .map(|i| {
            let [a, b, c, _] = random(56, i);
            Fit { c: glam::Vec4::new(0.05 + 0.1 * a, 0.1 * (b - 0.5), 0.1 * (c - 0.5), 0.0) }
        })
        .collect();
    let q =
        Question { jotons: &jotons, points: &points, fits: &fits, walls: &[], caustic: false, paths: "L.*E" };
    check(context, "diffuse map", &q, 200);
    let discs: Vec<Fit> = (0..points.len())
        .map(|i| {
            let [size, part, ..] = random(57, i);
            disc(0.3 + 1.7 * size, 0.03 + 0.97 * part)
        })
        .collect();
    let open = Question { fits: &discs, caustic: true, ..q };
    check(context, "caustic map", &open, 200);
    // of three points one has no wall, one has one, one has two at any angle
    let walls: Vec<Clip> = (0..points.len())
        .map(|i| {
            let [near, far, ..] = random(58, i);
            let across = |stream: u32| {
                let normal = walls[i % 3];
                let [u, v] = frame(normal);
                let [along, height, turn, _] = random(stream, i);
                let (sin, cos) = (std::f32::consts::TAU * turn).sin_cos();
                (u * cos + v * sin + normal * (along - height) * 0.5).normalize()
            };
            let wall = |stream: u32, offset: f32| across(stream).extend(-offset * discs[i].c.w);
            let none = glam::Vec4::ZERO;
            match i / 3 % 3 {
                0 => Clip { first: none, second: none },
                1 => Clip { first: wall(59, near), second: none },
                _ => Clip { first: wall(59, near), second: wall(64, far) },
            }
        })
        .collect();
    check(context, "caustic map with walls", &Question { walls: &walls, ..open }, 150);
}

/// A point exactly at the corner of eight cells meets the jotons of all of them, each once.
#[test]
fn corners_of_cells_meet_all_eight() {
    let context = device_or_return!();
    for corner in [
        Vec3::ZERO,
        Vec3::new(-100.0, -100.0, -100.0),
        Vec3::new(6.0, -8.0, 14.0),
        Vec3::new(100.0, 0.0, 2.0),
    ] {
        let jotons: Vec<Joton> = (0..8)
            .map(|i| {
                let side = |b: u32| if i & b == 0 { -1.0 } else { 1.0 };
                joton(corner + Vec3::new(side(1), 0.1 * side(2), side(4)) * 0.9, Vec3::Y, 1.0)
            })
            .collect();
        let points = [point(corner, Vec3::Y, MATTE)];
        let q = Question {
            jotons: &jotons,
            points: &points,
            fits: &[plain()],
            walls: &[],
            caustic: false,
            paths: "L.*E",
        };
        let one = f64::from(REFLECTANCE) / PI / (PI * f64::from(RADIUS).powi(2));
        let got = f64::from(q.ask(context).0[0][0]);
        assert!((got / one - 8.0).abs() < 1e-4, "at {corner}: {} jotons", got / one);
    }
}

/// Points outside the grid still find jotons that are in reach.
#[test]
fn points_outside_the_grid_find_what_is_near() {
    let context = device_or_return!();
    for (face, n) in [(Vec3::X, Vec3::Y), (Vec3::Y, Vec3::Z), (Vec3::Z, Vec3::X)] {
        for sign in [-1.0, 1.0] {
            let edge = face * (sign * 100.0);
            let p = point(edge + face * (sign * 0.6), n, MATTE);
            let l = alone(context, &p, joton(edge - face * (sign * 0.6), n, 1.0));
            assert!(l > 0.0, "across the face {}", edge);
        }
    }
}

/// Far cells whose rows share a bucket with ours: found there, and turned away.
#[test]
fn far_cells_in_our_buckets_are_not_ours() {
    let context = device_or_return!();
    let info = info(1);
    let cell = [40i32, 50, 60];
    let ours = row_bucket(cell[1], cell[2], info.row_mask);
    let shared: Vec<(i32, i32)> = (0..100)
        .flat_map(|y| (0..100).map(move |z| (y, z)))
        .filter(|&(y, z)| (y, z) != (cell[1], cell[2]))
        .filter(|&(y, z)| row_bucket(y, z, info.row_mask).abs_diff(ours) < 50)
        .collect();
    assert!(!shared.is_empty());
    let center =
        |x: i32, y: i32, z: i32| info.grid_origin + (Vec3::new(x as f32, y as f32, z as f32) + 0.5) * RADIUS;
    let mut jotons = vec![joton(center(cell[0], cell[1], cell[2]), Vec3::Y, 1.0)];
    for &(y, z) in &shared {
        // the column that falls into our bucket
        let x = cell[0] + ours as i32 - row_bucket(y, z, info.row_mask) as i32;
        if (0..100).contains(&x) {
            jotons.push(joton(center(x, y, z), Vec3::Y, 1.0));
        }
    }
    assert!(jotons.len() > 1, "some far cell shares the bucket");
    let points = [point(jotons[0].position, Vec3::Y, MATTE)];
    let q = Question {
        jotons: &jotons,
        points: &points,
        fits: &[plain()],
        walls: &[],
        caustic: false,
        paths: "L.*E",
    };
    check(context, "shared buckets", &q, 1);
}

#[test]
fn jotons_of_one_cell_are_all_summed() {
    let context = device_or_return!();
    let jotons = vec![joton(Vec3::new(0.5, 0.5, 0.5), Vec3::Y, 1.0); 4097];
    let points = vec![point(Vec3::new(0.4, 0.5, 0.4), Vec3::Y, MATTE); 3];
    let q = Question {
        jotons: &jotons,
        points: &points,
        fits: &[plain(); 3],
        walls: &[],
        caustic: false,
        paths: "L.*E",
    };
    check(context, "one cell", &q, 3);
}

/// More jotons in a disc than some drivers run iterations: either all are summed, or the cut is told.
#[test]
fn a_cut_loop_is_told() {
    let context = device_or_return!();
    const MANY: usize = 70_000;
    let jotons = vec![joton(Vec3::new(0.5, 0.5, 0.5), Vec3::Y, 1.0); MANY];
    let points = [point(Vec3::new(0.4, 0.5, 0.4), Vec3::Y, MATTE)];
    let q = Question {
        jotons: &jotons,
        points: &points,
        fits: &[plain()],
        walls: &[],
        caustic: false,
        paths: "L.*E",
    };
    let (film, found) = q.ask(context);
    let one = f64::from(REFLECTANCE) / PI / (PI * f64::from(RADIUS).powi(2));
    let whole = (f64::from(film[0][0]) / one / MANY as f64 - 1.0).abs() < 1e-3;
    let told = found[status::LOOP_CUT as usize] > 0;
    assert!(whole != told, "whole: {whole}, told: {told}");
}

/// The state in a joton's top bits and the point's specular chain decide whether the path is wanted.
#[test]
fn unwanted_paths_are_left_out() {
    let context = device_or_return!();
    // paths with exactly two D: the map holds those after one D, in the state after both
    let paths = joton::film::paths::LightPaths::parse("LD.?DSE").unwrap_or_else(|e| panic!("{e}"));
    use joton::film::paths::Event::{D, S};
    let walk = |events: &[joton::film::paths::Event]| events.iter().fold(0, |q, e| paths.step(q, *e));
    let mut p = point(Vec3::ZERO, Vec3::Y, MATTE);
    for (events, chain, counts) in [
        (vec![D, D], 1, true),
        (vec![D, S, D], 1, true),
        (vec![D, D], 0, false),
        (vec![D, D], 2, false),
        (vec![D, D, D, D], 1, false),
        (vec![S, D], 1, false),
    ] {
        let mut j = joton(Vec3::ZERO, Vec3::Y, 1.0);
        j.normal_state |= walk(&events) << 24;
        p.surface = MATTE | chain << 24;
        let q = Question {
            jotons: &[j],
            points: &[p],
            fits: &[plain()],
            walls: &[],
            caustic: false,
            paths: "LD.?DSE",
        };
        assert_eq!(q.ask(context).0[0][0] > 0.0, counts, "L{events:?}, then {chain} S");
    }
}
