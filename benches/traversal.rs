//! Rays a second through the hierarchy on one thread: a box of 38 triangles and a sphere of 200,000.
//!
//! `cargo bench --bench traversal`

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use joton::bvh::{Bvh, Edges};
use joton::pack::PackedScene;
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// Rays of a measurement: enough to cover a scene, few enough to take milliseconds.
const RAYS: u32 = 4096;
/// Edges of the icosahedron are cut into this many: 20 · 100² = 200,000 triangles.
const FREQUENCY: u32 = 100;

/// A triangle by its corners.
struct Corners([Vec3; 3]);

impl Edges for Corners {
    fn edges(&self) -> [Vec3; 3] {
        let [a, b, c] = self.0;
        [a, b - a, c - a]
    }
}

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

/// Rays from random points in a box to random points in it.
fn rays([lo, hi]: [Vec3; 2]) -> Vec<[Vec3; 2]> {
    let point = |i: u32, which: u32| {
        let [x, y, z, _] = joton::rng::random4(1, 0, i, which);
        lo + (hi - lo) * Vec3::new(x, y, z)
    };
    (0..RAYS).map(|i| [point(i, 0), point(i, 1)]).collect()
}

fn traversal(c: &mut Criterion) {
    let mut group = c.benchmark_group("traversal");
    group.throughput(Throughput::Elements(u64::from(RAYS)));
    group.sample_size(20).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(2));

    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let scene = PackedScene::new(&joton::scene::load(&file).expect("the scene"));
    measure(&mut group, "cornell", &scene.bvh, &scene.triangles, &rays(scene.bounds));

    let vertices = icosphere();
    assert_eq!(vertices.len(), 200_000);
    let (bvh, order) = Bvh::build(&vertices);
    let triangles: Vec<Corners> = order.iter().map(|&i| Corners(vertices[i as usize])).collect();
    measure(&mut group, "icosphere 200k", &bvh, &triangles, &rays([Vec3::splat(-1.0), Vec3::ONE]));
    group.finish();
}

fn measure<T: Edges>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    scene: &str,
    bvh: &Bvh,
    triangles: &[T],
    rays: &[[Vec3; 2]],
) {
    group.bench_function(format!("closest, {scene}"), |b| {
        b.iter(|| {
            let hit = |[from, to]: &[Vec3; 2]| {
                bvh.closest(triangles, *from, (to - from).normalize(), f32::INFINITY).is_some()
            };
            black_box(rays.iter().filter(|r| hit(r)).count())
        });
    });
    group.bench_function(format!("occluded, {scene}"), |b| {
        b.iter(|| {
            let hit = |[from, to]: &[Vec3; 2]| {
                bvh.occluded(triangles, *from, (to - from).normalize(), from.distance(*to))
            };
            black_box(rays.iter().filter(|r| hit(r)).count())
        });
    });
}

criterion_group!(benches, traversal);
criterion_main!(benches);
