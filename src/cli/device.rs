//! Which device a command runs on: `--device auto|gpu|cpu|NAME`.

use joton::backend::Backend;
use joton::cpu::{CpuBackend, PathTracer};
use joton::gpu::{Context, GpuBackend};
use joton::pack::PackedScene;
use joton::plan::Plan;
use joton::{Error, Result};
use std::sync::Arc;

/// A device, one line that says which it is, and the plan as the device could keep it.
type Opened = (Box<dyn Backend>, String, Plan);

/// Open the device that `--device` names and set it up for a scene.
pub(super) fn open(device: &str, reference: bool, scene: &Arc<PackedScene>, plan: Plan) -> Result<Opened> {
    if reference && device != "cpu" {
        return Err(Error::usage("--reference is the path tracer on the CPU", "add --device cpu"));
    }
    match device {
        "cpu" => Ok(cpu(reference, scene, plan)),
        "gpu" => gpu(None, scene, &plan),
        "auto" => gpu(None, scene, &plan).or_else(|e| {
            if let Error::Memory { .. } = e {
                // what is free decides about no picture
                return Err(e);
            }
            let (backend, line, plan) = cpu(false, scene, plan);
            Ok((backend, format!("{line}, because the GPU cannot be used: {e}"), plan))
        }),
        name => gpu(Some(name), scene, &plan),
    }
}

fn gpu(name: Option<&str>, scene: &Arc<PackedScene>, wanted: &Plan) -> Result<Opened> {
    let backend = GpuBackend::new(Context::open(name)?, Arc::clone(scene), wanted.clone())?;
    let (strips, plan) = (backend.needs().strips.count(), backend.needs().plan.clone());
    let mut line = backend.describe();
    if strips > 1 {
        line += &format!(", {strips} strips of the image after each other");
    }
    let jotons = |p: &Plan| p.caustic_jotons + p.diffuse_jotons;
    if jotons(&plan) < jotons(wanted) {
        line += &format!(", {} jotons a pass instead of {}", jotons(&plan), jotons(wanted));
    }
    Ok((Box::new(backend), line, plan))
}

fn cpu(reference: bool, scene: &Arc<PackedScene>, plan: Plan) -> Opened {
    let (scene, own) = (Arc::clone(scene), plan.clone());
    let backend: Box<dyn Backend> =
        if reference { Box::new(PathTracer::new(scene, own)) } else { Box::new(CpuBackend::new(scene, own)) };
    let line = backend.describe();
    (backend, line, plan)
}
