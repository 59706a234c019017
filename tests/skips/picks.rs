//! Learned picks of lights: less noise, and no light lost.

use crate::common::scenes::{Builder, emitter};
use crate::common::twins::{file, hall};
use crate::renders::{SIGNIFICANCE, Side, both, plan, run};
use joton::film::stats::{Estimate, test_equal};
use joton::film::{Image, Layer};
use joton::packed::{PackedEmitter, PackedScene};
use joton::plan::Part;
use joton::scene::Scene;
use joton::spectrum::{BANDS, sum};
use std::sync::Arc;

/// Light that bounces once.
const DIRECT: &str = "LDE";
const SEEDS: u32 = 8;

/// Direct layers of renders with seeds of their own.
fn direct(
    side: Side,
    scene: &Arc<PackedScene>,
    seeds: std::ops::Range<u32>,
    keep: &[Part],
    passes: u64,
) -> Vec<Image> {
    let render = |s| run(side, scene, plan(scene, DIRECT, s, keep), passes).picture;
    seeds.map(|s| render(s).layers[Layer::Direct as usize].clone()).collect()
}

/// Mean over the pixels of the variance between images.
fn variance(images: &[Image]) -> f64 {
    let count = images.len() as f64;
    let of = |p: usize, b: usize| {
        let mean = images.iter().map(|i| f64::from(i.pixels[p][b])).sum::<f64>() / count;
        images.iter().map(|i| (f64::from(i.pixels[p][b]) - mean).powi(2)).sum::<f64>() / (count - 1.0)
    };
    let pixels = images[0].pixels.len();
    (0..pixels).map(|p| (0..BANDS).map(|b| of(p, b)).sum::<f64>()).sum::<f64>() / pixels as f64
}

/// One room of ten is seen: nine of ten shadow rays would go to lamps behind walls. With learned picks direct light has less
/// than a fifth of the variance, on both sides.
#[test]
fn lamps_of_other_rooms_are_not_asked() {
    let scene = Arc::new(PackedScene::new(&file("rooms", 24)));
    for side in both() {
        let [learned, by_flux] =
            [&[][..], &[Part::UnseenLight]].map(|keep| variance(&direct(side, &scene, 0..SEEDS, keep, 4)));
        println!("{side:?}: {:.1}", by_flux / learned);
        assert!(by_flux > 5.0 * learned, "{side:?}: variance {by_flux:.2e} falls to {learned:.2e} only");
    }
}

/// A hall with two walls under many lamps, near and far: one shadow ray for eight light samples finds the light that a ray for each sample
/// finds, with less than half the variance, on both sides.
#[test]
fn one_ray_for_some_samples_finds_the_light_of_all() {
    const WIDTH: u32 = 32;
    let mut b = Builder { scene: hall(WIDTH) };
    let grey = b.matte(0.5);
    // behind walls which sample gets the ray matters: it alone may be shaded
    for x in [9.0, 19.0] {
        b.quad([x, 0., 4.], [0., 3., 0.], [0., 0., 22.], grey);
    }
    let scene = Arc::new(PackedScene::new(&b.scene));
    assert!(plan(&scene, DIRECT, 0, &[]).light_candidates > 1);
    for side in both() {
        let picked = direct(side, &scene, 0..SEEDS, &[], 32);
        let plain = direct(side, &scene, SEEDS..2 * SEEDS, &[Part::FaintLight], 64);
        let ratio = variance(&plain) * 2.0 / variance(&picked);
        println!("{side:?}: {ratio:.1}");
        assert!(ratio > 2.0, "{side:?}: variance falls to 1 / {ratio:.2} only");
        for block in [4, WIDTH] {
            let [a, b] =
                [&picked, &plain].map(|i| Estimate::from_renders(i, block).unwrap_or_else(|e| panic!("{e}")));
            let outcome = test_equal(&a, &b).unwrap_or_else(|e| panic!("{e}"));
            println!("{side:?}, blocks of {block}: p = {:.2e}", outcome.p_value);
            assert!(outcome.accepts(SIGNIFICANCE), "{side:?}, blocks of {block}: {outcome:?}");
        }
    }
}

/// Pixels across.
const SIZE: u32 = 96;

/// A wide floor under a lamp, which is dark where `alone`, and a brighter lamp in a closed box whose bottom has a slit.
fn slit(alone: bool) -> Scene {
    const BOTTOM: f64 = 0.3;
    const SLIT: f64 = 0.03;
    const HALF: f64 = 0.3;
    let mut b = Builder::new([0., 16., 0.], [0.; 3], [0., 0., -1.], 0.5, SIZE);
    let (white, black) = (b.matte(0.7), b.matte(0.0));
    let lamp = b.material(emitter(if alone { 0.0 } else { 20.0 }, 0.0));
    let boxed = b.material(emitter(2000.0, 0.0));
    b.quad([-10., 0., -10.], [0., 0., 20.], [20., 0., 0.], white);
    b.quad([2.2, 3., -0.3], [0.6, 0., 0.], [0., 0., 0.6], lamp);
    let [x, z] = [-5.6, 4.8];
    b.quad([x - 0.05, 0.6, z - 0.05], [0.1, 0., 0.], [0., 0., 0.1], boxed);
    let floor = b.scene.mesh.triangles.len();
    b.room([x - HALF, BOTTOM, z - HALF], [x + HALF, 0.7, z + HALF], black);
    // the first of its walls is the bottom
    b.scene.mesh.triangles.drain(floor..floor + 2);
    for side in [x - HALF, x + SLIT / 2.0] {
        b.quad([side, BOTTOM, z - HALF], [0., 0., 2.0 * HALF], [HALF - SLIT / 2.0, 0., 0.], black);
    }
    b.scene
}

/// The mean over some pixels, as an image of one.
fn region(image: &Image, pixels: &[usize]) -> Image {
    let mut mean = Image::new(1, 1);
    for &p in pixels {
        for (sum, x) in mean.pixels[0].iter_mut().zip(&image.pixels[p]) {
            *sum += x / pixels.len() as f32;
        }
    }
    mean
}

/// A lamp that no shadow ray of the pilot finds keeps a tenth of its flux's share, and so all of its light: where it shines
/// through a slit, into a few pixels of thousands, the mean is the path tracer's.
#[test]
fn a_lamp_that_nobody_saw_is_not_lost() {
    /// Passes: of ten shadow rays one goes to the lamp, and of ten a few through the slit.
    const PASSES: u64 = 32;
    let alone = Arc::new(PackedScene::new(&slit(true)));
    let image = &direct(Side::PathTracer, &alone, 0..1, &[], 64)[0];
    let lit: Vec<usize> = (0..image.pixels.len()).filter(|&p| image.pixels[p][0] > 0.0).collect();
    assert!((2..SIZE as usize).contains(&lit.len()), "{} pixels are lit", lit.len());
    let scene = Arc::new(PackedScene::new(&slit(false)));
    let flux = |e: &PackedEmitter| sum(&e.flux);
    let total: f64 = scene.emitters.iter().map(flux).sum();
    let own = plan(&scene, DIRECT, 0, &[]);
    let of_its_share = |e: &PackedEmitter| f64::from(e.pick) * total / flux(e);
    let parts: Vec<f64> = own.guides.direct.emitters(&scene.emitters).iter().map(of_its_share).collect();
    // the lamp, then the one in the box, two triangles each
    assert!(parts[0] > 1.0 && (0.0999..0.1001).contains(&parts[2]), "{parts:?}");
    let of = |images: Vec<Image>| {
        let means: Vec<Image> = images.iter().map(|i| region(i, &lit)).collect();
        Estimate::from_renders(&means, 1).expect("as many as seeds")
    };
    let paths = of(direct(Side::PathTracer, &scene, 0..SEEDS, &[], PASSES));
    let learned = of(direct(Side::Host, &scene, 0..SEEDS, &[], PASSES));
    let outcome = test_equal(&learned, &paths).expect("one pixel each");
    println!("{:?} against {:?}: {outcome:?}", learned.mean, paths.mean);
    assert!(outcome.accepts(SIGNIFICANCE), "{:?} against {:?}: {outcome:?}", learned.mean, paths.mean);
}
