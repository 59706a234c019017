//! Which device a command runs on: `--device auto|gpu|cpu|NAME`.

use joton::backend::Backend;
use joton::cpu::{CpuBackend, PathTracer};
use joton::gpu::{Context, GpuBackend};
use joton::pack::PackedScene;
use joton::plan::Plan;
use joton::{Error, Result};
use std::sync::Arc;

/// Open the device that `--device` names and set it up for a scene; with one line that says which it is.
pub(super) fn open(
    device: &str,
    reference: bool,
    scene: &Arc<PackedScene>,
    plan: &Plan,
) -> Result<(Box<dyn Backend>, String)> {
    let gpu = |name: Option<&str>| -> Result<Box<dyn Backend>> {
        let context = Context::open(name)?;
        Ok(Box::new(GpuBackend::new(context, Arc::clone(scene), plan.clone())?))
    };
    if reference && device != "cpu" {
        return Err(Error::usage("--reference is the path tracer on the CPU", "add --device cpu"));
    }
    let (backend, why): (Box<dyn Backend>, &str) = match device {
        "cpu" => return cpu(reference, scene, plan),
        "gpu" => (gpu(None)?, ""),
        "auto" => match gpu(None) {
            Ok(backend) => (backend, ""),
            Err(e) => {
                let (backend, line) = cpu(false, scene, plan)?;
                return Ok((backend, format!("{line}, because the GPU cannot be used: {e}")));
            }
        },
        name => (gpu(Some(name))?, ""),
    };
    let line = format!("{}{why}", backend.describe());
    Ok((backend, line))
}

fn cpu(reference: bool, scene: &Arc<PackedScene>, plan: &Plan) -> Result<(Box<dyn Backend>, String)> {
    let backend: Box<dyn Backend> = if reference {
        Box::new(PathTracer::new(Arc::clone(scene), plan.clone()))
    } else {
        Box::new(CpuBackend::new(Arc::clone(scene), plan.clone()))
    };
    let line = backend.describe();
    Ok((backend, line))
}
