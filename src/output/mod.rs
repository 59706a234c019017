//! What leaves the renderer: image files, the display transform, and comparisons with a reference.

pub mod compare;
pub mod display;
pub mod exr;
pub mod png;

mod atomic;
mod heatmap;
