//! Functions that the kernels share, each against Rust on given inputs: shaders/shared, file by file.

#[path = "../common/mod.rs"]
mod common;

mod anisotropy;
mod bsdf;
mod disc;
mod disc_count;
mod emit;
mod emitter;
mod facets;
mod followed;
mod grid;
mod intersect;
mod layers;
mod live;
mod paths;
mod rng;
mod sampling;
mod scatter;
mod texture;
