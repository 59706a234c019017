//! Rendering a scene on each side, with as many seeds as a test asks for.

use joton::backend::Backend;
use joton::cpu::{CpuBackend, PathTracer};
use joton::film::{Image, Layer, Picture};
use joton::gpu::{Context, GpuBackend};
use joton::pack::PackedScene;
use joton::paths::LightPaths;
use joton::plan::{Plan, Settings};
use joton::render::{Rendered, Stop, render};
use joton::scene::Scene;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

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

/// Every path from a light to the eye.
pub const EVERYTHING: &str = "L.*E";

/// One of the scenes of the repository at `size` × `size` pixels.
pub fn file(name: &str, size: u32) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    scene.resize([size; 2]);
    scene
}

/// The plan of a packed scene.
pub fn plan(scene: &PackedScene, paths: &str, seed: u32) -> Plan {
    let paths = LightPaths::parse(paths).unwrap_or_else(|e| panic!("{e}"));
    Plan::new(scene, Settings { seed, paths, ..Settings::default() })
}

/// A backend that renders a plan.
pub fn open(side: Side, scene: &Arc<PackedScene>, plan: Plan) -> Box<dyn Backend> {
    let scene = Arc::clone(scene);
    match side {
        Side::Host => Box::new(CpuBackend::new(scene, plan)),
        Side::PathTracer => Box::new(PathTracer::new(scene, plan)),
        Side::Device => {
            let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
            Box::new(GpuBackend::new(context, scene, plan).unwrap_or_else(|e| panic!("{e}")))
        }
    }
}

/// Render so many passes.
pub fn run(side: Side, scene: &Arc<PackedScene>, plan: Plan, passes: u64) -> Rendered {
    let stop = Stop { passes: Some(passes), ..Stop::default() };
    let mut backend = open(side, scene, plan);
    let rendered = render(backend.as_mut(), scene.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(rendered.tally.non_finite.total(), 0, "{side:?}: {:?}", rendered.tally.non_finite);
    rendered
}

/// Independent renders of a plan that `adjust` may change.
pub fn pictures(
    side: Side,
    scene: &Arc<PackedScene>,
    paths: &str,
    seeds: Range<u32>,
    passes: u64,
    adjust: impl Fn(&mut Plan),
) -> Vec<Picture> {
    // seeds of the sides are never the same
    let first = crate::chi_square::seed() * 10_000 + side as u32 * 1000;
    let render = |s| {
        let mut plan = plan(scene, paths, first + s);
        adjust(&mut plan);
        run(side, scene, plan, passes).picture
    };
    seeds.map(render).collect()
}

/// One layer of each picture.
pub fn layer(pictures: &[Picture], layer: Layer) -> Vec<Image> {
    pictures.iter().map(|p| p.layers[layer as usize].clone()).collect()
}
