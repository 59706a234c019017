//! Which device a command runs on: `--device auto|gpu|cpu|NAME`.

use joton::backend::cpu::{CpuBackend, PathTracer};
use joton::backend::gpu::{Context, GpuBackend};
use joton::backend::{Backend, guarded};
use joton::packed::PackedScene;
use joton::plan::Plan;
use joton::plan::process_memory::Place;
use joton::{Error, Result};
use std::collections::VecDeque;
use std::sync::Arc;

/// A device, one line that says which it is, and the plan as the device could keep it.
type Opened = (Box<dyn Backend>, String, Plan);

/// Opens a device and sets it up for a scene.
type Open = Box<dyn FnOnce(&Arc<PackedScene>, &Plan) -> Result<Opened>>;

/// The devices that `--device` names, the best first: for `auto` GPUs, then software Vulkan, then the CPU.
pub(super) struct Devices(VecDeque<Open>);

impl Devices {
    /// What is there for a word of `--device`.
    pub(super) fn named(device: &str, reference: bool) -> Result<Self> {
        check_reference(device, reference)?;
        let on_cpu: Open = Box::new(move |scene, plan| cpu(reference, scene, plan));
        let on_gpu = |name: Option<String>| -> Open {
            Box::new(move |scene, plan| gpu(Context::open(name.as_deref())?, scene, plan))
        };
        Ok(Self(match device {
            "cpu" => [on_cpu].into(),
            "gpu" => [on_gpu(None)].into(),
            "auto" => {
                let mut all: VecDeque<Open> = VecDeque::new();
                for adapter in joton::backend::gpu::adapters() {
                    all.push_back(Box::new(move |scene, plan| {
                        gpu(Context::from_adapter(&adapter)?, scene, plan)
                    }));
                }
                if all.is_empty() {
                    // it tells what is missing
                    all.push_back(on_gpu(None));
                }
                all.push_back(on_cpu);
                all
            }
            name => [on_gpu(Some(name.into()))].into(),
        }))
    }

    /// Open the next one that can be used; its line tells why those before cannot.
    ///
    /// # Errors
    /// What the last one reports.
    pub(super) fn open(&mut self, scene: &Arc<PackedScene>, plan: &Plan) -> Result<Opened> {
        let mut because: Vec<String> = Vec::new();
        while let Some(open) = self.0.pop_front() {
            match open(scene, plan) {
                Ok((backend, mut line, plan)) => {
                    for e in because {
                        line += &format!(", because the GPU cannot be used: {e}");
                    }
                    return Ok((backend, line, plan));
                }
                // what is free decides about no picture
                Err(e @ Error::Memory { .. }) => return Err(e),
                Err(e) if self.0.is_empty() => return Err(e),
                Err(e) => because.push(e.to_string()),
            }
        }
        Err(Error::device("no device is left", "choose one with --device"))
    }

    /// Whether there are more.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// Refuse the path tracer on another device than the CPU.
pub(super) fn check_reference(device: &str, reference: bool) -> Result<()> {
    if reference && device != "cpu" {
        return Err(Error::usage("--reference is the path tracer on the CPU", "add --device cpu"));
    }
    Ok(())
}

/// Open the device that `--device` names and set it up for a scene.
#[cfg(feature = "bench")]
pub(super) fn open(device: &str, reference: bool, scene: &Arc<PackedScene>, plan: &Plan) -> Result<Opened> {
    Devices::named(device, reference)?.open(scene, plan)
}

fn gpu(context: Context, scene: &Arc<PackedScene>, wanted: &Plan) -> Result<Opened> {
    #[cfg(debug_assertions)]
    ask_for_fault(&context);
    let mut own = wanted.clone();
    own.bound_process(scene, Place::Device)?;
    let unusable = |words: String| Error::device(words, "use --device cpu");
    let backend = guarded(|| GpuBackend::new(context, Arc::clone(scene), own)).map_err(unusable)??;
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

/// Let the device fail as a test asks by `JOTON_TEST_FAULT`, like `Running 12`. No release does that.
#[cfg(debug_assertions)]
fn ask_for_fault(context: &Context) {
    use joton::backend::gpu::faults::Point;
    let told = std::env::var("JOTON_TEST_FAULT").unwrap_or_default();
    if let Some((name, number)) = told.split_once(' ') {
        let point = Point::ALL.into_iter().find(|point| format!("{point:?}") == name);
        if let (Some(point), Ok(number)) = (point, number.parse()) {
            context.faults.ask_for(point, number);
        }
    }
}

fn cpu(reference: bool, scene: &Arc<PackedScene>, plan: &Plan) -> Result<Opened> {
    let (scene, mut own) = (Arc::clone(scene), plan.clone());
    own.bound_process(&scene, Place::Cpu)?;
    let backend: Box<dyn Backend> =
        if reference { Box::new(PathTracer::new(scene, own)) } else { Box::new(CpuBackend::new(scene, own)) };
    let line = backend.describe();
    Ok((backend, line, plan.clone()))
}
