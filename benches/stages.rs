//! The stages of a pass on the GPU, by its own timestamps: eye, direct, trace (emission and traversal), sort, boundary,
//! gather.
//!
//! `cargo bench --bench stages`. Left out, and says so, where there is no device or it has no timestamps.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use joton::backend::Backend;
use joton::backend::gpu::{Context, GpuBackend};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// Small enough for a pass to take milliseconds on a slow machine.
const SIZE: [u32; 2] = [128, 128];
/// Passes in one batch: a batch is read back once.
const BATCH: u32 = 4;

/// A stage and how the names of its kernels begin.
const STAGES: [(&str, &[&str]); 6] = [
    ("eye", &["eye", "glint"]),
    ("direct", &["direct"]),
    ("trace", &["trace"]),
    ("sort", &["lane_counts", "scan", "map_", "radix"]),
    ("boundary", &["boundary"]),
    ("gather", &["gather"]),
];

fn stages(c: &mut Criterion) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/ring.toml");
    let mut scene = joton::scene::load(&file).expect("the scene");
    scene.resize(SIZE);
    let scene = Arc::new(PackedScene::new(&scene));
    let plan = Plan::new(&scene, Settings::default());
    let jotons = u64::from(plan.caustic_jotons + plan.diffuse_jotons);
    let mut backend = match Context::open(None).and_then(|c| GpuBackend::new(c, Arc::clone(&scene), plan)) {
        Ok(backend) => backend,
        Err(e) => return eprintln!("stages: left out, {e}"),
    };
    backend.measure_kernels().expect("room for times");
    backend.render(0, 1).expect("a pass");
    if backend.kernel_seconds().is_empty() {
        return eprintln!("stages: left out, {} has no timestamps", backend.describe());
    }
    let mut group = c.benchmark_group("stages");
    group.sample_size(10).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(2));
    let mut pass = 1;
    for (stage, kernels) in STAGES {
        let seconds = |backend: &GpuBackend| -> f64 {
            let of_stage = |name: &str| kernels.iter().any(|k| name.starts_with(k));
            backend.kernel_seconds().iter().filter(|k| of_stage(&k.0)).map(|k| k.1).sum()
        };
        let per_joton = matches!(stage, "trace" | "sort");
        group.throughput(Throughput::Elements(if per_joton { jotons } else { scene.pixels() as u64 }));
        group.bench_function(stage, |b| {
            b.iter_custom(|count| {
                let before = seconds(&backend);
                let mut left = count;
                while left > 0 {
                    let batch = left.min(u64::from(BATCH));
                    backend.render(pass, batch as u32).expect("passes");
                    pass += batch;
                    left -= batch;
                }
                // a timer so coarse that it saw nothing must not divide by zero
                Duration::from_secs_f64((seconds(&backend) - before).max(1e-9))
            });
        });
    }
    group.finish();
}

criterion_group!(benches, stages);
criterion_main!(benches);
