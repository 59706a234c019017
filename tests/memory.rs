//! Memory: what the plan tells of buffers and kernels is what a device really has and does.

mod common;

use common::scenes::{Builder, emitter, mirror};
use glam::{IVec3, Vec3};
use joton::Error;
use joton::backend::gpu::{Context, GpuBackend};
use joton::backend::{Backend, Batch};
use joton::estimators::maps::MapKind;
use joton::estimators::split_paths::{Light, Look, SplitPaths};
use joton::film::stats::{Estimate, test_equal};
use joton::film::{Image, Layer};
use joton::packed::PackedScene;
use joton::packed::constants::row_bucket;
use joton::packed::scatter_area_points;
use joton::plan::buffers::{
    AREA_KEY_BITS, Buffer, BufferPlan, area_points_most, area_points_wanted, expected_shapes, fit,
};
use joton::plan::grid::Grid;
use joton::plan::map_layout::DeviceLimits;
use joton::plan::strips::Strips;
use joton::plan::traffic::Traffic;
use joton::plan::{Part, Plan, Settings};
use joton::render::{Stop, render};
use std::collections::{BTreeMap, HashMap, HashSet};
use std::path::Path;
use std::sync::Arc;

/// A probability at which two estimates count as different: one in ten thousand tests would do so by chance.
const SIGNIFICANCE: f64 = 1e-4;

/// One of the scenes of the repository at this size.
fn file(name: &str, size: [u32; 2]) -> Arc<PackedScene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    scene.resize(size);
    Arc::new(PackedScene::new(&scene))
}

/// Diffuse light by the diffuse map, not by paths.
fn with_map() -> Settings {
    Settings { keep: vec![Part::DiffuseMap], ..Settings::default() }
}

fn open(scene: &Arc<PackedScene>, settings: Settings) -> GpuBackend {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(scene, settings);
    GpuBackend::new(context, Arc::clone(scene), plan).unwrap_or_else(|e| panic!("{e}"))
}

/// The buffers that the plan lists for the shapes in use are those that were created, byte for byte; the kernels that it
/// lists are those that ran, as often. Scenes with and without a caustic map, in uniform buffers and not; diffuse light by paths
/// and by its map.
#[test]
fn what_the_plan_tells_is_what_the_device_does() {
    device_or_return!();
    let scenes = ["cornell.toml", "spheres.toml", "pool.toml"];
    for (name, settings) in scenes.into_iter().flat_map(|n| [(n, Settings::default()), (n, with_map())]) {
        let scene = file(name, [40, 24]);
        let mut backend = open(&scene, settings);
        backend.measure_kernels().unwrap_or_else(|e| panic!("{e}"));
        backend.render(0, 1).unwrap_or_else(|e| panic!("{e}"));

        let needs = backend.needs();
        let mut told: Vec<_> = needs.buffers().iter().map(|b| (b.name, b.bytes)).collect();
        told.sort_unstable();
        assert_eq!(told, backend.memory(), "{name}");

        let traffic = Traffic::look(&scene, needs.plan);
        let mut told: BTreeMap<String, u64> = BTreeMap::new();
        for kernel in needs.kernels(&traffic) {
            *told.entry(kernel.name.into()).or_default() += kernel.dispatches;
        }
        let mut ran: BTreeMap<String, u64> =
            backend.kernel_seconds().into_iter().map(|(n, _, d)| (n, d)).collect();
        assert!(!ran.is_empty(), "the device has timestamps");
        // nobody knows before a device looks whether there are trees in every pass, up to twice as many as pixels in parts of as
        // many as these, and in this one in turn
        let glints = ["glint", "glint_sum"].map(|kernel| (told.remove(kernel), ran.remove(kernel)));
        assert!(glints.iter().all(|(told, ran)| *told == Some(1) && ran.is_none_or(|n| n <= 3)), "{name}");
        assert_eq!(glints[0], glints[1], "{name}: all trees are summed");
        assert_eq!(told, ran, "{name}");
    }
}

/// What is expected before a device has looked comes near to what it then needs, and traces: bytes of jotons within a
/// factor of two, rays and jotons within a tenth (their means of 4096 paths have a standard error of 2 %).
#[test]
fn expectations_come_near() {
    device_or_return!();
    for name in ["cornell.toml", "spheres.toml", "ring.toml"] {
        let scene = file(name, [64, 64]);
        let mut backend = open(&scene, with_map());
        let tally = backend.render(0, 1).unwrap_or_else(|e| panic!("{e}")).tally;
        let needs = backend.needs();
        let traffic = Traffic::look(&scene, needs.plan);
        let expected = expected_shapes(&scene, needs.plan, needs.machine, &traffic);
        for (expected, found) in expected.each().zip(needs.shapes.each()) {
            let ratio = expected.max_stored() as f64 / found.max_stored() as f64;
            assert!((0.5..2.0).contains(&ratio), "{name}: room for {ratio} of the jotons");
        }
        let stored = f64::from(needs.plan.caustic_jotons) * traffic.caustic.stored
            + f64::from(needs.plan.diffuse_jotons) * traffic.diffuse.stored;
        let ratio = stored / tally.jotons_stored as f64;
        assert!((0.9..1.1).contains(&ratio), "{name}: {ratio} of the jotons are expected");
    }
}

/// Rays of all kernels, and jotons and area points that these test, within a factor of two of what is there: rays as the device counts
/// them; tests by looking into every cell that a disc touches, and those that share its bucket. A room, glass, a closed box; and a
/// plane far larger than what the camera sees, with a stack of boards.
#[test]
fn told_work_is_done() {
    let mut stack = Builder::new([0.5, 0.4, 1.2], [0., 0.1, 0.], [0., 1., 0.], 0.7, 48);
    let (floor, lamp) = (stack.matte(0.5), stack.material(emitter(8.0, 0.0)));
    stack.quad([-40., 0., -40.], [0., 0., 80.], [80., 0., 0.], floor);
    for board in 1..12 {
        stack.quad([-0.2, 0.02 * board as f64, -0.2], [0., 0., 0.4], [0.4, 0., 0.], floor);
    }
    stack.quad([-0.2, 0.9, -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    let mut scenes: Vec<_> =
        ["cornell.toml", "spheres.toml", "furnace.toml"].map(|name| (name, file(name, [48, 48]))).into();
    scenes.push(("stack", Arc::new(PackedScene::new(&stack.scene))));
    for ((name, scene), settings) in scenes.iter().flat_map(|s| [(s, Settings::default()), (s, with_map())]) {
        let plan = Plan::new(scene, settings.clone());
        let traffic = Traffic::look(scene, &plan);
        let machine = DeviceLimits::REFERENCE;
        let shapes = expected_shapes(scene, &plan, machine, &traffic);
        let needs = BufferPlan { scene, plan: &plan, machine, shapes, strips: Strips::whole(scene.size) };
        let kernels = needs.kernels(&traffic);
        let near = |told: f64, found: f64, what: &str| {
            let ratio = told / found;
            println!("{name}: {what} told {told:.3e}, found {found:.3e}");
            assert!((0.5..2.0).contains(&ratio), "{name}: {what} {ratio} of what is there");
        };
        if common::device().is_some() {
            let mut backend = open(scene, settings);
            let found = backend.render(0, 1).unwrap_or_else(|e| panic!("{e}")).tally.rays as f64;
            near(kernels.iter().map(|k| k.rays as f64).sum(), found, "rays");
        }
        if !plan.has_map(MapKind::Diffuse) {
            continue;
        }
        let radius = plan.diffuse.radius(0) as f32;
        let places: Vec<Vec3> = traffic.places.iter().map(|place| place.position).step_by(16).collect();
        let pixels = scene.pixels() as f64 * traffic.camera.stored / places.len() as f64;
        // cells that share a bucket are looked through, too
        let in_touched_cells = |all: &[Vec3], key_bits: u32| -> f64 {
            let Grid { row_mask, columns, .. } = Grid::new(scene.bounds, radius, key_bits);
            let bucket = |c: IVec3| row_bucket(c.y, c.z, row_mask) + c.x.clamp(0, columns as i32 - 1) as u32;
            let cell = |p: Vec3| ((p - scene.bounds[0]) / radius).floor().as_ivec3();
            let mut counts: HashMap<u32, f64> = HashMap::new();
            all.iter().for_each(|p| *counts.entry(bucket(cell(*p))).or_default() += 1.0);
            let around = |center: &Vec3| -> f64 {
                let offsets = (0..27).map(|i| IVec3::new(i % 3, i / 3 % 3, i / 9) - 1);
                let touched = offsets.map(|offset| cell(*center) + offset).filter(|c| {
                    let low = scene.bounds[0] + c.as_vec3() * radius;
                    let nearest = center.clamp(low, low + radius);
                    nearest.distance(*center) < radius
                });
                let buckets: HashSet<u32> = touched.map(bucket).collect();
                buckets.iter().filter_map(|b| counts.get(b)).sum()
            };
            pixels * places.iter().map(around).sum::<f64>()
        };
        let tests = |kernel: &str| {
            let found = kernels.iter().find(|k| (k.name, k.map) == (kernel, Some("diffuse")));
            found.expect("a kernel").tests as f64
        };
        let joton_bits = shapes.diffuse.expect("a map").key_bits();
        let jotons = joton::backend::cpu::harness::stored(scene, &plan, 0, false);
        near(tests("gather"), in_touched_cells(&jotons, joton_bits), "jotons");
        let wanted = area_points_wanted(scene, plan.diffuse.radius(0), area_points_most(None));
        let (points, _) = scatter_area_points(scene, wanted, 1);
        let points: Vec<Vec3> = points.iter().map(|p| p.position).collect();
        let cut = traffic.places.iter().filter(|p| p.is_cut).count() as f64 / traffic.places.len() as f64;
        let all = in_touched_cells(&points, AREA_KEY_BITS);
        println!("{name}: {cut:.2} of the discs are cut");
        // those that are whole are not measured, but where points are too few to tell
        let told = tests("kernel_correction");
        assert!((0.5 * cut * all..2.0 * all).contains(&told), "{name}: {told} of {all}, {cut} cut");
    }
}

/// Without any device: every number is there, the total is the sum, and costs follow the work.
#[test]
fn costs_follow_the_work() {
    let of = |size: [u32; 2]| -> (f64, u64) {
        let scene = file("spheres.toml", size);
        let plan = Plan::new(&scene, Settings::default());
        let traffic = Traffic::look(&scene, &plan);
        let machine = DeviceLimits::REFERENCE;
        let shapes = expected_shapes(&scene, &plan, machine, &traffic);
        let needs = BufferPlan { scene: &scene, plan: &plan, machine, shapes, strips: Strips::whole(size) };
        let kernels = needs.kernels(&traffic);
        assert!(kernels.iter().all(|k| k.milliseconds > 0.0 && k.dispatches > 0 && k.invocations > 0));
        let bytes = needs.buffers().iter().map(|b| b.bytes).sum();
        (kernels.iter().map(|k| k.milliseconds).sum(), bytes)
    };
    let (small, large) = (of([128, 128]), of([512, 512]));
    // sixteen times the pixels; jotons grow less, and a disc holds as many
    assert!((4.0..16.0).contains(&(large.0 / small.0)), "{small:?} {large:?}");
    assert!((4.0..16.0).contains(&(large.1 as f64 / small.1 as f64)), "{small:?} {large:?}");
}

/// Bytes that a render needs in so many strips, where area points take up all that they may.
fn memory_for(backend: &GpuBackend, count: u32) -> u64 {
    let needs = BufferPlan { strips: Strips::cut(backend.needs().scene.size, count), ..backend.needs() };
    assert_eq!(needs.strips.count(), count);
    let without = |b: &&Buffer| b.name != "area_points";
    let buffers = needs.buffers();
    let bytes: u64 = buffers.iter().filter(without).map(|b| b.bytes).sum();
    if buffers.iter().all(|b| without(&b)) {
        return bytes;
    }
    // area points get an eighth, and buffers come in 16 bytes
    bytes * 8 / 7 + 64
}

/// Strips leave no trace: one and three give the same image and the same counts, bit for bit, and three need less memory,
/// no more than they were allowed. Batches of several passes, with caustics, glints, walls and neighbours across seams.
#[test]
fn strips_leave_no_trace() {
    device_or_return!();
    // two maps are both kept where there are strips: only larger images win memory by these
    let scenes = [("cornell.toml", [36, 44]), ("spheres.toml", [160, 120]), ("pool.toml", [160, 120])];
    for (scene, settings) in scenes.into_iter().flat_map(|s| [(s, Settings::default()), (s, with_map())]) {
        let (name, size) = scene;
        let scene = file(name, size);
        let mut whole = open(&scene, settings.clone());
        let allowed = memory_for(&whole, 3);
        let mut cut = open(&scene, Settings { memory: Some(allowed), ..settings });
        assert_eq!((whole.needs().strips.count(), cut.needs().strips.count()), (1, 3), "{name}");
        for (first, count) in [(0, 1), (1, 3)] {
            let [a, b] =
                [&mut whole, &mut cut].map(|b| b.render(first, count).unwrap_or_else(|e| panic!("{e}")));
            assert!(bits(&a) == bits(&b), "{name}: strips are seen in passes from {first} on");
            assert_eq!(a.tally, b.tally, "{name}");
        }
        let total = |b: &GpuBackend| b.memory().iter().map(|(_, bytes)| bytes).sum::<u64>();
        assert!(total(&cut) <= allowed && total(&cut) < total(&whole), "{name}: {}", total(&cut));
    }
}

/// Trees that crowd into a strip, more than its buffer holds, take turns: the bits are those of one strip.
#[test]
fn crowded_trees_take_turns() {
    device_or_return!();
    const SIZE: [u32; 2] = [36, 44];
    let scene = file("cornell.toml", SIZE);
    let mut whole = open(&scene, Settings::default());
    let mut cut = open(&scene, Settings { memory: Some(memory_for(&whole, 6)), ..Settings::default() });
    assert_eq!(cut.needs().strips.count(), 6);
    // as if all of the second strip saw a light in part
    let looks: Vec<Look> = (0..SIZE[0] * SIZE[1])
        .map(|pixel| {
            let is_lit = (8..16).contains(&(pixel / SIZE[0]));
            let light = if is_lit { Light::InPart } else { Light::Nowhere };
            Look { light, branched: false, square: if is_lit { 1e3 } else { 0.0 }, squared_mean: 0.0 }
        })
        .collect();
    let glints = SplitPaths::mark(SIZE, &looks, &[]);
    let strip = 8 * SIZE[0]..16 * SIZE[0];
    let trees: f32 = strip.map(|pixel| glints.trees_a_pass(pixel as usize)).sum();
    let room = cut.memory().iter().find(|(name, _)| *name == "glints").expect("a buffer").1 / 4;
    assert!(trees > room as f32, "{trees} trees, room for {room}: nothing takes turns");
    for backend in [&mut whole, &mut cut] {
        backend.set_split_paths(glints.clone()).unwrap_or_else(|e| panic!("{e}"));
    }
    for (first, count) in [(0, 1), (1, 2)] {
        let [a, b] = [&mut whole, &mut cut].map(|b| b.render(first, count).unwrap_or_else(|e| panic!("{e}")));
        assert!(bits(&a) == bits(&b), "strips are seen in passes from {first} on");
        assert_eq!(a.tally, b.tally);
    }
}

/// How a picture is made follows from the scene, its size, `--memory` and the limits of the device. What the machine has free
/// decides about nothing: a device is set up as it was planned, and too little is an error that says what to do.
#[test]
fn free_memory_decides_about_no_picture() {
    device_or_return!();
    let scene = file("cornell.toml", [40, 24]);
    let backend = open(&scene, Settings::default());
    let needs = backend.needs();
    assert_eq!(needs.plan.settings.memory, None, "the device may take what it wants");
    let planned = Plan::new(&scene, Settings::default());
    assert_eq!((needs.plan.diffuse_jotons, needs.strips.count()), (planned.diffuse_jotons, 1));

    let told = needs.buffers().iter().map(|b| b.bytes).sum::<u64>() + needs.host_bytes();
    let error = needs.check_free(Some(told / 2)).expect_err("half is too little");
    let Error::Memory { need, free } = error else { panic!("{error}") };
    assert!(need >= told && free == told / 2, "{error}");
    for word in ["--memory", "--size", &need.to_string(), &free.to_string()] {
        assert!(error.to_string().contains(word), "{error}");
    }
    assert!(needs.check_free(Some(need)).is_ok() && needs.check_free(None).is_ok());
}

/// Large images fit in strips: every buffer into the least binding that devices have, all together into what is allowed. Plans
/// of 48 megapixels, whose trees alone are more than a binding.
#[test]
fn large_images_fit() {
    for (name, size, memory) in
        [("furnace.toml", [8000, 6000], None), ("spheres.toml", [8000, 6000], Some(512 << 20))]
    {
        let scene = file(name, size);
        let mut plan = Plan::new(&scene, Settings { memory, ..Settings::default() });
        let machine = DeviceLimits::REFERENCE;
        let traffic = Traffic::look(&scene, &plan);
        let mut shapes = expected_shapes(&scene, &plan, machine, &traffic);
        let strips = fit(&scene, &mut plan, &mut shapes, machine).unwrap_or_else(|e| panic!("{name}: {e}"));
        let needs = BufferPlan { scene: &scene, plan: &plan, machine, shapes, strips };
        assert!(strips.count() > 1);
        let bound = needs.buffers().into_iter().filter(|b| b.name != "staging");
        let largest = bound.max_by_key(|b| b.bytes).expect("a buffer");
        assert!(largest.bytes <= machine.storage_binding, "{name}: {largest:?}");
        let all: u64 = needs.buffers().iter().map(|b| b.bytes).sum();
        assert!(memory.is_none_or(|most| all <= most), "{name}: {all} bytes");
    }
}

/// A render that is allowed less than it would take keeps to that and shows the same image: fewer jotons a pass, more
/// passes to the same noise. z-test in blocks over independent seeds; 4 % more light is found to differ.
#[test]
fn less_memory_shows_the_same_image() {
    device_or_return!();
    const SIZE: u32 = 32;
    let scene = file("cornell.toml", [SIZE; 2]);
    let need: u64 = open(&scene, with_map()).memory().iter().map(|(_, bytes)| bytes).sum();
    // half: the jotons of a pass take most of it at this size
    let allowed = need / 2;
    let images = |seeds: std::ops::Range<u32>, memory: Option<u64>| -> Vec<Image> {
        seeds
            .map(|seed| {
                let mut backend = open(&scene, Settings { seed, memory, ..with_map() });
                let stop = Stop { passes: Some(8), ..Stop::default() };
                let done = render(&mut backend, scene.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"));
                if memory.is_some() {
                    let total: u64 = backend.memory().iter().map(|(_, bytes)| bytes).sum();
                    assert!(total <= allowed, "{total} of {allowed} bytes");
                    assert!(
                        backend.needs().plan.diffuse_jotons < Plan::new(&scene, with_map()).diffuse_jotons
                    );
                }
                // lamps in view are noisy at their edges
                let mut image = done.picture.layers[Layer::Diffuse as usize].clone();
                let direct = &done.picture.layers[Layer::Direct as usize];
                for (sum, x) in image.pixels.iter_mut().flatten().zip(direct.pixels.iter().flatten()) {
                    *sum += x;
                }
                image
            })
            .collect()
    };
    let (less, all) = (images(0..8, Some(allowed)), images(100..108, None));
    let estimate =
        |images: &[Image], block| Estimate::from_renders(images, block).unwrap_or_else(|e| panic!("{e}"));
    let mut brighter = less.clone();
    brighter.iter_mut().flat_map(|i| i.pixels.iter_mut().flatten()).for_each(|x| *x *= 1.04);
    for block in [8, SIZE] {
        let outcome =
            test_equal(&estimate(&less, block), &estimate(&all, block)).unwrap_or_else(|e| panic!("{e}"));
        assert!(outcome.accepts(SIGNIFICANCE), "blocks of {block}: {outcome:?}");
    }
    let outcome =
        test_equal(&estimate(&brighter, SIZE), &estimate(&all, SIZE)).unwrap_or_else(|e| panic!("{e}"));
    assert!(!outcome.accepts(SIGNIFICANCE), "4 % more light is not found: {outcome:?}");
}

/// Half the jotons have the radius of a disc that holds as many.
#[test]
fn fewer_jotons_have_larger_discs() {
    // no larger than a part of the image: only large images have room for larger discs
    let scene = file("cornell.toml", [512; 2]);
    let mut plan = Plan::new(&scene, with_map());
    let held = |p: &Plan| p.diffuse.base.powi(2) * f64::from(p.diffuse_jotons);
    let (before, jotons) = (held(&plan), plan.diffuse_jotons);
    plan.halve_jotons(&scene, MapKind::Diffuse);
    assert_eq!(plan.diffuse_jotons, jotons / 2);
    assert!((held(&plan) / before - 1.0).abs() < 1e-9, "{before} {}", held(&plan));
}

/// Where even the least does not fit, need and limit are told, and what to do.
#[test]
fn too_little_memory_is_an_error() {
    device_or_return!();
    let scene = file("cornell.toml", [32; 2]);
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let plan = Plan::new(&scene, Settings { memory: Some(100_000), ..Settings::default() });
    let error = GpuBackend::new(context, scene, plan).err().expect("an error");
    let Error::Capacity { need, limit, .. } = error else { panic!("{error}") };
    assert!(limit == 100_000 && need > limit, "{error}");
    assert!(error.to_string().contains("--memory"), "{error}");
}

/// A scene in several bindings is the same scene: the image is that of a device whose bindings hold them all.
#[test]
fn a_split_heap_shows_the_same_image() {
    device_or_return!();
    let mut b = Builder::new([0., 0.5, 1.9], [0., -0.3, 0.], [0., 1., 0.], 0.6, 24);
    let (walls, ball) = (b.matte(0.7), b.material(mirror(0.8)));
    let lamp = b.material(emitter(20.0, 0.0));
    b.room([-1., -1., -1.], [1., 1., 2.], walls);
    b.quad([-0.2, 0.99, -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    b.icosphere([0., -0.5, 0.], 0.5, 6, true, ball);
    let scene = Arc::new(PackedScene::new(&b.scene));
    let mut plan = Plan::new(&scene, Settings::default());
    // few enough for small bindings, too
    plan.caustic_jotons = 4096;
    let go = |binding: Option<u64>| {
        let mut context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
        let limit = &mut context.limits.max_storage_buffer_binding_size;
        *limit = binding.unwrap_or(*limit);
        let mut backend =
            GpuBackend::new(context, Arc::clone(&scene), plan.clone()).unwrap_or_else(|e| panic!("{e}"));
        let batch = backend.render(0, 2).unwrap_or_else(|e| panic!("{e}"));
        let parts = backend.memory().iter().filter(|(name, _)| name.starts_with("heap")).count();
        let largest = backend.memory().into_iter().filter(|(name, _)| *name != "staging").map(|b| b.1).max();
        (batch, parts, largest.unwrap_or(0))
    };
    // 81,932 triangles of 48 bytes, their normals, and the hierarchy: six parts of at most 2^20 bytes
    const BINDING: u64 = 1_600_000;
    let ((whole, one, _), (split, parts, largest)) = (go(None), go(Some(BINDING)));
    assert_eq!((one, parts), (1, 8));
    assert!(largest <= BINDING, "{largest}");
    assert!(bits(&whole) == bits(&split), "split triangles are seen");
    assert_eq!(whole.tally, split.tally);
}

fn bits(b: &Batch) -> Vec<u32> {
    b.layers.iter().flatten().flatten().map(|x| x.to_bits()).collect()
}
