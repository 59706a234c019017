//! `joton bench`: the tables and the plot that it leaves, and the numbers in them.

mod common;

use std::fs;
use std::path::Path;
use std::process::{Command, Output};
use tempfile::TempDir;

fn joton(folder: &TempDir, words: &str) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_joton"));
    command.args(words.split_whitespace()).current_dir(folder.path()).output().expect("joton runs")
}

/// The Cornell box in a folder of its own.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    for file in ["cornell.toml", "cornell.obj", "cornell.mtl"] {
        fs::copy(scenes.join(file), folder.path().join(file)).expect("a copy of the scene");
    }
    folder
}

/// The cells of a column of CSV; commas inside quotes do not count.
fn column(text: &str, name: &str) -> Vec<String> {
    let cells = |line: &str| -> Vec<String> {
        let parts = line.split('"').enumerate();
        let plain: String =
            parts.map(|(i, p)| if i % 2 == 0 { p.into() } else { p.replace(',', ";") }).collect();
        plain.split(',').map(String::from).collect()
    };
    let mut lines = text.lines().map(cells);
    let names = lines.next().expect("a heading");
    let at = names.iter().position(|n| n == name).unwrap_or_else(|| panic!("no column {name} in {names:?}"));
    lines
        .map(|line| {
            assert_eq!(line.len(), names.len(), "as many cells as columns: {line:?}");
            line[at].clone()
        })
        .collect()
}

fn numbers(text: &str, name: &str) -> Vec<f64> {
    column(text, name)
        .iter()
        .map(|c| c.parse().unwrap_or_else(|_| panic!("{name}: {c:?} is no number")))
        .collect()
}

/// `--timings`: every kernel of each seed, with the passes that it was measured in; and what the device holds.
#[test]
fn bench_tells_what_kernels_take() {
    let folder = folder();
    let words = "bench cornell.toml --size 16x16 --device gpu --times 0.05,0.1 --seeds 2 --timings -o b";
    if crate::common::device().is_none() {
        return;
    }
    let ended = joton(&folder, words);
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let [rows, kernels] =
        ["b.csv", "b.kernels.csv"].map(|f| fs::read_to_string(folder.path().join(f)).expect("a table"));
    assert!(numbers(&rows, "device_bytes").iter().all(|b| *b > 1e6), "{rows}");
    let [rays, seconds, speeds] = ["rays", "seconds", "rays_per_second"].map(|column| numbers(&rows, column));
    for ((r, s), speed) in rays.iter().zip(&seconds).zip(&speeds) {
        // seconds are printed to a tenth of a millisecond
        assert!((speed * s / r - 1.0).abs() < 0.01, "{speed} {r} {s}");
    }
    let (names, passes) = (column(&kernels, "kernel"), numbers(&kernels, "passes"));
    let (dispatches, seeds) = (numbers(&kernels, "dispatches"), numbers(&kernels, "seed"));
    for seed in [0.0, 1.0] {
        let eye = (0..names.len()).find(|&i| names[i] == "eye" && seeds[i] == seed).expect("eye runs");
        assert_eq!(dispatches[eye], passes[eye], "once a pass");
    }
    assert!(numbers(&kernels, "seconds").iter().sum::<f64>() > 0.0);
}

/// Two devices, two seeds, two times: eight rows, four summaries, a plot with a curve for each device; time grows, the
/// error shrinks, and bias² and variance make up the error.
#[test]
fn bench_leaves_tables_and_a_plot() {
    let folder = folder();
    let made = joton(
        &folder,
        "render cornell.toml --size 16x16 --device cpu --reference --passes 4000 --quiet -o r.exr",
    );
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    let ended = joton(
        &folder,
        "bench cornell.toml --size 16x16 --reference r.exr --device cpu --device cpu-reference \
         --times 0.8,0.2 --seeds 2 -o b",
    );
    let stderr = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.success(), "{stderr}");
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).expect("a file");
    let rows = read("b.csv");
    let all = "scene device device_name seed step seconds cpu_seconds passes rays jotons error_estimate rel_mse \
               rel_mse_trimmed mean_ratio_r mean_ratio_g mean_ratio_b";
    for name in all.split_whitespace() {
        assert_eq!(column(&rows, name).len(), 8, "{name}");
    }
    let devices = column(&rows, "device");
    assert_eq!(devices.iter().filter(|d| *d == "cpu").count(), 4, "{devices:?}");
    assert!(devices[4..].iter().all(|d| d == "cpu-reference"), "{devices:?}");
    let (steps, seconds) = (numbers(&rows, "step"), numbers(&rows, "seconds"));
    let errors = numbers(&rows, "rel_mse");
    for (i, step) in steps.iter().enumerate() {
        assert_eq!(*step, [0.2, 0.8][i % 2], "in ascending order");
        assert!(seconds[i] >= *step, "a picture is not older than it says: {} s at {step}", seconds[i]);
    }
    // four times the time: the path tracer's error falls to about a quarter
    assert!(errors[5] < errors[4] && errors[7] < errors[6], "{errors:?}");
    for band in ["r", "g", "b"] {
        let ratios = numbers(&rows, &format!("mean_ratio_{band}"));
        // of the path tracer, which had hundreds of passes; the maps may have had one, with the lamp's edge aliased
        assert!(ratios[4..].iter().all(|r| (r - 1.0).abs() < 0.05), "{ratios:?}");
    }

    let summary = read("b.summary.csv");
    let parts = [numbers(&summary, "rel_bias_squared"), numbers(&summary, "rel_variance")];
    for (i, whole) in numbers(&summary, "rel_mse").into_iter().enumerate() {
        let sum = parts[0][i] + parts[1][i];
        assert!((sum / whole - 1.0).abs() < 1e-3, "bias² + variance is the error: {sum}, {whole}");
    }
    assert_eq!(numbers(&summary, "seeds"), [2.0; 4]);

    let plot = read("b.svg");
    assert!(plot.starts_with("<svg") && plot.trim_end().ends_with("</svg>"));
    for text in ["cornell", "joton, cpu", "path tracer", "CPU seconds", "relMSE"] {
        assert!(plot.contains(text), "the plot says {text}");
    }
    // two devices in two panels: four curves and two points on each
    assert_eq!(plot.matches("<circle").count(), 8);
    assert!(String::from_utf8_lossy(&ended.stdout).lines().count() >= 9, "a table on stdout");
}

/// Without a reference there is still the renderer's own estimate to plot.
#[test]
fn bench_works_without_a_reference() {
    let folder = folder();
    let ended = joton(&folder, "bench cornell.toml --size 16x16 --device cpu --times 0.3,1.2 -o b");
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let rows = fs::read_to_string(folder.path().join("b.csv")).expect("a table");
    assert_eq!(column(&rows, "rel_mse"), ["", ""]);
    let plot = fs::read_to_string(folder.path().join("b.svg")).expect("a plot");
    // a busy machine may not have the four passes of an estimate at the first step
    let estimates = column(&rows, "error_estimate").iter().filter(|c| !c.is_empty()).count();
    assert!(plot.contains("estimated relMSE"));
    assert_eq!(plot.matches("<circle").count(), 2 * estimates, "in two panels");
    assert!(estimates > 0);
}

/// `--cpu-seconds`: a step is reached by processor seconds, of which two threads have two in a second; the plot is over
/// these alone.
#[test]
fn bench_goes_by_processor_seconds() {
    let folder = folder();
    let ended = joton(
        &folder,
        "bench cornell.toml --size 16x16 --device cpu-reference --cpu-seconds --times 0.5,1 -o b",
    );
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let rows = fs::read_to_string(folder.path().join("b.csv")).expect("a table");
    let (steps, seconds) = (numbers(&rows, "step"), numbers(&rows, "cpu_seconds"));
    assert_eq!(steps, [0.5, 1.0]);
    for (step, seconds) in steps.iter().zip(&seconds) {
        // passes are of milliseconds
        assert!((*step..1.5 * step).contains(seconds), "{seconds} CPU s at {step}");
    }
    let plot = fs::read_to_string(folder.path().join("b.svg")).expect("a plot");
    let estimates = column(&rows, "error_estimate").iter().filter(|c| !c.is_empty()).count();
    assert_eq!(plot.matches("<circle").count(), estimates, "in one panel");
    assert_eq!([plot.matches("CPU seconds").count(), plot.matches("seconds").count()], [1, 1]);
}

/// What cannot be measured is refused before anything is rendered.
#[test]
fn bench_refuses_what_it_cannot_measure() {
    let folder = folder();
    let made = joton(&folder, "render cornell.toml --size 8x8 --device cpu --passes 1 --quiet -o r.exr");
    assert!(made.status.success());
    for (words, part) in [
        ("bench cornell.toml --size 16x16 --device cpu --reference r.exr", "--size 8x8"),
        ("bench cornell.toml cornell.toml --device cpu --reference r.exr", "1 references for 2 scenes"),
        ("bench cornell.toml --device cpu --times 0,1", "--times"),
        ("bench cornell.toml --device cpu --times nan", "--times"),
        ("bench cornell.toml --device cpu --seeds 0", "--seeds"),
        ("bench cornell.toml --device cpu -o none/b", "none"),
        ("bench none.toml --device cpu", "none.toml"),
        ("bench cornell.toml --device abacus", "abacus"),
        ("bench", "SCENE"),
    ] {
        let ended = joton(&folder, words);
        let stderr = String::from_utf8_lossy(&ended.stderr);
        assert_eq!(ended.status.code(), Some(2), "joton {words}: {stderr}");
        assert!(stderr.contains(part) && ours(&stderr) == 1, "joton {words}: {stderr}");
        assert!(!folder.path().join("bench.csv").exists());
    }
}

/// Lines of the program itself: a Vulkan loader may add words of its own.
fn ours(stderr: &str) -> usize {
    stderr.lines().filter(|l| l.starts_with("joton: ")).count()
}
