//! Precompile: software devices compile a kernel when it is first dispatched, one after the other, and keep the result in the
//! driver's cache. A second device compiles them at the same time, the last one first; what it has done the first finds there.

use super::context::Context;
use super::kernel::{Kernel, Recipe};
use super::pipelines::Kernels;
use super::recorder::Recorder;
use super::ring::Ring;
use crate::host::memory;
use crate::packed::layout::{MapInfo, PassInfo};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// Whether some backend of this process has precompiled: for those that follow the cache is warm.
static DONE: AtomicBool = AtomicBool::new(false);

/// Where the first kernel is ready as soon as this it was in the cache, as the others will be.
const WARM: Duration = Duration::from_millis(60);

/// A thread that precompiles. Dropping it waits until the kernel that it is at is done.
pub(super) struct Precompiler {
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Precompiler {
    /// Start, where it helps: on a software device, once for each process.
    pub(super) fn start(context: &Context, kernels: &Kernels) -> Option<Self> {
        if !context.is_software() || DONE.swap(true, Ordering::SeqCst) {
            return None;
        }
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, adapter) = (Arc::clone(&stop), context.adapter.clone());
        let recipes: Vec<Recipe> =
            kernels.in_order_of_use().into_iter().rev().map(|k| k.recipe().clone()).collect();
        let thread = std::thread::spawn(move || {
            // what fails here fails where it matters, too, and is told there
            let Ok(context) = Context::from_adapter(&adapter) else { return };
            for (i, recipe) in recipes.iter().enumerate() {
                let begin = Instant::now();
                let compiled = recipe.cook(&context).and_then(|kernel| run_on_nothing(&context, &kernel));
                memory::give_back();
                let is_warm = i == 0 && begin.elapsed() < WARM;
                if is_warm || compiled.is_err() || stopped.load(Ordering::SeqCst) {
                    break;
                }
            }
        });
        Some(Self { stop, thread: Some(thread) })
    }
}

impl Drop for Precompiler {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            thread.join().ok();
        }
    }
}

/// Dispatch a kernel for an image and a map without anything in them.
fn run_on_nothing(context: &Context, kernel: &Kernel) -> crate::Result<()> {
    let (step, ring_buffer) = kernel.bind_nothing(context)?;
    let mut ring = Ring::new(context);
    let mut recorder = Recorder::new(context, &mut ring, None);
    let nothing: PassInfo = bytemuck::Zeroable::zeroed();
    let no_map: MapInfo = bytemuck::Zeroable::zeroed();
    let at = [("pass_info", recorder.ring.push(&nothing)), ("map_info", recorder.ring.push(&no_map))];
    recorder.dispatch(&step, &at, 1);
    recorder.submit(context, &ring_buffer);
    context.wait()
}
