//! joton: a progressive photon mapper that runs on the GPU.
#![forbid(unsafe_code)]
#![warn(missing_docs, unreachable_pub)]

pub mod backend;
pub mod bench;
mod error;
pub mod estimators;
pub mod film;
mod host;
pub mod optics;
pub mod output;
pub mod packed;
pub mod plan;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod spectrum;

pub use error::{Error, Result};
pub use host::memory::peak as peak_memory;
