//! Renders a scene on a GPU where there is one, otherwise on the CPU.
use joton::backend::{Backend, cpu::CpuBackend, gpu::Context, gpu::GpuBackend};
use joton::{output, packed::PackedScene, plan::Plan, render, scene};
use std::{path::Path, sync::Arc};

fn main() -> joton::Result<()> {
    let scene = Arc::new(PackedScene::new(&scene::load(Path::new("scenes/hello.toml"))?));
    let plan = Plan::new(&scene, Default::default());
    let on_gpu = |context| GpuBackend::new(context, Arc::clone(&scene), plan.clone());
    let mut backend: Box<dyn Backend> = match Context::open(None).and_then(on_gpu) {
        Ok(gpu) => Box::new(gpu),
        Err(_) => Box::new(CpuBackend::new(Arc::clone(&scene), plan)),
    };
    let stop = render::Stop { seconds: Some(10.0), ..Default::default() };
    let rendered = render::render(&mut *backend, scene.size, stop, |progress| {
        println!("passes: {}, done: {:.0} %", progress.passes, 100.0 * progress.done);
        true // false stops
    })?;
    output::exr::write_picture(Path::new("hello.exr"), &rendered.picture, "")
}
