//! Faults: what tests make a device do wrong. Only where debug assertions are on; in a release nothing is counted and nothing fails.

#[cfg(debug_assertions)]
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Where a device may fail. Each is counted from 0 on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Point {
    /// It is lost before commands are handed over.
    Submission,
    /// It is lost while they run.
    Running,
    /// It is lost when they are done, before what they found is read.
    Reading,
    /// It has no memory for a buffer.
    Buffer,
    /// It does not compile a kernel.
    Kernel,
}

impl Point {
    /// All of them.
    pub const ALL: [Point; 5] =
        [Point::Submission, Point::Running, Point::Reading, Point::Buffer, Point::Kernel];
}

/// What is to go wrong with a device, and how often it has come by each point.
#[derive(Debug, Default)]
pub struct Faults {
    #[cfg(debug_assertions)]
    told: Mutex<Told>,
}

#[cfg(debug_assertions)]
#[derive(Debug, Default)]
struct Told {
    fault: Option<(Point, u32)>,
    seen: [u32; Point::ALL.len()],
}

#[cfg(debug_assertions)]
impl Faults {
    fn told(&self) -> MutexGuard<'_, Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The device fails when it comes by a point for the `number`th time, counted from 0.
    pub fn ask_for(&self, point: Point, number: u32) {
        self.told().fault = Some((point, number));
    }

    /// How often it has come by a point.
    pub fn seen(&self, point: Point) -> u32 {
        self.told().seen[point as usize]
    }

    /// Whether it fails here.
    pub(super) fn strike(&self, point: Point) -> bool {
        let mut told = self.told();
        let seen = &mut told.seen[point as usize];
        let number = *seen;
        *seen += 1;
        told.fault == Some((point, number))
    }
}

#[cfg(not(debug_assertions))]
impl Faults {
    #[inline]
    pub(super) fn strike(&self, _: Point) -> bool {
        false
    }
}
