//! stdout and stderr: what is said where, and to whom.

use crate::folder::{Folder, QUICK};
use serde_json::Value;
use std::process::Stdio;

/// --quiet says nothing at all, and without a terminal there is no progress bar.
#[test]
fn stderr_is_calm() {
    let folder = Folder::new();
    let quiet = folder.done(&format!("{QUICK} --passes 2 --quiet -o a.exr"));
    assert_eq!((quiet.stdout, quiet.stderr), (String::new(), String::new()));
    let plain = folder.done(&format!("{QUICK} --time 0.7 -o a.exr"));
    assert_eq!(plain.stdout, "");
    assert_eq!(plain.stderr.lines().count(), 3, "the device, the end and the file: {}", plain.stderr);
    assert_eq!(plain.stderr.lines().last(), Some("joton: wrote a.exr"));
    assert!(!plain.stderr.contains(['\r', '\x1b']), "{:?}", plain.stderr);
}

/// Other programs read what goes on: each line of --progress json is an object, and the last ones tell how it ended.
#[test]
fn progress_is_told_to_programs() {
    let folder = Folder::new();
    let ended = folder.done(&format!("{QUICK} --time 1.5 -o a.exr -o a.png --progress json"));
    let events: Vec<Value> =
        ended.stderr.lines().map(|line| serde_json::from_str(line).expect("an object a line")).collect();
    let of = |name: &str| -> Vec<&Value> { events.iter().filter(|e| e["event"] == name).collect() };
    let steps: Vec<&str> = of("step").iter().filter_map(|e| e["what"].as_str()).collect();
    assert_eq!(steps, ["reading the scene", "building the hierarchy", "planning", "preparing the device"]);
    let progress = of("progress");
    assert!(!progress.is_empty(), "{}", ended.stderr);
    let passes: Vec<u64> = progress.iter().filter_map(|e| e["passes"].as_u64()).collect();
    assert!(passes.len() == progress.len() && passes.is_sorted(), "{passes:?}");
    assert!(progress.iter().all(|e| e["done"].as_f64().is_some_and(|d| (0.0..=1.0).contains(&d))));
    assert_eq!(
        (&of("done")[0]["reason"], of("done")[0]["passes"].as_u64() >= passes.last().copied()),
        (&"time".into(), true)
    );
    assert_eq!(events.last().map(|e| e["files"].clone()), Some(serde_json::json!(["a.exr", "a.png"])));
}

/// A log has a line every five seconds; one pass is one pass.
#[test]
fn logs_have_a_line_now_and_then() {
    let folder = Folder::new();
    let ended = folder.done(&format!("{QUICK} --time 6 -o a.exr"));
    let lines: Vec<&str> = ended.stderr.lines().filter(|line| line.ends_with(" left")).collect();
    assert_eq!(lines.len(), 1, "{}", ended.stderr);
    assert!(lines[0].contains(" passes, ") && lines[0].contains(" s, "), "{}", lines[0]);
    let ended = folder.done(&format!("{QUICK} --passes 1 -o a.exr"));
    assert!(ended.stderr.contains("joton: 1 pass in "), "{}", ended.stderr);
}

/// The report goes to stdout where it is asked for, and nothing else does.
#[test]
fn the_report_can_go_to_stdout() {
    let folder = Folder::new();
    let ended = folder.done(&format!("{QUICK} --passes 2 -o a.exr --report -"));
    let report: Value = serde_json::from_str(&ended.stdout).expect("JSON alone");
    assert_eq!(report["passes"], 2);
    assert!(!folder.path("-").exists());
}

/// So many threads work as --threads says, before or after the command's name.
#[test]
fn threads_are_as_many_as_asked_for() {
    let folder = Folder::new();
    for words in [format!("--threads 3 {QUICK}"), format!("{QUICK} --threads 3")] {
        let ended = folder.done(&format!("{words} --passes 1 -o a.exr"));
        assert!(ended.stderr.contains("CPU, 3 threads"), "{}", ended.stderr);
    }
    folder.fails(&format!("{QUICK} --threads 0"), &["--threads", "1"]);
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

/// What stdout does not take is an error in one line, whichever the command; files are written all the same.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disc_is_told() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 1 -o a.exr"));
    let bench = "bench cornell.toml --size 16x16 --device cpu --times 0.01";
    for words in [
        "plan cornell.toml",
        "plan cornell.toml --json",
        "devices",
        "--help",
        "compare a.exr a.exr --heatmap h.png",
        bench,
    ] {
        let full = std::fs::OpenOptions::new().write(true).open("/dev/full").expect("a device");
        let output = folder.command(words).stdout(full).output().expect("joton runs");
        let told = String::from_utf8(output.stderr).expect("UTF-8");
        // bench tells its devices, too
        let last = told.lines().last().unwrap_or_default();
        assert!(
            last.contains("stdout: cannot write") && last.contains("No space left"),
            "joton {words}: {told}"
        );
        assert_eq!(output.status.code(), Some(2), "joton {words}: {told}");
    }
    for file in ["h.png", "bench.csv", "bench.svg"] {
        assert!(folder.path(file).exists(), "{file}");
    }
}

/// A machine without windows hears nothing of them: libwayland does not complain, since no layer asks it.
#[cfg(target_os = "linux")]
#[test]
fn nothing_is_said_of_windows() {
    let folder = Folder::new();
    for words in ["devices", "render cornell.toml --size 32x32 --passes 1 --quiet -o a.exr"] {
        let mut command = folder.command(words);
        for name in ["XDG_RUNTIME_DIR", "WAYLAND_DISPLAY", "DISPLAY", "NODEVICE_SELECT"] {
            command.env_remove(name);
        }
        let ended = crate::folder::Ended::of(command.output().expect("joton runs"));
        assert_eq!((ended.code, ended.stderr), (Some(0), String::new()), "joton {words}");
    }
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
