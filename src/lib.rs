//! joton: a progressive photon mapper that runs on the GPU.
#![forbid(unsafe_code)]
#![warn(missing_docs, unreachable_pub)]

pub mod bands;
pub mod error;
pub mod film;
pub mod output;
pub mod paths;
pub mod scene;
pub mod stats;

pub use error::{Error, Result};
