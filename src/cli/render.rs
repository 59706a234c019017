//! `joton render SCENE`.

use super::bands::{self, Measured, Renders};
use super::checkpoint::{Keeper, Saved};
use super::device::Devices;
use super::fit::{pack_to_fit, places_of};
use super::progress::{Kind as ProgressKind, Narrator, passes};
use super::{DONE, INTERRUPTED, interrupt, json, memory, say};
use clap::Args;
use joton::backend::{Backend, PASSES_MAX};
use joton::film::paths::LightPaths;
use joton::film::{self, Monochrome};
use joton::output::report::{Circumstances, KernelTime, Report};
use joton::output::{self, display, exr, png};
use joton::plan::{Part, Plan, SHADOW_RAYS, Settings};
use joton::render::{Failure, PassRange, Progress, Reason, RenderState, Rendered, Stop};
use joton::scene::{Mesh, Scene};
use joton::spectrum::list::List;
use joton::{Error, Result};
use std::cell::RefCell;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Instant;

/// Arguments of `joton render`.
#[derive(Debug, Clone, Args, serde::Serialize, serde::Deserialize)]
pub(super) struct RenderArguments {
    /// A scene file (.toml) or a mesh (.obj).
    pub(super) scene: PathBuf,
    /// Where to write: .exr (linear radiance and its layers) or .png (for display); may be repeated.
    #[arg(short, long, value_name = "FILE")]
    pub(super) output: Vec<PathBuf>,
    /// Image size, instead of the scene's.
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub(super) size: Option<[u32; 2]>,
    /// Stop after this many passes.
    #[arg(long)]
    pub(super) passes: Option<u64>,
    /// Render these passes alone, from the first to the one before the last number, like 64..128, for joton merge.
    #[arg(long, value_name = "A..B", requires = "checkpoint", conflicts_with_all = ["passes", "time", "error"])]
    pub(super) pass_range: Option<PassRange>,
    /// Stop after this many seconds of rendering (set-up is not counted).
    #[arg(long, value_name = "SECONDS")]
    pub(super) time: Option<f64>,
    /// Stop when the estimated relative error is this small [default, where nothing else is asked for: 0.02, after 60 s at most].
    #[arg(long)]
    pub(super) error: Option<f64>,
    /// Seed of the random numbers: the same seed and device give the same image, bit for bit.
    #[arg(long, default_value_t = 0)]
    seed: u32,
    /// auto, gpu, cpu, or a part of a device's name (see `joton devices`).
    #[arg(long, default_value = "auto")]
    pub(super) device: String,
    /// With --device cpu: the plain path tracer instead of the photon mapper.
    #[arg(long)]
    pub(super) reference: bool,
    /// Light paths to render, from the light (L) to the eye (E) over diffuse (D) and specular (S) surfaces:
    /// "LS+DE", "L(S|D)E", "LD+E".
    #[arg(long, value_name = "EXPR")]
    paths: Option<String>,
    /// Shadow rays for each pixel and pass.
    #[arg(long, default_value_t = SHADOW_RAYS, value_parser = clap::value_parser!(u32).range(1..=32))]
    shadow_rays: u32,
    /// Do what the scene does not need, too: all, or names as `joton plan` tells them.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    no_skip: Vec<String>,
    /// Share light on surfaces with neighbouring pixels when the picture is made.
    #[arg(long, default_value = "on")]
    resolve: Switch,
    /// Render by wavelength: auto where the scene has spectra, dispersion or lamps of lines.
    #[arg(long, default_value = "auto")]
    #[serde(default)]
    pub(super) spectral: Spectral,
    /// Beside red, green and blue the radiance per nm at these wavelengths, nm, or at so many from 400 to 700 nm, as channels
    /// S0.550,000000nm of .exr files.
    #[arg(long, value_name = "NM,…|N", value_parser = List::from_str)]
    #[serde(default)]
    pub(super) bands: Option<List>,
    /// Memory of the whole process, device included, at most, e.g. 512M or 2G [default: what there is].
    #[arg(long, value_name = "SIZE", value_parser = memory::parse)]
    memory: Option<u64>,
    /// Exposure of PNG files: auto, or a number of stops.
    #[arg(long, default_value = "auto", allow_negative_numbers = true)]
    exposure: display::Exposure,
    /// Tone of PNG files: srgb, filmic or perception.
    #[arg(long, default_value = "srgb")]
    transform: display::Transform,
    /// Write what was done as JSON; - is stdout.
    #[arg(long, value_name = "FILE.json")]
    pub(super) report: Option<PathBuf>,
    /// Keep all that it takes to go on by `joton resume` in this file, also when the render is stopped.
    #[arg(long, value_name = "FILE")]
    pub(super) checkpoint: Option<PathBuf>,
    /// Seconds from one checkpoint to the next, at least.
    #[arg(long, value_name = "SECONDS", default_value_t = 60.0, requires = "checkpoint")]
    pub(super) every: f64,
    /// Measure what each kernel takes, for the report (a little slower).
    #[arg(long)]
    timings: bool,
    /// How progress is told.
    #[arg(long, value_name = "KIND", default_value = "auto")]
    pub(super) progress: ProgressKind,
    /// Say nothing but errors.
    #[arg(long)]
    pub(super) quiet: bool,
}

/// On or off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum, serde::Serialize, serde::Deserialize)]
pub(super) enum Switch {
    On,
    Off,
}

/// Whether a scene is rendered by wavelength.
#[derive(
    Debug, Clone, Copy, Default, PartialEq, Eq, clap::ValueEnum, serde::Serialize, serde::Deserialize,
)]
pub(super) enum Spectral {
    #[default]
    Auto,
    On,
    Off,
}

impl Spectral {
    /// Set it in a scene, which says itself whether it asks for wavelengths.
    pub(super) fn set(self, scene: &mut Scene) {
        match self {
            Self::Auto => {}
            Self::On => scene.wavelengths.are_rendered = true,
            Self::Off => scene.wavelengths.are_rendered = false,
        }
    }

    /// Bands are wavelengths.
    pub(super) fn with_bands(self, bands: Option<&List>) -> Self {
        if bands.is_some() { Self::On } else { self }
    }
}

impl RenderArguments {
    /// What changes the plan.
    pub(super) fn settings(&self) -> Result<Settings> {
        Ok(Settings {
            seed: self.seed,
            paths: self.paths.as_deref().map_or_else(|| Ok(LightPaths::everything()), LightPaths::parse)?,
            shadow_rays: self.shadow_rays,
            resolve: self.resolve == Switch::On,
            memory: self.memory,
            keep: kept(&self.no_skip)?,
            is_part: self.pass_range.is_some(),
            measured: self.measured(),
        })
    }

    /// How many bands there are beside red, green and blue.
    fn measured(&self) -> usize {
        self.bands.as_ref().map_or(0, |list| list.lambdas().len())
    }

    /// The first option that makes another picture of the same scene than another render's, but for which passes are rendered.
    pub(super) fn differs(&self, other: &Self) -> Option<&'static str> {
        let same = [
            ("--size", self.size == other.size),
            ("--seed", self.seed == other.seed),
            ("--reference", self.reference == other.reference),
            ("--paths", self.paths == other.paths),
            ("--shadow-rays", self.shadow_rays == other.shadow_rays),
            ("--no-skip", self.no_skip == other.no_skip),
            ("--resolve", self.resolve == other.resolve),
            ("--memory", self.memory == other.memory),
            ("--spectral", self.spectral == other.spectral),
            ("--bands", self.bands == other.bands),
        ];
        same.into_iter().find(|(_, is_same)| !is_same).map(|(name, _)| name)
    }

    /// Where the picture goes. Without -o: NAME.png and NAME.exr in the current folder; nowhere of a part of a render.
    pub(super) fn outputs(&self) -> Vec<PathBuf> {
        if !self.output.is_empty() || self.pass_range.is_some() {
            return self.output.clone();
        }
        let stem = PathBuf::from(self.scene.file_stem().unwrap_or_default());
        vec![stem.with_extension("png"), stem.with_extension("exr")]
    }
}

/// Render a scene, or go on with what was saved of it.
pub(super) fn run(a: &RenderArguments, saved: Option<Saved>) -> Result<u8> {
    let begin = Instant::now();
    let stop = checked_stop(a)?;
    if saved.is_none() {
        Keeper::check_new(a)?;
    }
    // the report may go to stdout
    let report_file = a.report.as_ref().filter(|path| **path != Path::new(STDOUT));
    // before the names of its outputs: a folder has none to give
    joton::scene::check_format(&a.scene)?;
    let outputs = a.outputs();
    for path in &outputs {
        kind_of(path)?;
    }
    bands::check(a, &outputs)?;
    let written = || outputs.iter().chain(report_file).chain(&a.checkpoint);
    check_outputs(&a.scene, written())?;
    let settings = a.settings()?;
    let mut narrator = Narrator::new(a.progress, a.quiet);
    let mut setup = Laps::from(begin);
    narrator.step("reading the scene");
    memory::bound(a.memory);
    let mut scene = joton::scene::load(&a.scene)?;
    a.spectral.with_bands(a.bands.as_ref()).set(&mut scene);
    setup.lap("reading");
    output::check_not_read(written(), &scene.files)?;
    if let Some(size) = a.size {
        scene.resize(size);
    }
    film::check_memory(scene.size, a.pass_range.is_some(), a.measured())?;
    narrator.step("building the hierarchy");
    let packed = Arc::new(pack_to_fit(&mut scene, &settings, places_of(&a.device))?);
    scene.warnings.extend(joton::packed::doubts(&scene, &packed));
    if a.bands.is_some() {
        scene.warnings.extend(bands::warning(&scene));
    }
    // it is packed, pictures included
    (scene.mesh, scene.materials) = (Mesh::default(), Vec::new());
    for warning in &scene.warnings {
        narrator.warning(warning);
    }
    setup.lap("hierarchy");
    narrator.step("planning");
    let wanted = Plan::new(&packed, settings);
    setup.lap("planning");
    narrator.step("preparing the device");
    let mut devices = Devices::named(&a.device, a.reference)?;
    let (mut backend, mut device, mut plan) = devices.open(&packed, &wanted)?;
    setup.lap("device");
    narrator.message(&device);
    let keeper = Keeper::new(a, &scene.files, &device)?;
    if a.timings {
        backend.measure_kernels()?;
    }

    let interrupted = interrupt::watch();
    narrator.begin();
    let renders = a.bands.as_ref().map_or(1, |list| 1 + list.threes().len());
    narrator.part(0, renders, 0.0);
    let all = Renders { arguments: a, packed: &packed, wanted: &wanted, stop, interrupted: &interrupted };
    let stop = if renders > 1 { bands::share(stop, 0.0, renders) } else { stop };
    let setup_seconds = begin.elapsed().as_secs_f64();
    let mut state = match saved {
        Some(Saved { header, state }) => {
            if header.device != device {
                let passes = passes(state.passes());
                narrator.message(&format!("{passes} before were rendered on {}", header.device));
            }
            state
        }
        None => match a.pass_range {
            Some(part) => RenderState::of_part(packed.size, part),
            None => RenderState::new(packed.size),
        },
    };
    state.look_ahead();
    let (narrator, keeper) = (RefCell::new(narrator), RefCell::new(keeper));
    let watch = |p: &Progress<'_>| {
        narrator.borrow_mut().show(p);
        if let Some(Err(e)) = keeper.borrow_mut().as_mut().map(|keeper| keeper.keep_when_due(p.state)) {
            narrator.borrow().warning(&e.to_string());
        }
        !interrupted.load(Ordering::SeqCst)
    };
    let next = |failed: &Failure| {
        if devices.is_empty() || interrupted.load(Ordering::SeqCst) {
            return None;
        }
        // where the others do not open either, it is the first failure that is told
        let (mut backend, line, kept) = devices.open(&packed, &wanted).ok()?;
        narrator.borrow().message(&format!("{line}, from pass {} on: {}", failed.passes + 1, failed.what));
        if a.timings {
            backend.measure_kernels().ok()?;
        }
        if let Some(keeper) = keeper.borrow_mut().as_mut() {
            keeper.set_device(&line);
        }
        (device, plan) = (line, kept);
        Some(backend)
    };
    let ended = state.go_on_while_devices_last(backend, stop, watch, next);
    let (mut narrator, mut keeper) = (narrator.into_inner(), keeper.into_inner());
    let (reason, kernels, failed) = match ended {
        Ok((reason, backend)) => (reason, kernel_times(backend.as_ref()), None),
        Err(e) if state.passes() == 0 => return Err(e),
        Err(e) => (Reason::Failed, Vec::new(), Some(saved_before(e, state.passes()))),
    };
    // where it cannot be written, the picture still is
    let kept = keeper.as_mut().map(|keeper| keeper.keep(&state));
    let rendered = state.finish(reason);
    let measured = match &a.bands {
        Some(list) if failed.is_none() && reason != Reason::Interrupted => {
            all.render(list, rendered.seconds, &mut narrator)
        }
        _ => Measured::default(),
    };
    narrator.end();

    let reason = match rendered.reason {
        Reason::Passes => "all passes are done",
        Reason::Time => "the time is up",
        Reason::Error => "the error estimate is small enough",
        Reason::Interrupted => "interrupted",
        Reason::Failed => "the device failed",
    };
    let error = estimated(&rendered);
    let mut words = format!("{} in {:.2} s{error}: {reason}", passes(rendered.passes), rendered.seconds);
    if a.bands.is_some() {
        words += &format!("; {}", measured.told());
    }
    let ended = serde_json::json!({
        "reason": rendered.reason,
        "passes": rendered.passes,
        "seconds": rendered.seconds,
        "error_estimate": rendered.error_estimate.map(|e| e.total),
    });
    narrator.done(&words, ended);

    let report = || {
        let (setup, warnings) = (setup.seconds, scene.warnings.clone());
        let around = Circumstances { device, setup_seconds, setup, kernels, warnings };
        Report { bands: measured.renders.clone(), ..Report::new(&rendered, &packed, &plan, around) }
    };
    let kept = keeper.as_ref().map(Keeper::path).zip(kept);
    let (wrote, saved) = save(a, &outputs, &rendered, &measured.bands, kept, report);
    if !wrote.is_empty() {
        narrator.wrote(&wrote);
    }
    if let (Some(keeper), Reason::Interrupted) = (&keeper, rendered.reason) {
        narrator.message(&format!("go on by: joton resume {}", keeper.path().display()));
    }
    saved?;
    if let Some(e) = failed.or(measured.failed) {
        return Err(e);
    }
    Ok(if rendered.reason == Reason::Interrupted || measured.is_interrupted { INTERRUPTED } else { DONE })
}

/// The error estimate of a picture, as a part of a sentence; nothing where there is none.
pub(super) fn estimated(rendered: &Rendered) -> String {
    rendered.error_estimate.map_or(String::new(), |e| format!(", estimated error {:.2} %", e.total * 100.0))
}

/// Write the pictures and the report; where one file cannot be written, the others still are. Those that were, the checkpoint among them,
/// and what stood in the way of the first that was not.
pub(super) fn save(
    a: &RenderArguments,
    outputs: &[PathBuf],
    rendered: &Rendered,
    measured: &[Monochrome],
    kept: Option<(&Path, Result<()>)>,
    report: impl FnOnce() -> Report,
) -> (Vec<String>, Result<()>) {
    let comment = format!("{}, seed {}, {} passes", a.scene.display(), a.seed, rendered.passes);
    let look = display::Display { exposure: a.exposure, transform: a.transform };
    let picture = |path: &PathBuf| match kind_of(path)? {
        Kind::Exr => exr::write_measured(path, &rendered.picture, measured, &comment),
        Kind::Png => png::write_image(path, &rendered.picture.whole, &look),
    };
    let mut written: Vec<(&Path, Result<()>)> = kept.into_iter().collect();
    written.extend(outputs.iter().map(|path| (path.as_path(), picture(path))));
    if let Some(path) = &a.report {
        let text = json(&report()).map_err(|e| Error::io(path, "write", e));
        match text {
            Ok(text) if path == Path::new(STDOUT) => say(text),
            Ok(text) => written.push((path, output::write_text(path, &(text + "\n")))),
            Err(e) => written.push((path, Err(e))),
        }
    }
    let names = written.iter().filter(|(_, done)| done.is_ok()).map(|(path, _)| path.display().to_string());
    let names = names.collect();
    (names, written.into_iter().try_for_each(|(_, done)| done))
}

/// Name of a file that stands for stdout.
pub(super) const STDOUT: &str = "-";

/// Seconds from one step to the next, by name.
struct Laps {
    before: Instant,
    seconds: Vec<(&'static str, f64)>,
}

impl Laps {
    fn from(before: Instant) -> Self {
        Self { before, seconds: Vec::new() }
    }

    fn lap(&mut self, name: &'static str) {
        let now = Instant::now();
        self.seconds.push((name, (now - self.before).as_secs_f64()));
        self.before = now;
    }
}

/// What stopped a render, with how much of it is saved.
fn saved_before(e: Error, passes: u64) -> Error {
    let saved = format!("passes 1 to {passes} are saved");
    match e {
        Error::Device { what, remedy } => Error::device(format!("{what}; {saved}"), remedy),
        e => Error::device(e.to_string(), saved),
    }
}

/// What the backend measured, longest first.
fn kernel_times(backend: &dyn Backend) -> Vec<KernelTime> {
    let times = backend.kernel_seconds().into_iter();
    let mut kernels: Vec<KernelTime> =
        times.map(|(name, seconds, dispatches)| KernelTime { name, seconds, dispatches }).collect();
    kernels.sort_by(|a, b| b.seconds.total_cmp(&a.seconds));
    kernels
}

pub(super) enum Kind {
    Exr,
    Png,
}

pub(super) fn kind_of(path: &Path) -> Result<Kind> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_lowercase).as_deref() {
        Some("exr") => Ok(Kind::Exr),
        Some("png") => Ok(Kind::Png),
        _ => Err(Error::usage(
            format!("{}: the kind of file is not known", path.display()),
            "give a name that ends in .exr or .png",
        )),
    }
}

/// What `--no-skip` keeps.
pub(super) fn kept(words: &[String]) -> Result<Vec<Part>> {
    Ok(words.iter().map(|word| Part::parse(word)).collect::<Result<Vec<_>>>()?.concat())
}

/// Find out before rendering whether all files can be written, and that none is written over another.
pub(super) fn check_outputs<'a>(scene: &Path, files: impl Iterator<Item = &'a PathBuf>) -> Result<()> {
    let mut taken: Vec<PathBuf> = Vec::new();
    for path in files {
        output::check_not_read([path], &[scene.to_owned()])?;
        output::check_writable(path)?;
        let name = output::resolve(path);
        if name.exists() && !name.is_file() {
            continue;
        }
        if taken.contains(&name) {
            let what = format!("{}: is named for output twice", path.display());
            return Err(Error::usage(what, "give each file a name of its own"));
        }
        taken.push(name);
    }
    Ok(())
}

/// When to stop, by numbers that can be meant.
pub(super) fn checked_stop(a: &RenderArguments) -> Result<Stop> {
    if a.passes == Some(0) {
        return Err(Error::usage("--passes 0 renders nothing", "give at least 1"));
    }
    if a.passes.is_some_and(|passes| passes > PASSES_MAX) {
        let what = format!("--passes: random numbers last for {PASSES_MAX} passes");
        return Err(Error::usage(what, "ask for fewer, and average renders with other seeds"));
    }
    for (name, value) in [("--time", a.time), ("--error", a.error), ("--every", Some(a.every))] {
        if value.is_some_and(|v| v.is_nan() || v <= 0.0) {
            return Err(Error::usage(format!("{name} must be larger than 0"), "give a positive number"));
        }
    }
    let passes = a.pass_range.map(PassRange::end).or(a.passes);
    Ok(Stop { passes, seconds: a.time, error: a.error })
}

/// WxH, 1 to 65,536 each.
pub(super) fn parse_size(text: &str) -> std::result::Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some([w, h]) if w > 0 && h > 0 && w <= 65_536 && h <= 65_536 => Ok([w, h]),
        _ => Err("give width and height in pixels, like 512x512, 65536 each at most".into()),
    }
}
