//! Sums over a hundred thousand passes, numbers of passes and jotons past 32 bits, and bits that must not depend on threads
//! or on what was rendered before.

use crate::build::{Build, glowing, matte, v};
use crate::common::{device, kernel, pass_info};
use crate::harness::{Renderer, everyone, mappers};
use crate::sheet::{Sheet, Stress, sized};
use crate::shoot::{alike, batch, few_jotons, images, open, seed, seed_by_map, shots};
use joton::backend::Batch;
use joton::backend::gpu::harness::{Harness, Work};
use joton::film::{Film, Layer};
use joton::packed::PackedScene;
use joton::packed::layout::{GatherPoint, status};
use joton::plan::{Plan, Settings};
use joton::render::{Stop, render};
use joton::scene::Scene;

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "film: 1e5 passes", run: film },
    Stress { name: "power over 1e5 passes", run: power },
    Stress { name: "passes past 2^32", run: late_passes },
    Stress { name: "jotons numbered past 2^32", run: wrapped_jotons },
    Stress { name: "a device counts rays past 2^32", run: ray_counter },
    Stress { name: "threads do not change the image", run: threads },
    Stress { name: "batches do not change the image", run: batches },
];

/// Pixels across and down.
const SIZE: u32 = 16;

/// A room with a lamp.
fn room(size: u32) -> Scene {
    let mut b = Build::new(v(0., -0.9, 0.2), v(0., 0.3, -0.3), 0.8, size);
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &matte([0.7, 0.5, 0.3]));
    b.ceiling(v(0., 0.2, 0.98), 0.4, &glowing([4.0, 3.0, 2.0], [0.5; 3]));
    b.0
}

/// Means of 1e5 passes whose values lie twelve powers of ten apart: no drift.
fn film(sheet: &mut Sheet) {
    const PASSES: u64 = 100_000;
    for (name, values) in
        [("0.1", [0.1f32; 2]), ("1e6 and 1e-6 in turns", [1e6, 1e-6]), ("1e-30", [1e-30; 2])]
    {
        let mut film = Film::new(1, 1);
        for pass in 0..PASSES {
            film.add(1, &std::array::from_fn(|_| vec![[values[pass as usize % 2]; 3]]));
        }
        let want = (f64::from(values[0]) + f64::from(values[1])) / 2.0;
        let drift =
            (film.sum_of_layers(0)[0] / (film.passes() as f64 * Layer::ALL.len() as f64) / want - 1.0).abs();
        sheet.at_most(format!("mean of {PASSES} passes of {name}"), "film", "relative", drift, 1e-9);
    }
    // a lamp that fills the view: every pass sees the same
    let mut b = Build::new(v(0., 0., 0.), v(0., 0., 1.), 0.3, 1);
    b.ceiling(v(0., 0., 1.), 1.0, &glowing([0.1, 0.2, 0.3], [0.0; 3]));
    let passes = sized(20_000, PASSES);
    let mut backend = open(Renderer::PathTracer, &b.0, seed(0), &|_| ());
    let stop = Stop { passes: Some(passes), ..Stop::default() };
    let done = render(&mut *backend, b.0.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"));
    let drift = (done.picture.whole.pixels[0][0] / 0.1 - 1.0).abs();
    sheet.at_most(format!("a lamp over {passes} passes"), "PathTracer", "relative", f64::from(drift), 1e-5);
    sheet.row(
        "passes counted",
        "PathTracer",
        done.passes.to_string(),
        passes.to_string(),
        done.passes == passes,
    );
}

/// What is emitted over the passes is the lights' flux, and all of it ends somewhere.
fn power(sheet: &mut Sheet) {
    const JOTONS: u32 = 64;
    let scene = room(2);
    let flux = PackedScene::new(&scene).total_flux;
    for who in mappers() {
        let passes = if who == Renderer::Cpu { sized(2_000, 100_000) } else { sized(100, 5_000) };
        let mut backend = open(who, &scene, seed_by_map(0), &|plan: &mut Plan| plan.diffuse_jotons = JOTONS);
        let (mut emitted, mut ended) = (0.0, 0.0);
        for pass in 0..passes {
            let tally = batch(&mut *backend, pass, 1).tally;
            emitted += tally.emitted[0];
            ended += tally.absorbed[0] + tally.escaped[0];
        }
        let drift = (emitted / (passes as f64 * flux[0]) - 1.0).abs();
        sheet.at_most(format!("emitted in {passes} passes"), format!("{who:?}"), "relative", drift, 1e-5);
        // the roulette's spread for a joton is about one
        let limit = 4.5 / (passes as f64 * f64::from(JOTONS)).sqrt();
        let lost = (ended / emitted - 1.0).abs();
        sheet.at_most(
            format!("absorbed and escaped in {passes} passes"),
            format!("{who:?}"),
            "relative",
            lost,
            limit,
        );
    }
}

/// Mean of passes around `first` against that of the first ones; the radius is nobody's here, the light is even enough.
fn passes_from(sheet: &mut Sheet, tried: &str, who: Renderer, settings: Settings, first: u64) {
    const PASSES: u32 = 8;
    let scene = room(SIZE);
    let early = images(&shots(who, &scene, settings.clone(), 2), &Layer::ALL, 1.0);
    let mut backend = open(who, &scene, settings, &few_jotons);
    let late: Vec<_> = (0..PASSES)
        .map(|k| {
            let mut film = Film::new(SIZE, SIZE);
            film.add(1, &batch(&mut *backend, first + u64::from(k), 1).layers);
            film.picture()
        })
        .collect();
    alike(sheet, tried, format!("{who:?}"), &images(&late, &Layer::ALL, 1.0), &early, SIZE);
}

/// The index of a pass is cut to 32 bits for its random numbers.
fn late_passes(sheet: &mut Sheet) {
    for who in everyone() {
        passes_from(sheet, "around pass 2^32", who, seed(0), u64::from(u32::MAX) - 3);
    }
}

/// Sobol's sequence has 2^32 points: then it begins again, other bounces follow.
fn wrapped_jotons(sheet: &mut Sheet) {
    for who in mappers() {
        // 2^12 jotons a pass
        passes_from(sheet, "around joton 2^32", who, seed_by_map(0), (1 << 20) - 4);
    }
}

/// Rays of a batch are counted in two words.
fn ray_counter(sheet: &mut Sheet) {
    let Some(context) = device() else { return };
    const BEFORE: u32 = u32::MAX - 10;
    let scene = PackedScene::new(&room(SIZE));
    let plan = Plan::new(&scene, Settings::default());
    let mut harness = Harness::with_scene(context, &scene, &plan).unwrap_or_else(|e| panic!("{e}"));
    let pixels = scene.pixels();
    let mut words = [0u32; status::SLOTS as usize];
    words[status::RAYS as usize] = BEFORE;
    harness.storage("status", &words);
    harness.storage("gather_points", &vec![0u8; pixels * size_of::<GatherPoint>()]);
    harness.storage("film_emission", &vec![[0.0f32; 4]; pixels]);
    let mut pass = pass_info();
    pass.camera = scene.camera_info();
    pass.set_image([SIZE, SIZE]);
    let eye = kernel(context, "passes/eye.wgsl", "main", &[]);
    let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
    harness.run(&eye, &[], &at, Work::Tiles(scene.size)).unwrap_or_else(|e| panic!("{e}"));
    let words: Vec<u32> = harness.read("status").unwrap_or_else(|e| panic!("{e}"));
    let counted = status::rays(&words) - u64::from(BEFORE);
    // the walls are matte: one ray a pixel
    sheet.row(
        "camera rays added to 2^32 − 11",
        "device",
        format!("{counted} rays"),
        pixels.to_string(),
        counted == pixels as u64,
    );
}

fn bits(b: &Batch) -> Vec<u32> {
    b.layers.iter().flatten().flatten().map(|x| x.to_bits()).collect()
}

fn differing(a: &[u32], b: &[u32]) -> u64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).filter(|(x, y)| x != y).count() as u64
}

/// Same seed: the same bits on any number of threads.
fn threads(sheet: &mut Sheet) {
    let scene = crate::frames::room();
    for who in [Renderer::Cpu, Renderer::PathTracer] {
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap_or_else(|e| panic!("{e}"));
            pool.install(|| bits(&batch(&mut *open(who, &scene, seed(4), &few_jotons), 0, 3)))
        };
        let one = on(1);
        for n in [2, 3, 7, 64] {
            sheet.none(
                format!("{n} threads against one"),
                format!("{who:?}"),
                "values differ",
                differing(&on(n), &one),
            );
        }
    }
}

/// A pass has the same bits whatever was rendered before; sums of batches of any size differ by their rounding alone.
fn batches(sheet: &mut Sheet) {
    let scene = crate::frames::room();
    const PASSES: u32 = 24;
    for who in everyone() {
        let fresh = || open(who, &scene, seed(4), &few_jotons);
        let mut used = fresh();
        let one_by_one: Vec<Vec<f32>> = (0..PASSES)
            .map(|p| batch(&mut *used, p.into(), 1).layers.into_iter().flatten().flatten().collect())
            .collect();
        for pass in [0u64, 5, 17, 23] {
            let alone = bits(&batch(&mut *fresh(), pass, 1));
            let after: Vec<u32> = one_by_one[pass as usize].iter().map(|x| x.to_bits()).collect();
            sheet.none(
                format!("pass {pass} alone"),
                format!("{who:?}"),
                "values differ",
                differing(&alone, &after),
            );
        }
        for size in [5, 16] {
            let mut worst = 0.0f64;
            let mut sums = vec![0.0f64; one_by_one[0].len()];
            let mut first = 0;
            while first < PASSES {
                let count = size.min(PASSES - first);
                let layers = batch(&mut *used, first.into(), count).layers;
                let values = layers.iter().flatten().flatten();
                sums.iter_mut().zip(values).for_each(|(s, x)| *s += f64::from(*x));
                first += count;
            }
            for (i, sum) in sums.iter().enumerate() {
                let want: f64 = one_by_one.iter().map(|p| f64::from(p[i])).sum();
                if want > 0.0 {
                    worst = worst.max((sum / want - 1.0).abs());
                }
            }
            // each addition in f32 rounds by half a unit in the last place
            let limit = f64::from(size) * 2f64.powi(-24);
            sheet.at_most(format!("sums in batches of {size}"), format!("{who:?}"), "relative", worst, limit);
        }
    }
}
