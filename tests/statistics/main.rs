//! Statistics: every sampler against its density, every random number against its neighbours, images against images,
//! random scenes against what must hold of any; tiles that rest.
//!
//! Seeds are fixed, so a run is repeatable. `JOTON_STATISTICS_SEED=n` draws other numbers: over many n a test fails by
//! chance about once in 10,000. `PROPTEST_CASES=n` renders n random scenes instead of a few.

#[path = "../common/mod.rs"]
mod common;

mod bsdf;
mod chi_square;
mod determinism;
mod device;
mod directions;
mod emission;
mod glints;
mod guide;
mod images;
mod layers;
mod media;
mod mitsuba;
mod mixtures;
mod negative;
mod non_finite;
mod picking;
mod random_numbers;
mod random_scenes;
mod recipe;
mod renders;
mod reservoir;
mod rest;
mod surfaces;
mod visible_cells;
mod walls;
mod winding;
