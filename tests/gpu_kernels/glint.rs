//! glint.wgsl and glint_mark.wgsl: means over the passes by closed forms, whatever the number of chains, and marks by their
//! rule.

use crate::common::scenes::{Builder, emitter, glass, mirror};
use crate::common::{kernel, pass_info, path_filter, random};
use crate::device_or_return;
use joton::gpu::Context;
use joton::gpu::harness::{Harness, PATTERN, Work};
use joton::layout::{GatherPoint, PILOT_PASS, PIXEL_GLINT, PassInfo, status};
use joton::pack::PackedScene;
use joton::plan::{Plan, Settings};
use joton::scene::Material;

const SIZE: u32 = 16;
const RADIANCE: f32 = 3.0;
const MIRROR: f32 = 0.9;
/// Distance of the camera to the plane z = 0, which it looks at from +z.
const DISTANCE: f64 = 3.0;
/// What is in the film of pixels that are not marked.
const UNTOUCHED: [f32; 4] = [5.0; 4];

/// A camera before the plane z = 0 and a lamp: a square of half width `half` there, `z` high, that looks up or down, its
/// right edge at `right`.
fn scene(
    tan_half_fov: f64,
    [z, half, right]: [f64; 3],
    looks_up: bool,
    build: impl Fn(&mut Builder),
) -> PackedScene {
    let mut b = Builder::new([0., 0., DISTANCE], [0.; 3], [0., 1., 0.], tan_half_fov, SIZE);
    let lamp = b.material(emitter(RADIANCE, 0.0));
    let (x, y) = ([right + half, 0., 0.], [0., 2. * half, 0.]);
    let (u, w) = if looks_up { (x, y) } else { (y, x) };
    b.quad([-half, -half, z], u, w, lamp);
    build(&mut b);
    PackedScene::new(&b.scene)
}

/// A lamp that ends at `right`, seen directly.
fn lamp(right: f64) -> PackedScene {
    scene(0.5, [0., 20., right], true, |_| ())
}

/// A lamp behind the camera, in a mirror.
fn mirrored() -> PackedScene {
    scene(0.5, [6., 20., 20.], false, |b| {
        let m = b.material(mirror(MIRROR));
        b.quad([-20., -20., 0.], [40., 0., 0.], [0., 40., 0.], m);
    })
}

/// A lamp behind a pane.
fn behind_glass() -> PackedScene {
    scene(0.1, [-1., 20., 20.], true, |b| {
        let g = b.material(glass(1.5));
        b.quad([-20., -20., 0.5], [40., 0., 0.], [0., 40., 0.], g);
        b.quad([-20., -20., 0.3], [0., 40., 0.], [40., 0., 0.], g);
    })
}

/// A lamp that fills the view and reflects.
fn lamp_that_mirrors() -> PackedScene {
    scene(0.5, [-1., 20., 20.], true, |b| {
        let m = b.material(Material { emission: [RADIANCE; 3], ..mirror(0.5) });
        b.quad([-20., -20., 0.], [40., 0., 0.], [0., 40., 0.], m);
    })
}

/// Is pixel `i` marked? Two of three are.
fn is_marked(i: usize) -> bool {
    i % 3 != 1
}

/// The film after these passes.
fn film(context: &Context, scene: &PackedScene, passes: &[u32]) -> Vec<[f32; 4]> {
    let plan = Plan::new(scene, Settings::default());
    let mut harness = Harness::with_scene(context, scene, &plan).unwrap_or_else(|e| panic!("{e}"));
    harness.uniform("path_filter", &path_filter("L.*E"));
    let pixels = scene.pixels();
    let mut points = vec![[PATTERN; 12]; pixels];
    points.iter_mut().enumerate().for_each(|(i, p)| p[11] = if is_marked(i) { PIXEL_GLINT } else { 0 });
    harness.storage("gather_points", &points);
    let start = |i| if is_marked(i) { [0.0f32; 4] } else { UNTOUCHED };
    harness.storage("film", &(0..pixels).map(start).collect::<Vec<_>>());
    harness.storage("status", &[0u32; status::SLOTS as usize]);
    let k = kernel(context, "glint.wgsl", "main", &[("HAS_PATH_FILTER", 0.0)]);
    let c = &scene.camera;
    for &pass_index in passes {
        let mut pass = PassInfo {
            eye: c.eye,
            right: c.right,
            up: c.up,
            seed: 3,
            forward: c.forward,
            pass_index,
            pixel_angle: scene.pixel_angle(),
            ..pass_info()
        };
        pass.set_image(scene.size);
        let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
        harness.run(&k, &[], &at, Work::Tiles(scene.size)).unwrap_or_else(|e| panic!("{e}"));
    }
    let words: Vec<u32> = harness.read("status").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((words[status::TRAVERSAL_CUT as usize], words[status::TRUNCATED as usize]), (0, 0));
    harness.read("film").unwrap_or_else(|e| panic!("{e}"))
}

/// Radiance of the marked pixels, mean of the passes; the others keep what they had.
fn radiance(context: &Context, scene: &PackedScene, passes: u32) -> Vec<(usize, f64)> {
    let film = film(context, scene, &(0..passes).collect::<Vec<_>>());
    for (i, pixel) in film.iter().enumerate().filter(|(i, _)| !is_marked(*i)) {
        assert_eq!(*pixel, UNTOUCHED, "pixel {i} is not the glint kernel's");
    }
    let mean = |(i, p): (usize, &[f32; 4])| is_marked(i).then(|| (i, f64::from(p[0]) / f64::from(passes)));
    film.iter().enumerate().filter_map(mean).collect()
}

/// A lamp's rim gives a pixel the part of its radiance that it fills. Even samples: 64 passes are off by a few of 64 at most.
#[test]
fn a_rim_fills_a_part_of_a_pixel() {
    let context = device_or_return!();
    const COLUMN: f64 = 5.3;
    let right = 0.5 * DISTANCE * (2.0 * COLUMN / f64::from(SIZE) - 1.0);
    for (i, mean) in radiance(context, &lamp(right), 64) {
        let filled = (COLUMN - (i as u32 % SIZE) as f64).clamp(0.0, 1.0);
        let tolerance = if filled.fract() == 0.0 { 1e-6 } else { 0.05 };
        assert!(
            (mean / f64::from(RADIANCE) - filled).abs() < tolerance,
            "pixel {i}: {mean}, filled {filled}"
        );
    }
}

/// A mirror shows its reflectance of the lamp, in every pass.
#[test]
fn mirrors_show_their_part() {
    let context = device_or_return!();
    for (i, mean) in radiance(context, &mirrored(), 2) {
        assert!((mean / f64::from(RADIANCE * MIRROR) - 1.0).abs() < 1e-5, "pixel {i}: {mean}");
    }
}

/// Through a pane comes (1 − R)/(1 + R) of the light [A6], however evenly chains branch; R is 4 % head on.
#[test]
fn a_pane_transmits_what_fresnel_leaves() {
    let context = device_or_return!();
    let seen = radiance(context, &behind_glass(), 64);
    let n = seen.len() as f64;
    let mean = seen.iter().map(|s| s.1).sum::<f64>() / n;
    let error = (seen.iter().map(|s| (s.1 - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
    let wanted = f64::from(RADIANCE) * (1.0 - 0.04) / (1.0 + 0.04);
    assert!(error < 0.01 * wanted && (mean - wanted).abs() < 5.0 * error, "{mean} ± {error}, not {wanted}");
}

/// The pilot tells a pixel without light (0) from one inside a lamp (2) and from one that sees it in a mirror or a pane, or
/// in a lamp that mirrors (1), and asks no mark.
#[test]
fn the_pilot_tells_who_sees_light() {
    let context = device_or_return!();
    let right = 0.0;
    for (i, p) in film(context, &lamp(right), &[PILOT_PASS]).iter().enumerate() {
        assert_eq!(p[0], if (i as u32 % SIZE) < SIZE / 2 { 2.0 } else { 0.0 }, "pixel {i}");
    }
    for scene in [mirrored(), behind_glass(), lamp_that_mirrors()] {
        assert!(film(context, &scene, &[PILOT_PASS]).iter().all(|p| p[0] == 1.0));
    }
}

/// A pixel is marked where it or a neighbour sees light in part, or where they see different things; nothing else changes.
#[test]
fn marks_are_where_light_is_seen_in_part() {
    let context = device_or_return!();
    for [width, height] in [[1, 1], [1, 9], [8, 8], [13, 7], [65, 30]] {
        let pixels = (width * height) as usize;
        // patches of one kind, so that there are pixels among their like
        let seen = |i: usize| {
            let (x, y) = (i as u32 % width / 5, i as u32 / width / 4);
            (3.0 * random(70, (x + 100 * y) as usize)[0]).floor()
        };
        let glints: Vec<[f32; 4]> = (0..pixels).map(|i| [seen(i), 0.0, 0.0, 0.0]).collect();
        let mut harness = Harness::new(context);
        harness.storage("glints", &glints);
        harness.storage("gather_points", &vec![[PATTERN; 12]; pixels]);
        let mut pass = pass_info();
        pass.set_image([width, height]);
        let k = kernel(context, "glint_mark.wgsl", "main", &[]);
        let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
        harness.run(&k, &[], &at, Work::Invocations(pixels as u32)).unwrap_or_else(|e| panic!("{e}"));
        let words: Vec<[u32; 12]> = harness.read("gather_points").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(std::mem::offset_of!(GatherPoint, pixel_flags), 44);
        for (i, words) in words.iter().enumerate() {
            let (x, y) = (i as u32 % width, i as u32 / width);
            let about = |j: usize| {
                let (u, v) = (j as u32 % width, j as u32 / width);
                x.abs_diff(u) <= 1 && y.abs_diff(v) <= 1
            };
            let near: Vec<f32> = (0..pixels).filter(|&j| about(j)).map(|j| glints[j][0]).collect();
            let mixed = near.iter().any(|&g| g == 1.0 || g != near[0]);
            assert_eq!(
                words[11],
                if mixed { PIXEL_GLINT } else { 0 },
                "{width} × {height}, pixel {i}: {near:?}"
            );
            assert_eq!(words[..11], [PATTERN; 11], "the rest of pixel {i}");
        }
    }
}
