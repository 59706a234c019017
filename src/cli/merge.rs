//! `joton merge PART…`: parts of a render put together.

use super::checkpoint::Header;
use super::device::Devices;
use super::render::{self, RenderArguments};
use super::{DONE, pack, tell};
use clap::Args;
use joton::output::report::{Circumstances, Report};
use joton::output::{self, checkpoint};
use joton::plan::Plan;
use joton::render::{PassRange, Reason, RenderState};
use joton::{Error, Result};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

/// Arguments of `joton merge`.
#[derive(Debug, Args)]
pub(super) struct MergeArguments {
    /// What `joton render --pass-range A..B --checkpoint PART` wrote, in any order.
    #[arg(required = true, value_name = "PART")]
    parts: Vec<PathBuf>,
    /// Where to write: .exr (linear radiance and its layers) or .png (for display); may be repeated.
    #[arg(short, long, value_name = "FILE", required_unless_present = "checkpoint")]
    output: Vec<PathBuf>,
    /// Write a part that has the passes of all, to be merged with others.
    #[arg(long, value_name = "PART")]
    checkpoint: Option<PathBuf>,
    /// The scene, where it is not where the parts were rendered.
    #[arg(long, value_name = "SCENE")]
    scene: Option<PathBuf>,
    /// Write what was done as JSON; - is stdout.
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// Say nothing but errors.
    #[arg(long)]
    quiet: bool,
}

/// A part as its header tells it.
struct Part<'a> {
    path: &'a Path,
    header: Header,
    range: PassRange,
}

pub(super) fn run(a: &MergeArguments) -> Result<u8> {
    let begin = Instant::now();
    let parts = in_order(&a.parts, !a.output.is_empty())?;
    let arguments = merged(&parts[0].header.arguments, a);
    for path in &a.output {
        render::kind_of(path)?;
    }
    let report_file = a.report.as_ref().filter(|path| **path != Path::new(render::STDOUT));
    let written = || a.output.iter().chain(report_file).chain(&a.checkpoint);
    render::check_outputs(&arguments.scene, written())?;
    output::check_not_read(written(), &a.parts)?;
    if a.output.is_empty() && report_file.is_none() {
        let kept = keep(a, &parts[0].header, &sum(&parts)?);
        return kept.map_or(Ok(DONE), |(path, kept)| {
            kept?;
            tell_written(a, &[path.display().to_string()]);
            Ok(DONE)
        });
    }

    let mut scene = joton::scene::load(&arguments.scene)?;
    arguments.spectral.set(&mut scene);
    output::check_not_read(written(), &scene.files)?;
    check_scene(&parts[0], &scene.files)?;
    if let Some(size) = arguments.size {
        scene.resize(size);
    }
    let settings = arguments.settings()?;
    let packed = Arc::new(pack(&scene, &settings)?);
    let wanted = Plan::new(&packed, settings);
    // no pass is rendered: it says how pictures are smoothed
    let (backend, _, plan) = Devices::named("cpu", arguments.reference)?.open(&packed, &wanted)?;
    let mut state = sum(&parts)?;
    let kept = keep(a, &parts[0].header, &state);
    state.set_resolver(backend.resolver());
    drop(backend);
    let rendered = state.finish(Reason::Passes);

    let mut devices: Vec<&str> = parts.iter().map(|part| part.header.device.as_str()).collect();
    // threads change no bit
    devices.dedup_by_key(|device| device.split(", ").next().filter(|name| *name == "CPU").unwrap_or(*device));
    let device = devices.join("; ");
    if !a.quiet {
        if devices.len() > 1 {
            tell(format_args!("joton: the parts are of different devices: {device}"));
        }
        let error = render::estimated(&rendered);
        let count = super::progress::passes(rendered.passes);
        tell(format_args!("joton: {count} of {} parts{error}", parts.len()));
    }
    let report = || {
        let (setup_seconds, warnings) = (begin.elapsed().as_secs_f64(), scene.warnings.clone());
        let around =
            Circumstances { device, setup_seconds, setup: Vec::new(), kernels: Vec::new(), warnings };
        Report::new(&rendered, &packed, &plan, around)
    };
    let (wrote, saved) = render::save(&arguments, &a.output, &rendered, &[], kept, report);
    tell_written(a, &wrote);
    saved.map(|()| DONE)
}

fn tell_written(a: &MergeArguments, names: &[String]) {
    if !a.quiet && !names.is_empty() {
        tell(format_args!("joton: wrote {}", names.join(", ")));
    }
}

/// What the whole render is told.
fn merged(of_part: &RenderArguments, a: &MergeArguments) -> RenderArguments {
    let mut whole = of_part.clone();
    if let Some(scene) = &a.scene {
        whole.scene = scene.clone();
    }
    (whole.output, whole.report, whole.checkpoint) = (a.output.clone(), a.report.clone(), None);
    whole
}

/// All parts together.
fn sum(parts: &[Part<'_>]) -> Result<RenderState> {
    let read = |part: &Part<'_>| checkpoint::read::<Header>(part.path).map(|(_, state)| state);
    let mut state = read(&parts[0])?;
    for part in &parts[1..] {
        state.merge(&read(part)?)?;
    }
    Ok(state)
}

/// Write all parts as one, where it is wanted: where, and whether it could be.
fn keep<'a>(a: &'a MergeArguments, of_first: &Header, state: &RenderState) -> Option<(&'a Path, Result<()>)> {
    let path = a.checkpoint.as_deref()?;
    let mut header = of_first.clone();
    (header.passes, header.arguments.pass_range) = (state.passes(), state.part());
    Some((path, checkpoint::write(path, &header, state)))
}

/// The parts by their passes: all of one render, finished, without gaps and overlaps; from its first pass on where they are to be a picture.
fn in_order(paths: &[PathBuf], is_whole: bool) -> Result<Vec<Part<'_>>> {
    let mut parts: Vec<Part<'_>> = paths.iter().map(|path| Part::open(path)).collect::<Result<_>>()?;
    parts.sort_by_key(|part| part.range.first());
    let first = &parts[0];
    for part in &parts[1..] {
        part.check_same_render(first)?;
    }
    let mut before: Option<&Part<'_>> = None;
    for part in &parts {
        let first = if is_whole { 0 } else { first.range.first() };
        let (range, end) = (part.range, before.map_or(first, |before| before.range.end()));
        if range.first() < end {
            let before = before.map_or(String::new(), |before| before.path.display().to_string());
            let what = format!("{} (passes {range}) and {before} have passes in common", part.path.display());
            return Err(Error::usage(what, "give each pass once"));
        }
        if range.first() > end {
            let what = format!("passes {end}..{} are in no part", range.first());
            return Err(Error::usage(what, format!("add the part of --pass-range {end}..{}", range.first())));
        }
        before = Some(part);
    }
    Ok(parts)
}

impl<'a> Part<'a> {
    fn open(path: &'a Path) -> Result<Self> {
        let header: Header = checkpoint::read_header(path)?;
        header.check_version(path)?;
        let refuse =
            |what: &str, remedy: String| Err(Error::usage(format!("{}: {what}", path.display()), remedy));
        let Some(range) = header.arguments.pass_range else {
            return refuse("is no part of a render", "render parts by --pass-range A..B".into());
        };
        if header.passes < range.passes() {
            let what = format!("has {} of the passes {range}", header.passes);
            return refuse(&what, format!("go on with it by joton resume {}", path.display()));
        }
        Ok(Self { path, header, range })
    }

    /// Refuse what is of another render.
    fn check_same_render(&self, other: &Self) -> Result<()> {
        let contents =
            |part: &Self| part.header.files.iter().map(|(_, print)| print.clone()).collect::<Vec<_>>();
        let what = if contents(self) != contents(other) {
            "the scene"
        } else {
            match self.header.arguments.differs(&other.header.arguments) {
                Some(option) => option,
                None => return Ok(()),
            }
        };
        let what = format!("{} and {} differ in {what}", other.path.display(), self.path.display());
        Err(Error::usage(what, "merge parts that differ in --pass-range alone"))
    }
}

/// Refuse a scene that is not the one that was rendered.
fn check_scene(part: &Part<'_>, files: &[PathBuf]) -> Result<()> {
    let rendered = part.header.files.iter().map(|(_, print)| print);
    let found: Vec<String> = files.iter().map(|file| checkpoint::fingerprint(file)).collect::<Result<_>>()?;
    if rendered.eq(&found) {
        return Ok(());
    }
    let what = format!("{}: the scene has changed since", part.path.display());
    Err(Error::usage(what, "name the scene as it was rendered by --scene"))
}
