//! `joton bench --versus` with a script in place of Python: what it is told, what becomes of its lines, and what is said
//! where it fails.
#![cfg(unix)]

use joton::film::Image;
use joton::output::{compare::compare, exr};
use serde_json::Value;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Width and height of the pictures.
const SIZE: [u32; 2] = [12, 8];
/// What the script's pictures are times the reference.
const BRIGHTER: f32 = 1.25;
/// A script's first words; `$2` is the job, `$folder` its folder.
const HELLO: &str = "echo '{\"kind\": \"renderer\", \"name\": \"Fake 1.0\", \"note\": \"a note\"}'\n\
                     [ -z \"$2\" ] && exit 0\nfolder=$(dirname \"$2\")\n";

/// A folder with scenes, a reference, and a raw picture.
struct Folder(TempDir);

struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        for name in ["cornell", "spheres"] {
            for kind in ["toml", "obj", "mtl"] {
                let file = format!("{name}.{kind}");
                fs::copy(scenes.join(&file), folder.path(&file)).expect("a copy of the scene");
            }
        }
        let reference = folder.reference();
        exr::write_image(&folder.path("r.exr"), &reference, "").expect("a reference");
        let values = reference.pixels.as_flattened().iter();
        let bytes: Vec<u8> = values.flat_map(|x| (x * BRIGHTER).to_le_bytes()).collect();
        fs::write(folder.path("picture.raw"), bytes).expect("a picture");
        folder
    }

    /// A picture that differs from its mirror images.
    fn reference(&self) -> Image {
        let mut image = Image::new(SIZE[0], SIZE[1]);
        for (i, value) in image.pixels.as_flattened_mut().iter_mut().enumerate() {
            *value = 0.1 + 0.01 * i as f32;
        }
        image
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Bench with a script that is run instead of Python.
    fn bench(&self, script: &str, words: &str) -> Ended {
        // copied by a process that forks nothing: a file that anyone holds open for writing cannot be run
        let (text, python) = (self.path("script"), self.path("python"));
        fs::write(&text, format!("#!/bin/sh\n{script}")).expect("a script");
        assert!(Command::new("cp").args([&text, &python]).status().expect("cp runs").success());
        fs::set_permissions(&python, fs::Permissions::from_mode(0o755)).expect("may be run");
        self.joton(&format!(
            "bench --device cpu --size {}x{} --python ./python -o b {words}",
            SIZE[0], SIZE[1]
        ))
    }

    fn joton(&self, words: &str) -> Ended {
        let mut command = Command::new(env!("CARGO_BIN_EXE_joton"));
        command.args(words.split_whitespace()).current_dir(self.0.path());
        command.env("XDG_RUNTIME_DIR", self.0.path()).env("TMPDIR", self.0.path());
        let output = command.output().expect("joton runs");
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ended { code: output.status.code(), stdout: text(&output.stdout), stderr: text(&output.stderr) }
    }

    fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }
}

/// A line of a script that hands over the picture.
fn picture(folder: &Folder, seed: u32, step: usize, cpu_seconds: f64) -> String {
    let raw = folder.path("picture.raw");
    format!(
        "cp {} \"$folder/p.raw\"\necho '{{\"kind\": \"picture\", \"seed\": {seed}, \"step\": {step}, \"seconds\": 0.5, \
         \"cpu_seconds\": {cpu_seconds}, \"samples\": 64, \"file\": \"p.raw\"}}'\n\
         while [ -e \"$folder/p.raw\" ]; do sleep 0.01; done\n",
        raw.display()
    )
}

const DONE: &str = "echo '{\"kind\": \"done\"}'\n";

/// Cells of the lines of a CSV whose second cell is `device`. No cell here holds a comma but the name of a device.
fn rows(csv: &str, device: &str) -> Vec<Vec<String>> {
    let cells = |line: &str| -> Vec<String> {
        let parts = line.split('"').enumerate();
        let plain: String =
            parts.map(|(i, p)| if i % 2 == 0 { p.into() } else { p.replace(',', ";") }).collect();
        plain.split(',').map(String::from).collect()
    };
    csv.lines().map(cells).filter(|c| c.get(1).is_some_and(|d| d == device)).collect()
}

fn number(cell: &str) -> f64 {
    cell.parse().unwrap_or_else(|_| panic!("{cell:?} is no number"))
}

/// Two seeds and two steps of each algorithm that fits: rows beside joton's, with the numbers that the script said, the
/// error that `compare` finds, summaries, curves; and the job holds all that a driver needs.
#[test]
fn other_renderers_stand_beside_the_devices() {
    let folder = Folder::new();
    let kept = folder.path("kept");
    fs::create_dir(&kept).expect("a folder");
    let mut script =
        format!("{HELLO}cp \"$1\" \"$folder\"/*.py \"$folder\"/scene0* \"$2\" {}\n", kept.display());
    for seed in 0..2 {
        script += &picture(&folder, seed, 0, 0.75);
        script += &picture(&folder, seed, 1, 1.5);
    }
    let ended = folder
        .bench(&(script + DONE), "cornell.toml --reference r.exr --times 0.2,0.1 --seeds 2 --versus mitsuba");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    assert!(ended.stderr.contains("Fake 1.0: a note"), "{}", ended.stderr);

    let csv = folder.read("b.csv");
    assert_eq!(rows(&csv, "cpu").len(), 4, "{csv}");
    let mut brighter = folder.reference();
    brighter.pixels.as_flattened_mut().iter_mut().for_each(|x| *x *= BRIGHTER);
    let wanted = compare(&brighter, &folder.reference()).expect("one size");
    for mode in ["path", "ptracer"] {
        let found = rows(&csv, &format!("mitsuba-{mode}"));
        assert_eq!(found.len(), 4, "{csv}");
        for (i, row) in found.iter().enumerate() {
            let [
                scene,
                _,
                name,
                seed,
                step,
                seconds,
                cpu_seconds,
                passes,
                rays,
                jotons,
                rays_per_second,
                jotons_per_second,
                device_bytes,
                estimate,
                error,
                trimmed,
                ratios @ ..,
            ] = &row[..]
            else {
                panic!("{row:?}");
            };
            assert_eq!((scene.as_str(), name), ("cornell", &format!("Fake 1.0; {mode}")));
            assert_eq!((number(seed), number(step)), ((i / 2) as f64, [0.1, 0.2][i % 2]));
            assert_eq!((number(seconds), number(cpu_seconds)), (0.5, [0.75, 1.5][i % 2]));
            assert_eq!(passes, "64");
            let untold = [rays, jotons, rays_per_second, jotons_per_second, device_bytes, estimate];
            assert_eq!(untold, [""; 6], "what it does not tell");
            // the digits that the table holds
            let close = |cell: &str, value: f64| (number(cell) / value - 1.0).abs() < 1e-6;
            assert!(close(error, wanted.rel_mse) && close(trimmed, wanted.rel_mse_trimmed), "{row:?}");
            assert!(ratios.iter().all(|r| close(r, f64::from(BRIGHTER))) && ratios.len() == 3, "{row:?}");
        }
    }
    let summary = folder.read("b.summary.csv");
    assert_eq!(rows(&summary, "mitsuba-path").len(), 2);
    // cpu and two algorithms in two panels, two steps each
    let plot = folder.read("b.svg");
    assert!(plot.contains("mitsuba-path") && plot.contains("mitsuba-ptracer"));
    assert_eq!(plot.matches("<circle").count(), 3 * 2 * 2);
    assert_eq!(
        ended.stdout.matches("mitsuba-ptracer").count(),
        5,
        "four rows and a line on the parts: {}",
        ended.stdout
    );

    let job: Value = serde_json::from_str(&folder.read("kept/job.json")).expect("JSON");
    assert_eq!([&job["width"], &job["height"], &job["seeds"]], [12, 8, 2]);
    assert_eq!(job["mode"], "ptracer", "the last one");
    assert_eq!(job["times"], serde_json::json!([0.1, 0.2]));
    assert!(job["extent"].as_f64().is_some_and(|e| e > 0.5 && e < 0.6), "metres: {job}");
    let scene = folder.read("kept/scene0.xml");
    assert!(scene.contains("name=\"width\" value=\"12\""), "the size of the bench: {scene}");
    assert!(kept.join("scene0.0.ply").is_file(), "its meshes beside it");
    let driver = folder.read("kept/drive_mitsuba.py");
    assert!(driver.contains("import driving") && kept.join("driving.py").is_file());
    let left = fs::read_dir(folder.0.path()).expect("a folder").flatten();
    let left: Vec<String> = left.map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    assert!(!left.iter().any(|n| n.starts_with("joton-versus-")), "nothing stays behind: {left:?}");
}

/// A scene with glass has other algorithms; one that is named runs alone.
#[test]
fn algorithms_follow_the_scene() {
    let folder = Folder::new();
    let script = format!("{HELLO}{}{DONE}", picture(&folder, 0, 0, 1.0));
    let ended = folder.bench(&script, "spheres.toml --times 0.1 --versus luxcore,mitsuba-path,mitsuba");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let csv = folder.read("b.csv");
    let devices: Vec<String> =
        csv.lines().skip(1).map(|l| l.split(',').nth(1).unwrap_or_default().to_string()).collect();
    assert_eq!(devices, ["cpu", "luxcore-photongi", "luxcore-bidirvm", "mitsuba-path"]);
}

/// A denoised renderer is one of its own: its driver with what it shares, the job's algorithm, and one more where
/// surfaces mirror or refract.
#[test]
fn a_denoised_renderer_stands_beside_the_plain_one() {
    let folder = Folder::new();
    let kept = folder.path("kept");
    fs::create_dir(&kept).expect("a folder");
    let script = format!(
        "{HELLO}cp \"$folder\"/*.py {kept}\necho \"$1\" >> {kept}/started\ncp \"$2\" {kept}\n{}{DONE}",
        picture(&folder, 0, 0, 1.0),
        kept = kept.display()
    );
    let words = "cornell.toml spheres.toml --times 0.1 --versus mitsuba-path,mitsuba+oidn,mitsuba+oidn-path";
    let ended = folder.bench(&script, words);
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let csv = folder.read("b.csv");
    for (device, scenes) in [
        ("mitsuba-path", &["cornell", "spheres"][..]),
        ("mitsuba+oidn-path", &["cornell", "spheres"]),
        ("mitsuba+oidn-path-colour", &["spheres"]),
    ] {
        let found = rows(&csv, device);
        assert_eq!(found.iter().map(|r| &r[0]).collect::<Vec<_>>(), scenes, "{device}: {csv}");
    }
    let started = folder.read("kept/started");
    let started: Vec<&str> = started.lines().filter_map(|l| l.rsplit('/').next()).collect();
    let [plain, denoised] = ["drive_mitsuba.py", "drive_mitsuba_oidn.py"];
    assert_eq!(started, [plain, denoised, plain, denoised, denoised], "one start for each algorithm");
    let job: Value = serde_json::from_str(&folder.read("kept/job.json")).expect("JSON");
    assert_eq!(job["mode"], "path-colour", "the last one");
    for file in [plain, denoised, "driving.py", "driving_mitsuba.py"] {
        assert!(kept.join(file).is_file(), "{file}");
    }
}

/// Before anything renders: what is not installed, not known, or not to be compared.
#[test]
fn what_cannot_run_is_told_first() {
    let folder = Folder::new();
    fs::write(folder.path("spot.toml"), folder.read("cornell.toml") + SOFT_SPOT).expect("a scene");
    let fine = format!("{HELLO}{DONE}");
    let missing = "echo '{\"kind\": \"missing\", \"module\": \"pyluxcore\"}'\n";
    for (script, words, part) in [
        (
            "echo '{\"kind\": \"missing\", \"module\": \"pyoidn\"}'\n",
            "cornell.toml --versus mitsuba+oidn",
            "./python has no package pyoidn; run: ./python -m pip install mitsuba pyoidn",
        ),
        (
            missing,
            "cornell.toml --versus luxcore",
            "./python has no package pyluxcore; run: ./python -m pip install pyluxcore",
        ),
        (&fine, "cornell.toml --versus blender", "mitsuba-ptracer, mitsuba+oidn, mitsuba+oidn-path"),
        (&fine, "cornell.toml --versus mitsuba-paths", "--versus mitsuba-paths: not a renderer"),
        (
            &fine,
            "cornell.toml --versus mitsuba+oidn-ptracer",
            "--versus mitsuba+oidn-ptracer: not a renderer",
        ),
        (&fine, "spheres.toml --versus mitsuba-ptracer", "misses what spheres.toml shows"),
        (&fine, "spot.toml --versus mitsuba", "the soft edge of a spot"),
        (&fine, "cornell.toml --versus mitsuba --paths LDE", "--paths"),
        ("", "cornell.toml --versus mitsuba", "ended before its work was done"),
        ("echo oh >&2; kill -9 $$", "cornell.toml --versus mitsuba", "(signal: 9 (SIGKILL)): oh"),
        ("echo Python 2.7", "cornell.toml --versus mitsuba", "is not understood"),
        (DONE, "cornell.toml --versus mitsuba", "comes first"),
    ] {
        let ended = folder.bench(script, &format!("{words} --times 0.1"));
        assert_eq!(ended.code, Some(2), "{words}: {}", ended.stderr);
        assert!(ended.stderr.contains(part), "{words}: {}", ended.stderr);
        assert!(!folder.path("b.csv").exists() && ended.stdout.is_empty(), "{words}: nothing was rendered");
    }
    let ended = folder.joton("bench cornell.toml --device cpu --versus mitsuba --python ./none");
    assert!(ended.code == Some(2) && ended.stderr.contains("./none cannot be run"), "{}", ended.stderr);
    let ended = folder.joton("bench cornell.toml --device cpu --python ./python");
    assert!(ended.code == Some(2) && ended.stderr.contains("--versus"), "{}", ended.stderr);
}

const SOFT_SPOT: &str = "\n[[light]]\nkind = \"spot\"\nposition = [0.2, 0.5, 0.2]\ndirection = [0, -1, 0]\nintensity = 1\n\
                         angle_inner = 20\nangle_outer = 30\n";

/// A renderer that fails on the way: its words, exit status 2, and what was measured before is kept.
#[test]
fn what_fails_on_the_way_is_told_and_the_rest_kept() {
    let folder = Folder::new();
    let good = picture(&folder, 0, 0, 1.0);
    for (rest, part) in [
        ("echo '{\"kind\": \"failed\", \"what\": \"no memory\"}'\n".to_string(), "mitsuba: no memory"),
        ("exit 3\n".into(), "exit status: 3"),
        (good.replace("\"step\": 0", "\"step\": 1"), "step 1 of seed 0 was not asked for"),
        (good.replace("\"seed\": 0", "\"seed\": 1"), "step 0 of seed 1 was not asked for"),
        (good.replace("\"file\": \"p.raw\"", "\"file\": \"q.raw\""), "q.raw: cannot read"),
        (
            good.replace("cp ", "head -c 99 ").replace(" \"$folder/p.raw\"\n", " > \"$folder/p.raw\"\n"),
            "99 bytes",
        ),
    ] {
        fs::remove_file(folder.path("b.csv")).ok();
        let ended = folder.bench(&format!("{HELLO}{rest}"), "cornell.toml --times 0.1 --versus mitsuba-path");
        assert_eq!(ended.code, Some(2), "{rest}: {}", ended.stderr);
        assert!(ended.stderr.contains(part), "{rest}: {}", ended.stderr);
        assert_eq!(rows(&folder.read("b.csv"), "cpu").len(), 1, "{rest}");
    }
}
