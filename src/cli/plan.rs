//! `joton plan SCENE`: what the scene needs, what is skipped and why.

use super::fit::pack_to_fit;
use super::memory::{self, mebibytes};
use super::render::{Spectral, Switch};
use super::{DONE, say, say_json};
use clap::Args;
use joton::Result;
use joton::film::Layer;
use joton::packed::OutOfReach;
use joton::plan::buffers::{Buffer, Expected};
use joton::plan::kernels::Kernel;
use joton::plan::model::{GpuModel, Prediction};
use joton::plan::process_memory::{Place, ProcessMemory};
use joton::plan::{Plan, Settings};
use joton::scene::{Scene, WavelengthReason};
use joton::spectrum::list::List;
use serde_json::json;
use std::path::PathBuf;
use std::str::FromStr;

/// Arguments of `joton plan`.
#[derive(Debug, Args)]
pub(super) struct PlanArguments {
    /// A scene file (.toml) or a mesh (.obj).
    scene: PathBuf,
    /// Image size, instead of the scene's.
    #[arg(long, value_name = "WxH", value_parser = super::render::parse_size)]
    size: Option<[u32; 2]>,
    /// Light paths to render, e.g. "LS+DE".
    #[arg(long, value_name = "EXPR")]
    paths: Option<String>,
    /// Do what the scene does not need, too: all, or names as they are told here.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    no_skip: Vec<String>,
    /// Memory of the whole process, device included, at most, e.g. 512M.
    #[arg(long, value_name = "SIZE", value_parser = memory::parse)]
    memory: Option<u64>,
    /// Share light on surfaces with neighbouring pixels when the picture is made.
    #[arg(long, default_value = "on")]
    resolve: Switch,
    /// Render by wavelength, as for `joton render`.
    #[arg(long, default_value = "auto")]
    spectral: Spectral,
    /// Bands beside red, green and blue, as for `joton render`.
    #[arg(long, value_name = "NM,…|N", value_parser = List::from_str)]
    bands: Option<List>,
    /// What a pass would take on a GPU, by a model: rtx-4070, h200, or bytes and rays a second, like 0.5T,1.5G.
    #[arg(long, value_name = "GPU")]
    model: Option<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(a: &PlanArguments) -> Result<u8> {
    let model = a.model.as_deref().map(GpuModel::parse).transpose()?;
    memory::bound(a.memory);
    let mut scene = joton::scene::load(&a.scene)?;
    a.spectral.with_bands(a.bands.as_ref()).set(&mut scene);
    if let Some(size) = a.size {
        scene.resize(size);
    }
    let keep = super::render::kept(&a.no_skip)?;
    let (resolve, list) = (a.resolve == Switch::On, measured(a));
    let mut settings =
        Settings { keep, memory: a.memory, resolve, measured: list.len(), ..Settings::default() };
    if let Some(paths) = &a.paths {
        settings.paths = joton::film::paths::LightPaths::parse(paths)?;
    }
    let packed = pack_to_fit(&mut scene, &settings, &[Place::Device])?;
    scene.warnings.extend(joton::packed::doubts(&scene, &packed));
    let mut wanted = Plan::new(&packed, settings);
    wanted.bound_process(&packed, Place::Device)?;
    let setup_bytes = joton::host::memory::peak();
    let expected = Expected::look(&packed, wanted)?;
    let (plan, needs) = (&expected.plan, expected.needs(&packed));
    let (kernels, buffers, strips) = (needs.kernels(&expected.traffic), needs.buffers(), needs.strips);
    let milliseconds: f64 = kernels.iter().map(|k| k.milliseconds).sum();
    let bytes: u64 = buffers.iter().map(|b| b.bytes).sum();
    let host_bytes = needs.host_bytes();
    let [process, on_cpu] = [Place::Device, Place::Cpu].map(|place| ProcessMemory::of(&packed, plan, place));
    let peak = |rendering: u64| rendering.max(setup_bytes.unwrap_or(0));
    let [peak, peak_on_cpu] = [peak((process.total() + bytes).max(process.compiling)), peak(on_cpu.total())];
    let per_pixel = [host_bytes as f64 / packed.pixels() as f64, needs.bytes_per_pixel()];
    let scale = packed.world_scale;
    let layers: Vec<&str> = Layer::ALL.into_iter().filter(|&l| plan.traces(l)).map(Layer::name).collect();
    if a.json {
        let value = json!({
            "triangles": packed.triangles.len(),
            "emitters": packed.emitters.len(),
            "out_of_reach": packed.out_of_reach,
            "layers": layers,
            "bands": bands(&scene),
            "measured": list,
            "indirect": plan.indirect.name(),
            "caustic_jotons": plan.caustic_jotons,
            "diffuse_jotons": plan.diffuse_jotons,
            "shadow_rays": plan.settings.shadow_rays,
            "warps": plan.guides.caustic.warps().len() + plan.guides.diffuse.warps().len(),
            "caustic_radius": plan.caustic.base * scale,
            "diffuse_radius": plan.diffuse.base * scale,
            "strips": strips.count(),
            "kernels": kernels,
            "milliseconds": milliseconds,
            "predictions": model.as_ref().map(|m| kernels.iter().map(|k| m.predict(k)).collect::<Vec<_>>()),
            "buffers": buffers,
            "bytes": bytes,
            "bytes_per_pixel": per_pixel[1],
            "host_bytes": host_bytes,
            "host_bytes_per_pixel": per_pixel[0],
            "process": process,
            "setup_bytes": setup_bytes,
            "peak_bytes": peak,
            "peak_bytes_on_cpu": peak_on_cpu,
            "skipped": plan.skipped,
            "warnings": scene.warnings,
        });
        say_json(&value)?;
        return Ok(DONE);
    }
    say(format_args!("{} triangles, {} emitters", packed.triangles.len(), packed.emitters.len()));
    if !packed.out_of_reach.is_empty() {
        let OutOfReach { triangles, lights } = packed.out_of_reach;
        say(format_args!("out of reach: {triangles} triangles, {lights} lights that are no surfaces"));
    }
    say(format_args!("layers: {}", layers.join(", ")));
    say(format_args!("bands: {}", bands(&scene)));
    if let Some(list) = &a.bands {
        let (count, renders) = (list.lambdas().len(), list.threes().len());
        let [first, last] =
            [list.lambdas().first(), list.lambdas().last()].map(|l| l.copied().unwrap_or(0.0));
        say(format_args!("measured: {count} bands from {first} to {last} nm, in {renders} renders more"));
    }
    for (what, jotons, schedule) in [
        ("caustic map", plan.caustic_jotons, &plan.caustic),
        ("diffuse map", plan.diffuse_jotons, &plan.diffuse),
    ] {
        if jotons > 0 {
            say(format_args!("{what}: {jotons} jotons a pass, radius {:.4}", schedule.base * scale));
        }
    }
    for (what, guide) in [
        ("caustic jotons", &plan.guides.caustic),
        ("diffuse jotons", &plan.guides.diffuse),
        ("shadow rays", &plan.guides.direct),
    ] {
        if !guide.is_empty() {
            let warps = guide.warps().len();
            say(format_args!("{what}: lamps picked by what the camera can use, {warps} of them warped"));
        }
    }
    if strips.count() > 1 {
        say(format_args!("image: {} strips of {} rows, one after the other", strips.count(), strips.rows));
    }
    if plan.traces(Layer::Direct) {
        say(format_args!("direct light: {} shadow rays a pixel and pass", plan.settings.shadow_rays));
    }
    if plan.has_indirect_paths() {
        say(format_args!("indirect light: a path a pixel and pass goes on from where light is gathered"));
    }
    let shared: Vec<&str> = plan.resolved_layers().into_iter().map(Layer::name).collect();
    if !shared.is_empty() {
        say(format_args!("shared with neighbours when the picture is made: {}", shared.join(", ")));
    }
    say(format_args!(
        "\nkernels of a pass, about {milliseconds:.0} ms on two cores with lavapipe; all but names and numbers of dispatches is estimated"
    ));
    table(
        ["kernel", "dispatches", "invocations", "rays", "steps", "tests", "MB moved", "ms"],
        kernels.iter().map(kernel_line),
    );
    if let Some(model) = &model {
        say_predictions(model, &kernels);
    }
    say(format_args!("\nbuffers, {} together; how many jotons lanes store is estimated", mebibytes(bytes)));
    table(["buffer", "bytes", "holds"], buffers.iter().map(buffer_line));
    say(format_args!(
        "\nmemory of a pixel: {:.0} bytes on the device while its strip is there, at most {:.0} on the host; films and files on \
         the host, at most {}",
        per_pixel[1],
        per_pixel[0],
        mebibytes(host_bytes)
    ));
    say(format_args!(
        "memory of the process, at most: {} with a device (program and driver {}, scene {}, films {}, buffers {}), {} with \
         --device cpu{}",
        mebibytes(peak),
        mebibytes(process.program),
        mebibytes(process.scene),
        mebibytes(process.films),
        mebibytes(bytes),
        mebibytes(peak_on_cpu),
        setup_bytes.map_or(String::new(), |b| format!("; reading and hierarchy took {}", mebibytes(b)))
    ));
    say("");
    for s in &plan.skipped {
        let (what, name, why, back) = (s.what.words(), s.what.name(), s.why.words(), s.why.back());
        say(format_args!("skipped {what} ({name}): {why}; back with {back}"));
    }
    for w in &scene.warnings {
        say(format_args!("warning {w}"));
    }
    Ok(DONE)
}

/// What the kernels would take on a GPU.
fn say_predictions(model: &GpuModel, kernels: &[Kernel]) {
    let all: Vec<_> = kernels.iter().map(|k| (k, model.predict(k))).collect();
    let milliseconds: f64 = all.iter().map(|(_, p)| p.milliseconds).sum();
    say(format_args!("\nby the model of {}, not measured: a pass in {milliseconds:.2} ms", model.name));
    let line = |(k, p): &(&Kernel, Prediction)| {
        [kernel_name(k), format!("{:.3}", p.milliseconds), p.bound.name().to_string()]
    };
    table(["kernel", "ms", "bound by"], all.iter().map(line));
}

/// What a kernel is called, and its map.
fn kernel_name(k: &Kernel) -> String {
    k.map.map_or(k.name.to_string(), |map| format!("{} ({map})", k.name))
}

/// Cells of a kernel's line.
fn kernel_line(k: &Kernel) -> [String; 8] {
    let megabytes = k.bytes as f64 * 1e-6;
    let [dispatches, invocations, rays, steps, tests] =
        [k.dispatches, k.invocations, k.rays, k.steps, k.tests].map(|n| n.to_string());
    [
        kernel_name(k),
        dispatches,
        invocations,
        rays,
        steps,
        tests,
        format!("{megabytes:.2}"),
        format!("{:.2}", k.milliseconds),
    ]
}

/// Cells of a buffer's line.
fn buffer_line(b: &Buffer) -> [String; 3] {
    [b.name.to_string(), b.bytes.to_string(), b.holds.to_string()]
}

/// Print lines of cells in columns: numbers to the right.
fn table<const N: usize>(heads: [&str; N], lines: impl Iterator<Item = [String; N]>) {
    let lines: Vec<[String; N]> = [heads.map(String::from)].into_iter().chain(lines).collect();
    let widths: [usize; N] = std::array::from_fn(|i| lines.iter().map(|l| l[i].len()).max().unwrap_or(0));
    let is_number = |i: usize| lines.iter().skip(1).all(|l| l[i].parse::<f64>().is_ok());
    let right: [bool; N] = std::array::from_fn(is_number);
    for line in &lines {
        let cells: Vec<String> = (0..N)
            .map(|i| {
                let width = widths[i];
                if right[i] { format!("{:>width$}", line[i]) } else { format!("{:<width$}", line[i]) }
            })
            .collect();
        say(format_args!("  {}", cells.join("  ").trim_end()));
    }
}

/// Wavelengths of the bands beside red, green and blue, nm.
fn measured(a: &PlanArguments) -> &[f64] {
    a.bands.as_ref().map_or(&[], List::lambdas)
}

/// What the bands are, in words.
fn bands(scene: &Scene) -> &'static str {
    match (scene.wavelengths.are_rendered, scene.asks_for_wavelengths()) {
        (false, _) => "red, green and blue",
        (true, Some(WavelengthReason::Dispersion)) => "three wavelengths a pass, since glass parts colours",
        (true, Some(WavelengthReason::Lines)) => "three wavelengths a pass, since lamps shine in lines",
        (true, Some(WavelengthReason::Spectra)) => "three wavelengths a pass, since spectra are stated",
        (true, None) => "three wavelengths a pass, as asked for",
    }
}
