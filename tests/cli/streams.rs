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

/// Help and version are answers: stdout, status 0.
#[test]
fn help_goes_to_stdout() {
    let folder = Folder::new();
    for words in ["--help", "--version", "render --help", "help compare"] {
        let ended = folder.done(words);
        assert!(!ended.stdout.is_empty() && ended.stderr.is_empty(), "joton {words}");
    }
}
