//! Run: render with each seed and look at the picture at every step of a ladder of times.

use super::ladder::{Ladder, PictureRun};
use super::subject::Subject;
use super::{KernelRow, Row, Summary};
use crate::backend::{Backend, PASSES_MAX};
use crate::render::{Stop, render};
use crate::{Error, Result};

/// What was found of a subject.
pub struct Measured {
    /// One for each picture.
    pub rows: Vec<Row>,
    /// One for each step that was reached.
    pub summaries: Vec<Summary>,
    /// What kernels took, where that was measured.
    pub kernels: Vec<KernelRow>,
    /// What opening or rendering reported, after what was found before.
    pub failure: Option<Error>,
}

/// Measure a subject. `open` sets a device up for a seed; `see` is shown each row as it is found, and returns false to
/// stop. Set-up, comparing and `see` are not part of any time.
pub fn measure(
    subject: &Subject<'_>,
    open: impl FnMut(u32) -> Result<Box<dyn Backend>>,
    see: impl FnMut(&Row) -> bool,
) -> Measured {
    let mut ladder = Ladder::new(subject);
    let mut kernels = Vec::new();
    let failure = climb(subject, &mut ladder, &mut kernels, open, see).err();
    let (rows, summaries) = ladder.finish();
    Measured { rows, summaries, kernels, failure }
}

/// Render with each seed, up the ladder.
fn climb(
    subject: &Subject<'_>,
    ladder: &mut Ladder<'_>,
    kernels: &mut Vec<KernelRow>,
    mut open: impl FnMut(u32) -> Result<Box<dyn Backend>>,
    mut see: impl FnMut(&Row) -> bool,
) -> Result<()> {
    for seed in 0..subject.seeds {
        let mut backend = open(seed)?;
        let (device_name, device_bytes) = (backend.describe(), backend.device_bytes());
        if subject.timings {
            backend.measure_kernels()?;
        }
        // until the last step is reached
        let stop = Stop { passes: Some(PASSES_MAX), ..Stop::default() };
        let (mut steps_done, mut go_on, mut failure) = (0, true, None);
        let rendered = render(backend.as_mut(), subject.size, stop, |progress| {
            // a slow pass may skip steps: its picture belongs to the last one that it reached
            let time = subject.clock.read(progress.seconds, progress.cpu_seconds);
            let reached = subject.times.partition_point(|t| *t <= time);
            if reached == steps_done {
                return true;
            }
            steps_done = reached;
            // what a picture costs is part of its time, as if it were the last
            let look = progress.look();
            let seen = PictureRun {
                device_name: device_name.clone(),
                seed,
                seconds: progress.seconds + look.seconds,
                cpu_seconds: progress.cpu_seconds + look.cpu_seconds,
                passes: progress.passes,
                rays: Some(progress.tally.rays),
                jotons: Some(progress.tally.jotons_emitted),
                device_bytes,
                error_estimate: look.error.map(|e| e.total),
            };
            match ladder.add(reached - 1, seen, &look.picture.whole) {
                Ok(row) => go_on = see(row),
                Err(e) => failure = Some(e),
            }
            go_on && failure.is_none() && steps_done < subject.times.len()
        })?;
        if let Some(e) = failure {
            return Err(e);
        }
        let of_kernel = |(kernel, seconds, dispatches)| {
            let (scene, device) = (subject.scene.into(), subject.device.into());
            KernelRow { scene, device, seed, passes: rendered.passes, kernel, seconds, dispatches }
        };
        kernels.extend(backend.kernel_seconds().into_iter().map(of_kernel));
        if subject.timings {
            let of_host = |(work, seconds)| of_kernel((format!("host: {work}"), seconds, rendered.passes));
            kernels.extend(rendered.host.by_name().map(of_host));
        }
        if !go_on {
            break;
        }
    }
    Ok(())
}
