//! joton: a progressive photon mapper that runs on the GPU.
#![forbid(unsafe_code)]
#![warn(missing_docs, unreachable_pub)]

pub mod backend;
pub mod bands;
pub mod bench;
pub mod bvh;
pub mod cpu;
pub mod error;
pub mod export;
pub mod film;
pub mod glints;
pub mod gpu;
mod halves;
mod input;
pub mod layout;
pub mod memory;
mod neighbours;
pub mod optics;
pub mod output;
pub mod pack;
pub mod paths;
pub mod plan;
mod quiet;
pub mod render;
pub mod report;
pub mod rest;
pub mod rng;
pub mod scene;
pub mod stats;

pub use error::{Error, Result};
