//! Rest: tiles that take part in some of the passes only. The expected image stays; what rests wakes; nothing depends on
//! the threads.

use crate::chi_square::Claims;
use crate::common::scenes::{Builder, emitter};
use crate::images::{BLOCKS, SEEDS, SIZE, claim, scene};
use crate::renders::{EVERYTHING, Side, open, plan, run};
use joton::film::tile_schedule::TileSchedule;
use joton::film::{Film, Layer, Picture};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan};
use joton::render::Rendered;
use std::sync::Arc;

/// The sides that rest, as far as they are here.
fn sides() -> impl Iterator<Item = Side> {
    [Side::Host].into_iter().chain(crate::common::device().map(|_| Side::Device))
}

/// Mean of `passes` passes; from pass `from` on with these rates.
fn forced(
    side: Side,
    scene: &Arc<PackedScene>,
    plan: Plan,
    schedule: &TileSchedule,
    from: u64,
    passes: u64,
) -> Picture {
    let mut backend = open(side, scene, plan);
    let mut film = Film::new(scene.size[0], scene.size[1]);
    for pass in 0..passes {
        if pass == from {
            assert!(backend.set_tile_schedule(schedule), "{side:?} rests");
            film.set_tile_schedule(schedule.clone());
        }
        let batch = backend.render(pass, 1).unwrap_or_else(|e| panic!("{e}"));
        assert_eq!(batch.tally.pixels_rested, if pass < from { 0 } else { schedule.pixels_resting(pass) });
        film.add(1, &batch.layers);
    }
    film.picture()
}

/// Whatever the rates, the expected image is that of all passes: every pixel of every layer, on both sides, though the
/// last blocks are open. Radii are the same in all passes: a block has that of its first one.
#[test]
fn rates_do_not_change_the_expected_image() {
    const FROM: u64 = 4;
    const PASSES: u64 = 7;
    let scene = scene("spheres.toml");
    let first = crate::chi_square::seed() * 10_000 + 5000;
    let keep_radii = |plan: &mut Plan| (plan.caustic.alpha, plan.diffuse.alpha) = (1.0, 1.0);
    // rates of every kind, side by side
    let schedule = TileSchedule::new([SIZE; 2], vec![0, 1, 2, 2, 0, 1, 1, 2, 0]);
    let seeds = |side: Side, schedule: &TileSchedule| -> Vec<Picture> {
        let seeds =
            (0..SEEDS).map(|s| first + 100 * side as u32 + if schedule.is_none() { 50 + s } else { s });
        let render = |seed| {
            let mut plan = plan(&scene, EVERYTHING, seed);
            keep_radii(&mut plan);
            forced(side, &scene, plan, schedule, FROM, PASSES)
        };
        seeds.map(render).collect()
    };
    let awake = seeds(Side::Host, &TileSchedule::none([SIZE; 2]));
    let mut claims = Claims::default();
    for side in sides() {
        claim(&mut claims, &format!("{side:?}"), &seeds(side, &schedule), &awake, &Layer::ALL, &BLOCKS);
    }
    claims.hold();
}

/// Width of the wire, pixels, and its radiance.
const WIRE: f64 = 0.004;
const WIRE_RADIANCE: f32 = 10.0;

/// A wire of light down an image that is black else, so thin that most of its tiles rest before they have seen it.
fn wire() -> Arc<PackedScene> {
    let mut b = Builder::new([0., 0., 1.], [0., 0., 0.], [0., 1., 0.], 1.0, SIZE);
    let light = b.material(emitter(WIRE_RADIANCE, 0.0));
    // the image is 2 wide at the wire
    let pixel = 2.0 / f64::from(SIZE);
    b.quad([-8.7 * pixel, -2., 0.], [WIRE * pixel, 0., 0.], [0., 4., 0.], light);
    Arc::new(PackedScene::new(&b.scene))
}

/// What no sample saw before its tile went to rest is found later, wakes the tile and is not lost in the mean.
#[test]
fn a_wire_in_a_resting_tile_is_not_lost() {
    const PASSES: u64 = 43;
    let scene = wire();
    for side in sides() {
        let seeds = if side == Side::Host { 400 } else { 16 };
        let means: Vec<f64> = (0..seeds)
            .map(|seed| {
                let picture = run(side, &scene, plan(&scene, EVERYTHING, 100 + seed), PASSES).picture;
                picture.whole.pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / f64::from(SIZE)
            })
            .collect();
        // a row of pixels sees the wire's radiance in a part of one
        let wanted = f64::from(WIRE_RADIANCE) * WIRE;
        let n = means.len() as f64;
        let mean = means.iter().sum::<f64>() / n;
        let error = (means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt();
        println!("{side:?}: {mean} ± {error}, {wanted} wanted");
        // 4.5 standard errors: once in 10^5 by chance for many seeds. Samples that count once and not for their block lose
        // two fifths of the light
        assert!((mean - wanted).abs() < 4.5 * error, "{side:?}: {mean} ± {error}, {wanted} wanted");
        assert!(side != Side::Host || 4.5 * error < 0.5 * wanted, "{side:?}: ± {error}");
    }
}

/// A ball on black, and a lamp that fills the right of the image.
fn ball_and_lamp() -> Arc<PackedScene> {
    const PIXELS: u32 = 64;
    let mut b = Builder::new([0., 0., 3.], [0., 0., 0.], [0., 1., 0.], 1.0, PIXELS);
    let grey = b.matte(0.5);
    b.icosphere([-0.8, 0., 0.], 0.5, 2, false, grey);
    let lamp = b.material(emitter(3.3, 0.0));
    b.quad([0.4, -4., 0.], [4., 0., 0.], [0., 8., 0.], lamp);
    b.point_light([0., 3., 3.], 20.0);
    Arc::new(PackedScene::new(&b.scene))
}

/// Where nothing wakes, resting changes not a bit, after any number of passes; it is counted and can be switched off.
#[test]
fn resting_changes_no_bit_of_what_is_quiet() {
    let scene = ball_and_lamp();
    for side in sides() {
        for passes in [6, 37] {
            let [resting, awake] = [true, false].map(|rests| {
                let mut plan = plan(&scene, EVERYTHING, 3);
                if !rests {
                    plan.settings.keep.push(Part::Rest);
                }
                run(side, &scene, plan, passes)
            });
            assert!(resting.picture.whole == awake.picture.whole, "{side:?}, {passes} passes");
            assert!(resting.picture.layers == awake.picture.layers, "{side:?}, {passes} passes");
            assert_eq!(awake.tally.pixels_rested, 0, "{side:?}");
            assert!(resting.tally.rays < awake.tally.rays, "{side:?}");
            let most = passes * scene.pixels() as u64;
            let share = resting.tally.pixels_rested as f64 / most as f64;
            println!("{side:?}, {passes} passes: {share:.3} rested");
            // half of the tiles are quiet, with all around them, and sleep through most of the passes
            assert!(passes < 37 || share > 0.25, "{side:?}, {passes} passes: {share} rested");
        }
    }
}

/// One seed gives one image, whatever the threads.
#[test]
fn threads_do_not_change_who_rests() {
    let scenes = [ball_and_lamp(), wire()];
    let on = |threads, scene: &Arc<PackedScene>| -> Rendered {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        pool.install(|| run(Side::Host, scene, plan(scene, EVERYTHING, 3), 40))
    };
    for scene in &scenes {
        let one = on(1, scene);
        assert!(one.tally.pixels_rested > 0);
        for threads in [2, 7] {
            let more = on(threads, scene);
            assert!(one.picture.whole == more.picture.whole, "{threads} threads");
            assert_eq!(one.tally, more.tally, "{threads} threads");
        }
    }
}
