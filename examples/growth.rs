//! How the cost of a pass grows with triangles, pixels and jotons.
//!
//! `cargo run --release --example growth -- [DEVICE…] > growth.csv`, devices gpu and cpu where none is named. A room with a
//! ball, of which one size is changed at a time: the ball's triangles, the image's pixels, the jotons of a pass. Each line:
//! what was changed, its size, set-up and rendering as CPU seconds, rays and jotons a CPU second, peak memory of the
//! process so far. A size that does not fit the device is a line with its message.

use joton::backend::Backend;
use joton::backend::cpu::CpuBackend;
use joton::backend::gpu::{Context, GpuBackend};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{Stop, render};
use std::error::Error;
use std::sync::Arc;

#[path = "../tests/common/scenes.rs"]
#[allow(dead_code, reason = "shared with the tests, which use all of it")]
mod scenes;

/// Passes of a measurement.
const PASSES: u64 = 4;
/// What is not changed: 20 · 4⁴ triangles, pixels across.
const LEVELS: u32 = 4;
const PIXELS: u32 = 128;

fn main() -> Result<(), Box<dyn Error>> {
    let named: Vec<String> = std::env::args().skip(1).collect();
    let devices = if named.is_empty() { vec!["gpu".into(), "cpu".into()] } else { named };
    println!(
        "device,changed,size,setup_cpu_seconds,cpu_seconds_a_pass,rays_a_second,jotons_a_second,peak_bytes"
    );
    for device in &devices {
        for levels in 3..=9 {
            measure(device, "triangles", 20 * 4u64.pow(levels), &room(levels, PIXELS), 1.0)?;
        }
        for width in [32, 64, 128, 256, 512, 1024] {
            measure(device, "pixels", u64::from(width * width), &room(LEVELS, width), 1.0)?;
        }
        for factor in [1.0, 4.0, 16.0, 64.0] {
            let packed = room(LEVELS, PIXELS);
            let jotons = f64::from(Plan::new(&packed, Settings::default()).diffuse_jotons) * factor;
            measure(device, "jotons", jotons as u64, &packed, factor)?;
        }
    }
    Ok(())
}

/// A room with a lamp and a matte ball of 20 · 4^`levels` triangles.
fn room(levels: u32, size: u32) -> Arc<PackedScene> {
    let mut b = scenes::Builder::new([0., 0.5, 1.9], [0., -0.3, 0.], [0., 1., 0.], 0.6, size);
    let (walls, ball) = (b.matte(0.7), b.matte(0.5));
    let lamp = b.material(scenes::emitter(20.0, 0.0));
    b.room([-1., -1., -1.], [1., 1., 2.], walls);
    b.quad([-0.2, 0.99, -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    b.icosphere([0., -0.5, 0.], 0.5, levels, true, ball);
    Arc::new(PackedScene::new(&b.scene))
}

fn measure(
    device: &str,
    changed: &str,
    size: u64,
    scene: &Arc<PackedScene>,
    factor: f64,
) -> joton::Result<()> {
    let mut plan = Plan::new(scene, Settings::default());
    plan.diffuse_jotons = (f64::from(plan.diffuse_jotons) * factor) as u32;
    // as many jotons in a disc
    plan.diffuse.base /= factor.sqrt();
    let since = cpu_time::ProcessTime::now();
    let opened: joton::Result<Box<dyn Backend>> = if device == "cpu" {
        Ok(Box::new(CpuBackend::new(scene.clone(), plan)))
    } else {
        let name = (device != "gpu").then_some(device);
        Context::open(name)
            .and_then(|c| GpuBackend::new(c, scene.clone(), plan))
            .map(|b| Box::new(b) as Box<dyn Backend>)
    };
    let mut backend = match opened {
        Ok(backend) => backend,
        Err(e) => {
            println!("{device},{changed},{size},\"{}\"", e.to_string().replace('"', "'"));
            return Ok(());
        }
    };
    let setup = since.elapsed().as_secs_f64();
    let stop = Stop { passes: Some(PASSES), ..Stop::default() };
    let done = render(backend.as_mut(), scene.size, stop, |_| true)?;
    let rate = |count: u64| count as f64 / done.cpu_seconds;
    println!(
        "{device},{changed},{size},{setup:.3},{:.4},{:.3e},{:.3e},{}",
        done.cpu_seconds / PASSES as f64,
        rate(done.tally.rays),
        rate(done.tally.jotons_emitted),
        joton::host::memory::peak().unwrap_or(0)
    );
    Ok(())
}
