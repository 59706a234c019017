//! The command line holds to its contract: exit status, what goes to stdout and stderr, files, numbers in the report.
//!
//! Runs the program in folders of its own. Tests that need a Vulkan, Metal or DX12 device fail where there is none,
//! unless JOTON_TEST_NO_GPU=1.

use joton::film::{Image, Layer};
use joton::output::compare::compare;
use joton::output::exr as exr_file;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Seconds after which a program that should have ended counts as hung.
const HUNG: f64 = 120.0;

/// A folder with the Cornell box in it, and the program to run there.
struct Folder(TempDir);

impl Folder {
    fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        for file in ["cornell.toml", "cornell.obj", "cornell.mtl", "ring.toml", "ring.obj", "ring.mtl"] {
            fs::copy(scenes.join(file), folder.path().join(file)).expect("a copy of the scene");
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_joton"));
        command.args(words.split_whitespace()).current_dir(self.0.path()).stdin(Stdio::null());
        // without one, Vulkan loaders complain on stderr
        command.env("XDG_RUNTIME_DIR", self.0.path());
        command
    }

    fn run(&self, words: &str) -> Ended {
        Ended::of(self.command(words).output().expect("joton runs"))
    }

    /// A run on a machine without any Vulkan driver.
    fn run_without_vulkan(&self, words: &str) -> Ended {
        let mut command = self.command(words);
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        Ended::of(command.output().expect("joton runs"))
    }

    /// A run that must succeed.
    fn done(&self, words: &str) -> Ended {
        let ended = self.run(words);
        assert_eq!(ended.code, Some(0), "joton {words}: {}", ended.stderr);
        ended
    }

    /// A run that must fail with status 2, nothing on stdout and one line on stderr that holds all of `parts`.
    fn fails(&self, words: &str, parts: &[&str]) {
        self.run(words).is_refusal(words, parts);
    }

    fn image(&self, name: &str) -> Image {
        exr_file::read_image(&self.path(name)).expect("a readable EXR")
    }

    fn report(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).expect("a report")).expect("a report in JSON")
    }
}

/// What a run left behind.
struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Ended {
    fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("messages in UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    fn is_refusal(&self, words: &str, parts: &[&str]) {
        assert_eq!(self.code, Some(2), "joton {words}: {}", self.stderr);
        assert_eq!(self.stdout, "", "joton {words} prints nothing to stdout");
        assert_eq!(self.stderr.lines().count(), 1, "joton {words}: one line, not\n{}", self.stderr);
        assert!(self.stderr.starts_with("joton: "), "{}", self.stderr);
        for part in parts {
            assert!(self.stderr.contains(part), "joton {words}: {:?} does not say {part:?}", self.stderr);
        }
    }
}

/// The fastest render there is.
const QUICK: &str = "render cornell.toml --size 32x32 --device cpu";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

fn names(folder: &Folder) -> Vec<String> {
    let entries = fs::read_dir(folder.0.path()).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("a name")).collect();
    names.sort();
    names
}

/// A render without -o leaves NAME.png and NAME.exr of the asked size in the current folder, and nothing else.
#[test]
fn render_writes_its_default_files() {
    let folder = Folder::new();
    let before = names(&folder);
    folder.done("render cornell.toml --size 24x16 --device cpu --passes 2");
    let after = names(&folder);
    let new: Vec<&String> = after.iter().filter(|n| !before.contains(n)).collect();
    assert_eq!(new, ["cornell.exr", "cornell.png"]);
    let image = folder.image("cornell.exr");
    assert_eq!((image.width, image.height), (24, 16));
    assert!(image.pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    assert!(image.pixels.iter().flatten().any(|x| *x > 0.0));
    let png = fs::read(folder.path("cornell.png")).expect("a PNG");
    assert_eq!(png[16..24], [0, 0, 0, 24, 0, 0, 0, 16], "the size in the PNG's header");
}

/// The layers of the EXR sum to its R G B; float32 rounding of five numbers is all that differs.
#[test]
fn layers_sum_to_the_image() {
    use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
    let folder = Folder::new();
    folder.done("render ring.toml --size 32x32 --device cpu --passes 4 -o a.exr");
    let image = read_all_flat_layers_from_file(folder.path("a.exr")).expect("an EXR");
    let channels = &image.layer_data[0].channel_data.list;
    let values = |name: &str| -> Vec<f32> {
        let channel =
            channels.iter().find(|c| c.name.eq(name)).unwrap_or_else(|| panic!("no channel {name}"));
        match &channel.sample_data {
            FlatSamples::F32(values) => values.clone(),
            other => panic!("{name} is no float32: {other:?}"),
        }
    };
    for band in ["R", "G", "B"] {
        let layers = Layer::ALL.map(|l| values(&format!("{}.{band}", l.name())));
        for (pixel, whole) in values(band).into_iter().enumerate() {
            let sum: f32 = layers.iter().map(|l| l[pixel]).sum();
            assert!((sum - whole).abs() <= 1e-5 * whole.abs().max(1e-3), "{band} of {pixel}: {sum}, {whole}");
        }
        assert!(layers[Layer::Caustic as usize].iter().any(|x| *x > 0.0), "the ring makes a caustic");
    }
}

/// One seed is one image, byte by byte; another seed is another image.
#[test]
fn a_seed_is_an_image() {
    let folder = Folder::new();
    for (name, seed) in [("a", 7), ("b", 7), ("c", 8)] {
        folder.done(&format!("{QUICK} --passes 3 --seed {seed} -o {name}.exr"));
    }
    let bytes = |name: &str| fs::read(folder.path(name)).expect("an EXR");
    assert_eq!(bytes("a.exr"), bytes("b.exr"));
    // the images, not the files: a file also says its seed
    assert_ne!(folder.image("a.exr"), folder.image("c.exr"));
}

/// The report holds what the contract names, and its numbers agree with each other and with what was asked.
#[test]
fn report_is_complete_and_consistent() {
    let folder = Folder::new();
    let ended =
        folder.done("render ring.toml --size 32x32 --device cpu --passes 24 -o a.exr --report r.json");
    assert_eq!(ended.stdout, "");
    let r = folder.report("r.json");
    assert!(ended.stderr.contains(r["device"].as_str().expect("a device")), "{}", ended.stderr);
    assert_eq!(r["passes"], 24);
    for key in [
        "seconds",
        "setup_seconds",
        "cpu_seconds",
        "rays",
        "jotons_emitted",
        "jotons_stored",
        "error_estimate",
    ] {
        assert!(number(&r[key]) > 0.0, "{key} is {}", r[key]);
    }
    if cfg!(target_os = "linux") {
        assert!(number(&r["peak_memory_bytes"]) > 1e6);
    }
    assert!(number(&r["jotons_emitted"]) >= 24.0, "at least one joton a pass");
    assert!(number(&r["rays"]) >= 24.0 * 32.0 * 32.0, "at least a ray for each pixel and pass");
    for skip in r["skipped"].as_array().expect("a list") {
        assert!(skip["what"].is_string() && skip["why"].is_string(), "{skip}");
    }
    let [first, last] = [0, 1].map(|i| number(&r["radius"]["diffuse"][i]));
    assert!(0.0 < last && last < first, "the radius shrinks: {first}, {last}");
    let flux = |key: &str| -> f64 { (0..3).map(|b| number(&r["energy"][key][b])).sum() };
    let (emitted, absorbed, escaped) = (flux("emitted"), flux("absorbed"), flux("escaped"));
    // the roulette is fair on average only: five standard errors of its own spread
    let allowed = 5.0 * number(&r["energy"]["standard_error"]) * emitted;
    assert!(emitted > 0.0 && absorbed > 0.0 && escaped > 0.0, "an open scene loses light: {}", r["energy"]);
    assert!((emitted - absorbed - escaped).abs() <= allowed.max(1e-6 * emitted), "{}", r["energy"]);
    assert!(allowed < 0.2 * emitted, "the balance means something");
}

/// A report is also written where no error can be estimated; what is not known is null, and no key is missing.
#[test]
fn report_of_one_pass_has_every_key() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 1 -o a.exr --report r.json"));
    let r = folder.report("r.json");
    let keys = "device passes seconds setup_seconds cpu_seconds rays jotons_emitted jotons_stored energy skipped \
                radius peak_memory_bytes error_estimate";
    for key in keys.split_whitespace() {
        assert!(r.get(key).is_some(), "no {key}");
    }
    for key in ["emitted", "absorbed", "escaped"] {
        assert_eq!(r["energy"][key].as_array().map(Vec::len), Some(3), "{key}");
    }
    assert_eq!(r["passes"], 1);
}

/// --time ends rendering within about a second of what was asked, and does not count set-up.
#[test]
fn time_is_kept() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --time 1.5 -o a.exr --report r.json"));
    let r = folder.report("r.json");
    let seconds = number(&r["seconds"]);
    assert!((1.5..2.5).contains(&seconds), "{seconds} s");
    assert_eq!(r["stopped_by"], "time");
}

/// --error goes on until the estimate is that small.
#[test]
fn error_is_reached() {
    let folder = Folder::new();
    for error in [0.5, 0.1] {
        folder.done(&format!("{QUICK} --error {error} -o a.exr --report r.json"));
        let r = folder.report("r.json");
        assert_eq!(r["stopped_by"], "error");
        assert!(number(&r["error_estimate"]) <= error, "{} against {error}", r["error_estimate"]);
    }
}

/// Whichever of --passes, --time and --error is met first ends the render.
#[test]
fn the_first_limit_stops() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 2 --time 600 --error 1e-9 -o a.exr --report r.json"));
    let r = folder.report("r.json");
    assert_eq!((&r["stopped_by"], &r["passes"]), (&"passes".into(), &2.into()));
}

/// Expressions that share no path and leave none out give images that sum to the whole.
#[test]
fn paths_partition_the_image() {
    let folder = Folder::new();
    let render = |name: &str, paths: &str| {
        folder.done(&format!("render ring.toml --size 16x16 --device cpu --passes 64 -o {name}.exr {paths}"));
        folder.image(&format!("{name}.exr"))
    };
    let whole = render("whole", "");
    let parts = ["LS*E", "LDS*E", "LS+DS*E", "L.*D.*DS*E"].map(|p| render("part", &format!("--paths {p}")));
    let mean = |image: &Image| image.pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>();
    let sum: f64 = parts.iter().map(mean).sum();
    for (part, what) in parts.iter().zip(["emission", "direct", "caustic", "diffuse"]) {
        assert!(mean(part) < mean(&whole), "{what} is not all there is");
    }
    // the same random numbers throughout, but the maps may be cut differently: noise of the mean of 16,384 samples
    assert!((sum / mean(&whole) - 1.0).abs() < 0.01, "{sum} against {}", mean(&whole));
}

/// --quiet says nothing at all, and without a terminal there is no progress bar.
#[test]
fn stderr_is_calm() {
    let folder = Folder::new();
    let quiet = folder.done(&format!("{QUICK} --passes 2 --quiet -o a.exr"));
    assert_eq!((quiet.stdout, quiet.stderr), (String::new(), String::new()));
    let plain = folder.done(&format!("{QUICK} --time 0.7 -o a.exr"));
    assert_eq!(plain.stdout, "");
    assert_eq!(plain.stderr.lines().count(), 2, "the device and the end: {}", plain.stderr);
    assert!(!plain.stderr.contains(['\r', '\x1b']), "{:?}", plain.stderr);
}

/// What cannot be rendered, or not saved, is refused before rendering: one line, status 2, no file touched.
#[test]
fn errors_are_one_line_and_leave_files_alone() {
    let folder = Folder::new();
    fs::write(folder.path("a.exr"), b"precious").expect("a file");
    fs::write(folder.path("a.json"), b"precious").expect("a file");
    fs::create_dir(folder.path("folder.toml")).expect("a folder");
    fs::write(folder.path("broken.toml"), "[camera\n").expect("a file");
    fs::write(folder.path("nothing.obj"), "").expect("a file");
    let files = names(&folder);
    let to = "-o a.exr --report a.json";
    for (words, parts) in [
        ("render missing.toml", &["missing.toml", "No such file"][..]),
        ("render folder.toml", &["folder.toml", "directory"]),
        ("render broken.toml", &["broken.toml:1"]),
        ("render nothing.obj", &["nothing.obj"]),
        ("render cornell.mtl", &["cornell.mtl", ".toml", ".obj"]),
        ("render", &["SCENE"]),
        ("render cornell.toml --size 0x5", &["0x5", "512x512"]),
        ("render cornell.toml --size 5", &["512x512"]),
        ("render cornell.toml --size 5x-5", &["512x512"]),
        ("render cornell.toml --size 100000x100000", &["100000x100000"]),
        ("render cornell.toml --size 65536x65536 --device cpu", &["film", "limit", "--size"]),
        ("render cornell.toml --passes 0", &["--passes", "at least 1"]),
        ("render cornell.toml --passes -1", &["-1"]),
        ("render cornell.toml --time nan", &["--time", "positive"]),
        ("render cornell.toml --time 0", &["--time", "positive"]),
        ("render cornell.toml --time soon", &["soon"]),
        ("render cornell.toml --error nan", &["--error", "positive"]),
        ("render cornell.toml --error=-1", &["--error", "positive"]),
        ("render cornell.toml --seed x", &["--seed"]),
        ("render cornell.toml --paths LDX", &["X"]),
        ("render cornell.toml --frobnicate", &["--frobnicate"]),
        ("render cornell.toml --reference --device gpu", &["--reference", "--device cpu"]),
        ("render cornell.toml --exposure bright", &["bright", "auto"]),
        ("render cornell.toml -o b.jpg", &["b.jpg", ".exr", ".png"]),
        ("render cornell.toml -o exr", &["exr", ".png"]),
        ("render cornell.toml -o none/b.exr", &["none/b.exr", "none", "create it"]),
        ("render cornell.toml -o b.exr -o ./b.exr", &["./b.exr", "twice"]),
    ] {
        // the precious files are named last, so that what is refused is what comes before
        folder.fails(&format!("{words} {to}"), parts);
    }
    folder.fails("render cornell.toml -o a.exr --report none/r.json", &["none/r.json", "create it"]);
    folder.fails("render cornell.toml -o a.exr --report a.exr", &["a.exr", "twice"]);
    folder.fails("render cornell.toml -o b.exr --report cornell.toml", &["cornell.toml", "scene"]);
    folder.fails("", &["--help"]);
    folder.fails("frobnicate", &["frobnicate"]);
    for precious in ["a.exr", "a.json"] {
        assert_eq!(fs::read(folder.path(precious)).expect("a file"), b"precious");
    }
    assert_eq!(names(&folder), files, "nothing is left behind");
}

/// A scene that must not be read is refused with its name. Skips nothing: who may read everything is given a folder.
#[cfg(unix)]
#[test]
fn unreadable_scene_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let path = folder.path("cornell.obj");
    fs::set_permissions(&path, fs::Permissions::from_mode(0o0)).expect("permissions");
    if fs::File::open(&path).is_ok() {
        fs::remove_file(&path).expect("a file");
        fs::create_dir(&path).expect("a folder");
    }
    folder.fails("render cornell.toml", &["cornell.obj"]);
}

/// A picture that exists is replaced by a render that succeeds.
#[test]
fn success_replaces_files() {
    let folder = Folder::new();
    fs::write(folder.path("a.exr"), b"old").expect("a file");
    fs::write(folder.path("r.json"), b"old").expect("a file");
    folder.done(&format!("{QUICK} --passes 1 -o a.exr --report r.json"));
    assert_eq!(folder.image("a.exr").width, 32);
    assert_eq!(folder.report("r.json")["passes"], 1);
}

/// The device is chosen by name; a name that no device has is refused with those that there are.
#[test]
fn unknown_device_lists_the_known_ones() {
    let folder = Folder::new();
    let words = "render cornell.toml --size 8x8 --passes 1 --device abacus -o a.exr";
    folder.fails(words, &["abacus", "choose one of", "cpu"]);
    folder.run_without_vulkan(words).is_refusal(words, &["abacus", "choose one of", "cpu"]);
    assert!(!folder.path("a.exr").exists());
}

/// Without Vulkan `auto` renders on the CPU, says so in one line, and succeeds; `gpu` fails and says what to install.
#[cfg(target_os = "linux")]
#[test]
fn auto_falls_back_to_the_cpu() {
    let folder = Folder::new();
    let ended =
        folder.run_without_vulkan("render cornell.toml --size 32x32 --passes 2 -o a.exr --report r.json");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let said = ended.stderr.lines().filter(|l| l.contains("CPU") && l.contains("no Vulkan")).count();
    assert_eq!(said, 1, "{}", ended.stderr);
    assert!(folder.report("r.json")["device"].as_str().is_some_and(|d| d.starts_with("CPU")));
    let words = "render cornell.toml --size 32x32 --passes 2 -o b.exr --device gpu";
    folder.run_without_vulkan(words).is_refusal(words, &["no Vulkan", "--device cpu"]);
    let devices = folder.run_without_vulkan("devices");
    assert!(devices.stdout.lines().any(|l| l.starts_with("cpu") && l.contains("auto")), "{}", devices.stdout);
}

/// The GPU's picture is the CPU's: means within 5 %, which noise of 16 passes at this size does not exceed.
#[test]
fn gpu_renders_what_the_cpu_renders() {
    if std::env::var("JOTON_TEST_NO_GPU").is_ok_and(|v| v == "1") {
        return;
    }
    let folder = Folder::new();
    let words = "render cornell.toml --size 32x32 --passes 16";
    let ended = folder.run(&format!("{words} --device gpu -o gpu.exr"));
    assert_eq!(ended.code, Some(0), "no device? Set JOTON_TEST_NO_GPU=1 to leave this out. {}", ended.stderr);
    folder.done(&format!("{words} --device cpu -o cpu.exr"));
    let c = compare(&folder.image("gpu.exr"), &folder.image("cpu.exr")).expect("a comparison");
    assert!(c.mean_ratio.iter().all(|r| (r - 1.0).abs() < 0.05), "{c:?}");
}

/// Ctrl-C ends a render with status 130, and everything so far is saved.
#[cfg(unix)]
#[test]
fn interrupted_render_is_saved() {
    let folder = Folder::new();
    let words = format!("{QUICK} --time {HUNG} -o a.exr -o a.png --report r.json");
    let mut child = folder.command(&words).stderr(Stdio::piped()).spawn().expect("joton runs");
    // the line that names the device comes last before rendering
    let mut stderr = child.stderr.take().expect("a pipe");
    std::io::Read::read_exact(&mut stderr, &mut [0]).expect("a line");
    std::thread::sleep(Duration::from_millis(500));
    let sent = Instant::now();
    let killed = Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs");
    assert!(killed.success());
    let status = child.wait().expect("joton ends");
    assert_eq!(status.code(), Some(130));
    assert!(sent.elapsed().as_secs_f64() < HUNG / 4.0, "it stops soon");
    let r = folder.report("r.json");
    assert_eq!(r["stopped_by"], "interrupted");
    assert!(number(&r["passes"]) >= 1.0);
    assert_eq!(folder.image("a.exr").width, 32);
    assert!(folder.path("a.png").exists());
}

/// `compare` exits with 0 within the tolerance and 1 beyond it, tells the errors on stdout, and draws the heat map.
#[test]
fn compare_judges() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 2 -o a.exr"));
    folder.done(&format!("{QUICK} --passes 2 --seed 1 -o b.exr"));
    let same = folder.done("compare a.exr a.exr --tolerance 0");
    assert!(same.stdout.contains("relMSE 0"), "{}", same.stdout);
    for (tolerance, code) in [("1000", 0), ("1e-12", 1)] {
        let ended = folder.run(&format!("compare a.exr b.exr --tolerance {tolerance} --heatmap h.png"));
        assert_eq!(ended.code, Some(code), "{}{}", ended.stdout, ended.stderr);
        assert!(ended.stdout.contains("relMSE") && ended.stdout.contains("mean/ref"), "{}", ended.stdout);
        assert!(fs::read(folder.path("h.png")).expect("a heat map").starts_with(b"\x89PNG"));
        fs::remove_file(folder.path("h.png")).expect("a file");
    }
    assert_eq!(folder.run("compare a.exr b.exr").code, Some(0), "without a tolerance nothing is judged");
    folder.done("render cornell.toml --size 16x16 --device cpu --passes 1 -o small.exr");
    folder.fails("compare a.exr small.exr", &["32x32", "16x16"]);
    folder.fails("compare a.exr none.exr", &["none.exr"]);
    folder.fails("compare a.exr cornell.obj", &["cornell.obj", "EXR"]);
    folder.fails("compare a.exr b.exr --tolerance nan", &["--tolerance"]);
    folder.fails("compare a.exr b.exr --heatmap none/h.png", &["none/h.png"]);
}

/// `plan --json` is JSON that tells what is done and what is skipped and why; without --json it is text.
#[test]
fn plan_can_be_read_by_programs() {
    let folder = Folder::new();
    let plan: Value = serde_json::from_str(&folder.done("plan cornell.toml --json").stdout).expect("JSON");
    assert!(number(&plan["triangles"]) > 0.0);
    assert_eq!((number(&plan["shadow_rays"]), number(&plan["warps"])), (2.0, 0.0));
    let skips = plan["skipped"].as_array().expect("a list");
    assert!(skips.iter().any(|s| s["what"] == "caustic map" && s["why"].is_string()), "{plan}");
    let sum = |list: &str, of: &str| -> f64 {
        plan[list].as_array().expect("a list").iter().map(|entry| number(&entry[of])).sum()
    };
    assert!(number(&plan["bytes"]) > 0.0 && number(&plan["bytes"]) == sum("buffers", "bytes"));
    let cost = number(&plan["milliseconds"]);
    assert!(cost > 0.0 && (sum("kernels", "milliseconds") / cost - 1.0).abs() < 1e-9);
    // it needs no device
    let ended = folder.run_without_vulkan("plan cornell.toml");
    assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
    for part in ["gather (diffuse)", "gather_points", "MiB together"] {
        assert!(ended.stdout.contains(part), "{part}: {}", ended.stdout);
    }
    let text = folder.done("plan cornell.toml").stdout;
    assert!(
        text.contains(
            "skipped caustic map (caustic-map): no surface mirrors or refracts; back with a mirror"
        ),
        "{text}"
    );
    assert!(text.contains("direct light: 2 shadow rays"), "{text}");
}

/// `--memory` is understood or refused with what to write, and the plan keeps to it without a device: strips first, then
/// fewer jotons, and an error with need, limit and remedy where nothing helps.
#[test]
fn memory_is_kept_to() {
    let folder = Folder::new();
    let plan = |memory: &str| -> Value {
        let words = format!("plan ring.toml --json --memory {memory}");
        serde_json::from_str(&folder.done(&words).stdout).expect("JSON")
    };
    let (ample, cut, scarce) = (plan("1G"), plan("14M"), plan("4M"));
    assert_eq!(number(&ample["strips"]), 1.0);
    assert!(number(&ample["bytes"]) > 14.0 * 1048576.0 && number(&cut["bytes"]) <= 14.0 * 1048576.0);
    assert!(number(&cut["strips"]) > 1.0 && cut["caustic_jotons"] == ample["caustic_jotons"]);
    assert!(number(&scarce["bytes"]) <= 4.0 * 1048576.0);
    assert!(number(&scarce["caustic_jotons"]) < number(&ample["caustic_jotons"]));
    folder.fails("plan ring.toml --memory 100K", &["bytes", "102400", "--memory"]);
    folder.fails("render ring.toml --memory 12", &["--memory", "512M"]);
}

/// `devices` lists at least the processor, and says of exactly one device that auto picks it.
#[test]
fn devices_are_listed() {
    let folder = Folder::new();
    let text = folder.done("devices").stdout;
    assert!(text.lines().any(|l| l.starts_with("cpu")), "{text}");
    assert_eq!(text.matches("auto").count(), 1, "{text}");
}

/// Who stops reading, as `head` does, makes no error: neither on stdout nor on stderr.
#[cfg(unix)]
#[test]
fn a_closed_pipe_is_no_error() {
    let folder = Folder::new();
    for words in ["plan cornell.toml", "plan cornell.toml --json", "devices", "--help", "render --help"] {
        let mut child = folder.command(words).stdout(Stdio::piped()).spawn().expect("joton runs");
        drop(child.stdout.take());
        assert_eq!(child.wait().expect("joton ends").code(), Some(0), "joton {words}");
    }
    let words = format!("{QUICK} --passes 1 -o a.exr");
    let mut child = folder.command(&words).stderr(Stdio::piped()).spawn().expect("joton runs");
    drop(child.stderr.take());
    assert_eq!(child.wait().expect("joton ends").code(), Some(0), "stderr closed");
}

/// Help and version are answers: stdout, status 0.
#[test]
fn help_goes_to_stdout() {
    let folder = Folder::new();
    for words in ["--help", "--version", "render --help", "help compare"] {
        let ended = folder.done(words);
        assert!(!ended.stdout.is_empty() && ended.stderr.is_empty(), "joton {words}");
    }
}
