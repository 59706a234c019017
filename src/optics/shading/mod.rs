//! Shading: what a surface does with light.

pub mod bsdf;
pub(crate) mod roulette;
