//! Rays a second through the hierarchy, on all threads of the host and on the device: a box of 38 triangles and a sphere of
//! 200,000. On a software device the host's figure is the floor of the device's: the same cores, without WGSL between.
//!
//! `cargo bench --bench traversal`. The device is left out, and that is said, where there is none.

#[path = "../tests/common/scenes.rs"]
#[allow(dead_code, reason = "shared with the tests, which use all of it")]
mod scenes;

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use joton::backend::gpu::harness::{Harness, Work, is_small};
use joton::backend::gpu::{Context, Kernel, Variant, link_source};
use joton::packed::PackedScene;
use joton::packed::layout::PassInfo;
use joton::plan::{Plan, Settings};
use rayon::prelude::*;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// Rays of a measurement: enough to keep a device busy, few enough to take a fraction of a second on two cores.
const RAYS: u32 = 1 << 17;
/// Edges of the icosahedron are cut into this many: 20 · 100² = 200,000 triangles.
const FREQUENCY: u32 = 100;

/// A geodesic sphere of radius 1: the faces of an icosahedron, each cut into FREQUENCY² triangles.
fn icosphere() -> Vec<[Vec3; 3]> {
    let g = 0.5 + 1.25f32.sqrt();
    // the corners in cyclic order of their coordinates: (0, ±1, ±g), (±g, 0, ±1), (±1, ±g, 0)
    let mut corners = Vec::new();
    for turn in 0..3 {
        for (s, t) in [(1.0, g), (1.0, -g), (-1.0, g), (-1.0, -g)] {
            let mut at = [0.0, s, t];
            at.rotate_right(turn);
            corners.push(Vec3::from(at));
        }
    }
    let near = |a: Vec3, b: Vec3| (a.distance(b) - 2.0).abs() < 1e-3;
    let mut triangles = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                if near(a, b) && near(b, c) && near(a, c) {
                    subdivide([a, b, c], &mut triangles);
                }
            }
        }
    }
    triangles
}

fn subdivide([a, b, c]: [Vec3; 3], triangles: &mut Vec<[Vec3; 3]>) {
    let n = FREQUENCY as f32;
    let at = |i: u32, j: u32| (a + (b - a) * (i as f32 / n) + (c - a) * (j as f32 / n)).normalize();
    for i in 0..FREQUENCY {
        for j in 0..FREQUENCY - i {
            triangles.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
            if i + j + 2 <= FREQUENCY {
                triangles.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }
}

/// Rays from random points in a box to random points in it: origin and unit direction.
fn rays([lo, hi]: [Vec3; 2]) -> Vec<[Vec3; 2]> {
    let point = |i: u32, which: u32| {
        let [x, y, z, _] = joton::sampling::rng::random4(1, 0, i, which);
        lo + (hi - lo) * Vec3::new(x, y, z)
    };
    (0..RAYS).map(|i| [point(i, 0), (point(i, 1) - point(i, 0)).normalize()]).collect()
}

fn traversal(c: &mut Criterion) {
    let mut group = c.benchmark_group("traversal");
    group.throughput(Throughput::Elements(u64::from(RAYS)));
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));
    let context = Context::open(None);
    if let Err(e) = &context {
        eprintln!("traversal: the device is left out, {e}");
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let cornell = PackedScene::new(&joton::scene::load(&file).expect("the scene"));
    let mut sphere = scenes::Builder::new([0.; 3], [0., 0., 1.], [0., 1., 0.], 1.0, 1);
    let material = sphere.matte(0.5);
    let triangles = icosphere();
    assert_eq!(triangles.len(), 200_000);
    for corners in triangles {
        sphere.triangle(corners.map(|v| v.as_dvec3()), material);
    }
    for (name, scene) in [("cornell", &cornell), ("icosphere 200k", &PackedScene::new(&sphere.scene))] {
        let rays = rays(scene.bounds);
        group.bench_function(format!("host, closest, {name}"), |b| {
            b.iter(|| {
                let hit = |[o, d]: &[Vec3; 2]| scene.bvh.closest(&scene.triangles, *o, *d, f32::INFINITY);
                black_box(rays.par_iter().filter(|r| hit(r).is_some()).count())
            });
        });
        group.bench_function(format!("host, occluded, {name}"), |b| {
            b.iter(|| {
                let hit = |[o, d]: &[Vec3; 2]| scene.bvh.occluded(&scene.triangles, *o, *d, 1e3);
                black_box(rays.par_iter().filter(|r| hit(r)).count())
            });
        });
        if let Ok(context) = &context {
            on_device(&mut group, context, name, scene, &rays).unwrap_or_else(|e| panic!("{e}"));
        }
    }
    group.finish();
}

/// The nearest hits by the kernels' traversal, the scene bound as a render binds it.
fn on_device(
    group: &mut BenchmarkGroup<'_, WallTime>,
    context: &Context,
    name: &str,
    scene: &PackedScene,
    rays: &[[Vec3; 2]],
) -> joton::Result<()> {
    let variant = Variant { small_scene: is_small(context, scene), ..Variant::default() };
    let text = "// import: accel/intersect.wgsl
// import: scene/features.wgsl
// import: dispatch/index.wgsl
         @group(1) @binding(0) var<storage, read> rays: array<vec4<f32>>;
         @group(1) @binding(1) var<storage, read_write> hits: array<u32>;
         @compute @workgroup_size(64)
         fn main(@builtin(global_invocation_id) id: vec3<u32>, @builtin(num_workgroups) groups: vec3<u32>) {
             let i = linear_index(id, groups);
             if i < arrayLength(&hits) {
                 hits[i] = traverse(rays[2u * i].xyz, rays[2u * i + 1u].xyz, 1e30, false).triangle;
             }
         }";
    let kernel = Kernel::from_source(context, "traversal", &link_source(text, variant)?, "main", &[])?;
    let mut harness = Harness::with_scene(context, scene, &Plan::new(scene, Settings::default()))?;
    let words: Vec<[f32; 4]> = rays.iter().flatten().map(|v| [v.x, v.y, v.z, 0.0]).collect();
    harness.storage("rays", &words);
    harness.storage("hits", &vec![0u32; rays.len()]);
    let pass: PassInfo = bytemuck::Zeroable::zeroed();
    let mut run = || {
        let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
        harness.run(&kernel, &[], &at, Work::Invocations(RAYS)).unwrap_or_else(|e| panic!("{e}"));
    };
    group.bench_function(format!("device, closest, {name}"), |b| b.iter(&mut run));
    // what was measured is what the host finds
    let hits: Vec<u32> = harness.read("hits")?;
    let found =
        rays.iter().map(|[o, d]| scene.bvh.closest(&scene.triangles, *o, *d, f32::INFINITY).is_some());
    let other = hits.iter().zip(found).filter(|&(&hit, host)| (hit != u32::MAX) != host).count();
    assert!(other * 10_000 < rays.len(), "{other} rays of {} hit on one side only", rays.len());
    Ok(())
}

criterion_group!(benches, traversal);
criterion_main!(benches);
