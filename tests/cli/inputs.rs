//! What is read: no output is written over it, and what is no file with an end is refused.

use crate::folder::{Folder, QUICK, names};
use std::fs;

/// No output of any command is written over a file that it reads: by its name, another spelling, a link or a hard link.
#[cfg(unix)]
#[test]
fn what_is_read_is_never_written_over() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 1 -o a.exr"));
    fs::copy(folder.path("a.exr"), folder.path("b.exr")).expect("a copy");
    for (link, file) in [
        ("mesh.exr", "cornell.obj"),
        ("library.json", "cornell.mtl"),
        ("scene.xml", "cornell.toml"),
        ("plot.csv", "cornell.mtl"),
        ("plot2.summary.csv", "a.exr"),
        ("mesh.0.ply", "cornell.obj"),
        ("map.png", "b.exr"),
    ] {
        fs::hard_link(folder.path(file), folder.path(link)).expect("a hard link");
    }
    for (link, file) in [("link.exr", "cornell.obj"), ("link.xml", "cornell.mtl")] {
        std::os::unix::fs::symlink(file, folder.path(link)).expect("a link");
    }
    fs::create_dir(folder.path("sub")).expect("a folder");
    let before: Vec<_> = names(&folder).into_iter().filter(|n| n != "sub").collect();
    let contents = |folder: &Folder| -> Vec<Vec<u8>> {
        before.iter().map(|name| fs::read(folder.path(name)).expect("a file")).collect()
    };
    let precious = contents(&folder);
    let bench = "bench cornell.toml --device cpu --times 0.01 --size 32x32";
    for (words, culprit) in [
        (format!("{QUICK} --passes 1 -o c.exr --report cornell.obj"), "cornell.obj"),
        (format!("{QUICK} --passes 1 -o c.exr --report sub/../cornell.mtl"), "cornell.mtl"),
        (format!("{QUICK} --passes 1 -o c.exr --report cornell.toml"), "cornell.toml"),
        (format!("{QUICK} --passes 1 -o mesh.exr"), "mesh.exr"),
        (format!("{QUICK} --passes 1 -o link.exr"), "link.exr"),
        (format!("{QUICK} --passes 1 -o c.exr --report library.json"), "library.json"),
        ("render cornell.obj --size 32x32 --passes 1 -o c.exr --report cornell.mtl".into(), "cornell.mtl"),
        ("export cornell.toml -o scene.xml".into(), "scene.xml"),
        ("export cornell.toml -o link.xml".into(), "link.xml"),
        ("export cornell.toml -o mesh.xml".into(), "mesh.0.ply"),
        ("compare a.exr b.exr --heatmap map.png".into(), "map.png"),
        ("compare a.exr b.exr --heatmap ./a.exr".into(), "a.exr"),
        ("compare b.exr b.exr --twin a.exr --heatmap a.exr".into(), "a.exr"),
        (format!("{bench} -o plot"), "plot.csv"),
        (format!("{bench} --reference a.exr -o plot2"), "plot2.summary.csv"),
    ] {
        folder.fails(&words, &[culprit, "written over"]);
    }
    assert_eq!(contents(&folder), precious);
    assert!(!folder.path("c.exr").exists());
}

/// A scene, mesh, library, picture or checkpoint that is a directory, a device or a pipe is refused before it is opened, which a pipe would
/// never return from; a file of 5 GiB before it is read.
#[cfg(unix)]
#[test]
fn what_has_no_end_is_refused() {
    use std::os::unix::fs::symlink;
    let folder = Folder::new();
    let pipe = |name: &str| {
        let made = std::process::Command::new("mkfifo").arg(folder.path(name)).status();
        assert!(made.expect("mkfifo runs").success());
    };
    for name in ["pipe.toml", "pipe.obj", "pipe.exr", "pipe.joton"] {
        pipe(name);
    }
    for name in ["zero.toml", "zero.obj", "zero.exr", "zero.joton"] {
        symlink("/dev/zero", folder.path(name)).expect("a link");
    }
    for name in ["dir.toml", "dir.obj", "dir.exr", "dir.joton"] {
        fs::create_dir(folder.path(name)).expect("a folder");
    }
    let huge = fs::File::create(folder.path("huge.obj")).expect("a file");
    huge.set_len(5 << 30).expect("a file with a hole");
    for mesh in ["pipe", "zero", "dir", "huge"] {
        let scene = format!("[[mesh]]\nfile = \"{mesh}.obj\"\n");
        fs::write(folder.path(&format!("of-{mesh}.toml")), scene).expect("a scene");
    }
    folder.done(&format!("{QUICK} --passes 1 -o a.exr"));
    for (kind, what) in [("pipe", "device or pipe"), ("zero", "device or pipe"), ("dir", "directory")] {
        for words in ["plan K.toml", "render K.obj -o c.png", "export K.toml -o c.xml", "plan of-K.toml"] {
            folder.fails_in_time(&words.replace('K', kind), &[&format!("{kind}."), what]);
        }
        for words in ["compare K.exr a.exr", "compare a.exr K.exr", "bench cornell.toml --reference K.exr"] {
            folder.fails_in_time(&words.replace('K', kind), &[&format!("{kind}.exr"), what]);
        }
    }
    for kind in ["pipe", "zero", "dir"] {
        for words in ["resume K.joton", "merge K.joton -o c.png"] {
            let what = if kind == "dir" { "directory" } else { "device or pipe" };
            folder.fails_in_time(&words.replace('K', kind), &[&format!("{kind}.joton"), what]);
        }
    }
    folder.fails_in_time("plan huge.obj", &["huge.obj", "5368709120 bytes", "4294967296"]);
    folder.fails_in_time("plan of-huge.toml", &["huge.obj", "5368709120 bytes", "4294967296"]);
}

/// A library that is a pipe is not found, as a warning tells; nobody waits for it.
#[cfg(unix)]
#[test]
fn a_library_that_is_a_pipe_is_not_waited_for() {
    let folder = Folder::new();
    fs::remove_file(folder.path("cornell.mtl")).expect("removed");
    let made = std::process::Command::new("mkfifo").arg(folder.path("cornell.mtl")).status();
    assert!(made.expect("mkfifo runs").success());
    let ended = folder.ends("plan cornell.obj");
    assert!(ended.stdout.contains("cornell.mtl"), "{}{}", ended.stdout, ended.stderr);
}

/// What does not fit the memory that the process may have is refused in one line: an image, a mesh, a shape.
#[cfg(target_os = "linux")]
#[test]
fn too_little_memory_is_one_line() {
    let folder = Folder::new();
    let huge = fs::File::create(folder.path("huge.obj")).expect("a file");
    huge.set_len(1 << 30).expect("a file with a hole");
    // 70 bytes that stand for five million triangles
    let sphere = "[[shape]]\nkind = \"sphere\"\ntolerance = 4e-6\n";
    fs::write(folder.path("fine.toml"), sphere).expect("a scene");
    for (kib, words, parts) in [
        (
            2_000_000,
            "render cornell.toml --size 6000x6000 --device cpu -o c.png",
            &["the film needs", "--size"][..],
        ),
        (2_000_000, "plan huge.obj", &["huge.obj", "bytes of memory"]),
        (500_000, "check fine.toml --threads 1", &["fine.toml:1", "5242880 triangles", "tolerance"]),
    ] {
        let mut shell = folder.command("");
        let (program, path) = (shell.get_program().to_owned(), folder.path(""));
        shell = std::process::Command::new("sh");
        let program = program.to_string_lossy().into_owned();
        shell.args(["-c", &format!("ulimit -v {kib}; exec {program} {words}")]).current_dir(path);
        crate::folder::Ended::of(shell.output().expect("a shell")).is_refusal(words, parts);
    }
}

/// `check` reads a scene as a render does, tells its warnings, and fails with --strict where there are any; a fault is a refusal.
#[test]
fn scenes_are_checked() {
    let folder = Folder::new();
    let calm = folder.done("check cornell.toml --strict");
    assert!(calm.stdout.contains("38 triangles") && !calm.stdout.contains("warning"), "{}", calm.stdout);
    let toml = "[[shape]]\nkind = \"cube\"\nmaterial = { kd = 0.7, ks = 0.7 }\n[[light]]\nkind = \"sun\"\n\
                direction = [0, -1, 0]\nirradiance = 1\n";
    std::fs::write(folder.path("bright.toml"), toml).expect("a scene");
    let warned = folder.done("check bright.toml");
    assert!(
        warned.stdout.contains("warning: ") && warned.stdout.contains("scaled down"),
        "{}",
        warned.stdout
    );
    let strict = folder.run("check bright.toml --strict --json");
    let told: serde_json::Value = serde_json::from_str(&strict.stdout).expect("JSON alone");
    assert_eq!(
        (strict.code, told["warnings"].as_array().map(Vec::len), &told["triangles"]),
        (Some(1), Some(1), &12.into())
    );
    assert!(strict.stderr.contains("--strict"), "{}", strict.stderr);
    folder.fails("check none.toml", &["none.toml"]);
}
