//! `compare`.

use crate::folder::{Folder, QUICK};
use std::fs;

/// `compare` exits with 0 within the tolerance and 1 beyond it, tells the errors on stdout, and draws the heat map.
#[test]
fn compare_judges() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 2 -o a.exr"));
    folder.done(&format!("{QUICK} --passes 2 --seed 1 -o b.exr"));
    let same = folder.done("compare a.exr a.exr --tolerance 0");
    assert!(same.stdout.contains("relMSE 0"), "{}", same.stdout);
    for (tolerance, code) in [("1000", 0), ("1e-12", 1)] {
        let ended = folder.run(&format!("compare a.exr b.exr --tolerance {tolerance} --heatmap h.png"));
        assert_eq!(ended.code, Some(code), "{}{}", ended.stdout, ended.stderr);
        assert!(ended.stdout.contains("relMSE") && ended.stdout.contains("mean/ref"), "{}", ended.stdout);
        assert!(fs::read(folder.path("h.png")).expect("a heat map").starts_with(b"\x89PNG"));
        fs::remove_file(folder.path("h.png")).expect("a file");
    }
    assert_eq!(folder.run("compare a.exr b.exr").code, Some(0), "without a tolerance nothing is judged");
    folder.done("render cornell.toml --size 16x16 --device cpu --passes 1 -o small.exr");
    folder.fails("compare a.exr small.exr", &["32x32", "16x16"]);
    folder.fails("compare a.exr none.exr", &["none.exr"]);
    folder.fails("compare a.exr cornell.obj", &["cornell.obj", "EXR"]);
    folder.fails("compare a.exr b.exr --tolerance nan", &["--tolerance"]);
    folder.fails("compare a.exr b.exr --heatmap none/h.png", &["none/h.png"]);
}
