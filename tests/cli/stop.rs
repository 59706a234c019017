//! When a render stops.

use crate::folder::{Folder, QUICK, number};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Seconds after which a program that should have ended counts as hung.
const HUNG: f64 = 120.0;

/// --time ends when it was asked to, the picture made; it does not count set-up.
#[test]
fn time_is_kept() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --time 1.5 -o a.exr --report r.json"));
    let r = folder.report("r.json");
    let seconds = number(&r["seconds"]);
    assert!((1.2..1.8).contains(&seconds), "{seconds} s");
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

/// A signal that was ignored when the program started, as `nohup` does and shells do for what runs in the background, stays
/// ignored: the render goes on to its end.
#[cfg(unix)]
#[test]
fn ignored_signals_stay_ignored() {
    let folder = Folder::new();
    let render = folder.command(&format!("{QUICK} --time 1.5 -o a.exr --report r.json"));
    let words: Vec<_> = render.get_args().map(|word| word.to_string_lossy().into_owned()).collect();
    let program = render.get_program().to_string_lossy().into_owned();
    for signal in ["HUP", "INT"] {
        let mut shell = Command::new("sh");
        shell.args(["-c", &format!("trap '' {signal}; exec {program} {}", words.join(" "))]);
        let mut child = shell.current_dir(folder.path("")).stderr(Stdio::piped()).spawn().expect("a shell");
        let mut stderr = child.stderr.take().expect("a pipe");
        std::io::Read::read_exact(&mut stderr, &mut [0]).expect("a line");
        std::thread::sleep(Duration::from_millis(500));
        let sent = Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(sent.expect("kill runs").success());
        assert_eq!(child.wait().expect("joton ends").code(), Some(0), "{signal}");
        assert_eq!(folder.report("r.json")["stopped_by"], "time", "{signal}");
    }
}

/// A hang-up that nobody ignores ends a render like Ctrl-C, and everything so far is saved.
#[cfg(unix)]
#[test]
fn a_hang_up_saves() {
    let folder = Folder::new();
    let words = format!("{QUICK} --time {HUNG} -o a.exr --report r.json");
    let mut child = folder.command(&words).stderr(Stdio::piped()).spawn().expect("joton runs");
    let mut stderr = child.stderr.take().expect("a pipe");
    std::io::Read::read_exact(&mut stderr, &mut [0]).expect("a line");
    std::thread::sleep(Duration::from_millis(500));
    assert!(
        Command::new("kill").args(["-HUP", &child.id().to_string()]).status().expect("kill runs").success()
    );
    assert_eq!(child.wait().expect("joton ends").code(), Some(130));
    assert_eq!(folder.report("r.json")["stopped_by"], "interrupted");
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
