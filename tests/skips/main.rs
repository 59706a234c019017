//! Skips: which there are and why, that keeping what is skipped changes nothing in the image, and that nothing is skipped
//! that would be in it.
//!
//! Seeds are fixed, so a run is repeatable.

mod dark;
mod edges;
mod kept;
mod picks;
mod reach;
mod renders;
mod snapshot;

#[path = "../common/mod.rs"]
mod common;
