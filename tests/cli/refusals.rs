//! What is refused: one line, status 2, and no file is touched.

use crate::folder::{Folder, names};
use std::fs;

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
        ("render .", &["joton: .: not a scene format", ".toml"]),
        ("render ..", &["joton: ..: not a scene format"]),
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
