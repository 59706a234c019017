//! Lights: how jotons leave them, and how shadow rays find them.

pub(crate) mod cone;
pub(crate) mod emit;
pub mod reservoir;
pub(crate) mod sample;
