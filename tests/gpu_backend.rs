//! The GPU backend as a whole: determinism, energy, closed answers, and the CPU backend as its judge.

mod common;

use common::scenes::{Builder, emitter, glass, mirror};
use glam::DVec3;
use joton::backend::cpu::CpuBackend;
use joton::backend::gpu::GpuBackend;
use joton::backend::{Backend, Batch};
use joton::film::paths::LightPaths;
use joton::film::stats::{Estimate, test_equal};
use joton::film::tile_schedule::TileSchedule;
use joton::film::{Image, Layer, Picture};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Settings};
use joton::render::{Rendered, Stop, render};
use joton::scene::{Light, Material, Scene};
use std::path::Path;
use std::sync::Arc;

/// A probability at which two estimates count as different: one in ten thousand tests would do so by chance.
const SIGNIFICANCE: f64 = 1e-4;

fn settings(seed: u32, paths: &str) -> Settings {
    Settings {
        seed,
        paths: LightPaths::parse(paths).unwrap_or_else(|e| panic!("{e}")),
        ..Settings::default()
    }
}

/// Diffuse light by the diffuse map, not by paths.
fn with_map(settings: Settings) -> Settings {
    Settings { keep: vec![Part::DiffuseMap], ..settings }
}

/// All share a device: what is compiled for one is there for the next.
fn open(scene: &Arc<PackedScene>, settings: Settings) -> GpuBackend {
    let context = common::device().expect("a device").clone();
    let plan = Plan::new(scene, settings);
    GpuBackend::new(context, Arc::clone(scene), plan).unwrap_or_else(|e| panic!("{e}"))
}

fn batch(backend: &mut dyn Backend, first: u64, count: u32) -> Batch {
    backend.render(first, count).unwrap_or_else(|e| panic!("{e}"))
}

fn run(backend: &mut dyn Backend, scene: &PackedScene, passes: u64) -> Rendered {
    let stop = Stop { passes: Some(passes), ..Stop::default() };
    render(backend, scene.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"))
}

/// One of the scenes of the repository at this size.
fn file(name: &str, size: u32) -> Arc<PackedScene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    scene.resize([size; 2]);
    Arc::new(PackedScene::new(&scene))
}

fn pack(scene: &Scene) -> Arc<PackedScene> {
    Arc::new(PackedScene::new(scene))
}

/// Every kind of light and surface: coloured lobes, gloss, sharp gloss, smooth glass, a mirror.
fn everything(size: u32) -> Arc<PackedScene> {
    let mut b = Builder::new([0., 0.1, 0.95], [0., -0.2, 0.], [0., 1., 0.], 0.8, size);
    let walls = b.material(Material::matte("walls", [0.7, 0.5, 0.3]));
    let lobes = b.material(Material {
        glossy: [0.1, 0.5, 0.1],
        glossy_exponent: 20.0,
        specular: [0.1, 0.1, 0.6],
        ..Material::matte("lobes", [0.7, 0.2, 0.1])
    });
    let sharp = b.material(Material {
        glossy: [0.8; 3],
        glossy_exponent: 3000.0,
        ..Material::matte("sharp", [0.1; 3])
    });
    let lamp = b.material(emitter(4.0, 0.3));
    let clear = b.material(glass(1.5));
    let shiny = b.material(mirror(0.9));
    b.room([-1.; 3], [1.; 3], walls);
    b.quad([-0.99, -0.99, -0.99], [0., 0., 1.], [1., 0., 0.], lobes);
    b.quad([-0.9, -0.9, -0.95], [0.8, 0., 0.], [0., 0.8, 0.], sharp);
    b.quad([-0.3, 0.98, -0.3], [0.6, 0., 0.], [0., 0., 0.6], lamp);
    b.icosphere([-0.35, -0.5, 0.1], 0.3, 2, true, clear);
    b.icosphere([0.5, -0.6, -0.2], 0.3, 2, true, shiny);
    b.scene.lights.push(Light::Spot {
        position: DVec3::new(0.8, 0.8, 0.5),
        direction: DVec3::new(-1.0, -1.2, -0.6).normalize(),
        intensity: [1.5, 1.0, 0.5],
        angle_inner: f64::acos(0.95),
        angle_outer: f64::acos(0.85),
    });
    b.point_light([-0.7, 0.6, 0.4], 0.3);
    pack(&b.scene)
}

fn bits(b: &Batch) -> Vec<u32> {
    b.layers.iter().flatten().flatten().map(|x| x.to_bits()).collect()
}

/// Same seed, device and driver: the same image, bit for bit, whatever was rendered before.
#[test]
fn one_seed_gives_one_image() {
    device_or_return!();
    let scene = everything(32);
    let mut first = open(&scene, settings(7, "L.*E"));
    let a = batch(&mut first, 0, 3);
    let b = batch(&mut open(&scene, settings(7, "L.*E")), 0, 3);
    let again = batch(&mut first, 0, 3);
    assert!(bits(&a) == bits(&b), "two backends differ");
    assert!(bits(&a) == bits(&again), "two renders of one backend differ");
    assert_eq!(a.tally, b.tally);
    let other = batch(&mut open(&scene, settings(8, "L.*E")), 0, 3);
    assert!(bits(&a) != bits(&other), "another seed gives the same image");
    assert_eq!((a.tally.non_finite.total(), a.tally.truncated), (0, 0));
}

/// Any split into batches, and any order, gives the same sums up to the rounding of f32.
#[test]
fn passes_are_independent() {
    device_or_return!();
    let scene = everything(32);
    let mut one = open(&scene, settings(7, "L.*E"));
    let mut other = open(&scene, settings(7, "L.*E"));
    // passes in one order here, in another there; area points are scattered anew every 16
    let whole = batch(&mut one, 0, 24);
    let parts: Vec<Batch> = [(20, 4), (0, 1), (1, 12), (13, 7)].map(|(f, n)| batch(&mut other, f, n)).into();
    for layer in Layer::ALL {
        for (pixel, sum) in whole.layers[layer as usize].iter().enumerate() {
            for (band, sum) in sum.iter().enumerate() {
                let parts: f32 = parts.iter().map(|p| p.layers[layer as usize][pixel][band]).sum();
                let limit = 1e-5 * sum.abs() + 1e-6;
                assert!((parts - sum).abs() < limit, "{layer:?}, pixel {pixel}: {parts} against {}", sum);
            }
        }
    }
    let stored: u64 = parts.iter().map(|p| p.tally.jotons_stored).sum();
    assert_eq!(stored, whole.tally.jotons_stored);
}

/// A batch in the memory of one that came before holds its own passes alone, where rows of the image rest, too; on both backends.
#[test]
fn memory_of_a_batch_is_used_again_without_what_it_held() {
    device_or_return!();
    let scene = everything(32);
    // the rows of tiles at the top and at the bottom take no part in odd passes
    let resting = TileSchedule::new(scene.size, [vec![1; 4], vec![0; 8], vec![1; 4]].concat());
    type Open = fn(&Arc<PackedScene>) -> Box<dyn Backend>;
    let backends: [Open; 2] = [
        |scene| Box::new(open(scene, settings(1, "L(S|D)*E"))),
        |scene| Box::new(CpuBackend::new(scene.clone(), Plan::new(scene, settings(1, "L(S|D)*E")))),
    ];
    for open in backends {
        let (mut fresh, mut used) = (open(&scene), open(&scene));
        let before = batch(used.as_mut(), 0, 1);
        assert!(before.layers.iter().flatten().any(|l| l[0] > 0.0), "the first pass is not black");
        used.reuse(before);
        for backend in [&mut fresh, &mut used] {
            assert!(backend.set_tile_schedule(&resting), "tiles rest");
        }
        let [a, b] = [&mut fresh, &mut used].map(|backend| batch(backend.as_mut(), 1, 1));
        assert_eq!(bits(&a), bits(&b), "{}", fresh.describe());
        assert!(a.layers.iter().all(|layer| layer[..32 * 8].iter().flatten().all(|x| *x == 0.0)), "rest");
    }
}

/// Emitted flux is the lights' flux; what was not absorbed has escaped.
#[test]
fn energy_is_balanced() {
    device_or_return!();
    for (name, scene) in [("everything", everything(16)), ("cornell", file("cornell.toml", 16))] {
        const PASSES: u32 = 8;
        let t = batch(&mut open(&scene, with_map(settings(1, "L.*E"))), 0, PASSES).tally;
        for b in 0..3 {
            let emitted = t.emitted[b] / f64::from(PASSES) / scene.total_flux[b];
            // lights of several colours are picked by their share: stratified, 1e-4 and better
            assert!(
                (emitted - 1.0).abs() < 1e-3,
                "{name}, band {b}: {emitted} of the lights' flux is emitted"
            );
            let ends = (t.absorbed[b] + t.escaped[b]) / t.emitted[b];
            // 2^17 jotons whose flux has a standard deviation of about one: 4 standard errors are 1.1 %
            assert!((ends - 1.0).abs() < 0.011, "{name}, band {b}: {ends} of the flux ends somewhere");
        }
    }
}

/// Independent renders of a scene by a backend.
fn renders(
    seeds: std::ops::Range<u32>,
    passes: u64,
    scene: &Arc<PackedScene>,
    paths: &str,
    gpu: bool,
) -> Vec<Image> {
    pictures(seeds, passes, scene, paths, gpu).into_iter().map(|p| p.whole).collect()
}

/// The same with their layers.
fn pictures(
    seeds: std::ops::Range<u32>,
    passes: u64,
    scene: &Arc<PackedScene>,
    paths: &str,
    gpu: bool,
) -> Vec<Picture> {
    pictures_by(seeds, passes, scene, gpu, |seed| settings(seed, paths))
}

/// The same by any settings.
fn pictures_by(
    seeds: std::ops::Range<u32>,
    passes: u64,
    scene: &Arc<PackedScene>,
    gpu: bool,
    settings: impl Fn(u32) -> Settings,
) -> Vec<Picture> {
    seeds
        .map(|seed| {
            let settings = settings(seed);
            let mut backend: Box<dyn Backend> = if gpu {
                Box::new(open(scene, settings))
            } else {
                Box::new(CpuBackend::new(Arc::clone(scene), Plan::new(scene, settings)))
            };
            run(backend.as_mut(), scene, passes).picture
        })
        .collect()
}

fn estimate(images: &[Image], block: u32) -> Estimate {
    Estimate::from_renders(images, block).unwrap_or_else(|e| panic!("{e}"))
}

/// A closed box with albedo 0.5 and emission 0.5 has radiance 1 everywhere.
#[test]
fn furnace_radiance_is_one() {
    device_or_return!();
    let scene = file("furnace.toml", 32);
    let images = renders(0..8, 4, &scene, "L.*E", true);
    let whole = estimate(&images, 32);
    for band in 0..3 {
        // what edges and corners are off by (see gpu_kernels, boundary) is a few thousandths of the image
        assert!((whole.mean[0][band] - 1.0).abs() < 5e-3, "mean {:?}", whole.mean[0]);
    }
    let blocks = estimate(&images, 4);
    for (i, mean) in blocks.mean.iter().enumerate() {
        let error = 4.0 * blocks.variance[i][0].sqrt();
        assert!((mean[0] - 1.0).abs() < 0.01 + error, "block {i}: {mean:?} ± {error}");
    }
}

/// The classes of paths, rendered apart with other seeds, add up to the whole.
#[test]
fn layers_rendered_apart_add_up_to_the_whole() {
    device_or_return!();
    const SIZE: u32 = 32;
    const PASSES: u64 = 4;
    let scene = everything(SIZE);
    let whole = estimate(&renders(0..8, PASSES, &scene, "L.*E", true), 8);
    let classes = ["LS*E", "LDS*E", "LS+DS*E", "LS*DS*D.*E"];
    let apart: Vec<Vec<Image>> = (1..)
        .zip(classes)
        .map(|(k, class)| renders(100 * k..100 * k + 8, PASSES, &scene, class, true))
        .collect();
    let sum_of = |kept: &[usize]| -> Vec<Image> {
        (0..8)
            .map(|i| {
                let mut sum = Image::new(SIZE, SIZE);
                for image in kept.iter().map(|&k| &apart[k][i]) {
                    for (s, p) in sum.pixels.iter_mut().flatten().zip(image.pixels.iter().flatten()) {
                        *s += p;
                    }
                }
                sum
            })
            .collect()
    };
    let all = test_equal(&estimate(&sum_of(&[0, 1, 2, 3]), 8), &whole).unwrap_or_else(|e| panic!("{e}"));
    assert!(all.accepts(SIGNIFICANCE), "{all:?}");
    // and each class is needed: without it the sums differ
    for (missing, class) in classes.iter().enumerate() {
        let kept: Vec<usize> = (0..4).filter(|&k| k != missing).collect();
        let outcome = test_equal(&estimate(&sum_of(&kept), 8), &whole).unwrap_or_else(|e| panic!("{e}"));
        assert!(!outcome.accepts(SIGNIFICANCE), "{class} is not missed: {outcome:?}");
    }
}

/// Classes of indirect light: paths that go on take the same ways whatever is wanted of them, so with one seed the classes add up to
/// the whole; each is what the CPU backend finds.
#[test]
fn classes_of_indirect_light_add_up_to_it() {
    device_or_return!();
    const SIZE: u32 = 16;
    const PASSES: u64 = 24;
    let scene = everything(SIZE);
    // what is direct or caustic is wanted besides: without it there are no paths that go on
    let classes = ["LS*DDS*E", "LS*DS+DS*E", "LS*DS*DS*D.*E"];
    let of = |class: &'static str| move |seed| settings(seed, &format!("LS*DS*E|{class}"));
    let indirect = |p: &[Picture]| layers_of(p, &[Layer::Diffuse], 1.0);
    let wanted = |class| Plan::new(&scene, of(class)(0)).has_indirect_paths();
    assert!(classes.into_iter().all(wanted));
    let whole = indirect(&pictures_by(0..8, PASSES, &scene, true, |seed| settings(seed, "L.*E")));
    let each = classes.map(|class| indirect(&pictures_by(0..8, PASSES, &scene, true, of(class))));
    let mean = |images: &[Image]| estimate(images, SIZE).mean[0];
    let sums =
        each.iter().map(|images| mean(images)).fold([0.0; 3], |sum, one| [0, 1, 2].map(|b| sum[b] + one[b]));
    for (sum, whole) in sums.into_iter().zip(mean(&whole)) {
        // long paths end by a chance that counts the work of a filter, too
        assert!((sum / whole - 1.0).abs() < 5e-3, "{sum} of {whole}");
    }
    for (class, gpu) in classes.into_iter().zip(&each) {
        let cpu = indirect(&pictures_by(1000..1008, PASSES, &scene, false, of(class)));
        let outcome =
            test_equal(&estimate(gpu, SIZE), &estimate(&cpu, SIZE)).unwrap_or_else(|e| panic!("{e}"));
        assert!(outcome.accepts(SIGNIFICANCE), "{class}: {outcome:?}");
        assert!(mean(gpu).iter().all(|x| *x > 1e-3), "{class} is dark");
    }
}

/// Sum of some layers.
fn layers_of(pictures: &[Picture], kept: &[Layer], factor: f32) -> Vec<Image> {
    let sum = |p: &Picture| {
        let mut image = Image::new(p.whole.width, p.whole.height);
        for layer in kept {
            for (s, x) in
                image.pixels.iter_mut().flatten().zip(p.layers[*layer as usize].pixels.iter().flatten())
            {
                *s += x * factor;
            }
        }
        image
    };
    pictures.iter().map(sum).collect()
}

/// Both backends estimate the same image, block by block and as a whole, with diffuse light by paths and by its map; the same
/// images 2 % brighter are found to differ.
#[test]
fn gpu_and_cpu_render_the_same_image() {
    device_or_return!();
    const SIZE: u32 = 32;
    // lamps in view make the mean of the whole noisy (the edges of their image): these are compared in blocks only
    const SCATTERED: [Layer; 3] = [Layer::Direct, Layer::Caustic, Layer::Diffuse];
    let by_paths = |seed| settings(seed, "L.*E");
    let by_map = |seed| with_map(settings(seed, "L.*E"));
    type Of = fn(u32) -> Settings;
    for (name, scene, passes, of) in [
        ("everything", everything(SIZE), 40, by_paths as Of),
        ("everything, map", everything(SIZE), 12, by_map as Of),
        ("cornell", file("cornell.toml", SIZE), 40, by_paths as Of),
        ("cornell, map", file("cornell.toml", SIZE), 12, by_map as Of),
        ("spheres", file("spheres.toml", SIZE), 40, by_paths as Of),
        ("spheres, map", file("spheres.toml", SIZE), 12, by_map as Of),
    ] {
        let gpu = pictures_by(0..8, passes, &scene, true, of);
        let cpu = pictures_by(1000..1008, passes, &scene, false, of);
        let differ = |layers: &[Layer], block: u32, factor: f32| {
            let (a, b) = (layers_of(&gpu, layers, factor), layers_of(&cpu, layers, 1.0));
            test_equal(&estimate(&a, block), &estimate(&b, block)).unwrap_or_else(|e| panic!("{e}"))
        };
        for (layers, block) in [(&Layer::ALL[..], 8), (&SCATTERED[..], 8), (&SCATTERED[..], SIZE)] {
            let outcome = differ(layers, block, 1.0);
            assert!(outcome.accepts(SIGNIFICANCE), "{name}, blocks of {block}: {outcome:?}");
        }
        let outcome = differ(&SCATTERED, SIZE, 1.02);
        assert!(!outcome.accepts(SIGNIFICANCE), "{name}: 2 % more light is not found: {outcome:?}");
    }
}

/// Scenes that lack something: they render, stay finite, and are black where nothing can shine.
#[test]
fn scenes_that_lack_something_render() {
    device_or_return!();
    let view = || Builder::new([0., 0., 2.], [0.; 3], [0., 1., 0.], 0.5, 16);
    let sum = |r: &Rendered| r.picture.whole.pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>();
    let go = |scene: &Scene| {
        let scene = pack(scene);
        let r = run(&mut open(&scene, settings(1, "L.*E")), &scene, 3);
        assert!(r.picture.whole.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
        assert_eq!(r.tally.non_finite.total(), 0);
        r
    };

    let mut b = view();
    let lamp = b.material(emitter(2.0, 0.0));
    b.triangle([DVec3::new(-1., -1., 0.), DVec3::new(1., -1., 0.), DVec3::new(0., 1., 0.)], lamp);
    assert!(sum(&go(&b.scene)) > 0.0, "one triangle that shines");

    let mut b = view();
    let m = b.matte(0.5);
    b.triangle([DVec3::new(-1., -1., 0.), DVec3::new(1., -1., 0.), DVec3::new(0., 1., 0.)], m);
    b.point_light([0., 0., 1.], 1.0);
    let r = go(&b.scene);
    assert!(sum(&r) > 0.0, "one matte triangle");
    assert_eq!(r.picture.layers[Layer::Diffuse as usize].pixels.iter().flatten().sum::<f32>(), 0.0);

    let mut b = view();
    let shiny = b.material(mirror(0.9));
    let lamp = b.material(emitter(2.0, 0.0));
    b.room([-3.; 3], [3.; 3], shiny);
    b.quad([-1., 2.9, -1.], [2., 0., 0.], [0., 0., 2.], lamp);
    assert!(sum(&go(&b.scene)) > 0.0, "a room of mirrors without anything diffuse");

    let mut b = view();
    let m = b.matte(0.5);
    let clear = b.material(glass(1.5));
    b.quad([-1., -1., 0.], [2., 0., 0.], [0., 2., 0.], m);
    b.icosphere([0., 0., 0.5], 0.2, 1, true, clear);
    b.scene.lights.push(Light::Spot {
        position: DVec3::new(0., 0., 1.),
        direction: DVec3::Z,
        intensity: [1.0; 3],
        angle_inner: f64::acos(0.99),
        angle_outer: f64::acos(0.9),
    });
    let r = go(&b.scene);
    assert_eq!(sum(&r), 0.0, "a light that looks away");
    assert_eq!(r.tally.absorbed, [0.0; 3]);

    let mut b = view();
    let m = b.matte(0.9);
    let lamp = b.material(emitter(1.0, 0.9));
    b.room([-3.; 3], [3.; 3], m);
    b.quad([-1., 2.9, -1.], [2., 0., 0.], [0., 0., 2.], lamp);
    let r = go(&b.scene);
    assert!(sum(&r) > 0.0 && r.tally.escaped == [0.0; 3], "a closed room of albedo 0.9");
}
