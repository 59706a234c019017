//! Render: pass after pass on a backend until the picture is good enough, the time is up or the user stops it. Where a device
//! fails, what it has finished stays, and another one goes on from there: passes are independent given their index, and
//! films are sums.

mod blur_line;
mod clock;
mod error_estimate;
mod imbalance;
mod lattice;
mod merge;
mod pass_range;
mod state;
mod static_tiles;

use crate::backend::{Backend, HostSeconds, Tally};
use crate::error::Result;
use crate::film::{Film, Image, Layer, Picture};
use crate::render::error_estimate::ErrorEstimator;
use crate::resolve::{Resolved, Resolver};
use crate::spectrum::{BLACK, add};
use clock::Clock;
pub use error_estimate::ErrorEstimate;
pub use pass_range::PassRange;
pub use state::RenderState;

/// When to stop; the first that is met. None at all: until the error estimate is [`DEFAULT_ERROR`], at most
/// [`DEFAULT_SECONDS`].
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Stop {
    /// After this many passes; after [`PASSES_MAX`](crate::backend::PASSES_MAX) in any case.
    pub passes: Option<u64>,
    /// After this many seconds of rendering, the picture among them: the last batch is the one that ends next to that.
    pub seconds: Option<f64>,
    /// When the error estimate (relative, root mean square) is at most this.
    pub error: Option<f64>,
}

/// Error estimate at which a render stops where nothing else is asked for.
pub const DEFAULT_ERROR: f64 = 0.02;
/// Seconds after which a render stops where nothing else is asked for.
pub const DEFAULT_SECONDS: f64 = 60.0;

/// Why a render stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Reason {
    /// All passes are done.
    Passes,
    /// The time is up.
    Time,
    /// The error estimate is small enough.
    Error,
    /// The user stopped it.
    Interrupted,
    /// The device failed, and no other one was left.
    Failed,
}

/// A device that failed.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Failure {
    /// Which it was.
    pub device: String,
    /// Passes in the picture when it failed: those before and its own.
    pub passes: u64,
    /// Its words.
    pub what: String,
}

/// How far a render is.
#[derive(Debug, Clone, Copy)]
pub struct Progress<'a> {
    /// Passes done.
    pub passes: u64,
    /// Seconds of rendering.
    pub seconds: f64,
    /// Estimate of the error; none before there are passes enough.
    pub error: Option<ErrorEstimate>,
    /// Part of the work that is done, 0 to 1, as far as it can be told.
    pub done: f64,
    /// Processor seconds of all threads while rendering.
    pub cpu_seconds: f64,
    /// Sums of all counts so far.
    pub tally: &'a Tally,
    /// All that it takes to go on from here.
    pub state: &'a RenderState,
    estimator: &'a ErrorEstimator,
    resolver: Option<&'a Resolver>,
}

/// Layers that were resolved.
type ResolvedLayers = Vec<(Layer, Resolved)>;

/// The picture of a film, with its layers as they were resolved.
fn picture(film: &Film, resolved: ResolvedLayers) -> Picture {
    if resolved.is_empty() {
        return film.picture();
    }
    let [width, height] = film.size();
    let mut picture = Picture {
        whole: Image::new(width, height),
        layers: Layer::ALL.map(|layer| film.layer(layer)),
        unresolved: Vec::with_capacity(resolved.len()),
    };
    for (layer, Resolved { radiance, .. }) in resolved {
        let image = Image { width, height, pixels: radiance };
        picture.unresolved.push((layer, std::mem::replace(&mut picture.layers[layer as usize], image)));
    }
    for (pixel, whole) in picture.whole.pixels.iter_mut().enumerate() {
        *whole = picture.layers.iter().fold(BLACK, |sum, layer| add(&sum, &layer.pixels[pixel]));
    }
    picture
}

impl Progress<'_> {
    /// The mean of the passes so far, resolved. Computed for who asks; the time that takes is not counted as rendering.
    pub fn picture(&self) -> Picture {
        self.look().picture
    }

    /// The same, and what is known of it.
    pub fn look(&self) -> Look {
        let clock = Clock::start();
        let mut estimator = std::borrow::Cow::Borrowed(self.estimator);
        let resolved = self
            .resolver
            .map(|r| r.resolve(self.estimator.film(), self.estimator.step()))
            .unwrap_or_default();
        if self.resolver.is_some() {
            estimator.to_mut().set_resolved(&resolved);
        }
        let picture = picture(self.estimator.film(), resolved);
        let [seconds, cpu_seconds] = clock.read();
        let error = if self.resolver.is_some() { estimator.error() } else { self.error };
        Look { picture, error, seconds, cpu_seconds }
    }
}

/// A picture that was asked for while rendering.
#[derive(Debug, Clone)]
pub struct Look {
    /// The mean of the passes so far.
    pub picture: Picture,
    /// Estimate of its error.
    pub error: Option<ErrorEstimate>,
    /// Seconds that it took to make.
    pub seconds: f64,
    /// Processor seconds of all threads.
    pub cpu_seconds: f64,
}

/// A finished render.
#[derive(Debug, Clone)]
pub struct Rendered {
    /// The mean of the passes.
    pub picture: Picture,
    /// Passes in it.
    pub passes: u64,
    /// Seconds of rendering, without set-up.
    pub seconds: f64,
    /// Processor seconds of all threads while rendering.
    pub cpu_seconds: f64,
    /// Sums of all counts.
    pub tally: Tally,
    /// Standard error of (emitted − absorbed − escaped) / emitted, from the spread between batches.
    pub energy_error: Option<f64>,
    /// Estimate of the error.
    pub error_estimate: Option<ErrorEstimate>,
    /// Why it stopped.
    pub reason: Reason,
    /// Devices that failed before.
    pub failures: Vec<Failure>,
    /// Where the seconds went.
    pub host: HostSeconds,
}

/// Render until `stop`; `watch` sees every batch and returns false to stop.
///
/// # Errors
/// What the backend reports.
pub fn render(
    backend: &mut dyn Backend,
    size: [u32; 2],
    stop: Stop,
    watch: impl FnMut(&Progress<'_>) -> bool,
) -> Result<Rendered> {
    let mut state = RenderState::new(size);
    let reason = state.go_on(backend, stop, watch)?;
    Ok(state.finish(reason))
}

#[cfg(test)]
mod tests {
    use super::state::batch;
    use super::*;
    use crate::backend::{Batch, PASSES_MAX};
    use crate::error::Error;
    use crate::film::tile_schedule::TileSchedule;
    use crate::spectrum::BANDS;
    use std::time::Duration;

    /// One pixel that is as bright as the number of its pass.
    struct Counter;

    impl Backend for Counter {
        fn describe(&self) -> String {
            "counter".into()
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            let sum: f32 = (first..first + u64::from(count)).map(|pass| pass as f32).sum();
            Ok(Batch { layers: std::array::from_fn(|_| vec![[sum; BANDS]]), tally: Tally::default() })
        }
    }

    /// [`Counter`] that fails at a pass.
    struct Failing(u64);

    impl Backend for Failing {
        fn describe(&self) -> String {
            format!("fails at {}", self.0)
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            if first >= self.0 {
                return Err(Error::device(format!("no pass {first}"), "try another"));
            }
            Counter.render(first, count)
        }
    }

    /// Where a device fails its passes stay, and the next one goes on with those that follow: the picture is that of a device
    /// that never failed.
    #[test]
    fn another_device_goes_on() {
        let stop = Stop { passes: Some(8), ..Stop::default() };
        let whole = render(&mut Counter, [1, 1], stop, |_| true).expect("a picture");
        // the second one fails at once
        let mut others: Vec<Box<dyn Backend>> = vec![Box::new(Counter), Box::new(Failing(0))];
        let mut state = RenderState::new([1, 1]);
        let mut seen = Vec::new();
        let watch = |p: &Progress<'_>| {
            seen.push(p.passes);
            true
        };
        let ended = state.go_on_while_devices_last(Box::new(Failing(3)), stop, watch, |_| others.pop());
        let (reason, last) = ended.map_err(|e| e.to_string()).expect("the third one renders");
        assert_eq!((reason, last.describe()), (Reason::Passes, "counter".into()));
        assert_eq!(seen, (1..=8).collect::<Vec<_>>(), "each pass once");
        let rendered = state.finish(reason);
        assert_eq!(rendered.picture.whole, whole.picture.whole);
        assert_eq!(rendered.error_estimate, whole.error_estimate);
        let failed: Vec<_> =
            rendered.failures.iter().map(|f| (&f.device[..], f.passes, &f.what[..])).collect();
        let wanted =
            [("fails at 3", 3, "no pass 3; try another"), ("fails at 0", 3, "no pass 3; try another")];
        assert_eq!(failed, wanted);
    }

    /// Where the last device fails, its words come out, and the passes before are a picture.
    #[test]
    fn passes_before_a_failure_are_kept() {
        let stop = Stop { passes: Some(8), ..Stop::default() };
        let mut state = RenderState::new([1, 1]);
        let ended = state.go_on_while_devices_last(Box::new(Failing(3)), stop, |_| true, |_| None);
        assert_eq!(ended.err().expect("it fails").to_string(), "no pass 3; try another");
        assert_eq!(state.passes(), 3);
        let rendered = state.finish(Reason::Failed);
        let three = Stop { passes: Some(3), ..Stop::default() };
        let whole = render(&mut Counter, [1, 1], three, |_| true).expect("a picture");
        assert_eq!(rendered.picture.whole, whole.picture.whole);
        assert_eq!((rendered.passes, rendered.reason, rendered.failures.len()), (3, Reason::Failed, 1));
    }

    /// A pixel of radiance 1 in each layer, as a device sees it that lets it rest or not, up to a pass at which it fails.
    struct Steady {
        schedule: Option<TileSchedule>,
        batch: u32,
        fails_at: u64,
    }

    impl Backend for Steady {
        fn describe(&self) -> String {
            "steady".into()
        }

        fn batch_passes(&self, _: u64) -> u32 {
            self.batch
        }

        fn set_tile_schedule(&mut self, schedule: &TileSchedule) -> bool {
            self.schedule.as_mut().map(|r| *r = schedule.clone()).is_some()
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            if first >= self.fails_at {
                return Err(Error::device("it fails", "try another"));
            }
            let passes = first..first + u64::from(count);
            let is_live =
                |pass: &u64| self.schedule.as_ref().is_none_or(|schedule| schedule.is_live(0, *pass));
            let sum = passes.filter(is_live).count() as f32;
            Ok(Batch { layers: std::array::from_fn(|_| vec![[sum; BANDS]; 64]), tally: Tally::default() })
        }
    }

    /// Every pass counts once, whether pixels rest on the device that fails, on the one that goes on, or on both, and wherever the
    /// one stops in a block of the other.
    #[test]
    fn pixels_that_rest_count_once_on_the_next_device() {
        let size = [8, 8];
        for (rests, batch) in [([true, true], 4), ([true, false], 4), ([false, true], 1), ([true, false], 16)]
        {
            for fails_at in [1, 5, 37, 48] {
                let schedule = rests.map(|rests| rests.then(|| TileSchedule::none(size)));
                let [first, second] = schedule;
                let first = Steady { schedule: first, batch: 1, fails_at };
                let second = Steady { schedule: second, batch, fails_at: u64::MAX };
                let (mut state, mut next) =
                    (RenderState::new(size), Some(Box::new(second) as Box<dyn Backend>));
                let stop = Stop { passes: Some(130), ..Stop::default() };
                let watch = |p: &Progress<'_>| {
                    let found = p.picture().whole.pixels[9][0];
                    assert_eq!(found, 4.0, "{rests:?}, {batch}, {fails_at}: {} passes", p.passes);
                    true
                };
                let ended = state.go_on_while_devices_last(Box::new(first), stop, watch, |_| next.take());
                assert_eq!(ended.map(|e| e.0).map_err(|e| e.to_string()), Ok(Reason::Passes));
                assert_eq!(state.passes(), 130);
            }
        }
    }

    /// [`Counter`] that works beside the host, in batches of half of the passes so far.
    #[derive(Default)]
    struct Ahead {
        begun: Vec<(u64, u64)>,
        rendered: Vec<(u64, u64)>,
        nap: Duration,
    }

    impl Backend for Ahead {
        fn describe(&self) -> String {
            "ahead".into()
        }

        fn batch_passes(&self, first: u64) -> u32 {
            (first.next_power_of_two() / 2).clamp(1, 16) as u32
        }

        fn works_beside_host(&self) -> bool {
            true
        }

        fn begin(&mut self, first: u64, count: u32) -> Result<()> {
            if !self.begun.contains(&(first, count.into())) {
                self.begun.push((first, count.into()));
            }
            Ok(())
        }

        fn render(&mut self, first: u64, count: u32) -> Result<Batch> {
            self.rendered.push((first, count.into()));
            std::thread::sleep(self.nap);
            Counter.render(first, count)
        }
    }

    /// A device begins with the batches that follow, but for those that begin at powers of two of passes, where it is told anew who
    /// rests; with none that is not asked for later.
    #[test]
    fn the_next_batch_begins_before_it_is_asked_for() {
        let mut backend = Ahead::default();
        let mut state = RenderState::new([1, 1]);
        state.look_ahead();
        let stop = Stop { passes: Some(45), ..Stop::default() };
        let reason = state.go_on(&mut backend, stop, |_| true).expect("a picture");
        let wanted = [
            (0, 1),
            (1, 1),
            (2, 1),
            (3, 1),
            (4, 2),
            (6, 2),
            (8, 4),
            (12, 4),
            (16, 8),
            (24, 8),
            (32, 8),
            (40, 4),
            (44, 1),
        ];
        assert_eq!(backend.rendered, wanted);
        let begun: Vec<_> = wanted.into_iter().filter(|(first, _)| *first > 1).collect();
        assert_eq!(backend.begun, begun);
        let whole = render(&mut Counter, [1, 1], stop, |_| true).expect("a picture");
        assert_eq!(state.finish(reason).picture.whole, whole.picture.whole);
        // a state that was not told to
        let mut backend = Ahead::default();
        render(&mut backend, [1, 1], stop, |_| true).expect("a picture");
        assert!(backend.begun.is_empty());
    }

    /// Where the time ends soon nothing begins that may not be asked for.
    #[test]
    fn nothing_begins_when_the_time_is_nearly_up() {
        let mut backend = Ahead { nap: Duration::from_millis(5), ..Ahead::default() };
        let mut state = RenderState::new([1, 1]);
        state.look_ahead();
        let stop = Stop { seconds: Some(0.1), ..Stop::default() };
        state.go_on(&mut backend, stop, |_| true).expect("a picture");
        assert!(backend.begun.len() > 3, "{:?}", backend.begun);
        for batch in &backend.begun {
            assert!(backend.rendered.contains(batch), "{batch:?} of {:?}", backend.rendered);
        }
    }

    /// A render ends before its passes have numbers of more than 32 bits, or the pilot's.
    #[test]
    fn passes_end_before_their_numbers_do() {
        let mut passes = 0;
        while passes < PASSES_MAX {
            passes += batch(passes, u32::MAX, PASSES_MAX);
        }
        assert_eq!(passes - 1, u64::from(u32::MAX) - 1);
        let last = u64::from(crate::packed::constants::PILOT_PASS);
        assert_eq!(PASSES_MAX, last, "the pilot's pass comes after all others");
    }

    /// A watcher sees the picture so far, layers summed, and its own time is not counted as rendering.
    #[test]
    fn watching_is_free_and_sees_the_picture() {
        let nap = Duration::from_millis(40);
        let mut seen = Vec::new();
        let stop = Stop { passes: Some(4), ..Stop::default() };
        let rendered = render(&mut Counter, [1, 1], stop, |p| {
            seen.push((p.passes, p.picture().whole.pixels[0][0]));
            std::thread::sleep(nap);
            true
        })
        .expect("a picture");
        // means of 0, 0 1, 0 1 2, 0 1 2 3, in each of four layers
        assert_eq!(seen, [(1, 0.0), (2, 2.0), (3, 4.0), (4, 6.0)]);
        assert_eq!(rendered.picture.whole.pixels[0][0], 6.0);
        assert!(rendered.seconds < nap.as_secs_f64(), "{} s for nothing but naps", rendered.seconds);
    }
}
