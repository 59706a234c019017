//! Checkpoints: a render that was stopped, or killed, goes on to the picture that it would have been.

use crate::folder::{Folder, QUICK, bits, devices};
use std::fs;
use std::process::Stdio;
use std::time::Duration;

/// Passes of the whole render.
const PASSES: u64 = 40;

/// A render that ends early and goes on has the bits, the error and the counts of one that never ended, on every device; and goes on
/// once more.
#[test]
fn a_render_goes_on_to_the_same_bits() {
    let folder = Folder::new();
    for device in devices() {
        let render = format!("render ring.toml --size 24x24 --seed 3 --device {device}");
        folder.done(&format!("{render} --passes 20 -o whole.exr --report whole.json"));
        folder.done(&format!("{render} --passes 6 -o part.exr --checkpoint c.joton"));
        folder.done("resume c.joton --passes 11 -o part.exr");
        let ended = folder.done("resume c.joton --passes 20 -o part.exr --report part.json");
        assert!(ended.stderr.contains("wrote c.joton, part.exr"), "{}", ended.stderr);
        assert!(bits(&folder, "part.exr") == bits(&folder, "whole.exr"), "{device}");
        let [part, whole] = ["part.json", "whole.json"].map(|name| folder.report(name));
        for key in ["passes", "error_estimate", "rays", "jotons_stored", "energy_error"] {
            assert_eq!(part[key], whole[key], "{device}: {key}");
        }
        // without a word it goes on as it was told, and is there already
        assert!(folder.done("resume c.joton -o same.exr").stderr.contains("20 passes in "));
        assert!(bits(&folder, "same.exr") == bits(&folder, "whole.exr"), "{device}");
        fs::remove_file(folder.path("c.joton")).expect("a file");
    }
}

/// Ctrl-C leaves a checkpoint and says how to go on.
#[cfg(unix)]
#[test]
fn an_interrupted_render_goes_on() {
    let folder = Folder::new();
    let words = format!("{QUICK} --time 600 -o a.exr --checkpoint c.joton");
    let child = folder.command(&words).stderr(Stdio::piped()).spawn().expect("joton runs");
    std::thread::sleep(Duration::from_millis(1500));
    let sent = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(sent.expect("kill runs").success());
    let ended = child.wait_with_output().expect("joton ends");
    let told = String::from_utf8(ended.stderr).expect("UTF-8");
    assert_eq!(ended.status.code(), Some(130), "{told}");
    assert_eq!(told.lines().last(), Some("joton: go on by: joton resume c.joton"), "{told}");
    let before: u64 = told
        .lines()
        .find_map(|line| line.strip_prefix("joton: ")?.split_once(" passes in ")?.0.parse().ok())
        .expect("how many passes");
    folder.done(&format!("resume c.joton --passes {} -o a.exr", before + 3));
    folder.done(&format!("{QUICK} --passes {} -o whole.exr", before + 3));
    assert!(bits(&folder, "a.exr") == bits(&folder, "whole.exr"));
}

/// Killed again and again, while it writes, too, a render comes to the same picture.
#[cfg(unix)]
#[test]
fn a_killed_render_goes_on() {
    let folder = Folder::new();
    let render = format!("render ring.toml --size 32x32 --device cpu --passes {PASSES} -o a.exr");
    folder.done(&format!("{render} -o whole.exr"));
    let whole = bits(&folder, "whole.exr");
    fs::remove_file(folder.path("a.exr")).expect("a file");
    let render = format!("{render} --checkpoint c.joton --every 1e-9");
    let kills = folder.done_though_killed(&render, "c.joton");
    assert!(bits(&folder, "a.exr") == whole, "after {kills} kills");
}

/// What does not belong together is refused by name.
#[test]
fn what_cannot_go_on_is_refused() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 2 -o a.exr --checkpoint c.joton"));
    let again = format!("{QUICK} --passes 2 -o a.exr --checkpoint c.joton");
    folder.fails(&again, &["c.joton: there is a checkpoint already", "joton resume c.joton"]);
    folder.fails("resume none.joton", &["none.joton"]);
    folder.fails("resume cornell.obj", &["cornell.obj: is no checkpoint"]);
    folder.fails(&format!("{QUICK} --passes 2 --checkpoint cornell.obj"), &["cornell.obj"]);
    folder.fails(&format!("{QUICK} --every 5"), &["--checkpoint"]);
    folder.fails("resume c.joton --passes 0", &["--passes 0"]);
    let mtl = fs::read_to_string(folder.path("cornell.mtl")).expect("a library");
    fs::write(folder.path("cornell.mtl"), mtl + "\n").expect("changed");
    folder.fails("resume c.joton --passes 4", &["cornell.mtl has changed since"]);
    let bytes = fs::read(folder.path("c.joton")).expect("a checkpoint");
    fs::write(folder.path("c.joton"), &bytes[..bytes.len() - 100]).expect("cut");
    folder.fails("resume c.joton", &["c.joton: is damaged"]);
}
