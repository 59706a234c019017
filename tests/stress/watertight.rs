//! Closed surfaces from inside: rays that aim at edges, at corners and anywhere. Every ray must hit.

use crate::build::{Build, glowing, icosphere, matte, v};
use crate::common::world::{Ray, World, trace};
use crate::common::{device, random, random_direction};
use crate::harness::{Renderer, everyone, mappers};
use crate::sheet::{Sheet, Stress, is_long, sized};
use crate::shoot::{seed, shots};
use glam::{DVec3, Vec3};
use joton::backend::Backend;
use joton::backend::cpu::CpuBackend;
use joton::backend::gpu::GpuBackend;
use joton::film::Layer;
use joton::film::paths::LightPaths;
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use rayon::prelude::*;
use std::f64::consts::PI;
use std::sync::Arc;

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "edges and corners hit exactly", run: exact_edges },
    Stress { name: "slivers 1e6:1", run: slivers },
    Stress { name: "triangles below the resolution of f32", run: below_resolution },
    Stress { name: "thousands of triangles in one place", run: one_place },
    Stress { name: "pilots whose rays are cut", run: cut_pilot },
];

/// Coordinates of scenes in internal units are of this size.
const RADIUS: f64 = 700.0;

/// A closed surface around its centre.
struct Closed {
    name: &'static str,
    world: World,
    triangles: Vec<[Vec3; 3]>,
    center: Vec3,
    /// Half axes of a box inside of it.
    room: Vec3,
}

impl Closed {
    /// A ball of 20 · 4^levels triangles, stretched along the axes.
    fn ball(name: &'static str, levels: u32, axes: DVec3, center: Vec3) -> Self {
        let triangles: Vec<[Vec3; 3]> =
            icosphere(levels).iter().map(|t| t.map(|p| (p * axes).as_vec3() + center)).collect();
        // half of the largest box in the ball: facets lie inside the sphere
        let room = (axes / 3f64.sqrt()).as_vec3() * 0.5;
        Self { name, world: World::new(&triangles), triangles, center, room }
    }

    /// The `i`-th ray from inside: to a corner, a point on an edge, along the axes, or anywhere.
    fn ray(&self, i: usize) -> Ray {
        let [a, b, c] = self.triangles[i / 8 % self.triangles.len()];
        let [s, x, y, z] = random(1, i);
        let from = match i % 2 {
            0 => self.center,
            _ => self.center + (Vec3::new(x, y, z) * 2.0 - 1.0) * self.room,
        };
        let target = match i / 2 % 4 {
            0 => [a, b, c][i / 64 % 3],
            1 => a + (b - a) * s,
            2 => 0.5 * (b + c),
            _ if (i / 8).is_multiple_of(16) => return [from, with_zeros(i / 128)],
            _ => return [from, random_direction(2, i)],
        };
        [from, (target - from).normalize()]
    }

    /// Rays that leak, of `count`, through the host's hierarchy.
    fn host_leaks(&self, count: usize) -> u64 {
        let leaks = |i: usize| {
            let [o, d] = self.ray(i);
            self.world.bvh.closest(&self.world.triangles, o, d, f32::INFINITY).is_none()
        };
        (0..count).into_par_iter().filter(|&i| leaks(i)).count() as u64
    }

    /// Rays that leak on the device; a few chunks, so that they fit its buffers.
    fn device_leaks(&self, context: &joton::backend::gpu::Context, count: usize) -> u64 {
        const CHUNK: usize = 1 << 20;
        let chunk = |first: usize| {
            let rays: Vec<Ray> = (first..(first + CHUNK).min(count)).map(|i| self.ray(i)).collect();
            trace(context, &self.world, &rays, &[1e30], false).iter().filter(|h| h.0 == u32::MAX).count()
                as u64
        };
        (0..count).step_by(CHUNK).map(chunk).sum()
    }

    fn check(&self, sheet: &mut Sheet, host: usize, on_device: usize) {
        let n = self.triangles.len();
        sheet.none(
            format!("{}, {n} triangles, {host} rays", self.name),
            "host",
            "leaks",
            self.host_leaks(host),
        );
        if let Some(context) = device() {
            let leaks = self.device_leaks(context, on_device);
            sheet.none(format!("{}, {n} triangles, {on_device} rays", self.name), "device", "leaks", leaks);
        }
    }
}

/// A direction along an axis or between two, its zeros of either sign.
fn with_zeros(i: usize) -> Vec3 {
    let sign = |bit: usize, x: f32| if i >> bit & 1 == 1 { -x } else { x };
    let mut d = [sign(0, 0.0), sign(1, if i >> 3 & 1 == 1 { 0.6 } else { 0.0 }), 0.0];
    d[2] = sign(2, (1.0 - d[1] * d[1]).sqrt());
    d.rotate_left(i / 16 % 3);
    Vec3::from(d)
}

fn exact_edges(sheet: &mut Sheet) {
    let (host, on_device) = (sized(250_000, 25_000_000), sized(50_000, 2_000_000));
    let away = Vec3::new(37.0, -11.0, 5.0);
    for closed in [
        Closed::ball("icosahedron", 0, DVec3::splat(RADIUS), Vec3::ZERO),
        Closed::ball("ball", 3, DVec3::splat(RADIUS), Vec3::ZERO),
        Closed::ball("ball off the centre", 4, DVec3::splat(0.5 * RADIUS), away * 10.0),
        Closed::ball("small ball off the centre", 5, DVec3::splat(1.0), away * 10.0),
    ] {
        closed.check(sheet, host, on_device);
    }
}

fn slivers(sheet: &mut Sheet) {
    let (host, on_device) = (sized(250_000, 25_000_000), sized(50_000, 2_000_000));
    for (name, thin) in [("ball 1e2:1", 1e-2), ("ball 1e4:1", 1e-4), ("ball 1e6:1", 1e-6)] {
        Closed::ball(name, 2, DVec3::new(1.0, thin, 1.0) * RADIUS, Vec3::ZERO).check(sheet, host, on_device);
    }
}

/// A floor of squares in squares, each half as large, down to what f32 cannot tell apart: the sun's light on it is even,
/// from afar and from so near that the smallest ones fill the view.
fn below_resolution(sheet: &mut Sheet) {
    const RINGS: i32 = 70;
    let floor = matte([0.5; 3]);
    for view in [1.0, 1e-3, 1e-6] {
        let mut b = Build::new(v(0., -0.3 * view, view), v(0., 0., 0.), 0.4, 16);
        let corners =
            |half: f64| [v(-half, -half, 0.), v(half, -half, 0.), v(half, half, 0.), v(-half, half, 0.)];
        for ring in 0..RINGS {
            let (outer, inner) = (corners(2f64.powi(-ring)), corners(2f64.powi(-ring - 1)));
            for i in 0..4 {
                let j = (i + 1) % 4;
                b.triangle([outer[i], outer[j], inner[j]], &floor);
                b.triangle([outer[i], inner[j], inner[i]], &floor);
            }
        }
        b.sun(v(0.3, 0.2, -1.0), [1.0; 3]);
        let want = 0.5 / PI / (1.0f64 + 0.13).sqrt();
        for who in everyone() {
            let pictures = shots(who, &b.0, seed(1), sized(2, 16));
            let pixels = pictures.iter().flat_map(|p| &p.layers[Layer::Direct as usize].pixels).flatten();
            let off = |x: &f32| (f64::from(*x) / want - 1.0).abs();
            let worst = pixels.map(off).fold(0.0, f64::max);
            let tried = format!("triangles of 1 to 2^-{RINGS}, eye at {view:e}: direct light, worst pixel");
            sheet.at_most(tried, format!("{who:?}"), "relative", worst, 1e-3);
        }
    }
}

/// Copies of a square, two triangles each: more than the 65,535 iterations that some drivers give a loop.
const MANY: usize = 33_000;

/// Squares in one plane and nearly one place.
fn pile(copies: usize, apart: f64) -> Build {
    let mut b = Build::new(v(0., -0.5, 2.), v(0., 0., 0.), 0.2, 8);
    for i in 0..copies {
        let [x, y, ..] = random(4, i).map(|x| f64::from(x) * apart);
        b.floor(v(x, y, 0.), 1.0, &matte([0.5; 3]));
    }
    b
}

/// Thousands of triangles in one plane and place: a ray must meet them all. Right, or told.
fn one_place(sheet: &mut Sheet) {
    const JOTONS: u32 = 64;
    for (copies, apart) in [(10_000, 0.0), (50, 1e-3), (1_000, 1e-3), (MANY, 1e-3)] {
        let mut b = pile(copies, apart);
        b.sun(v(0., 0., -1.), [1.0; 3]);
        let scene = Arc::new(PackedScene::whole(&b.0));
        // the host has no such limit, and is slow here
        let here = mappers().into_iter().filter(|&who| copies < MANY || who == Renderer::Device || is_long());
        for who in here {
            let mut plan = Plan::new(&scene, seed(1));
            plan.diffuse_jotons = JOTONS;
            let rendered = match who {
                Renderer::Device => joton::backend::gpu::Context::open(None)
                    .and_then(|context| GpuBackend::new(context, Arc::clone(&scene), plan))
                    .and_then(|mut backend| backend.render(0, 1)),
                _ => CpuBackend::new(Arc::clone(&scene), plan).render(0, 1),
            };
            let (found, holds) = match rendered {
                Ok(batch) => {
                    let off = |x: &f32| (f64::from(*x) / (0.5 / PI) - 1.0).abs();
                    let direct = batch.layers[Layer::Direct as usize].iter().flatten();
                    let worst = direct.map(off).fold(0.0, f64::max);
                    (format!("off by {worst:.1e}"), worst < 1e-4)
                }
                Err(e) => (format!("told: {e}"), matches!(e, joton::Error::Device { .. })),
            };
            let how = if apart > 0.0 { format!("{apart:e} apart") } else { "copies".to_string() };
            sheet.row(
                format!("{} triangles, {how}", 2 * copies),
                format!("{who:?}"),
                found,
                "1e-4, or an error",
                holds,
            );
        }
    }
}

/// A pilot whose rays a driver cuts marks glints by what they have missed: that is told before the first pass. No map here,
/// whose pilot would tell; a device that follows its rays renders.
fn cut_pilot(sheet: &mut Sheet) {
    let Some(_) = device() else { return };
    let mut b = pile(MANY, 1e-3);
    b.ceiling(v(0., 0., 3.), 0.2, &glowing([1.0; 3], [0.0; 3]));
    let scene = Arc::new(PackedScene::new(&b.0));
    let paths = LightPaths::parse("LE").unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(&scene, Settings { paths, ..seed(1) });
    let opened =
        joton::backend::gpu::Context::open(None).and_then(|c| GpuBackend::new(c, Arc::clone(&scene), plan));
    let (found, holds) = match opened {
        Err(e) => (format!("told: {e}"), matches!(e, joton::Error::Device { .. })),
        Ok(mut backend) => match backend.render(0, 1) {
            Ok(_) => ("rendered".to_string(), true),
            Err(e) => (format!("told in the first pass: {e}"), false),
        },
    };
    let tried = format!("{} triangles, emission only", 2 * MANY);
    sheet.row(tried, "device", found, "rendered, or told by the pilot", holds);
}
