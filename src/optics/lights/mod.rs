//! Lights: how jotons leave them, how shadow rays find them, and what rays that meet them see. Each kind is a file; `light.rs` is the
//! table.

pub(crate) mod cone;
pub(crate) mod light;
pub(crate) mod pick;
mod point;
pub mod reservoir;
pub(crate) mod samples;
mod spot;
mod sun;
mod triangle;
