//! Checkpoints of `joton render`, and `joton resume`, which goes on from one.

use super::progress::Kind as ProgressKind;
use super::render::{self, RenderArguments};
use clap::Args;
use joton::output::checkpoint;
use joton::render::RenderState;
use joton::{Error, Result};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Writing takes a fiftieth of the time at most.
const RENDERED_PER_WRITTEN: u32 = 50;

/// Arguments of `joton resume`.
#[derive(Debug, Args)]
pub(super) struct ResumeArguments {
    /// What `joton render --checkpoint` wrote; it is kept up to date.
    checkpoint: PathBuf,
    /// Where to write, instead of where the render would have.
    #[arg(short, long, value_name = "FILE")]
    output: Vec<PathBuf>,
    /// Stop after this many passes, those before among them [default for all three: as the render was told].
    #[arg(long)]
    passes: Option<u64>,
    /// Stop after this many seconds of rendering, those before among them.
    #[arg(long, value_name = "SECONDS")]
    time: Option<f64>,
    /// Stop when the estimated relative error is this small.
    #[arg(long)]
    error: Option<f64>,
    /// auto, gpu, cpu, or a part of a device's name, instead of the device that the render was told.
    #[arg(long)]
    device: Option<String>,
    /// Write what was done as JSON; - is stdout.
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// How progress is told.
    #[arg(long, value_name = "KIND", default_value = "auto")]
    progress: ProgressKind,
    /// Say nothing but errors.
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(a: &ResumeArguments) -> Result<u8> {
    let (header, state): (Header, RenderState) = checkpoint::read(&a.checkpoint)?;
    header.check(&a.checkpoint)?;
    let mut arguments = header.arguments.clone();
    arguments.go_on_by(a)?;
    render::run(&arguments, Some(Saved { header, state }))
}

/// What a checkpoint holds.
pub(super) struct Saved {
    pub(super) header: Header,
    pub(super) state: RenderState,
}

/// What is told of a checkpoint in its second line.
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub(super) struct Header {
    /// Of joton.
    version: String,
    /// The device that rendered last.
    pub(super) device: String,
    /// Passes so far.
    pub(super) passes: u64,
    /// What the scene was read from, and what was in it.
    pub(super) files: Vec<(PathBuf, String)>,
    /// What the render was told.
    pub(super) arguments: RenderArguments,
}

impl Header {
    /// Refuse what cannot be gone on with.
    fn check(&self, path: &Path) -> Result<()> {
        self.check_version(path)?;
        for (file, fingerprint) in &self.files {
            if checkpoint::fingerprint(file)? != *fingerprint {
                return Err(refuse(path, &format!("{} has changed since", file.display())));
            }
        }
        Ok(())
    }

    /// Refuse what another joton wrote.
    pub(super) fn check_version(&self, path: &Path) -> Result<()> {
        let version = env!("CARGO_PKG_VERSION");
        if self.version != version {
            return Err(refuse(
                path,
                &format!("was written by joton {}, and this is {version}", self.version),
            ));
        }
        Ok(())
    }
}

/// What cannot be gone on with.
fn refuse(path: &Path, what: &str) -> Error {
    Error::usage(format!("{}: {what}", path.display()), "render anew, with another --checkpoint")
}

/// Writes checkpoints while a render goes on.
pub(super) struct Keeper {
    path: PathBuf,
    every: Duration,
    header: Header,
    since: Instant,
    took: Duration,
}

impl Keeper {
    /// Refuse to begin anew where there is a checkpoint.
    pub(super) fn check_new(a: &RenderArguments) -> Result<()> {
        match a.checkpoint.as_ref().filter(|path| path.is_file()) {
            Some(path) => {
                let what = format!("{}: there is a checkpoint already", path.display());
                let remedy = format!("go on from it by joton resume {}, or remove it", path.display());
                Err(Error::usage(what, remedy))
            }
            None => Ok(()),
        }
    }

    /// For a render that asks for checkpoints, of a scene that was read from these files.
    pub(super) fn new(a: &RenderArguments, files: &[PathBuf], device: &str) -> Result<Option<Self>> {
        let Some(path) = a.checkpoint.clone() else { return Ok(None) };
        let told = |file: &PathBuf| Ok((absolute(file)?, checkpoint::fingerprint(file)?));
        let header = Header {
            version: env!("CARGO_PKG_VERSION").into(),
            device: device.into(),
            passes: 0,
            files: files.iter().map(told).collect::<Result<_>>()?,
            arguments: a.with_absolute_paths()?,
        };
        let every = Duration::try_from_secs_f64(a.every).unwrap_or(Duration::MAX);
        Ok(Some(Self { path, every, header, since: Instant::now(), took: Duration::ZERO }))
    }

    /// Where it is written.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// Another device goes on.
    pub(super) fn set_device(&mut self, device: &str) {
        self.header.device = device.into();
    }

    /// Write one, where the last one is old enough.
    pub(super) fn keep_when_due(&mut self, state: &RenderState) -> Result<()> {
        let due = self.every.max(self.took * RENDERED_PER_WRITTEN);
        if self.since.elapsed() < due { Ok(()) } else { self.keep(state) }
    }

    /// Write one.
    pub(super) fn keep(&mut self, state: &RenderState) -> Result<()> {
        let begin = Instant::now();
        self.header.passes = state.passes();
        let written = checkpoint::write(&self.path, &self.header, state);
        (self.since, self.took) = (Instant::now(), begin.elapsed());
        written
    }
}

/// The same file, wherever joton is started.
pub(super) fn absolute(file: &Path) -> Result<PathBuf> {
    std::path::absolute(file).map_err(|e| Error::system(file, "find", &e))
}

impl RenderArguments {
    /// What was asked for anew.
    fn go_on_by(&mut self, a: &ResumeArguments) -> Result<()> {
        if a.passes.is_some() || a.time.is_some() || a.error.is_some() {
            if let Some(part) = self.pass_range {
                let what =
                    format!("{}: has the passes {part} of a render, and no others", a.checkpoint.display());
                return Err(Error::usage(what, "leave out --passes, --time and --error"));
            }
            (self.passes, self.time, self.error) = (a.passes, a.time, a.error);
        }
        if !a.output.is_empty() {
            self.output = a.output.clone();
        }
        if let Some(device) = &a.device {
            self.device = device.clone();
        }
        self.checkpoint = Some(a.checkpoint.clone());
        self.report = a.report.clone();
        (self.progress, self.quiet) = (a.progress, a.quiet);
        Ok(())
    }

    /// The same, wherever joton is started.
    fn with_absolute_paths(&self) -> Result<Self> {
        let mut told = self.clone();
        told.scene = absolute(&self.scene)?;
        told.output = self.outputs().iter().map(|file| absolute(file)).collect::<Result<_>>()?;
        Ok(told)
    }
}
