//! trace.wgsl: every joton is traced to its end, in however many dispatches and lanes; no flux is lost or made.

use crate::common::scenes::{Builder, emitter, glass, mirror};
use crate::common::{kernel, map_info, pass_info, path_filter};
use crate::device_or_return;
use bytemuck::Zeroable;
use joton::backend::gpu::harness::{Harness, Work};
use joton::backend::gpu::{Context, Kernel, Variant, link_source};
use joton::packed::PackedScene;
use joton::packed::constants::STEP_BUDGET;
use joton::packed::layout::{Joton, LaneTally, PathState};
use joton::plan::{Plan, Settings};
use joton::sampling::rng::seed_at;
use joton::scene::Material;

const DONE: u32 = 256;

/// What a map's emission left behind.
struct Traced {
    /// Stored jotons as words, in no order that means anything.
    jotons: Vec<[u32; 8]>,
    emitted: [f64; 3],
    absorbed: [f64; 3],
    escaped: [f64; 3],
    started: u64,
    rays: u64,
    dispatches: u32,
}

impl Traced {
    /// Jotons in an order of their own: by their words.
    fn sorted(&self) -> Vec<[u32; 8]> {
        let mut all = self.jotons.clone();
        all.sort_unstable();
        all
    }
}

fn trace(context: &Context, scene: &PackedScene, caustic: bool, emitted: u32, lanes: u32) -> Traced {
    let plan = Plan::new(scene, Settings::default());
    let f = &plan.features;
    let flag = |on: bool| if on { 1.0 } else { 0.0 };
    let trace = kernel(
        context,
        "passes/trace.wgsl",
        "main",
        &[
            ("CAUSTIC", flag(caustic)),
            ("HAS_SMOOTH", flag(f.smooth_normals)),
            ("HAS_SPECULAR", flag(f.specular)),
            ("HAS_DIELECTRIC", flag(f.dielectric)),
            ("HAS_GLOSSY", flag(f.glossy)),
            ("HAS_PATH_FILTER", 0.0),
        ],
    );
    let mut harness = Harness::with_scene(context, scene, &plan).unwrap_or_else(|e| panic!("{e}"));
    harness.uniform("path_filter", &path_filter("L.*E"));
    let mut pass = pass_info();
    pass.seed = 3;
    pass.emitters = scene.emitters.len() as u32;
    pass.targets = scene.targets.len() as u32;
    let mut map = map_info();
    (map.seed, map.seed_wrapped) = (seed_at(pass.seed, 0), seed_at(pass.seed, 1));
    map.emitted = emitted;
    map.lanes = lanes;
    // albedo 0.9 stores nine times on average, and now and then far more
    map.lane_capacity = 20 * emitted.div_ceil(lanes) + 100;
    harness.storage("lanes", &vec![PathState::zeroed(); lanes as usize]);
    harness.storage("jotons", &vec![Joton::zeroed(); (lanes * map.lane_capacity) as usize]);
    harness.storage("tallies", &vec![LaneTally::zeroed(); lanes as usize]);
    let at: [(&str, &[u8]); 2] =
        [("pass_info", bytemuck::bytes_of(&pass)), ("map_info", bytemuck::bytes_of(&map))];
    let mut dispatches = 0;
    let states: Vec<PathState> = loop {
        harness.run(&trace, &[], &at, Work::Invocations(lanes)).unwrap_or_else(|e| panic!("{e}"));
        dispatches += 1;
        let lanes: Vec<PathState> = harness.read("lanes").unwrap_or_else(|e| panic!("{e}"));
        if lanes.iter().all(|l| l.status & DONE != 0) {
            break lanes;
        }
        assert!(dispatches < 10_000, "lanes do not end");
    };
    let stored: Vec<[u32; 8]> = harness.read("jotons").unwrap_or_else(|e| panic!("{e}"));
    let tallies: Vec<LaneTally> = harness.read("tallies").unwrap_or_else(|e| panic!("{e}"));
    let mut t = Traced {
        jotons: Vec::new(),
        emitted: [0.0; 3],
        absorbed: [0.0; 3],
        escaped: [0.0; 3],
        started: 0,
        rays: 0,
        dispatches,
    };
    for ((lane, tally), region) in states.iter().zip(&tallies).zip(stored.chunks(map.lane_capacity as usize))
    {
        assert!(lane.stored <= map.lane_capacity, "a lane wants to store {}", lane.stored);
        assert_eq!(lane.stored, tally.stored);
        t.jotons.extend(&region[..lane.stored as usize]);
        t.started += u64::from(lane.started);
        t.rays += u64::from(tally.rays);
        for b in 0..3 {
            t.emitted[b] += f64::from(tally.emitted[b]);
            t.absorbed[b] += f64::from(tally.absorbed[b]);
            t.escaped[b] += f64::from(tally.escaped[b]);
        }
    }
    t
}

/// A closed room of many triangles: rays are long in loop iterations.
fn room(reflectance: f32, levels: u32) -> PackedScene {
    let mut b = Builder::new([0., 0., 0.9], [0.; 3], [0., 1., 0.], 0.5, 16);
    let walls = b.matte(reflectance);
    let lamp = b.material(emitter(3.0, reflectance));
    let g = b.material(glass(1.5));
    let m = b.material(mirror(0.9));
    b.room([-1.; 3], [1.; 3], walls);
    b.quad([-0.3, 0.99, -0.3], [0.6, 0., 0.], [0., 0., 0.6], lamp);
    b.icosphere([-0.4, -0.4, 0.], 0.4, levels, true, g);
    b.icosphere([0.5, -0.5, 0.2], 0.3, levels, true, m);
    PackedScene::new(&b.scene)
}

/// One joton to a lane, or 512: the same jotons are stored, bit for bit. A driver that ends loops early loses some in the
/// second case; so would work that is put away wrongly.
#[test]
fn jotons_do_not_depend_on_lanes_and_dispatches() {
    let context = device_or_return!();
    let scene = room(0.8, 4);
    for caustic in [false, true] {
        let emitted = 64 * 128 + 5;
        let short = trace(context, &scene, caustic, emitted, emitted);
        let long = trace(context, &scene, caustic, emitted, 64);
        assert!(long.dispatches > 2 * short.dispatches, "{} dispatches are no test", long.dispatches);
        for t in [&short, &long] {
            assert_eq!(t.started, u64::from(emitted), "jotons that were started");
        }
        assert_eq!(short.rays, long.rays);
        assert!(short.jotons.len() > 1000);
        assert!(short.sorted() == long.sorted(), "caustic {caustic}: other jotons in other lanes");
        for b in 0..3 {
            assert!((short.emitted[b] / long.emitted[b] - 1.0).abs() < 1e-5, "emitted {b}");
            assert!((short.absorbed[b] / long.absorbed[b] - 1.0).abs() < 1e-4, "absorbed {b}");
        }
        // every joton of the diffuse map carries total / emitted: nothing is lost but by rounding of f32 sums
        if !caustic {
            assert!((long.emitted[0] / scene.total_flux[0] - 1.0).abs() < 1e-5);
        }
    }
}

/// In a closed room all flux is absorbed in the end, in every band, whatever lobes dip below the surface; in an open one it
/// is absorbed or escapes. 2^16 jotons of standard deviation about one: 4 standard errors are 1.5 %.
#[test]
fn closed_rooms_absorb_what_is_emitted() {
    let context = device_or_return!();
    let flat = |build: &dyn Fn(&mut Builder)| {
        let mut b = Builder::new([0., 0., 0.9], [0.; 3], [0., 1., 0.], 0.5, 16);
        build(&mut b);
        b.point_light([0.1, 0.2, 0.3], 1.0);
        PackedScene::new(&b.scene)
    };
    let coloured = flat(&|b| {
        // chances of red matte, green gloss and blue mirror together are over two
        let m = b.material(Material {
            glossy: [0.05, 0.8, 0.05],
            glossy_exponent: 10.0,
            specular: [0.05, 0.05, 0.8],
            ..Material::matte("lobes", [0.8, 0.05, 0.05])
        });
        b.room([-1.; 3], [1.; 3], m);
    });
    let mirrors = flat(&|b| {
        let m = b.material(mirror(0.8));
        let d = b.matte(0.5);
        b.room([-1.; 3], [1.; 3], m);
        b.quad([-0.5, -0.9, -0.5], [0., 0., 1.], [1., 0., 0.], d);
    });
    let open = flat(&|b| {
        let d = b.matte(0.7);
        b.quad([-0.5, -0.9, -0.5], [0., 0., 1.], [1., 0., 0.], d);
    });
    for (name, scene, closed) in [
        ("albedo 0.9 with glass", &room(0.9, 1), true),
        ("coloured lobes", &coloured, true),
        ("mirrors", &mirrors, true),
        ("an open floor", &open, false),
    ] {
        let t = trace(context, scene, false, 1 << 16, 1 << 13);
        for b in 0..3 {
            assert!((t.emitted[b] / scene.total_flux[b] - 1.0).abs() < 1e-4, "{name}: emitted in band {b}");
            let (absorbed, escaped) = (t.absorbed[b] / t.emitted[b], t.escaped[b] / t.emitted[b]);
            assert_eq!(closed, escaped == 0.0, "{name}: {escaped} escaped from band {b}");
            assert!((absorbed + escaped - 1.0).abs() < LOSS, "{name}, band {b}: {absorbed} + {escaped}");
        }
    }
}

/// See [`closed_rooms_absorb_what_is_emitted`].
const LOSS: f64 = 0.015;

/// Past the capture of a test's output.
fn tell(line: &str) {
    use std::io::Write;
    writeln!(std::io::stderr(), "{line}").ok();
}

/// Whether this driver ends long loops: told, not judged. What counts is that joton's own loops stay below.
#[test]
fn loops_of_this_driver() {
    let context = device_or_return!();
    const ROUNDS: u32 = 200_000;
    let text = "@group(0) @binding(0) var<storage, read_write> rounds: array<u32>;
        @compute @workgroup_size(64)
        fn main(@builtin(global_invocation_id) id: vec3<u32>) {
            var i = 0u;
            var x = id.x;
            while i < rounds[64] { x = x * 1664525u + 1013904223u; i += 1u; }
            rounds[id.x] = i + (x & 0u);
        }";
    let linked = link_source(text, Variant::default()).unwrap_or_else(|e| panic!("{e}"));
    let k = Kernel::from_source(context, "canary", &linked, "main", &[]).unwrap_or_else(|e| panic!("{e}"));
    let run = |rounds: u32| -> u32 {
        let mut harness = Harness::new(context);
        let mut all = vec![0u32; 64];
        all.push(rounds);
        harness.storage("rounds", &all);
        harness.run(&k, &[], &[], Work::Invocations(64)).unwrap_or_else(|e| panic!("{e}"));
        let found: Vec<u32> = harness.read("rounds").unwrap_or_else(|e| panic!("{e}"));
        found[0]
    };
    let done = run(ROUNDS);
    if done == ROUNDS {
        tell(&format!("{}: loops run to their end ({ROUNDS} rounds)", context.info.name));
    } else {
        tell(&format!("{}: loops are ended after {done} of {ROUNDS} rounds", context.info.name));
    }
    // a lane's budget is counted for each invocation; the driver counts the union of up to 16 that run together
    let union = STEP_BUDGET * 16;
    assert_eq!(run(union), union, "the step budget is over what this driver runs");
}
