//! Devices that fail at each of the points where they can: no finished pass is lost, and what goes on has the bits of what was never
//! disturbed.
#![cfg(debug_assertions)]

mod common;

use joton::backend::Backend;
use joton::backend::gpu::faults::{Faults, Point};
use joton::backend::gpu::{Context, GpuBackend};
use joton::film::paths::LightPaths;
use joton::output::checkpoint;
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{Progress, Reason, RenderState, Stop};
use joton::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// Passes of a render.
const PASSES: u64 = 3;
const STOP: Stop = Stop { passes: Some(PASSES), seconds: None, error: None };

/// A small scene, and how it is rendered.
struct Job {
    scene: Arc<PackedScene>,
    plan: Plan,
}

impl Job {
    /// A scene of this repository, with these light paths where they are named.
    fn new(name: &str, paths: Option<&str>) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{name}.toml"));
        let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        scene.resize([16, 16]);
        let scene = Arc::new(PackedScene::new(&scene));
        let mut settings = Settings::default();
        if let Some(paths) = paths {
            settings.paths = LightPaths::parse(paths).unwrap_or_else(|e| panic!("{e}"));
        }
        Self { plan: Plan::new(&scene, settings), scene }
    }

    /// Set a device up that fails at a point.
    fn set_up_failing(&self, point: Point, number: u32) -> Result<GpuBackend> {
        let (context, faults) = open();
        faults.ask_for(point, number);
        self.set_up(context)
    }

    fn set_up(&self, context: Context) -> Result<GpuBackend> {
        GpuBackend::new(context, Arc::clone(&self.scene), self.plan.clone())
    }

    /// An undisturbed render: its bits, and how often its device came by each point.
    fn undisturbed(&self) -> (Vec<u32>, impl Fn(Point) -> Counts + use<>) {
        let (context, faults) = open();
        let mut backend = self.set_up(context).unwrap_or_else(|e| panic!("{e}"));
        let seen = || Point::ALL.map(|point| faults.seen(point));
        let set_up = seen();
        let mut state = RenderState::new(self.scene.size);
        state.go_on(&mut backend, STOP, |_| true).unwrap_or_else(|e| panic!("{e}"));
        let done = seen();
        let counts =
            move |point: Point| Counts { set_up: set_up[point as usize], done: done[point as usize] };
        (bits(state), counts)
    }
}

/// A device, and what may go wrong with it.
fn open() -> (Context, Arc<Faults>) {
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let faults = Arc::clone(&context.faults);
    (context, faults)
}

/// How often a device comes by a point: until it is set up, and until the render is done.
struct Counts {
    set_up: u32,
    done: u32,
}

fn bits(state: RenderState) -> Vec<u32> {
    let rendered = state.finish(Reason::Passes);
    assert_eq!(rendered.passes, PASSES);
    let layers = rendered.picture.layers.iter().chain([&rendered.picture.whole]);
    layers.flat_map(|image| image.pixels.iter().flatten().map(|x| x.to_bits())).collect()
}

/// What is told: one line, what happened and what to do.
fn check_words(e: &Error, parts: &[&str], what: &str) {
    let words = e.to_string();
    assert!(matches!(e, Error::Device { .. }), "{what}: {e:?}");
    assert_eq!(words.lines().count(), 1, "{what}: {words}");
    assert!(parts.iter().all(|part| words.contains(part)), "{what}: {words}");
}

/// A device that is lost while it renders, at each submission, before it and while it runs, and at each reading: every pass that came out
/// before is in the checkpoint, and the render goes on from there to the bits of one that was never disturbed.
#[test]
fn no_finished_pass_is_lost() {
    device_or_return!();
    let job = Job::new("cornell", None);
    let (whole, counts) = job.undisturbed();
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("c.joton");
    let mut lost = 0;
    for point in [Point::Submission, Point::Running, Point::Reading] {
        let Counts { set_up: before, done } = counts(point);
        assert!(before < done, "{point:?}: no pass comes by");
        for number in before..done {
            let what = format!("{point:?} {number}");
            let mut backend = job.set_up_failing(point, number).unwrap_or_else(|e| panic!("{what}: {e}"));
            let mut state = RenderState::new(job.scene.size);
            let mut finished = 0;
            let watch = |p: &Progress<'_>| {
                finished = p.passes;
                true
            };
            match state.go_on(&mut backend, STOP, watch) {
                Err(e) => check_words(&e, &["lost", "--device cpu"], &what),
                // what was read before it was lost is whole
                Ok(_) => assert!(point == Point::Reading && number + 1 == done, "{what}: nothing is lost"),
            }
            assert_eq!(state.passes(), finished, "{what}: what came out is there");
            if finished == 0 {
                continue;
            }
            lost += u64::from(finished < PASSES);
            checkpoint::write(&file, &"", &state).unwrap_or_else(|e| panic!("{e}"));
            let (_, mut state): (String, _) = checkpoint::read(&file).unwrap_or_else(|e| panic!("{e}"));
            let mut sound = job.set_up(open().0).unwrap_or_else(|e| panic!("{e}"));
            state.go_on(&mut sound, STOP, |_| true).unwrap_or_else(|e| panic!("{what}: {e}"));
            assert!(bits(state) == whole, "{what}: other bits after {finished} passes");
        }
    }
    assert!(lost > 2, "{lost}");
}

/// A device that is lost while it is set up is an error that says so, at the latest when it is to render: at each submission of a scene
/// without glass, at every other reading of one with it.
#[test]
fn a_device_may_be_lost_while_it_is_set_up() {
    device_or_return!();
    for (scene, point, every) in [("cornell", Point::Submission, 1), ("ring", Point::Reading, 2)] {
        let job = Job::new(scene, None);
        let (_, counts) = job.undisturbed();
        let count = counts(point).set_up;
        assert!(count > 0, "{scene}: {point:?}");
        for number in (0..count).step_by(every) {
            let what = format!("{scene}: {point:?} {number}");
            let lost = job.set_up_failing(point, number).and_then(|mut backend| backend.render(0, 1));
            match lost {
                Err(e) => check_words(&e, &["lost", "--device cpu"], &what),
                Ok(_) => panic!("{what}: it renders"),
            }
        }
    }
}

/// A device without memory for one of its buffers, whichever that is, is an error that names it, its size and the remedy; one that does not
/// compile a kernel is one, too. Neither renders.
#[test]
fn a_device_may_have_no_memory_and_compile_nothing() {
    device_or_return!();
    let memory = &["no memory is left for the buffer ", " bytes", "--memory", "--device cpu"][..];
    let kernel = &["missing", "--device cpu"][..];
    // setting up takes as long as compiling: all buffers of a scene with few kernels, some of one with many
    for (scene, paths, point, every, parts) in [
        ("cornell", Some("LDE"), Point::Buffer, 1, memory),
        ("ring", None, Point::Buffer, 13, memory),
        ("ring", None, Point::Kernel, 9, kernel),
    ] {
        let job = Job::new(scene, paths);
        let (_, counts) = job.undisturbed();
        let count = counts(point).done;
        assert!(count > 3, "{scene}: {point:?}");
        for number in (0..count).step_by(every) {
            let what = format!("{scene}: {point:?} {number} of {count}");
            let render = |mut backend: GpuBackend| {
                let failed = (0..PASSES).find_map(|pass| backend.render(pass, 1).err());
                failed.map_or(Ok(()), Err)
            };
            match job.set_up_failing(point, number).and_then(render) {
                Err(e) => check_words(&e, parts, &what),
                Ok(()) => panic!("{what}: it renders"),
            }
        }
    }
}

/// What a device has compiled is there for the next scene on it, with the bits of a device of its own; what another scene needs
/// besides is compiled.
#[test]
fn a_device_compiles_each_kernel_once() {
    device_or_return!();
    let (plain, ring) = (Job::new("cornell", None), Job::new("ring", None));
    let alone = |job: &Job| {
        let (bits, counts) = job.undisturbed();
        (bits, counts(Point::Kernel).done)
    };
    let ((plain_bits, plain_kernels), (ring_bits, ring_kernels)) = (alone(&plain), alone(&ring));
    let (context, faults) = open();
    let mut seen = 0;
    let mut render = |job: &Job| {
        let mut backend = job.set_up(context.clone()).unwrap_or_else(|e| panic!("{e}"));
        let mut state = RenderState::new(job.scene.size);
        state.go_on(&mut backend, STOP, |_| true).unwrap_or_else(|e| panic!("{e}"));
        let compiled = faults.seen(Point::Kernel) - seen;
        seen += compiled;
        (bits(state), compiled)
    };
    assert!(render(&plain) == (plain_bits.clone(), plain_kernels));
    assert!(render(&plain) == (plain_bits.clone(), 0));
    let (found, compiled) = render(&ring);
    assert!(found == ring_bits, "kernels of another scene are taken");
    assert!((1..ring_kernels).contains(&compiled), "{compiled} of {ring_kernels}");
    assert!(render(&plain) == (plain_bits, 0) && render(&ring) == (ring_bits, 0));
}
