//! Files that are written: their place, their permissions, and what is left when writing is broken off.

use crate::folder::{Folder, QUICK, names};
use std::fs;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// A file that is replaced keeps its permissions, so that what few may read stays so.
#[cfg(unix)]
#[test]
fn permissions_are_kept() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    let outputs = ["a.exr", "a.png", "r.json"];
    for (output, mode) in outputs.iter().zip([0o600, 0o640, 0o666]) {
        fs::write(folder.path(output), "old").expect("a file");
        fs::set_permissions(folder.path(output), fs::Permissions::from_mode(mode)).expect("permissions");
    }
    folder.done(&format!("{QUICK} --passes 1 -o a.exr -o a.png --report r.json"));
    for (output, mode) in outputs.iter().zip([0o600, 0o640, 0o666]) {
        let meta = fs::metadata(folder.path(output)).expect("a file");
        assert_eq!(meta.permissions().mode() & 0o777, mode, "{output}");
        assert!(meta.len() > 3, "{output} is new");
    }
}

/// A link is followed, over several steps and where nothing is at its end yet: the link stays, the file at its end is written.
#[cfg(unix)]
#[test]
fn links_are_followed_to_their_end() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    fs::create_dir(folder.path("sub")).expect("a folder");
    fs::write(folder.path("sub/old.exr"), "old").expect("a file");
    for (link, target) in [
        ("old.exr", "sub/old.exr"),
        ("new.exr", "sub/new.exr"),
        ("far.png", "sub/near.png"),
        ("sub/near.png", "end.png"),
        ("lost.exr", "none/lost.exr"),
        ("round.exr", "round.exr"),
    ] {
        symlink(target, folder.path(link)).expect("a link");
    }
    folder.done(&format!("{QUICK} --passes 1 -o old.exr -o new.exr -o far.png"));
    for link in ["old.exr", "new.exr", "far.png", "sub/near.png"] {
        assert!(folder.path(link).is_symlink(), "{link}");
    }
    for file in ["sub/old.exr", "sub/new.exr"] {
        assert!(!folder.path(file).is_symlink());
        assert_eq!(folder.image(file).width, 32, "{file}");
    }
    assert!(folder.path("sub/end.png").is_file());
    folder.fails(&format!("{QUICK} --passes 1 -o new.exr -o sub/new.exr"), &["sub/new.exr", "twice"]);
    folder.fails(&format!("{QUICK} --passes 1 -o lost.exr"), &["lost.exr", "none", "create it"]);
    folder.fails(&format!("{QUICK} --passes 1 -o round.exr"), &["round.exr"]);
}

/// Where one file of an export cannot be written, all others are as they were.
#[test]
fn an_export_replaces_all_files_or_none() {
    let folder = Folder::new();
    folder.done("export cornell.toml -o box.xml");
    let files: Vec<String> = names(&folder).into_iter().filter(|n| n.starts_with("box.")).collect();
    assert!(files.len() > 3, "{files:?}");
    let (last, others) = files.split_last().expect("files");
    assert_eq!(last, "box.xml");
    for name in others {
        fs::write(folder.path(name), "precious").expect("a file");
    }
    // the last mesh
    let blocked = &others[others.len() - 1];
    fs::remove_file(folder.path(blocked)).expect("removed");
    fs::create_dir(folder.path(blocked)).expect("a folder");
    let scene = fs::read(folder.path("box.xml")).expect("a scene");
    folder.fails("export cornell.toml -o box.xml --size 20x20", &[blocked, "folder"]);
    for name in &others[..others.len() - 1] {
        assert_eq!(fs::read(folder.path(name)).expect("a file"), b"precious", "{name}");
    }
    assert_eq!(fs::read(folder.path("box.xml")).expect("a scene"), scene);
    assert!(names(&folder).iter().all(|n| !n.ends_with(".part")));
}

/// A second Ctrl-C while files are written ends the program at once, and leaves nothing half-written.
#[cfg(unix)]
#[test]
fn a_second_interrupt_leaves_nothing_half_written() {
    let folder = Folder::new();
    fs::write(folder.path("a.exr"), "precious").expect("a file");
    let words = "render cornell.toml --size 1500x1500 --device cpu --paths LE --time 600 -o a.exr";
    let mut child = folder.command(words).stderr(Stdio::piped()).spawn().expect("joton runs");
    let mut stderr = child.stderr.take().expect("a pipe");
    // the line that names the device comes last before rendering
    std::io::Read::read_exact(&mut stderr, &mut [0]).expect("a line");
    std::thread::sleep(Duration::from_millis(300));
    let interrupt = || {
        let id = child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    };
    let is_part = |name: &String| name.ends_with(".part");
    assert!(!names(&folder).iter().any(is_part), "nothing is written while it renders");
    interrupt();
    let begin = Instant::now();
    while !names(&folder).iter().any(is_part) {
        assert!(begin.elapsed() < Duration::from_secs(120), "it writes");
        std::thread::sleep(Duration::from_millis(2));
    }
    interrupt();
    assert_eq!(child.wait().expect("joton ends").code(), Some(130));
    assert!(!names(&folder).iter().any(is_part), "{:?}", names(&folder));
    assert_eq!(
        fs::read(folder.path("a.exr")).expect("a file"),
        b"precious",
        "it was interrupted while it wrote"
    );
}

/// What a killed process left half written is gone after the next run.
#[cfg(target_os = "linux")]
#[test]
fn what_was_left_half_written_is_removed() {
    let folder = Folder::new();
    let mut dead = Command::new("true").spawn().expect("a process");
    dead.wait().expect("it ends");
    let left = format!(".a.exr.joton-{}-3.part", dead.id());
    fs::write(folder.path(&left), "half").expect("a file");
    folder.done(&format!("{QUICK} --passes 1 -o b.exr"));
    assert!(!folder.path(&left).exists());
}
