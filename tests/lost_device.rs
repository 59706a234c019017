//! A device that is lost while it renders: what it has finished stays, and the next one goes on.

mod common;

use joton::backend::Backend;
use joton::backend::cpu::CpuBackend;
use joton::backend::gpu::{Context, GpuBackend};
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{Progress, Reason, RenderState, Stop};
use std::path::Path;
use std::sync::Arc;

/// Passes before the device is lost, and in all.
const LOST: u64 = 3;
const PASSES: u64 = 6;

fn scene() -> Arc<PackedScene> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/cornell.toml");
    let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    scene.resize([24, 24]);
    Arc::new(PackedScene::new(&scene))
}

fn backend(context: Context, scene: &Arc<PackedScene>) -> GpuBackend {
    let plan = Plan::new(scene, Settings::default());
    GpuBackend::new(context, Arc::clone(scene), plan).unwrap_or_else(|e| panic!("{e}"))
}

fn open() -> Context {
    Context::open(None).unwrap_or_else(|e| panic!("{e}"))
}

/// The picture of a render whose device is lost after three of six passes is the mean of three passes of that device and three of
/// the next one, the fourth to the sixth. Light of the maps and of the lamps' direct light, which no device decides by what it
/// saw before; f32 sums of six numbers are equal to 1e-5.
#[test]
fn the_next_device_goes_on_where_one_was_lost() {
    device_or_return!();
    let scene = scene();
    let context = open();
    let device = context.device.clone();
    let lost = backend(context, &scene);
    let cpu = || CpuBackend::new(Arc::clone(&scene), Plan::new(&scene, Settings::default()));
    let mut state = RenderState::new(scene.size);
    let stop = Stop { passes: Some(PASSES), ..Stop::default() };
    let watch = |p: &Progress<'_>| {
        if p.passes == LOST {
            device.destroy();
        }
        true
    };
    let ended = state.go_on_while_devices_last(Box::new(lost), stop, watch, |_| Some(Box::new(cpu())));
    let (reason, last) = ended.map_err(|e| e.to_string()).expect("the CPU is there");
    assert_eq!((reason, last.describe()), (Reason::Passes, cpu().describe()));
    let rendered = state.finish(reason);
    assert_eq!((rendered.passes, rendered.failures.len()), (PASSES, 1));
    assert_eq!(rendered.failures[0].passes, LOST);
    assert!(rendered.failures[0].what.contains("lost"), "{}", rendered.failures[0].what);

    let (mut gpu, mut cpu) = (backend(open(), &scene), cpu());
    let layers = [Layer::Direct, Layer::Diffuse];
    let mut sums = layers.map(|_| vec![0.0f64; scene.size[0] as usize * scene.size[1] as usize]);
    for pass in 0..PASSES {
        let device: &mut dyn Backend = if pass < LOST { &mut gpu } else { &mut cpu };
        let batch = device.render(pass, 1).unwrap_or_else(|e| panic!("{e}"));
        for (sums, layer) in sums.iter_mut().zip(layers) {
            sums.iter_mut().zip(&batch.layers[layer as usize]).for_each(|(s, l)| *s += f64::from(l[0]));
        }
    }
    for (sums, layer) in sums.iter().zip(layers) {
        let picture = &rendered.picture.layers[layer as usize];
        for (pixel, (sum, found)) in sums.iter().zip(&picture.pixels).enumerate() {
            let (wanted, found) = (sum / PASSES as f64, f64::from(found[0]));
            assert!(
                (wanted - found).abs() <= 1e-5 * wanted.abs(),
                "{layer:?}, pixel {pixel}: {found}, not {wanted}"
            );
        }
    }
}

/// A device that is lost before its first pass is an error that says so, never a panic, and no picture.
#[test]
fn a_lost_device_is_an_error() {
    device_or_return!();
    let scene = scene();
    let context = open();
    let device = context.device.clone();
    let mut lost = backend(context, &scene);
    device.destroy();
    let e = lost.render(0, 1).expect_err("it is lost").to_string();
    assert!(e.contains("lost") && e.contains("--device cpu"), "{e}");
}
