//! Numerical stress: scenes and numbers at the limits of f32, u32 and of what surfaces do to each other. Each stress says
//! what it tried, on which backend, its worst error and the limit of it.
//!
//! `cargo test --test stress` runs them all in a size for every day. The table of docs is written by
//! ```text
//! JOTON_STRESS=long JOTON_STRESS_TABLE=docs/STRESS.md cargo test --release --test stress
//! ```
//! `JOTON_STRESS_TABLE=-` prints it. Names of stresses filter, as in any test. `JOTON_TEST_NO_GPU=1` leaves out what needs
//! a device, and says so. One stress runs at a time: most use all cores.

#[path = "../analytic/build.rs"]
#[allow(dead_code, reason = "shared with the closed forms, which use all of it")]
mod build;
#[path = "../common/mod.rs"]
mod common;
mod frames;
#[path = "../analytic/harness.rs"]
#[allow(dead_code, reason = "shared with the closed forms, which use all of it")]
mod harness;
mod lights;
mod maps;
mod numbers;
mod optics;
mod sheet;
mod shoot;
mod surfaces;
mod watertight;

use libtest_mimic::{Arguments, Trial};
use sheet::Stress;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = Arguments::from_args();
    arguments.test_threads.get_or_insert(1);
    let stresses: Vec<Stress> = [
        frames::STRESSES,
        watertight::STRESSES,
        surfaces::STRESSES,
        optics::STRESSES,
        lights::STRESSES,
        maps::STRESSES,
        numbers::STRESSES,
    ]
    .concat();
    let trials = stresses.iter().map(|&s| Trial::test(s.name, move || sheet::run(s))).collect();
    let conclusion = libtest_mimic::run(&arguments, trials);
    if let Err(e) = sheet::write(&stresses) {
        eprintln!("the table is not written: {e}");
        return ExitCode::FAILURE;
    }
    conclusion.exit_code()
}
