//! joton: a progressive photon mapper that runs on the GPU.
//!
//! A scene is read by [`scene::load`], packed into the arrays that kernels read ([`packed::PackedScene`]), planned
//! ([`plan::Plan`]: what is traced, with how many jotons, and what is skipped) and rendered pass after pass by a backend
//! ([`backend::gpu::GpuBackend`] or [`backend::cpu::CpuBackend`]) until [`render::Stop`] says so. The picture has a layer for each
//! class of light path ([`film::Layer`]).
//!
//! ```
//! use joton::backend::cpu::CpuBackend;
//! use joton::film::Layer;
//! use joton::packed::PackedScene;
//! use joton::plan::{Plan, Settings};
//! use joton::render::{Stop, render};
//! use std::{path::Path, sync::Arc};
//!
//! # fn main() -> joton::Result<()> {
//! let mut scene = joton::scene::load(Path::new("scenes/cornell.toml"))?;
//! scene.resize([32, 32]);
//! let packed = Arc::new(PackedScene::new(&scene));
//! let plan = Plan::new(&packed, Settings::default());
//! // on a GPU: GpuBackend::new(Context::open(None)?, Arc::clone(&packed), plan)?
//! let mut backend = CpuBackend::new(Arc::clone(&packed), plan);
//! let stop = Stop { passes: Some(4), ..Stop::default() };
//! let rendered = render(&mut backend, packed.size, stop, |progress| {
//!     println!("{:3.0} %", 100.0 * progress.done);
//!     true // false stops
//! })?;
//! let caustics = &rendered.picture.layers[Layer::Caustic as usize];
//! println!("{} passes, {} × {} pixels", rendered.passes, caustics.width, caustics.height);
//! # Ok(())
//! # }
//! ```
//!
//! Everything that fails says so by an [`Error`], whose text names what to do about it. Lengths, powers and radiances of a
//! [`scene::Scene`] are in the file's units and W, W/m² and W/(m² sr); those of a packed scene in internal units of length.
//!
//! Modules that these pages do not list are public for joton's own program and tests. They change without notice.
#![forbid(unsafe_code)]
#![warn(missing_docs, unreachable_pub)]

pub mod backend;
#[cfg(feature = "bench")]
#[doc(hidden)]
pub mod bench;
mod error;
#[doc(hidden)]
pub mod estimators;
pub mod film;
#[doc(hidden)]
pub mod host;
#[doc(hidden)]
pub mod optics;
pub mod output;
pub mod packed;
pub mod plan;
pub mod render;
#[doc(hidden)]
pub mod resolve;
#[doc(hidden)]
pub mod sampling;
pub mod scene;
pub mod spectrum;

pub use error::{Error, Result};
