//! Subject: what is measured, and by which clock.

use crate::film::Image;

/// What time is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Clock {
    /// Processor seconds of all threads: other work on the machine hardly changes them.
    Cpu,
    /// Seconds as they pass.
    Wall,
}

impl Clock {
    /// The one of both times that this clock shows.
    pub(super) fn read(self, seconds: f64, cpu_seconds: f64) -> f64 {
        match self {
            Self::Cpu => cpu_seconds,
            Self::Wall => seconds,
        }
    }
}

/// What is measured: a scene on a device.
pub struct Subject<'a> {
    /// Name of the scene.
    pub scene: &'a str,
    /// The device as it was asked for.
    pub device: &'a str,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// What the picture should be.
    pub reference: Option<&'a Image>,
    /// Steps of the ladder, seconds of rendering by `clock`, ascending and above 0.
    pub times: &'a [f64],
    /// What `times` count; other renderers count processor seconds.
    pub clock: Clock,
    /// Seeds 0, 1, … below this.
    pub seeds: u32,
    /// Measure what each kernel takes, where the device can.
    pub timings: bool,
}
