//! Host seconds: what the host does between kernels, by cause. A device waits for it.

use std::ops::AddAssign;
use std::time::{Duration, Instant};

/// What the host does for a render, and what it waits for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum HostWork {
    /// Kernels that run, and what drivers do around them: no work of the host, but on the CPU backend and where an image is rendered in
    /// strips, whose recording and reading back are not told apart.
    Device,
    /// Lists for the device: who rests, who has trees, area points.
    Lists,
    /// Recording what a pass dispatches, and handing it over.
    Recording,
    /// Copying films and counts to the host.
    ReadingBack,
    /// Adding them to the sums over passes.
    Summing,
    /// Estimating the error, finding out who may rest and who needs trees.
    Statistics,
    /// Sharing light with neighbours.
    Resolving,
    /// Making the picture.
    Picture,
}

impl HostWork {
    /// All causes, in the order of a render.
    pub const ALL: [HostWork; 8] = [
        HostWork::Device,
        HostWork::Lists,
        HostWork::Recording,
        HostWork::ReadingBack,
        HostWork::Summing,
        HostWork::Statistics,
        HostWork::Resolving,
        HostWork::Picture,
    ];

    /// Name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            HostWork::Device => "device",
            HostWork::Lists => "lists",
            HostWork::Recording => "recording",
            HostWork::ReadingBack => "reading_back",
            HostWork::Summing => "summing",
            HostWork::Statistics => "statistics",
            HostWork::Resolving => "resolving",
            HostWork::Picture => "picture",
        }
    }
}

/// Seconds of each kind of work.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HostSeconds([f64; HostWork::ALL.len()]);

impl HostSeconds {
    /// Do some work and count its time.
    pub fn time<T>(&mut self, work: HostWork, what: impl FnOnce() -> T) -> T {
        let begin = Instant::now();
        let done = what();
        self.add(work, begin.elapsed());
        done
    }

    /// Count some time.
    pub fn add(&mut self, work: HostWork, time: Duration) {
        self.0[work as usize] += time.as_secs_f64();
    }

    /// Seconds of one kind.
    pub fn of(&self, work: HostWork) -> f64 {
        self.0[work as usize]
    }

    /// All together.
    pub fn total(&self) -> f64 {
        self.0.iter().sum()
    }

    /// What it is called, and its seconds, of each kind.
    pub fn by_name(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let all = *self;
        HostWork::ALL.into_iter().map(move |work| (work.name(), all.of(work)))
    }

    /// As an object: seconds by name.
    ///
    /// # Errors
    /// What the serializer reports.
    pub fn as_object<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.by_name())
    }
}

impl AddAssign for HostSeconds {
    fn add_assign(&mut self, other: Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += more);
    }
}
