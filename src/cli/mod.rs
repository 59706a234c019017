//! The command line: arguments, one file for each command.

mod bench;
mod compare;
mod device;
mod devices;
mod export;
mod memory;
mod plan;
mod render;
mod versus;

use clap::{Parser, Subcommand};
use joton::Result;
use joton::pack::PackedScene;
use joton::plan::{Part, Settings};
use joton::scene::Scene;

/// A progressive photon mapper that runs on the GPU.
#[derive(Debug, Parser)]
#[command(version, about)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to EXR and PNG files.
    Render(render::RenderArguments),
    /// Tell what a scene needs, what is skipped and why.
    Plan(plan::PlanArguments),
    /// Compare an image with a reference.
    Compare(compare::CompareArguments),
    /// Write a scene for other renderers: Mitsuba 3 XML and PLY.
    Export(export::ExportArguments),
    /// Error over time on each device: CSV and plot.
    Bench(bench::BenchArguments),
    /// List the devices, and which one is chosen.
    Devices,
}

/// Exit code of a finished command.
const DONE: u8 = 0;
/// Exit code of `compare` out of tolerance.
const OUT_OF_TOLERANCE: u8 = 1;
/// Exit code after Ctrl-C, with everything so far saved.
const INTERRUPTED: u8 = 130;

/// Run a command; its exit code.
pub(crate) fn run(arguments: Arguments) -> Result<u8> {
    match arguments.command {
        Command::Render(a) => render::run(&a),
        Command::Plan(a) => plan::run(&a),
        Command::Compare(a) => compare::run(&a),
        Command::Export(a) => export::run(&a),
        Command::Bench(a) => bench::run(&a),
        Command::Devices => devices::run(),
    }
}

/// What clap made of a command line that names no command to run: help and version are an answer, the rest is an
/// error, which is put into one line.
pub(crate) fn refuse(e: &clap::Error) -> Result<u8, String> {
    if !e.use_stderr() {
        // a closed pipe is no error
        e.print().ok();
        return Ok(DONE);
    }
    if e.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return Err("no command is given; try --help".into());
    }
    let text = e.to_string();
    let told = text.split("\n\nUsage:").next().unwrap_or_default();
    let what: Vec<&str> = told.split_whitespace().filter(|word| *word != "tip:").collect();
    let what = what.join(" ");
    let what = what.trim_start_matches("error: ").trim_end_matches(" For more information, try '--help'.");
    Err(format!("{what}; try --help"))
}

/// Pack a scene: what is out of reach is left out, unless it is to be kept.
fn pack(scene: &Scene, settings: &Settings) -> PackedScene {
    if settings.keeps(Part::OutOfReach) { PackedScene::whole(scene) } else { PackedScene::new(scene) }
}

/// Print a line to stderr; a closed pipe is no error.
pub(crate) fn tell(line: impl std::fmt::Display) {
    use std::io::Write;
    writeln!(std::io::stderr(), "{line}").ok();
}

/// Print a line to stdout; a closed pipe is no error.
fn say(line: impl std::fmt::Display) {
    use std::io::Write;
    writeln!(std::io::stdout(), "{line}").ok();
}
