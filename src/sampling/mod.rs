//! Sampling: random numbers, and what is distributed by them.

pub mod distributions;
pub mod rng;
