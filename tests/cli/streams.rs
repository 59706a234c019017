//! stdout and stderr: what is said where, and to whom.

use crate::folder::{Folder, QUICK};
use std::process::Stdio;

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
