//! Subject: what is measured.

use crate::film::Image;

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
    /// Steps of the ladder, seconds of rendering, ascending and above 0.
    pub times: &'a [f64],
    /// Seeds 0, 1, … below this.
    pub seeds: u32,
    /// Measure what each kernel takes, where the device can.
    pub timings: bool,
}
