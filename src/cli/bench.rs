//! `joton bench SCENE…`: error over time on each device.

use super::render::Spectral;
use super::versus::{Peer, Versus};
use super::{DONE, INTERRUPTED, device, interrupt, memory, say, tell};
use clap::Args;
use joton::bench::{
    Clock, KernelRow, Row, Subject, Summary, error_plot, kernels_csv, measure, runs_csv, summary_csv,
};
use joton::film::paths::LightPaths;
use joton::film::{Image, check_memory};
use joton::output::{self, exr};
use joton::packed::PackedScene;
use joton::plan::buffers::Expected;
use joton::plan::model::GpuModel;
use joton::plan::{Plan, Settings};
use joton::{Error, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Arguments of `joton bench`.
#[derive(Debug, Args)]
pub(super) struct BenchArguments {
    /// Scene files (.toml) or meshes (.obj).
    #[arg(required = true, value_name = "SCENE")]
    scenes: Vec<PathBuf>,
    /// What the picture should be, an EXR; one for each scene, in their order.
    #[arg(long, value_name = "R.exr")]
    reference: Vec<PathBuf>,
    /// gpu, cpu, cpu-reference (the path tracer) or a part of a device's name; may be repeated [default: all].
    #[arg(long)]
    device: Vec<String>,
    /// Seconds of rendering at which the picture is looked at; processor seconds for other renderers.
    #[arg(long, value_name = "SECONDS,…", value_delimiter = ',', default_value = "0.5,1,2,4,8")]
    times: Vec<f64>,
    /// Steps are processor seconds on joton's devices, too, and the plot is over these alone.
    #[arg(long)]
    cpu_seconds: bool,
    /// Other renderers to measure beside, by name or by name and algorithm: mitsuba, mitsuba+oidn (denoised), luxcore,
    /// mitsuba-path, …; needs Python with their packages.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', conflicts_with = "paths")]
    versus: Vec<String>,
    /// The Python that runs other renderers [default: python3].
    #[arg(long, value_name = "PATH", requires = "versus")]
    python: Option<PathBuf>,
    /// Number of seeds; two or more tell bias and variance apart.
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    seeds: u32,
    /// Image size, instead of the scene's.
    #[arg(long, value_name = "WxH", value_parser = super::render::parse_size)]
    size: Option<[u32; 2]>,
    /// Memory of the whole process, device included, at most, as for `joton render`.
    #[arg(long, value_name = "SIZE", value_parser = memory::parse)]
    memory: Option<u64>,
    /// Light paths to render, as for `joton render`.
    #[arg(long, value_name = "EXPR")]
    paths: Option<String>,
    /// Do what the scene does not need, too: all, or names as `joton plan` tells them.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    no_skip: Vec<String>,
    /// Render by wavelength, as for `joton render`.
    #[arg(long, default_value = "auto")]
    spectral: Spectral,
    /// Measure what each kernel takes, too (a little slower): PREFIX.kernels.csv.
    #[arg(long)]
    timings: bool,
    /// With --timings: print what each kernel of a pass takes beside what a model of the device says, as for `joton plan`.
    #[arg(long, value_name = "GPU", requires = "timings")]
    model: Option<String>,
    /// Write PREFIX.csv, PREFIX.summary.csv and PREFIX.svg.
    #[arg(short, long, value_name = "PREFIX", default_value = "bench")]
    output: String,
}

/// A scene, ready to be rendered.
struct Loaded {
    name: String,
    packed: Arc<PackedScene>,
    plan: Plan,
    reference: Option<Image>,
    /// The files that the scene was read from.
    files: Vec<PathBuf>,
    /// As other renderers read it, where there are any.
    peer: Option<Peer>,
}

pub(super) fn run(a: &BenchArguments) -> Result<u8> {
    let times = ladder(&a.times)?;
    let model = a.model.as_deref().map(GpuModel::parse).transpose()?;
    let files = ["csv", "summary.csv", "svg", "kernels.csv"]
        .map(|kind| PathBuf::from(format!("{}.{kind}", a.output)));
    // a file of kernels is written with --timings only
    let files = if a.timings { &files[..] } else { &files[..3] };
    output::check_not_read(files, &[&a.scenes[..], &a.reference].concat())?;
    for file in files {
        output::check_writable(file)?;
    }
    if !a.reference.is_empty() && a.reference.len() != a.scenes.len() {
        let what = format!("{} references for {} scenes", a.reference.len(), a.scenes.len());
        return Err(Error::usage(what, "give one --reference for each scene, in the same order, or none"));
    }
    let versus = Versus::open(&a.versus, a.python.as_deref())?;
    let references = a.reference.iter().map(Some).chain(std::iter::repeat(None));
    let scenes: Vec<Loaded> = a
        .scenes
        .iter()
        .zip(references)
        .enumerate()
        .map(|(i, (s, r))| load(a, s, r.map(PathBuf::as_path), versus.as_ref().map(|v| (v, i))))
        .collect::<Result<_>>()?;
    let inputs: Vec<PathBuf> = scenes.iter().flat_map(|s| &s.files).chain(&a.reference).cloned().collect();
    output::check_not_read(files, &inputs)?;
    let interrupted = interrupt::watch();
    let stopped = || interrupted.load(Ordering::SeqCst);
    say(HEADING);
    let mut found = Found::default();
    let measured = measure_all(a, &times, &scenes, versus.as_ref(), stopped, &mut found);
    // what was found before something failed took its time
    if measured.is_ok() || !found.rows.is_empty() {
        if a.seeds > 1 {
            say_parts(&found.summaries);
        }
        if let Some(model) = &model {
            scenes.iter().try_for_each(|scene| say_predictions(model, scene, &found.kernels))?;
        }
        // where one file cannot be written, the others still are
        let mut saved = output::write_text(&files[0], &runs_csv(&found.rows));
        saved = saved.and(output::write_text(&files[1], &summary_csv(&found.summaries)));
        if a.timings {
            saved = saved.and(output::write_text(&files[3], &kernels_csv(&found.kernels)));
        }
        let clocks = if a.cpu_seconds { &[Clock::Cpu][..] } else { &[Clock::Cpu, Clock::Wall] };
        let plot = error_plot(&found.summaries, clocks).map_err(|e| Error::io(&files[2], "write", e));
        saved.and(plot.and_then(|plot| output::write_text(&files[2], &plot)))?;
    }
    measured?;
    Ok(if stopped() { INTERRUPTED } else { DONE })
}

/// What was measured so far.
#[derive(Default)]
struct Found {
    rows: Vec<Row>,
    summaries: Vec<Summary>,
    kernels: Vec<KernelRow>,
}

impl Found {
    fn add(&mut self, (rows, summaries): (Vec<Row>, Vec<Summary>)) {
        self.rows.extend(rows);
        self.summaries.extend(summaries);
    }
}

/// Each scene on each device and with each other renderer.
fn measure_all(
    a: &BenchArguments,
    times: &[f64],
    scenes: &[Loaded],
    versus: Option<&Versus>,
    stopped: impl Fn() -> bool + Copy,
    found: &mut Found,
) -> Result<()> {
    let devices = if a.device.is_empty() { all_devices() } else { a.device.clone() };
    let see = |row: &Row| {
        say(line_of(row));
        !stopped()
    };
    for scene in scenes {
        let subject_on = |device| Subject {
            scene: &scene.name,
            device,
            size: scene.packed.size,
            reference: scene.reference.as_ref(),
            times,
            clock: if a.cpu_seconds { Clock::Cpu } else { Clock::Wall },
            seeds: a.seeds,
            timings: a.timings,
        };
        for device in &devices {
            let open = |seed| {
                let mut plan = scene.plan.clone();
                plan.settings.seed = seed;
                let reference = device == "cpu-reference";
                let name = if reference { "cpu" } else { device };
                let (backend, line, _) = device::open(name, reference, &scene.packed, &plan)?;
                if seed == 0 {
                    tell(format_args!("joton: {}: {line}", scene.name));
                }
                Ok(backend)
            };
            let measured = measure(&subject_on(device), open, see);
            found.add((measured.rows, measured.summaries));
            found.kernels.extend(measured.kernels);
            measured.failure.map_or(Ok(()), Err)?;
            if stopped() {
                return Ok(());
            }
        }
        if let (Some(versus), Some(peer)) = (versus, &scene.peer) {
            versus.measure(&subject_on(""), peer, see, stopped, |new| found.add(new))?;
            if stopped() {
                return Ok(());
            }
        }
    }
    Ok(())
}

/// The times in ascending order, each once.
fn ladder(times: &[f64]) -> Result<Vec<f64>> {
    if times.iter().any(|t| !t.is_finite() || *t <= 0.0) {
        return Err(Error::usage("--times must be finite and larger than 0", "give seconds, like 0.5,1,2"));
    }
    let mut times = times.to_vec();
    times.sort_by(f64::total_cmp);
    times.dedup();
    Ok(times)
}

/// The devices that `joton devices` lists: the best adapter where there is one, the CPU, and the path tracer there.
fn all_devices() -> Vec<String> {
    let gpu = (!joton::backend::gpu::adapters().is_empty()).then_some("gpu");
    gpu.into_iter().chain(["cpu", "cpu-reference"]).map(String::from).collect()
}

fn load(
    a: &BenchArguments,
    file: &Path,
    reference: Option<&Path>,
    versus: Option<(&Versus, usize)>,
) -> Result<Loaded> {
    let mut scene = joton::scene::load(file)?;
    a.spectral.set(&mut scene);
    if let Some(size) = a.size {
        scene.resize(size);
    }
    check_memory(scene.size, false, 0)?;
    let reference = reference.map(exr::read_image).transpose()?;
    if let Some(r) = &reference
        && [r.width, r.height] != scene.size
    {
        let size = |s: [u32; 2]| format!("{}x{}", s[0], s[1]);
        let (of_reference, of_scene) = (size([r.width, r.height]), size(scene.size));
        let what = format!("{}: has {of_scene} pixels, its reference {of_reference}", file.display());
        return Err(Error::usage(what, format!("add --size {of_reference}")));
    }
    let keep = super::render::kept(&a.no_skip)?;
    let mut settings = Settings { keep, memory: a.memory, ..Settings::default() };
    if let Some(paths) = &a.paths {
        settings.paths = LightPaths::parse(paths)?;
    }
    let peer = versus.map(|(versus, index)| versus.export(&scene, file, index)).transpose()?;
    let packed = Arc::new(super::pack(&scene, &settings)?);
    let plan = Plan::new(&packed, settings);
    let name = file.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Loaded { name, packed, plan, reference, files: scene.files, peer })
}

/// Above the lines of [`line_of`].
const HEADING: &str = "scene            device                   seed  seconds  cpu s    passes  Mrays     estimate  \
                       relMSE     trimmed    mean ratios";

fn line_of(r: &Row) -> String {
    let percent = r.error_estimate.map_or("-".into(), |e| format!("{:.2} %", e * 100.0));
    let compared = r.comparison.as_ref().map_or(String::new(), |c| {
        let ratios: Vec<String> = c.mean_ratio.iter().map(|m| format!("{m:.4}")).collect();
        format!("{:<9.3e}  {:<9.3e}  {}", c.rel_mse, c.rel_mse_trimmed, ratios.join(" "))
    });
    let rays = r.rays.map_or("-".into(), |rays| format!("{:.2}", rays as f64 * 1e-6));
    let line = format!(
        "{:<16} {:<24} {:<5} {:<8.2} {:<8.2} {:<7} {rays:<9} {percent:<9} {compared}",
        r.scene, r.device, r.seed, r.seconds, r.cpu_seconds, r.passes
    );
    line.trim_end().into()
}

/// Bias and variance of the last step of each device.
fn say_parts(summaries: &[Summary]) {
    for (i, s) in summaries.iter().enumerate() {
        let next = summaries.get(i + 1);
        if next.is_some_and(|n| n.scene == s.scene && n.device == s.device) {
            continue;
        }
        let part = |x: Option<f64>| x.map_or("unknown".into(), |x| format!("{x:.3e}"));
        say(format_args!(
            "{} {} after {:.2} s, {} seeds: bias² {} variance {}",
            s.scene,
            s.device,
            s.seconds,
            s.seeds,
            part(s.rel_bias_squared),
            part(s.rel_variance)
        ));
    }
}

/// What the kernels of a pass took on each device, beside what the model says.
fn say_predictions(model: &GpuModel, scene: &Loaded, measured: &[KernelRow]) -> Result<()> {
    let expected = Expected::look(&scene.packed, scene.plan.clone())?;
    // both maps together, as they are measured
    let mut predicted: BTreeMap<&str, f64> = BTreeMap::new();
    for kernel in expected.needs(&scene.packed).kernels(&expected.traffic) {
        *predicted.entry(kernel.name).or_default() += model.predict(&kernel).milliseconds;
    }
    let of_scene = || measured.iter().filter(|row| row.scene == scene.name);
    let devices: BTreeSet<&str> = of_scene().map(|row| row.device.as_str()).collect();
    for device in devices {
        say(format_args!(
            "\n{} on {device}, ms a pass: measured, and by the model of {}",
            scene.name, model.name
        ));
        let of = |kernel: &str| {
            let rows = || of_scene().filter(|row| row.device == device && row.kernel == kernel);
            let passes: u64 = rows().map(|row| row.passes).sum();
            (passes > 0).then(|| rows().map(|row| row.seconds).sum::<f64>() * 1e3 / passes as f64)
        };
        let both = predicted.iter().filter_map(|(kernel, told)| Some((*kernel, of(kernel)?, *told)));
        let both: Vec<(&str, f64, f64)> = both.collect();
        let sums = both.iter().fold([0.0; 2], |sum, (_, a, b)| [sum[0] + a, sum[1] + b]);
        for (kernel, found, told) in both.into_iter().chain([("all", sums[0], sums[1])]) {
            say(format_args!("  {kernel:<20} {found:>10.3} {told:>10.3}"));
        }
    }
    Ok(())
}
