//! Rendering with and without skips.

use joton::backend::Backend;
use joton::bands::BANDS;
use joton::cpu::{CpuBackend, PathTracer};
use joton::film::{Image, Layer, Picture};
use joton::gpu::{Context, GpuBackend};
use joton::pack::PackedScene;
use joton::paths::LightPaths;
use joton::plan::{Part, Plan, Settings};
use joton::render::{Rendered, Stop, render};
use joton::scene::Scene;
use joton::stats::{Estimate, test_equal};
use std::sync::Arc;

/// Scenes of the repository.
pub const SCENES: [&str; 7] = ["cornell", "furnace", "pedestal", "pool", "ring", "rooms", "spheres"];

/// Who renders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The photon mapper on threads.
    Host,
    /// The photon mapper on a device.
    Device,
    /// The path tracer.
    PathTracer,
}

/// The photon mapper on threads and, where there is one, on a device.
pub fn both() -> Vec<Side> {
    let device = crate::common::device().map(|_| Side::Device);
    [Side::Host].into_iter().chain(device).collect()
}

/// A packed scene with some parts kept.
pub fn packed(scene: &Scene, keep: &[Part]) -> Arc<PackedScene> {
    let whole = keep.contains(&Part::OutOfReach);
    Arc::new(if whole { PackedScene::whole(scene) } else { PackedScene::new(scene) })
}

/// The plan of a packed scene with some parts kept.
pub fn plan(scene: &PackedScene, paths: &str, seed: u32, keep: &[Part]) -> Plan {
    let paths = LightPaths::parse(paths).unwrap_or_else(|e| panic!("{e}"));
    Plan::new(scene, Settings { seed, paths, keep: keep.to_vec(), ..Settings::default() })
}

/// Render so many passes: all finite.
pub fn run(side: Side, scene: &Arc<PackedScene>, plan: Plan, passes: u64) -> Rendered {
    let shared = Arc::clone(scene);
    let mut backend: Box<dyn Backend> = match side {
        Side::Host => Box::new(CpuBackend::new(shared, plan)),
        Side::PathTracer => Box::new(PathTracer::new(shared, plan)),
        Side::Device => {
            let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
            Box::new(GpuBackend::new(context, shared, plan).unwrap_or_else(|e| panic!("{e}")))
        }
    };
    let stop = Stop { passes: Some(passes), ..Stop::default() };
    let rendered = render(backend.as_mut(), scene.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(rendered.tally.non_finite.total(), 0, "{side:?}: {:?}", rendered.tally.non_finite);
    rendered
}

/// The bits of all layers.
pub fn bits(picture: &Picture) -> Vec<[u32; BANDS]> {
    picture.layers.iter().flat_map(|l| &l.pixels).map(|p| p.map(f32::to_bits)).collect()
}

/// Chance that one comparison of equal images fails, over random seeds.
pub const SIGNIFICANCE: f64 = 1e-4;

/// Assert that two sets of pictures have the same mean in every layer, by blocks of so many pixels across.
pub fn is_alike(name: &str, a: &[Picture], b: &[Picture], blocks: &[u32]) {
    for layer in Layer::ALL {
        for &block in blocks {
            let [x, y] = [a, b].map(|pictures| {
                let images: Vec<Image> = pictures.iter().map(|p| p.layers[layer as usize].clone()).collect();
                Estimate::from_renders(&images, block).unwrap_or_else(|e| panic!("{e}"))
            });
            let outcome = test_equal(&x, &y).unwrap_or_else(|e| panic!("{e}"));
            println!("{name}, {}, blocks of {block}: p = {:.2e}", layer.name(), outcome.p_value);
            assert!(
                outcome.accepts(SIGNIFICANCE),
                "{name}, {}, blocks of {block}: {outcome:?}",
                layer.name()
            );
        }
    }
}

/// True where a layer holds no light at all.
pub fn is_black(picture: &Picture, layer: Layer) -> bool {
    picture.layers[layer as usize].pixels.iter().flatten().all(|x| *x == 0.0)
}
