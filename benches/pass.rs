//! Whole passes, as jotons a second, on the CPU, the path tracer (as pixels a second) and the GPU.
//!
//! `cargo bench --bench pass`. Where there is no GPU nor software Vulkan, that part is left out and says so.

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use joton::backend::Backend;
use joton::backend::cpu::{CpuBackend, PathTracer};
use joton::backend::gpu::{Context, GpuBackend};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Small enough for a pass to take milliseconds on a slow machine.
const SIZE: [u32; 2] = [128, 128];
/// One scene without and one with caustics.
const SCENES: [&str; 2] = ["cornell", "ring"];

fn load(name: &str) -> (Arc<PackedScene>, Plan) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
    let mut scene = joton::scene::load(&file).expect("the scene");
    scene.resize(SIZE);
    let packed = Arc::new(PackedScene::new(&scene));
    let plan = Plan::new(&packed, Settings::default());
    (packed, plan)
}

fn passes(c: &mut Criterion) {
    let mut group = c.benchmark_group("pass");
    group.sample_size(10).warm_up_time(Duration::from_millis(500)).measurement_time(Duration::from_secs(3));
    for name in SCENES {
        let (scene, plan) = load(name);
        group.throughput(Throughput::Elements(u64::from(plan.caustic_jotons + plan.diffuse_jotons)));
        measure(&mut group, &format!("cpu, {name}"), &mut CpuBackend::new(Arc::clone(&scene), plan.clone()));
        match Context::open(None).and_then(|c| GpuBackend::new(c, Arc::clone(&scene), plan.clone())) {
            Ok(mut backend) => measure(&mut group, &format!("gpu, {name}"), &mut backend),
            Err(e) => eprintln!("gpu, {name}: left out, {e}"),
        }
        group.throughput(Throughput::Elements(scene.pixels() as u64));
        measure(&mut group, &format!("path tracer, {name}"), &mut PathTracer::new(scene, plan));
    }
    group.finish();
}

/// Pass after pass, each with its own number: as in a render, the radii shrink and the area points are renewed.
fn measure(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, backend: &mut dyn Backend) {
    let mut pass = 0;
    group.bench_function(name, |b| {
        b.iter(|| {
            backend.render(pass, 1).expect("a pass");
            pass += 1;
        });
    });
}

criterion_group!(benches, passes);
criterion_main!(benches);
