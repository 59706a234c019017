//! `--bands`: after red, green and blue, renders of three wavelengths each, for who measures  \[E53\].

use super::device::Devices;
use super::progress::{Narrator, passes};
use super::render::{Kind, RenderArguments, Spectral, kind_of};
use joton::film::Monochrome;
use joton::output::report::BandsRender;
use joton::packed::PackedScene;
use joton::plan::Plan;
use joton::render::{DEFAULT_ERROR, DEFAULT_SECONDS, Failure, Progress, Reason, RenderState, Rendered, Stop};
use joton::scene::Scene;
use joton::spectrum::list::List;
use joton::{Error, Result};
use std::cell::RefCell;
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// Refuse what does not go with bands.
pub(super) fn check(a: &RenderArguments, outputs: &[PathBuf]) -> Result<()> {
    if a.bands.is_none() {
        return Ok(());
    }
    let refuse = |what: &str, remedy: &str| Err(Error::usage(what, remedy));
    if a.pass_range.is_some() {
        let what = "--bands with --pass-range: a part of a render has red, green and blue alone";
        return refuse(what, "leave --bands out, or render all passes in one run");
    }
    if a.checkpoint.is_some() {
        let what = "--bands with --checkpoint: a checkpoint has red, green and blue alone";
        return refuse(what, "leave one of them out");
    }
    if a.spectral == Spectral::Off {
        return refuse("--bands with --spectral off: bands are wavelengths", "leave --spectral out");
    }
    if !outputs.iter().any(|path| matches!(kind_of(path), Ok(Kind::Exr))) {
        return refuse("--bands: only .exr files hold bands", "add -o with a name that ends in .exr");
    }
    Ok(())
}

/// What cannot be measured of a scene.
pub(super) fn warning(scene: &Scene) -> Option<String> {
    let what = "light in lines has no radiance per nm: it is in red, green and blue, and in none of the bands; \
                state a lamp by a spectrum with peaks of some width to have it there";
    scene.shines_in_lines().then(|| what.to_string())
}

/// When to stop one of `left` renders, where those before took so many seconds: each to the same error and passes, and all together in the time.
pub(super) fn share(stop: Stop, spent: f64, left: usize) -> Stop {
    let stop = if stop == Stop::default() {
        Stop { error: Some(DEFAULT_ERROR), seconds: Some(DEFAULT_SECONDS), passes: None }
    } else {
        stop
    };
    Stop { seconds: stop.seconds.map(|all| (all - spent).max(0.0) / left as f64), ..stop }
}

/// What was found in bands.
#[derive(Default)]
pub(super) struct Measured {
    /// Those that were rendered.
    pub(super) bands: Vec<Monochrome>,
    pub(super) renders: Vec<BandsRender>,
    /// What ended it before all were.
    pub(super) failed: Option<Error>,
    pub(super) is_interrupted: bool,
}

impl Measured {
    /// In words.
    pub(super) fn told(&self) -> String {
        let seconds: f64 = self.renders.iter().map(|r| r.seconds).sum();
        let counts = || self.renders.iter().map(|r| r.passes);
        let [least, most] = [counts().min(), counts().max()].map(Option::unwrap_or_default);
        let each = if least == most { passes(most) } else { format!("{least} to {}", passes(most)) };
        let worst = self.renders.iter().filter_map(|r| r.error_estimate).reduce(f64::max);
        let error = worst.map_or(String::new(), |e| format!(", estimated error at most {:.2} %", e * 100.0));
        format!("{} bands in {seconds:.2} s, {each} each{error}", self.bands.len())
    }

    fn add(&mut self, lambdas: [f64; 3], rendered: &Rendered, device: String, setup_seconds: f64) {
        let found = Monochrome::of(&rendered.picture.whole, lambdas);
        self.renders.push(BandsRender {
            wavelengths: found.iter().map(|band| band.lambda).collect(),
            device,
            passes: rendered.passes,
            seconds: rendered.seconds,
            setup_seconds,
            stopped_by: rendered.reason,
            device_failures: rendered.failures.clone(),
            rays: rendered.tally.rays,
            error_estimate: rendered.error_estimate.map(|e| e.total),
            non_finite: rendered.tally.non_finite,
        });
        self.bands.extend(found);
    }
}

/// How the renders of bands are done.
pub(super) struct Renders<'a> {
    pub(super) arguments: &'a RenderArguments,
    pub(super) packed: &'a PackedScene,
    pub(super) wanted: &'a Plan,
    pub(super) stop: Stop,
    pub(super) interrupted: &'a AtomicBool,
}

impl Renders<'_> {
    /// One after the other, in the order of wavelength, where red, green and blue took so many seconds. What is finished stays, whatever
    /// ends the rest.
    pub(super) fn render(&self, list: &List, spent: f64, narrator: &mut Narrator) -> Measured {
        let mut measured = Measured::default();
        let count = 1 + list.threes().len();
        let mut spent = spent;
        for (i, lambdas) in list.threes().enumerate() {
            narrator.part(1 + i, count, spent);
            let stop = share(self.stop, spent, count - 1 - i);
            match self.three(lambdas, stop, narrator, &mut measured) {
                Ok(seconds) => spent += seconds,
                Err(e) => measured.failed = Some(e),
            }
            let is_last = i + 2 == count;
            measured.is_interrupted = self.interrupted.load(Ordering::SeqCst) && !is_last
                || measured.renders.last().is_some_and(|r| r.stopped_by == Reason::Interrupted);
            if measured.failed.is_some() || measured.is_interrupted {
                break;
            }
        }
        measured
    }

    /// The render of three wavelengths; how long it took.
    fn three(
        &self,
        lambdas: [f64; 3],
        stop: Stop,
        narrator: &mut Narrator,
        measured: &mut Measured,
    ) -> Result<f64> {
        let begin = Instant::now();
        let scene = Arc::new(self.packed.at_wavelengths(lambdas));
        let a = self.arguments;
        let mut devices = Devices::named(&a.device, a.reference)?;
        let (backend, mut device, _) = devices.open(&scene, self.wanted)?;
        let setup_seconds = begin.elapsed().as_secs_f64();
        let mut state = RenderState::new(scene.size);
        state.look_ahead();
        let narrator = RefCell::new(narrator);
        let watch = |p: &Progress<'_>| {
            narrator.borrow_mut().show(p);
            !self.interrupted.load(Ordering::SeqCst)
        };
        let next = |failed: &Failure| {
            if devices.is_empty() || self.interrupted.load(Ordering::SeqCst) {
                return None;
            }
            let (backend, line, _) = devices.open(&scene, self.wanted).ok()?;
            narrator.borrow().message(&format!(
                "{line}, from pass {} on: {}",
                failed.passes + 1,
                failed.what
            ));
            device = line;
            Some(backend)
        };
        let ended = state.go_on_while_devices_last(backend, stop, watch, next);
        let (reason, failed) = match ended {
            // its memory is free before the picture takes some
            Ok((reason, backend)) => {
                drop(backend);
                (reason, None)
            }
            Err(e) if state.passes() == 0 => return Err(e),
            Err(e) => (Reason::Failed, Some(e)),
        };
        let rendered = state.finish(reason);
        measured.add(lambdas, &rendered, device, setup_seconds);
        failed.map_or(Ok(rendered.seconds), Err)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Who ends early leaves time to those that follow, and who is late takes it from them.
    #[test]
    fn time_is_shared() {
        let stop = Stop { seconds: Some(12.0), passes: Some(7), error: None };
        let seconds = |spent, left| share(stop, spent, left).seconds;
        assert_eq!((seconds(0.0, 4), seconds(2.0, 4), seconds(11.0, 1)), (Some(3.0), Some(2.5), Some(1.0)));
        assert_eq!(seconds(13.0, 2), Some(0.0));
        assert_eq!(share(stop, 0.0, 4).passes, Some(7));
        let free = share(Stop::default(), 0.0, 12);
        assert_eq!((free.error, free.seconds, free.passes), (Some(0.02), Some(5.0), None));
        let passes = Stop { passes: Some(7), ..Stop::default() };
        assert_eq!(share(passes, 100.0, 3), passes);
    }
}
