//! eye.wgsl and direct.wgsl on a floor under a light: positions by projection, radiance by the law of each light.

use crate::common::scenes::{Builder, emitter};
use crate::common::{kernel, pass_info, path_filter};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::packed::layout::{GatherPoint, PassInfo, status};
use joton::packed::{PackedEmitter, PackedScene};
use joton::plan::{Plan, Settings};
use joton::scene::Light;
use std::f64::consts::PI;

/// Words of a gather point.
const POINT_WORDS: usize = size_of::<joton::packed::layout::GatherPoint>() / 4;
const SIZE: u32 = 24;
const REFLECTANCE: f32 = 0.6;

struct Seen {
    points: Vec<GatherPoint>,
    emission: Vec<[f32; 4]>,
    direct: Vec<[f32; 4]>,
}

/// One pass of eye and direct.
fn look(context: &Context, scene: &PackedScene, shadow_rays: u32) -> Seen {
    let plan = Plan::new(scene, Settings::default());
    let mut harness = Harness::with_scene(context, scene, &plan).unwrap_or_else(|e| panic!("{e}"));
    harness.uniform("path_filter", &path_filter("L.*E"));
    let pixels = scene.pixels();
    let mut pass = PassInfo {
        camera: scene.camera_info(),
        seed: 9,
        pass_index: 4,
        shadow_rays,
        emitters: scene.emitters.len() as u32,
        ..pass_info()
    };
    pass.set_image(scene.size);
    // no pixel is the glint kernel's; the rest must be overwritten
    let mut unwritten = [PATTERN; POINT_WORDS];
    unwritten[11] = 0;
    harness.storage("gather_points", &vec![unwritten; pixels]);
    harness.storage("film_emission", &vec![[0.0f32; 4]; pixels]);
    harness.storage("film_direct", &vec![[0.0f32; 4]; pixels]);
    harness.storage("status", &[0u32; status::SLOTS as usize]);
    let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
    for name in ["passes/eye.wgsl", "passes/direct.wgsl"] {
        let k = kernel(context, name, "main", &[("HAS_PATH_FILTER", 0.0)]);
        harness.run(&k, &[], &at, Work::Tiles(scene.size)).unwrap_or_else(|e| panic!("{e}"));
    }
    Seen {
        points: harness.read("gather_points").unwrap_or_else(|e| panic!("{e}")),
        emission: harness.read("film_emission").unwrap_or_else(|e| panic!("{e}")),
        direct: harness.read("film_direct").unwrap_or_else(|e| panic!("{e}")),
    }
}

/// A floor (y = 0, front up) seen from above at an angle, and what `build` adds.
fn scene(build: impl Fn(&mut Builder)) -> PackedScene {
    let mut b = Builder::new([0., 2., 2.], [0.; 3], [0., 1., 0.], 0.4, SIZE);
    let floor = b.matte(REFLECTANCE);
    b.quad([-4., 0., -4.], [0., 0., 8.], [8., 0., 0.], floor);
    build(&mut b);
    PackedScene::new(&b.scene)
}

/// Irradiance of one emitter at a place that faces up, nothing between, internal units.
fn irradiance(e: &PackedEmitter, p: DVec3) -> f64 {
    let [origin, e1, e2] = [e.origin, e.e1, e.e2].map(|v| v.as_dvec3());
    let strength = f64::from(e.strength[0]);
    let d = origin - p;
    match e.kind {
        0 => {
            // midpoint rule over the triangle
            const N: usize = 48;
            let n = e1.cross(e2).normalize();
            let area = 0.5 * e1.cross(e2).length() / (N * N) as f64;
            let mut sum = 0.0;
            for i in 0..N {
                for j in 0..N - i {
                    for third in [1.0, 2.0] {
                        if third == 2.0 && i + j + 1 >= N {
                            continue;
                        }
                        let (u, v) = (i as f64 + third / 3.0, j as f64 + third / 3.0);
                        let d = d + (e1 * u + e2 * v) / N as f64;
                        let wi = d.normalize();
                        sum += wi.y.max(0.0) * (-wi.dot(n)).max(0.0) / d.length_squared() * area;
                    }
                }
            }
            strength * sum
        }
        3 => strength * (-e1.y).max(0.0),
        kind => {
            let wi = d.normalize();
            let mut falloff = 1.0;
            if kind == 2 {
                let x = ((e2.y - 1.0 - wi.dot(e1)) / (e2.y - e2.x)).clamp(0.0, 1.0);
                falloff = x * x * (3.0 - 2.0 * x);
            }
            strength * falloff * wi.y.max(0.0) / d.length_squared()
        }
    }
}

fn wanted(scene: &PackedScene, p: Vec3) -> f64 {
    scene.emitters.iter().map(|e| irradiance(e, p.as_dvec3())).sum::<f64>() * f64::from(REFLECTANCE) / PI
}

#[test]
fn gather_points_lie_in_their_pixels_on_the_floor() {
    let context = device_or_return!();
    let scene = scene(|b| b.point_light([0.3, 1.0, -0.2], 5.0));
    let seen = look(context, &scene, 1);
    let floor = scene.bounds[0].y;
    let c = &scene.camera;
    let mut jitter = [0.0; 2];
    for (i, p) in seen.points.iter().enumerate() {
        assert!((p.position.y - floor).abs() < 1e-3, "pixel {i} lies at height {}", p.position.y - floor);
        let d = p.position - c.eye;
        let along = d.dot(c.forward);
        let x = 0.5 * (d.dot(c.right) / c.right.length_squared() / along + 1.0) * SIZE as f32;
        let y = 0.5 * (1.0 - d.dot(c.up) / c.up.length_squared() / along) * SIZE as f32;
        let (dx, dy) = (x - (i as u32 % SIZE) as f32, y - (i as u32 / SIZE) as f32);
        // positions near 500 are rounded to 6e-5, pixels are wider than 10 there
        assert!(
            (-1e-3..1.001).contains(&dx) && (-1e-3..1.001).contains(&dy),
            "pixel {i} is met at {dx}, {dy}"
        );
        jitter = [jitter[0] + dx, jitter[1] + dy];
        assert!((p.path_length - d.length()).abs() < 1e-2);
        assert_eq!((p.throughput, p.surface >> 24), ([1.0; 3], 0));
    }
    for j in jitter {
        // uniform jitter: the mean of 576 has a standard error of 0.012
        assert!((j / (SIZE * SIZE) as f32 - 0.5).abs() < 0.05, "mean jitter {j}");
    }
}

#[test]
fn radiance_under_small_lights_is_their_law() {
    let context = device_or_return!();
    type Case = (&'static str, fn(&mut Builder));
    let cases: [Case; 3] = [
        ("point", |b| b.point_light([0.3, 1.0, -0.2], 5.0)),
        ("spot", |b| {
            b.scene.lights.push(Light::Spot {
                position: DVec3::new(0.5, 2.0, 0.0),
                direction: DVec3::new(-0.2, -1.0, 0.1).normalize(),
                intensity: [4.0; 3],
                angle_inner: f64::acos(0.97),
                angle_outer: f64::acos(0.8),
            });
        }),
        ("sun", |b| {
            b.scene
                .lights
                .push(Light::Sun { direction: DVec3::new(0.5, -1.0, 0.2).normalize(), irradiance: [3.0; 3] });
        }),
    ];
    for (name, build) in cases {
        let scene = scene(build);
        let seen = look(context, &scene, 1);
        let mut lit = 0;
        for (p, l) in seen.points.iter().zip(&seen.direct) {
            let wanted = wanted(&scene, p.position);
            lit += usize::from(wanted > 0.0);
            // normals are kept in 32 bits: 6e-5; a spot's rim is steep
            let tolerance = 5e-4 * wanted + 1e-5;
            assert!(
                (f64::from(l[0]) - wanted).abs() < tolerance,
                "{name} at {}: {} against {wanted}",
                p.position,
                l[0]
            );
        }
        assert!(lit > 100, "{name}: {lit} pixels are lit");
        assert!(seen.emission.iter().all(|e| e[0] == 0.0));
    }
}

#[test]
fn radiance_under_a_lamp_is_its_integral() {
    let context = device_or_return!();
    let scene = scene(|b| {
        let m = b.material(emitter(2.0, 0.0));
        b.quad([-0.5, 1.0, -0.6], [1., 0., 0.], [0., 0., 0.8], m);
    });
    let seen = look(context, &scene, 1024);
    let (mut checked, mut sum) = (0, 0.0);
    for ((p, l), e) in seen.points.iter().zip(&seen.direct).zip(&seen.emission) {
        if (p.position.y - scene.bounds[0].y).abs() > 1e-2 {
            continue;
        }
        checked += 1;
        assert_eq!(e[0], 0.0, "a lamp shines to its front only");
        let wanted = wanted(&scene, p.position);
        let ratio = f64::from(l[0]) / wanted;
        // 1024 pairs of a shadow ray and a BSDF sample: a standard error of 1.5 % near the lamp
        assert!((ratio - 1.0).abs() < 0.06, "{} against {wanted}", l[0]);
        sum += ratio;
    }
    assert!(checked > 200);
    // all together 2e5 pairs and more: 0.1 %
    let mean = sum / f64::from(checked);
    assert!((mean - 1.0).abs() < 4e-3, "{mean} of what is there");
}

/// A screen over half of the floor, above the camera: what lies under it is black, the rest as if it were not there.
#[test]
fn screens_cast_shadows() {
    let context = device_or_return!();
    let scene = scene(|b| {
        let m = b.matte(0.5);
        b.quad([-4., 2.7, -4.], [0., 0., 8.], [4.3, 0., 0.], m);
        b.point_light([0.3, 3.0, -0.2], 5.0);
    });
    let seen = look(context, &scene, 1);
    let scale = scene.world_scale as f32;
    let (mut dark, mut lit) = (0, 0);
    for (p, l) in seen.points.iter().zip(&seen.direct) {
        let world = p.position * scale + scene.world_center.as_vec3();
        // the light stands right above the screen's edge at x = 0.3
        if world.x < 0.29 {
            dark += 1;
            assert_eq!(l[0], 0.0, "light under the screen at {world}");
        } else if world.x > 0.31 {
            lit += 1;
            let wanted = wanted(&scene, p.position);
            assert!((f64::from(l[0]) / wanted - 1.0).abs() < 1e-3, "{} against {wanted} at {world}", l[0]);
        }
    }
    assert!(dark > 20 && lit > 100, "{dark} dark, {lit} lit");
}

/// A lamp in view: its radiance from its front, black from its back.
#[test]
fn lamps_are_seen_from_their_front() {
    let context = device_or_return!();
    for (front, wanted) in [(true, 2.5), (false, 0.0)] {
        let mut b = Builder::new([0., 0., 2.], [0.; 3], [0., 1., 0.], 0.4, SIZE);
        let m = b.material(emitter(2.5, 0.0));
        let (u, v) = ([4., 0., 0.], [0., 4., 0.]);
        let (u, v) = if front { (u, v) } else { (v, u) };
        b.quad([-2., -2., 0.], u, v, m);
        let scene = PackedScene::new(&b.scene);
        let seen = look(context, &scene, 1);
        assert!(seen.emission.iter().all(|e| e[..3] == [wanted; 3]), "front {front}: {:?}", seen.emission[0]);
    }
}
