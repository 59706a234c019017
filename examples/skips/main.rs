//! What skips save: a table in Markdown.
//!
//! `cargo run --release --example skips -- [--device gpu|cpu] [--quick] > table.md`
//!
//! For each part that a plan may skip, a scene without it, rendered with the skip and with the part kept, and its twin that
//! has it, where keeping must change nothing. Then scenes that skip much, with everything kept that can be. Times are
//! processor seconds of all threads; both kinds of render take turns, seed by seed.

mod measure;
mod table;

#[path = "../../tests/common/scenes.rs"]
#[allow(dead_code, reason = "shared with the tests, which use all of it")]
mod scenes;
#[path = "../../tests/common/twins.rs"]
#[allow(dead_code, reason = "shared with the tests, which use all of it")]
mod twins;

use joton::plan::Part;
use std::error::Error;
use twins::{Case, EVERYTHING, file};

/// How much is rendered.
#[derive(Debug, Clone, Copy)]
struct Effort {
    /// On threads, not on a device.
    cpu: bool,
    /// Pixels across and down.
    size: u32,
    /// Passes of a render.
    passes: u64,
    /// Renders of each kind.
    runs: u32,
}

const USAGE: &str = "skips [--device gpu|cpu] [--quick]";

fn main() -> Result<(), Box<dyn Error>> {
    let mut effort = Effort { cpu: false, size: 128, passes: 8, runs: 5 };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--quick" => effort = Effort { size: 64, runs: 3, ..effort },
            "--device" => {
                effort.cpu = match arguments.next().as_deref() {
                    Some("cpu") => true,
                    Some("gpu") => false,
                    _ => return Err(USAGE.into()),
                }
            }
            _ => return Err(USAGE.into()),
        }
    }
    let Effort { cpu, size, passes, runs } = effort;
    let device = if cpu { "cpu" } else { "gpu" };
    println!(
        "--device {device}, {size} × {size} pixels, {runs} renders of {passes} passes of each kind; all skips of a scene \
              together at twice the width.\n"
    );
    println!("{}", table::HEAD);
    for name in ["cornell", "rooms", "pedestal"] {
        // where pixels are many, as they mostly are
        let case = Case { name, scene: file(name, 2 * size), paths: EVERYTHING, keep: &[] };
        println!("{}", table::together(&effort, &case, &Part::ALL)?);
    }
    for t in twins::all(size) {
        println!("{}", table::skipped(&effort, t.part, &t.without)?);
    }
    println!("\nWhere a part is needed, keeping it changes nothing:\n\n{}", table::NEEDED_HEAD);
    for t in twins::all(size) {
        println!("{}", table::needed(&effort, t.part, &t.with)?);
    }
    Ok(())
}
