//! eye.wgsl, glint.wgsl, glint_sum.wgsl and glint_mark.wgsl: emission by closed forms, whatever the number of trees beside the
//! eye path.

use crate::common::scenes::{Builder, emitter, glass, mirror};
use crate::common::{kernel, pass_info, path_filter};
use crate::device_or_return;
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::{Harness, PATTERN, Work};
use joton::packed::PackedScene;
use joton::packed::constants::{GLINT_PIXEL_BITS, GLINT_TREES, GLINT_TURNS, PILOT_PASS, STEP_BUDGET};
use joton::packed::layout::{GatherPoint, PassInfo, status};
use joton::plan::{Plan, Settings};
use joton::scene::Material;

/// Words of a gather point.
const POINT_WORDS: usize = size_of::<joton::packed::layout::GatherPoint>() / 4;
const SIZE: u32 = 16;
const RADIANCE: f32 = 3.0;
const MIRROR: f32 = 0.9;
/// Distance of the camera to the plane z = 0, which it looks at from +z.
const DISTANCE: f64 = 3.0;
/// Steps of a tree that are too few for it.
const STEPS: u32 = 1000;
/// Passes of which one has a tree in pixels that have them in turn.
const TURNS: u32 = 2;

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

/// A lamp behind so many panes.
fn behind_panes(panes: u32) -> PackedScene {
    scene(0.1, [-1., 20., 20.], true, |b| {
        let g = b.material(glass(1.5));
        for z in (0..panes).map(|i| 0.25 * f64::from(i)) {
            b.quad([-20., -20., z + 0.1], [40., 0., 0.], [0., 40., 0.], g);
            b.quad([-20., -20., z], [0., 40., 0.], [40., 0., 0.], g);
        }
    })
}

/// A lamp that fills the view and reflects.
fn lamp_that_mirrors() -> PackedScene {
    scene(0.5, [-1., 20., 20.], true, |b| {
        let m = b.material(Material { emission: [RADIANCE; 3], ..mirror(0.5) });
        b.quad([-20., -20., 0.], [40., 0., 0.], [0., 40., 0.], m);
    })
}

/// Levels of the pixels in turn: none, now and then, two trees and eight.
fn level(pixel: u32) -> u32 {
    [0, GLINT_TURNS, GLINT_TURNS + 1, GLINT_TURNS + 3][pixel as usize % 4]
}

/// The list of the trees of a pass: the most first.
fn trees(pixels: u32, pass: u32) -> Vec<u32> {
    let of = |wanted: u32, times: u32| {
        let here = (0..pixels).filter(move |p| level(*p) == wanted);
        here.flat_map(move |p| (0..times).map(move |_| p | wanted << GLINT_PIXEL_BITS))
    };
    let now = u32::from(pass.is_multiple_of(TURNS));
    of(GLINT_TURNS + 3, 4 * GLINT_TREES)
        .chain(of(GLINT_TURNS + 1, GLINT_TREES))
        .chain(of(GLINT_TURNS, now))
        .collect()
}

fn pass_of(scene: &PackedScene, pass_index: u32) -> PassInfo {
    let mut pass =
        PassInfo { camera: scene.camera_info(), seed: 3, pass_index, glint_turns: TURNS, ..pass_info() };
    pass.set_image(scene.size);
    pass
}

fn harness<'a>(context: &'a Context, scene: &PackedScene) -> Harness<'a> {
    let plan = Plan::new(scene, Settings::default());
    let mut harness = Harness::with_scene(context, scene, &plan).unwrap_or_else(|e| panic!("{e}"));
    harness.uniform("path_filter", &path_filter("L.*E"));
    harness.storage("status", &[0u32; status::SLOTS as usize]);
    harness
}

fn check_status(harness: &Harness<'_>) {
    let words: Vec<u32> = harness.read("status").unwrap_or_else(|e| panic!("{e}"));
    assert_eq!((words[status::TRAVERSAL_CUT as usize], words[status::TRUNCATED as usize]), (0, 0));
}

/// Emission of each pixel, mean of the passes: eye paths and trees together.
fn radiance(context: &Context, scene: &PackedScene, passes: u32) -> Vec<f64> {
    radiance_in_steps(context, scene, passes, STEP_BUDGET)
}

/// The same with trees that have so many steps.
fn radiance_in_steps(context: &Context, scene: &PackedScene, passes: u32, steps: u32) -> Vec<f64> {
    let mut harness = harness(context, scene);
    let pixels = scene.pixels() as u32;
    let mut points = vec![[PATTERN; POINT_WORDS]; pixels as usize];
    (0..pixels).zip(&mut points).for_each(|(i, p)| p[11] = level(i));
    harness.storage("gather_points", &points);
    harness.storage("film_emission", &vec![[0.0f32; 4]; pixels as usize]);
    let compiled = |file: &str, overrides: &[(&str, f64)]| kernel(context, file, "main", overrides);
    let unfiltered = ("HAS_PATH_FILTER", 0.0);
    let eye = compiled("passes/eye.wgsl", &[unfiltered]);
    let glint = compiled("passes/glint.wgsl", &[unfiltered, ("CAMERA_STEPS", f64::from(steps))]);
    let sum = compiled("passes/glint_sum.wgsl", &[]);
    for pass_index in 0..passes {
        let list = trees(pixels, pass_index);
        let count = list.len() as u32;
        harness.storage("glints", &list);
        harness.storage("seen", &vec![[f32::NAN; 4]; list.len()]);
        let pass = PassInfo { glint_count: count, ..pass_of(scene, pass_index) };
        let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
        let all = Work::Invocations(count);
        for (kernel, work) in [(&eye, Work::Tiles(scene.size)), (&glint, all), (&sum, all)] {
            harness.run(kernel, &[], &at, work).unwrap_or_else(|e| panic!("{e}"));
        }
    }
    check_status(&harness);
    let film: Vec<[f32; 4]> = harness.read("film_emission").unwrap_or_else(|e| panic!("{e}"));
    film.iter().map(|p| f64::from(p[0]) / f64::from(passes)).collect()
}

/// What the pilot's trees see.
fn looks(context: &Context, scene: &PackedScene) -> Vec<[f32; 4]> {
    let mut harness = harness(context, scene);
    harness.storage("glints", &[0u32]);
    harness.storage("seen", &vec![[f32::NAN; 4]; scene.pixels()]);
    let k = kernel(context, "passes/glint.wgsl", "main", &[("HAS_PATH_FILTER", 0.0)]);
    let pass = pass_of(scene, PILOT_PASS);
    let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
    harness.run(&k, &[], &at, Work::Tiles(scene.size)).unwrap_or_else(|e| panic!("{e}"));
    check_status(&harness);
    harness.read("seen").unwrap_or_else(|e| panic!("{e}"))
}

/// A lamp's rim gives a pixel the part of its radiance that it fills. Even samples: 64 passes are off by a few of 64 at most.
#[test]
fn a_rim_fills_a_part_of_a_pixel() {
    let context = device_or_return!();
    const COLUMN: f64 = 7.3;
    let right = 0.5 * DISTANCE * (2.0 * COLUMN / f64::from(SIZE) - 1.0);
    for (i, mean) in radiance(context, &lamp(right), 64).into_iter().enumerate() {
        let filled = (COLUMN - (i as u32 % SIZE) as f64).clamp(0.0, 1.0);
        let tolerance = if filled.fract() == 0.0 { 1e-6 } else { 0.05 };
        assert!(
            (mean / f64::from(RADIANCE) - filled).abs() < tolerance,
            "pixel {i}: {mean}, filled {filled}"
        );
    }
    // eight different trees and an eye path tell it in one pass to an eighth or two
    for (i, seen) in radiance(context, &lamp(right), 1).into_iter().enumerate().skip(3).step_by(4) {
        let filled = (COLUMN - (i as u32 % SIZE) as f64).clamp(0.0, 1.0);
        assert!((seen / f64::from(RADIANCE) - filled).abs() < 0.26, "pixel {i}: {seen}, filled {filled}");
    }
}

/// A mirror shows its reflectance of the lamp, after as many passes as there are turns; before, a tree in turn counts for more.
#[test]
fn mirrors_show_their_part() {
    let context = device_or_return!();
    for (i, mean) in radiance(context, &mirrored(), 2 * TURNS).into_iter().enumerate() {
        assert!((mean / f64::from(RADIANCE * MIRROR) - 1.0).abs() < 1e-5, "pixel {i}: {mean}");
    }
}

/// What pixels of each level see in the mean is this, to five standard errors, which are at most this part of it.
fn check_levels(seen: &[f64], wanted: f64, noise: f64) {
    for of in 0..4 {
        let here: Vec<f64> = seen.iter().skip(of).step_by(4).copied().collect();
        let n = here.len() as f64;
        let mean = here.iter().sum::<f64>() / n;
        let error = (here.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        // view rays are up to 8 degrees from the normal
        let tolerance = 5.0 * error + 1e-4 * wanted;
        let level = level(of as u32);
        assert!(error < noise * wanted, "level {level}: {mean} ± {error}");
        assert!((mean - wanted).abs() < tolerance, "level {level}: {mean} ± {error}, not {wanted}");
    }
}

/// Through a pane comes (1 − R)/(1 + R) of the light [A6], at every level; R is 4 % head on.
#[test]
fn a_pane_transmits_what_fresnel_leaves() {
    let context = device_or_return!();
    let wanted = f64::from(RADIANCE) * (1.0 - 0.04) / (1.0 + 0.04);
    check_levels(&radiance(context, &behind_glass(), 128), wanted, 0.005);
}

/// Through m panes comes (1 − R)/(1 + (2m − 1) R). A tree of six has more rays than the steps that it gets here: one way goes
/// on for all that are left, and nothing is lost, nor is there a pixel of hundreds of times the light.
#[test]
fn trees_larger_than_their_steps_lose_nothing() {
    let context = device_or_return!();
    const PANES: u32 = 6;
    let wanted = f64::from(RADIANCE) * (1.0 - 0.04) / (1.0 + f64::from(2 * PANES - 1) * 0.04);
    let seen = radiance_in_steps(context, &behind_panes(PANES), 256, STEPS);
    check_levels(&seen, wanted, 0.01);
    assert!(seen.iter().all(|s| *s < 1.5 * wanted), "{wanted}: {seen:?}");
}

/// The pilot tells a pixel without light (0) from one inside a lamp (2) and from one that sees it in a mirror or a pane, or
/// in a lamp that mirrors (1); whether a tree took both ways; and the mean square and squared mean of what they saw.
#[test]
fn the_pilot_tells_who_sees_light() {
    let context = device_or_return!();
    let right = 0.0;
    let squared = RADIANCE * RADIANCE * 3.0;
    for (i, p) in looks(context, &lamp(right)).iter().enumerate() {
        let wanted = if (i as u32 % SIZE) < SIZE / 2 { [2.0, 0.0, squared, squared] } else { [0.0; 4] };
        assert_eq!(*p, wanted, "pixel {i}");
    }
    for (scene, branched) in [(mirrored(), 0.0), (behind_glass(), 1.0), (lamp_that_mirrors(), 0.0)] {
        assert!(looks(context, &scene).iter().all(|p| p[..2] == [1.0, branched]));
    }
}

/// Each pixel in the list learns its level; nothing else changes.
#[test]
fn marks_are_levels() {
    let context = device_or_return!();
    for [width, height] in [[1, 1], [8, 8], [65, 30]] {
        let pixels = width * height;
        let list = trees(pixels, 0);
        let mut harness = Harness::new(context);
        // a list of something else before it
        harness.storage("glints", &[vec![PATTERN; 3], list.clone()].concat());
        harness.storage("gather_points", &vec![[PATTERN; POINT_WORDS]; pixels as usize]);
        let mut pass = PassInfo { glint_first: 3, glint_count: list.len() as u32, ..pass_info() };
        pass.set_image([width, height]);
        let k = kernel(context, "passes/glint_mark.wgsl", "main", &[]);
        let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
        let work = Work::Invocations(list.len() as u32);
        harness.run(&k, &[], &at, work).unwrap_or_else(|e| panic!("{e}"));
        let words: Vec<[u32; POINT_WORDS]> = harness.read("gather_points").unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(std::mem::offset_of!(GatherPoint, glint_level), 44);
        for (i, words) in (0..pixels).zip(&words) {
            let wanted = if level(i) > 0 { level(i) } else { PATTERN };
            assert_eq!(words[11], wanted, "{width} × {height}, pixel {i}");
            assert_eq!(words[..11], [PATTERN; 11], "the rest of pixel {i}");
        }
    }
}
