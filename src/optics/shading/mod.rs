//! Shading: what a surface does with light, as a short list of lobes. Each lobe is a file; `bsdf` holds the list at a hit, and all that
//! follow light see that only.

pub mod bsdf;
pub(crate) mod dielectric;
pub(crate) mod frame;
pub(crate) mod lambert;
pub(crate) mod mirror;
pub mod phong;
pub(crate) mod roulette;
