//! State: what a render has found so far, and the loop that goes on from there.

use super::clock::{Clock, StillToCome};
use super::imbalance::Imbalance;
use super::{
    DEFAULT_ERROR, DEFAULT_SECONDS, Failure, PassRange, Progress, Reason, Rendered, ResolvedLayers, Stop,
    picture,
};
use crate::backend::{Backend, Batch, HostSeconds, HostWork, PASSES_MAX, Tally, guarded};
use crate::error::Result;
use crate::estimators::split_paths::{self, SplitPaths};
use crate::film::Layer;
use crate::film::tile_schedule::{EXPONENT_MAX, TileSchedule};
use crate::render::error_estimate::{self, ErrorEstimate, ErrorEstimator};
use crate::render::static_tiles::StaticTiles;
use crate::resolve::Resolver;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Where the time or the error is within this part of what stops a render, no batch begins before it is known to be needed.
const SURELY: f64 = 0.9;

/// Passes before an error estimate is trusted.
const ERROR_PASSES: u64 = 4;

/// What a render has found so far: all that it takes to go on.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub struct RenderState {
    pub(super) size: [u32; 2],
    pub(super) sums: ErrorEstimator,
    /// Who may rest, where the first device lets pixels rest.
    static_tiles: Option<StaticTiles>,
    glimpses: split_paths::Watch,
    /// Who had trees last.
    glints: Option<SplitPaths>,
    /// Where it is a part of a render, which.
    pub(super) part: Option<PassRange>,
    pub(super) tally: Tally,
    pub(super) imbalance: Imbalance,
    /// The next one.
    pub(super) pass: u64,
    pub(super) error: Option<ErrorEstimate>,
    /// Seconds of rendering, and processor seconds of all threads.
    pub(super) reading: [f64; 2],
    pub(super) failures: Vec<Failure>,
    /// Of this process.
    #[serde(skip)]
    host: HostSeconds,
    /// Whether a device may begin with a batch before it is known that the picture needs it.
    #[serde(skip)]
    looks_ahead: bool,
    /// Whether it has.
    #[serde(skip)]
    is_ahead: bool,
    /// What the picture will take after the last pass, and the last batch took: time is kept with them in mind.
    #[serde(skip)]
    still_to_come: StillToCome,
    /// Smooths pictures.
    #[serde(skip)]
    resolver: Option<Arc<Resolver>>,
    /// The last that was.
    #[serde(skip)]
    resolved: ResolvedLayers,
}

impl RenderState {
    /// Nothing rendered yet.
    pub fn new(size: [u32; 2]) -> Self {
        Self::with_sums(size, ErrorEstimator::new(size), None)
    }

    /// Nothing rendered yet of a part of a render. Parts can be merged, by [`RenderState::merge`], into the very sums of a part that has all
    /// their passes. What a render decides by what it sees, it decides in its first [`PassRange::HEAD`] passes; a part that begins later
    /// renders these, too, where there is something to decide, and forgets their light.
    pub fn of_part(size: [u32; 2], range: PassRange) -> Self {
        Self::with_sums(size, ErrorEstimator::of_part(size, 0), Some(range))
    }

    fn with_sums(size: [u32; 2], sums: ErrorEstimator, part: Option<PassRange>) -> Self {
        Self {
            size,
            sums,
            static_tiles: None,
            glimpses: split_paths::Watch::new(size),
            glints: None,
            part,
            tally: Tally::default(),
            imbalance: Imbalance::default(),
            pass: 0,
            error: None,
            reading: [0.0; 2],
            failures: Vec::new(),
            host: HostSeconds::default(),
            looks_ahead: false,
            is_ahead: false,
            still_to_come: StillToCome::default(),
            resolver: None,
            resolved: Vec::new(),
        }
    }

    /// Whether it is one that a render can have left, where it was stored: whatever else says it is, no index leads out of it.
    pub(crate) fn is_sound(&self) -> bool {
        let (size, film) = (self.size, self.sums.film());
        if !self.sums.is_sound(size, self.part.is_some()) {
            return false;
        }
        let is_of_part = match self.part {
            None => film.range().start == 0,
            Some(part) => {
                let first = if self.is_in_head() { 0 } else { part.first() };
                PassRange::new(part.first(), part.end()).is_ok() && film.range().start == first
            }
        };
        is_of_part
            && self.pass == film.range().end
            && self.pass <= PASSES_MAX
            && self.glimpses.is_sound(size)
            && self.glints.as_ref().is_none_or(|glints| glints.is_sound(size))
            && self.static_tiles.as_ref().is_none_or(|tiles| tiles.is_sound(size))
    }

    /// How pictures are smoothed, where no device says so: of a state that was stored.
    pub fn set_resolver(&mut self, resolver: Option<Arc<Resolver>>) {
        self.resolver = resolver;
    }

    /// From now on a device that works beside the host begins with the next batch while the host adds up the last one. Watchers then
    /// run beside it, too, and what they take is part of the rendering. The picture is the same.
    pub fn look_ahead(&mut self) {
        self.looks_ahead = true;
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Passes in the picture.
    pub fn passes(&self) -> u64 {
        if self.is_in_head() { 0 } else { self.sums.film().passes() }
    }

    /// The passes in the picture: the first, and the one after the last.
    pub fn range(&self) -> Range<u64> {
        self.sums.film().range()
    }

    /// Whether it is a part of a render.
    pub fn part(&self) -> Option<PassRange> {
        self.part
    }

    /// Whether the passes so far come before those of the part, to decide what it must know.
    fn is_in_head(&self) -> bool {
        self.part.is_some_and(|part| self.pass < part.first())
    }

    /// Forget the light of the head: the part begins.
    fn begin_part(&mut self, part: PassRange) {
        let mut sums = ErrorEstimator::of_part(self.size, part.first());
        sums.set_resolves(self.sums.resolves());
        (self.sums, self.pass) = (sums, part.first());
        (self.tally, self.imbalance) = Default::default();
    }

    /// Render until `stop` on `backend`; where it fails, go on with what `next` gives. Why it stopped, and the device that was
    /// in use then.
    ///
    /// # Errors
    /// What the last device reports when `next` has none. The passes before are still there.
    pub fn go_on_while_devices_last(
        &mut self,
        mut backend: Box<dyn Backend>,
        stop: Stop,
        mut watch: impl FnMut(&Progress<'_>) -> bool,
        mut next: impl FnMut(&Failure) -> Option<Box<dyn Backend>>,
    ) -> Result<(Reason, Box<dyn Backend>)> {
        loop {
            let e = match self.go_on(backend.as_mut(), stop, &mut watch) {
                Ok(reason) => return Ok((reason, backend)),
                Err(e) => e,
            };
            let failure = Failure { device: backend.describe(), passes: self.passes(), what: e.to_string() };
            // its memory is free before the next one asks for some; where even that fails, nothing better can be done
            guarded(|| drop(backend)).ok();
            let found = next(&failure);
            self.failures.push(failure);
            backend = found.ok_or(e)?;
        }
    }

    /// Render on from the passes so far until `stop`, which counts those, too.
    ///
    /// # Errors
    /// What the backend reports. The passes before are still there.
    pub fn go_on(
        &mut self,
        backend: &mut dyn Backend,
        stop: Stop,
        mut watch: impl FnMut(&Progress<'_>) -> bool,
    ) -> Result<Reason> {
        let stop = if stop == Stop::default() {
            Stop { error: Some(DEFAULT_ERROR), seconds: Some(DEFAULT_SECONDS), passes: None }
        } else {
            stop
        };
        self.resolver = backend.resolver();
        if self.pass > 0
            && let Some(reason) = self.reason(stop, true)
        {
            return Ok(reason);
        }
        self.set_up(backend)?;
        let reason = self.add_batches(backend, stop, &mut watch);
        // the picture takes the place of the last batch
        backend.reuse(Batch::default());
        reason
    }

    /// Batch after batch until `stop`.
    fn add_batches(
        &mut self,
        backend: &mut dyn Backend,
        stop: Stop,
        watch: &mut dyn FnMut(&Progress<'_>) -> bool,
    ) -> Result<Reason> {
        let mut clock = Clock::start();
        clock.go_on_from(self.reading);
        if let Some(resolver) = self.resolver.clone().filter(|_| stop.seconds.is_some()) {
            self.still_to_come.picture = self.host.time(HostWork::Resolving, || resolver.foresee());
        }
        loop {
            let count = self.batch_passes(backend, self.pass, stop);
            let begin = Instant::now();
            let added = self.add_batch(backend, count, stop);
            self.still_to_come.pass = begin.elapsed().as_secs_f64() / count as f64;
            self.still_to_come.passes = self.batch_passes(backend, self.pass, stop);
            if stop.error.is_some() {
                self.renew_estimate(backend, stop);
            }
            self.reading = clock.read();
            added?;
            let go_on = watch(&self.progress(stop));
            if !self.is_ahead {
                clock.go_on_from(self.reading);
            }
            if let Some(reason) = self.reason(stop, go_on) {
                return Ok(reason);
            }
        }
    }

    /// Tell a backend who rests and who has trees.
    fn set_up(&mut self, backend: &mut dyn Backend) -> Result<()> {
        let can_rest = backend.set_tile_schedule(&TileSchedule::none(self.size));
        if self.pass == 0 {
            if let Some(resolver) = &self.resolver {
                self.sums.set_resolves(resolver.layers());
            }
            // who rests is decided by all passes before
            let can_rest = can_rest && self.part.is_none();
            self.static_tiles = can_rest.then(|| StaticTiles::new(self.size));
            return Ok(());
        }
        if can_rest {
            backend.set_tile_schedule(self.sums.film().tile_schedule());
        } else {
            // pixels that rest get their samples, and more that nobody asked for, until they wake
            self.static_tiles = None;
        }
        if let Some(before) = &self.glints {
            // a backend that has not looked yet need not
            let joined = backend.split_paths().map_or_else(|| before.clone(), |own| own.joined(before));
            backend.set_split_paths(joined)?;
        }
        Ok(())
    }

    /// Passes of the batch from pass `first` on: a power of two, which blocks of resting tiles are whole parts of, or whole multiples.
    /// 0 where all are done.
    fn batch_passes(&self, backend: &dyn Backend, first: u64, stop: Stop) -> u64 {
        if first >= most(stop) {
            return 0;
        }
        if self.static_tiles.is_none() && !self.sums.film().tile_schedule().is_none() {
            // the film takes single samples, and the device sums all
            return 1;
        }
        // it begins at a multiple of it, wherever another device stopped
        let aligned = 1 << first.trailing_zeros().min(u64::BITS - 1);
        batch(first, backend.batch_passes(first), most(stop)).min(aligned)
    }

    /// Passes of the batch that a device may begin with while the one of `count` passes is added up: where nothing is decided in between,
    /// and it looks as if the picture will need it.
    fn batch_ahead(&self, backend: &dyn Backend, count: u64, stop: Stop) -> Option<u64> {
        let after = self.pass + count;
        // who rests and who has trees is told at powers of two
        if !self.looks_ahead || !backend.works_beside_host() || after.is_power_of_two() || after >= most(stop)
        {
            return None;
        }
        let passes = self.batch_passes(backend, after, stop);
        let by_then = StillToCome { passes, ..self.still_to_come };
        let seconds = self.reading[0] + self.still_to_come.pass * count as f64 + by_then.seconds();
        let is_over = stop.seconds.is_some_and(|most| seconds >= SURELY * most);
        let is_good = self.error.zip(stop.error).is_some_and(|(e, limit)| SURELY * e.total <= limit);
        (!is_over && !is_good).then_some(passes)
    }

    /// Render a batch and add it. Where the backend fails, the batch is in whole or not at all.
    fn add_batch(&mut self, backend: &mut dyn Backend, count: u64, stop: Stop) -> Result<()> {
        let begin = Instant::now();
        let ahead = self.batch_ahead(backend, count, stop);
        self.is_ahead = ahead.is_some();
        if let Some(ahead) = ahead {
            backend.begin(self.pass, count as u32)?;
            backend.begin(self.pass + count, ahead as u32)?;
        }
        let rendered = backend.render(self.pass, count as u32);
        let between = backend.take_host_seconds();
        self.host += between;
        self.host
            .add(HostWork::Device, begin.elapsed().saturating_sub(Duration::from_secs_f64(between.total())));
        let mut batch = rendered?;
        // black layers are not summed
        for layer in Layer::ALL.into_iter().filter(|l| !backend.traces(*l)) {
            batch.layers[layer as usize] = Vec::new();
        }
        let blur = mean_blur(backend, self.pass, count);
        self.host.time(HostWork::Summing, || self.sums.add(self.pass, count, &batch.layers, blur));
        let (begin, mut lists) = (Instant::now(), Duration::ZERO);
        self.tally += batch.tally;
        self.imbalance.add(count, &batch.tally);
        if let Some(static_tiles) = &mut self.static_tiles {
            static_tiles.watch(self.pass, count, &batch.layers);
        }
        let head_of = self.part.filter(|_| self.is_in_head());
        self.pass += count;
        if is_estimated(self.passes()) {
            self.error = self.sums.error();
        }
        if let Some(glints) = backend.split_paths() {
            self.glimpses.watch(count, &batch.layers[Layer::Emission as usize], glints);
            let may_grow = self.part.is_none() || self.pass <= PassRange::HEAD;
            if self.pass > 1 && self.pass.is_power_of_two() && may_grow {
                let grown = self.glimpses.grown(glints, self.sums.film());
                self.glints = Some(grown.clone());
                let begin = Instant::now();
                backend.set_split_paths(grown)?;
                lists = begin.elapsed();
            }
        }
        match &mut self.static_tiles {
            Some(static_tiles) => {
                if let Some(schedule) = static_tiles.renew(self.pass, backend.split_paths()) {
                    backend.set_tile_schedule(schedule);
                    self.sums.set_tile_schedule(schedule.clone());
                }
            }
            // all blocks end here
            None if self.pass.is_multiple_of(1 << EXPONENT_MAX)
                && !self.sums.film().tile_schedule().is_none() =>
            {
                self.sums.set_tile_schedule(TileSchedule::none(self.size));
            }
            None => {}
        }
        let is_decided = self.pass >= PassRange::HEAD || backend.split_paths().is_none();
        if let Some(part) = head_of.filter(|_| is_decided) {
            self.begin_part(part);
        }
        self.host.add(HostWork::Statistics, begin.elapsed() - lists);
        self.host.add(HostWork::Lists, lists);
        backend.reuse(batch);
        Ok(())
    }

    /// Where the picture is resolved, its error is known when it is: at powers of four of passes, and where it may be small enough.
    fn renew_estimate(&mut self, backend: &mut dyn Backend, stop: Stop) {
        let Some(resolver) = self.resolver.clone() else { return };
        let passes = self.passes();
        let is_due = passes >= ERROR_PASSES && passes.is_power_of_two() && passes.ilog2().is_multiple_of(2);
        let may_stop = self.error.is_some_and(|e| stop.error.is_some_and(|limit| e.total <= limit));
        let is_known = self.sums.resolved_at() == Some(passes);
        if (is_due || may_stop) && !is_known {
            let begin = Instant::now();
            // what sharing holds takes the place of the last batch
            backend.reuse(Batch::default());
            self.resolve(&resolver);
            self.still_to_come.picture = begin.elapsed().as_secs_f64();
            self.error = self.sums.error();
        }
    }

    /// Share light as the passes so far have it.
    fn resolve(&mut self, resolver: &Resolver) {
        let step = self.sums.step();
        self.resolved = Vec::new();
        self.resolved = self.host.time(HostWork::Resolving, || resolver.resolve(self.sums.film(), step));
        self.host.time(HostWork::Statistics, || self.sums.set_resolved(&self.resolved));
        // that tells it from here on
        self.resolved.iter_mut().for_each(|(_, resolved)| resolved.squared_error = Vec::new());
    }

    fn progress(&self, stop: Stop) -> Progress<'_> {
        let [seconds, cpu_seconds] = self.reading;
        let part = |value: f64, limit: Option<f64>| limit.map_or(0.0, |l| value / l);
        let by_error = match (self.error, stop.error) {
            (Some(e), Some(l)) => (l / e.total).powi(2),
            _ => 0.0,
        };
        let passes = self.passes();
        let first = self.part.map_or(0, PassRange::first);
        let by_passes = part(passes as f64, stop.passes.map(|end| end.saturating_sub(first) as f64));
        let done = by_passes.max(part(seconds, stop.seconds)).max(by_error).min(1.0);
        Progress {
            passes,
            seconds,
            error: self.error,
            done,
            cpu_seconds,
            tally: &self.tally,
            state: self,
            estimator: &self.sums,
            resolver: self.resolver.as_deref(),
        }
    }

    /// Why to stop here, if so.
    fn reason(&self, stop: Stop, go_on: bool) -> Option<Reason> {
        let is_small = |limit: f64| self.error.is_some_and(|e| e.total <= limit);
        if self.pass >= most(stop) {
            Some(Reason::Passes)
        } else if stop.error.is_some_and(is_small) {
            Some(Reason::Error)
        } else if !go_on {
            Some(Reason::Interrupted)
        } else if stop.seconds.is_some_and(|most| self.reading[0] + self.still_to_come.seconds() >= most) {
            Some(Reason::Time)
        } else {
            None
        }
    }

    /// The picture of the passes so far, and what is known of it.
    pub fn finish(mut self, reason: Reason) -> Rendered {
        let clock = Clock::start();
        let passes = self.passes();
        // a state that was stored comes without
        let is_resolved = self.sums.resolved_at() == Some(passes) && !self.resolved.is_empty();
        if let Some(resolver) = self.resolver.clone().filter(|_| !is_resolved) {
            self.resolve(&resolver);
        }
        let is_known = self.resolver.is_none() && (passes < ERROR_PASSES || is_estimated(passes));
        let error_estimate = if is_known { self.error } else { self.sums.error() };
        // the picture takes the place of what told its error, and of what it shows
        (self.resolver, self.static_tiles, self.glints) = Default::default();
        let mut film = self.sums.into_film();
        film.forget_halves();
        let resolved = self.resolved;
        let picture = self.host.time(HostWork::Picture, || picture(&film, resolved));
        let spent = clock.read();
        let [seconds, cpu_seconds] = [0, 1].map(|i| self.reading[i] + spent[i]);
        Rendered {
            picture,
            passes,
            seconds,
            cpu_seconds,
            tally: self.tally,
            energy_error: self.imbalance.relative_error(),
            error_estimate,
            reason,
            failures: self.failures,
            host: self.host,
        }
    }
}

/// Passes in all, at most.
fn most(stop: Stop) -> u64 {
    stop.passes.unwrap_or(PASSES_MAX).min(PASSES_MAX)
}

/// Passes of the batch from pass `first` on, where the backend would like so many, of `most` in all: powers of two, which blocks
/// of resting tiles are whole parts of, or whole multiples.
pub(super) fn batch(first: u64, wanted: u32, most: u64) -> u64 {
    1 << u64::from(wanted).min(error_estimate::run(first)).min(most - first).ilog2()
}

/// Whether the error is estimated after so many passes: after each one first, later after every sixteenth part of them, so
/// that it costs nothing.
fn is_estimated(passes: u64) -> bool {
    passes >= ERROR_PASSES && passes.is_multiple_of(1 << passes.ilog2().saturating_sub(4))
}

/// Mean of the maps' blur over `count` passes.
fn mean_blur(backend: &dyn Backend, first: u64, count: u64) -> f64 {
    (first..first + count).map(|pass| backend.blur(pass)).sum::<f64>() / count as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A render stops where what is still to come ends next to the time that was asked for: the picture, and no batch of which more
    /// than half would come later.
    #[test]
    fn time_is_kept_with_the_picture_in_mind() {
        let stop = Stop { seconds: Some(10.0), ..Stop::default() };
        for (seconds, picture, batch, stops) in [
            (10.0, 0.0, 0.0, true),
            (9.9, 0.0, 0.0, false),
            (8.9, 1.0, 0.0, false),
            (9.1, 1.0, 0.0, true),
            (8.9, 0.0, 2.0, false),
            (9.1, 0.0, 2.0, true),
            (8.1, 1.0, 2.0, true),
        ] {
            let mut state = RenderState::new([1, 1]);
            state.reading = [seconds, seconds];
            state.still_to_come = StillToCome { picture, pass: batch / 4.0, passes: 4 };
            let reason = state.reason(stop, true);
            assert_eq!(
                reason,
                stops.then_some(Reason::Time),
                "{seconds} s, picture {picture}, batch {batch}"
            );
        }
    }
}
