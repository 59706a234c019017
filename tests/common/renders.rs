//! Rendering a scene on each side.

use joton::backend::Backend;
use joton::backend::cpu::{CpuBackend, PathTracer};
use joton::backend::gpu::GpuBackend;
use joton::film::paths::LightPaths;
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Settings};
use joton::render::{Rendered, Stop, render};
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

/// The plan of a packed scene with some parts kept.
pub fn plan_keeping(scene: &PackedScene, paths: &str, seed: u32, keep: &[Part]) -> Plan {
    let paths = LightPaths::parse(paths).unwrap_or_else(|e| panic!("{e}"));
    Plan::new(scene, Settings { seed, paths, keep: keep.to_vec(), ..Settings::default() })
}

/// A plan whose pictures are the bare means of its passes: what neighbours share is no independent sample, and a little biased.
pub fn unresolved(plan: Plan) -> Plan {
    Plan { resolves: false, ..plan }
}

/// A backend that renders a plan.
pub fn open(side: Side, scene: &Arc<PackedScene>, plan: Plan) -> Box<dyn Backend> {
    let scene = Arc::clone(scene);
    match side {
        Side::Host => Box::new(CpuBackend::new(scene, plan)),
        Side::PathTracer => Box::new(PathTracer::new(scene, plan)),
        Side::Device => {
            // one device for all: what is compiled for one test is there for the next
            let context = super::device().expect("a device").clone();
            Box::new(GpuBackend::new(context, scene, plan).unwrap_or_else(|e| panic!("{e}")))
        }
    }
}

/// Render so many passes: all finite.
pub fn run(side: Side, scene: &Arc<PackedScene>, plan: Plan, passes: u64) -> Rendered {
    let stop = Stop { passes: Some(passes), ..Stop::default() };
    let mut backend = open(side, scene, plan);
    let rendered = render(backend.as_mut(), scene.size, stop, |_| true).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(rendered.tally.non_finite.total(), 0, "{side:?}: {:?}", rendered.tally.non_finite);
    rendered
}
