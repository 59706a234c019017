//! Clock: what a render has taken, and what is still to come.

use std::time::Instant;

/// Seconds of rendering, without what the watcher does in between.
#[derive(Debug)]
pub(super) struct Clock {
    since: Instant,
    cpu_since: cpu_time::ProcessTime,
    before: [f64; 2],
}

impl Clock {
    pub(super) fn start() -> Self {
        Self { since: Instant::now(), cpu_since: cpu_time::ProcessTime::now(), before: [0.0; 2] }
    }

    /// Seconds, and processor seconds of all threads.
    pub(super) fn read(&self) -> [f64; 2] {
        let now = [self.since.elapsed(), self.cpu_since.elapsed()].map(|d| d.as_secs_f64());
        [self.before[0] + now[0], self.before[1] + now[1]]
    }

    /// Go on from an earlier reading.
    pub(super) fn go_on_from(&mut self, reading: [f64; 2]) {
        *self = Self { before: reading, ..Self::start() };
    }
}

/// Seconds of what follows.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StillToCome {
    pub(super) picture: f64,
    /// Of a pass.
    pub(super) pass: f64,
    /// Passes of the next batch.
    pub(super) passes: u64,
}

impl StillToCome {
    /// Where another batch would end nearer to the time that is wanted than this one there is one.
    pub(super) fn seconds(&self) -> f64 {
        self.picture + self.pass * self.passes as f64 / 2.0
    }
}
