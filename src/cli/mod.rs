//! The command line: arguments, one file for each command.

mod bands;
#[cfg(feature = "bench")]
mod bench;
mod check;
mod checkpoint;
mod compare;
mod device;
mod devices;
mod export;
mod fit;
mod interrupt;
mod memory;
mod merge;
mod plan;
mod progress;
mod render;
mod slurm;
#[cfg(feature = "bench")]
mod versus;

use crate::system;
use clap::{Parser, Subcommand};
use joton::Result;
use joton::packed::PackedScene;
use joton::plan::{Part, Settings};
use joton::scene::Scene;
use std::sync::OnceLock;

/// A progressive photon mapper that runs on the GPU.
#[derive(Debug, Parser)]
#[command(version, about, after_help = EXAMPLES)]
pub(crate) struct Arguments {
    /// Threads of the host, also of software Vulkan [default: one for each processor].
    #[arg(long, global = true, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    #[command(subcommand)]
    command: Command,
}

const EXAMPLES: &str = "\
Examples:
  joton render scene.toml                        scene.png and scene.exr, at an error of 2 %, after a minute at most
  joton render scene.obj --time 600 -o out.exr   ten minutes
  joton plan scene.toml                          what will be done, and what is skipped
  joton compare out.exr reference.exr            how far apart they are";

#[derive(Debug, Subcommand)]
enum Command {
    /// Render a scene to EXR and PNG files.
    Render(Box<render::RenderArguments>),
    /// Go on with a render from its checkpoint.
    Resume(checkpoint::ResumeArguments),
    /// Put parts of a render together, which --pass-range made.
    Merge(merge::MergeArguments),
    /// Write, and submit, a cluster's jobs that render a scene: parts by an array of Slurm tasks, and their merge.
    Slurm(slurm::SlurmArguments),
    /// Read a scene as a render would, and tell what is wrong with it.
    Check(check::CheckArguments),
    /// Tell what a scene needs, what is skipped and why.
    Plan(plan::PlanArguments),
    /// Compare an image with a reference.
    Compare(compare::CompareArguments),
    /// Write a scene for other renderers: Mitsuba 3 XML and PLY.
    Export(export::ExportArguments),
    /// Error over time on each device: CSV and plot.
    #[cfg(feature = "bench")]
    Bench(bench::BenchArguments),
    /// List the devices, and which one is chosen.
    Devices(devices::DevicesArguments),
}

/// Exit code of a finished command.
const DONE: u8 = 0;
/// Exit code of what was judged and is not good enough: by `compare`, or by `check --strict`.
const FAULTY: u8 = 1;
/// Exit code after Ctrl-C, with everything so far saved.
const INTERRUPTED: u8 = 130;

/// Run a command; its exit code.
pub(crate) fn run(arguments: Arguments) -> Result<u8> {
    let print = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !joton::backend::is_guarded() {
            print(panic);
        }
    }));
    let on_device = match &arguments.command {
        Command::Render(a) => a.device != "cpu",
        Command::Resume(_) => true,
        _ => false,
    };
    if on_device {
        system::share_heap();
        joton::host::memory::set_give_back(system::give_back);
    }
    if let Some(threads) = arguments.threads {
        system::limit_software_devices(threads);
        // a pool that is there already has threads enough
        rayon::ThreadPoolBuilder::new().num_threads(threads.into()).build_global().ok();
    }
    let code = match arguments.command {
        Command::Render(a) => render::run(&a, None),
        Command::Resume(a) => checkpoint::run(&a),
        Command::Merge(a) => merge::run(&a),
        Command::Slurm(a) => slurm::run(&a),
        Command::Check(a) => check::run(&a),
        Command::Plan(a) => plan::run(&a),
        Command::Compare(a) => compare::run(&a),
        Command::Export(a) => export::run(&a),
        #[cfg(feature = "bench")]
        Command::Bench(a) => bench::run(&a),
        Command::Devices(a) => devices::run(&a),
    }?;
    check_said().map(|()| code)
}

/// What clap made of a command line that names no command to run: help and version are an answer, the rest is an
/// error, which is put into one line.
pub(crate) fn refuse(e: &clap::Error) -> Result<u8, String> {
    if !e.use_stderr() {
        note_unsaid(e.print());
        return check_said().map(|()| DONE).map_err(|e| e.to_string());
    }
    if e.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        return Err("no command is given; try --help".into());
    }
    let text = e.to_string();
    let told = text.split("\n\nUsage:").next().unwrap_or_default();
    // each tip is a sentence of its own
    let sentences: Vec<String> =
        told.split("tip:").map(|part| part.split_whitespace().collect::<Vec<_>>().join(" ")).collect();
    let what = sentences.join("; ");
    let what = what.trim_start_matches("error: ").trim_end_matches(" For more information, try '--help'.");
    Err(format!("{what}; try --help"))
}

/// Pack a scene: what is out of reach is left out, unless it is to be kept.
///
/// # Errors
/// [`joton::Error::Capacity`] where there is not the memory for it.
fn pack(scene: &Scene, settings: &Settings) -> Result<PackedScene> {
    joton::packed::check_memory(scene)?;
    let keeps_all = settings.keeps(Part::OutOfReach);
    Ok(if keeps_all { PackedScene::whole(scene) } else { PackedScene::new(scene) })
}

/// Print a line to stderr; a closed pipe is no error.
pub(crate) fn tell(line: impl std::fmt::Display) {
    use std::io::Write;
    writeln!(std::io::stderr(), "{line}").ok();
}

/// Print a line to stdout. What stands in the way is told by [`check_said`]: work that writes files goes on.
fn say(line: impl std::fmt::Display) {
    use std::io::Write;
    note_unsaid(writeln!(std::io::stdout(), "{line}"));
}

/// Print a value to stdout as JSON.
///
/// # Errors
/// [`joton::Error::Io`] where it has no text.
fn say_json(value: &impl serde::Serialize) -> Result<()> {
    say(json(value).map_err(|e| joton::Error::system("stdout", "write", &e))?);
    Ok(())
}

/// The text of a value.
fn json(value: &impl serde::Serialize) -> std::io::Result<String> {
    serde_json::to_string_pretty(value).map_err(std::io::Error::from)
}

/// The first error of stdout.
static UNSAID: OnceLock<std::io::Error> = OnceLock::new();

/// A closed pipe is no error: who reads has seen enough.
fn note_unsaid(printed: std::io::Result<()>) {
    if let Err(e) = printed
        && e.kind() != std::io::ErrorKind::BrokenPipe
    {
        UNSAID.get_or_init(|| e);
    }
}

/// Whether all that was said has reached stdout.
fn check_said() -> Result<()> {
    note_unsaid(std::io::Write::flush(&mut std::io::stdout()));
    UNSAID.get().map_or(Ok(()), |e| Err(joton::Error::system("stdout", "write", e)))
}
