//! A device that is lost while it renders: what it has finished stays, and the next one goes on.

mod common;

use joton::backend::Backend;
use joton::backend::cpu::CpuBackend;
use joton::backend::gpu::{Context, GpuBackend};
use joton::film::{Film, Layer};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{Progress, Reason, RenderState, Stop};
use joton::spectrum::Bands;
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
/// the next one, the fourth to the sixth. Direct and diffuse light, which no device decides by what it saw before; f32 sums of six
/// numbers are equal to 1e-5. What neighbours share is that of all passes.
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
    let mut film = Film::new(scene.size[0], scene.size[1]);
    film.keep_halves(&Layer::ON_SURFACES);
    for pass in 0..PASSES {
        let device: &mut dyn Backend = if pass < LOST { &mut gpu } else { &mut cpu };
        let batch = device.render(pass, 1).unwrap_or_else(|e| panic!("{e}"));
        film.add(1, &batch.layers);
    }
    let shared = cpu.resolver().expect("eye paths are resolved").resolve(&film, 1);
    let bare = film.picture().layers;
    let is_near = |what: &str, wanted: &[Bands], found: &[Bands]| {
        for (pixel, (wanted, found)) in wanted.iter().zip(found).enumerate() {
            let [wanted, found] = [wanted, found].map(|x| f64::from(x[0]));
            let is_near = (wanted - found).abs() <= 1e-5 * wanted.abs();
            assert!(is_near, "{what}, pixel {pixel}: {found}, not {wanted}");
        }
    };
    let found = |layer: Layer| &rendered.picture.layers[layer as usize].pixels;
    for layer in [Layer::Direct, Layer::Diffuse] {
        let (_, resolved) = shared.iter().find(|(of, _)| *of == layer).expect("it is shared");
        is_near(layer.name(), &resolved.radiance, found(layer));
        assert_ne!(found(layer), &bare[layer as usize].pixels, "{layer:?} is shared");
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
