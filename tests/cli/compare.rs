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
        let why = "joton: relMSE ";
        assert_eq!(
            ended.stderr.starts_with(why) && ended.stderr.contains("above the tolerance of 1.0000e-12"),
            code == 1,
            "{}",
            ended.stderr
        );
        assert_eq!(ended.stderr.lines().count(), code as usize);
        assert!(ended.stdout.contains("relMSE") && ended.stdout.contains("mean/ref"), "{}", ended.stdout);
        assert!(fs::read(folder.path("h.png")).expect("a heat map").starts_with(b"\x89PNG"));
        fs::remove_file(folder.path("h.png")).expect("a file");
    }
    assert_eq!(folder.run("compare a.exr b.exr").code, Some(0), "without a tolerance nothing is judged");
    let json = folder.run("compare a.exr b.exr --json --tolerance 1e-12 --regions 2");
    let told: serde_json::Value = serde_json::from_str(&json.stdout).expect("JSON alone");
    assert_eq!((json.code, told["tolerance"].as_f64()), (Some(1), Some(1e-12)));
    assert!(
        told["rel_mse"].as_f64().is_some_and(|e| e > 0.0) && told["region_ratios"][1][1][2].is_f64(),
        "{told}"
    );
    // as many rows as there are regions down, however many are asked for
    let json = folder.run("compare a.exr b.exr --json --regions 100");
    let told: serde_json::Value = serde_json::from_str(&json.stdout).expect("JSON alone");
    let rows = told["region_ratios"].as_array().expect("rows");
    let columns: Vec<usize> = rows.iter().map(|row| row.as_array().map_or(0, Vec::len)).collect();
    assert_eq!(columns, [32; 32]);
    let twins = folder.done("compare a.exr b.exr --twin a.exr");
    assert!(twins.stdout.contains("\nin common "), "{}", twins.stdout);
    let told: serde_json::Value =
        serde_json::from_str(&folder.done("compare a.exr b.exr --twin a.exr --json").stdout).expect("JSON");
    let [common, error] =
        [&told["common"]["rel_mse"], &told["rel_mse"]].map(|e| e.as_f64().expect("a number"));
    assert!(
        (common / error - 1.0).abs() < 1e-9,
        "an image that is its own twin has all of its error in common: {told}"
    );
    folder.done("render cornell.toml --size 16x16 --device cpu --passes 1 -o small.exr");
    folder.fails("compare a.exr small.exr", &["a.exr: has 32x32", "small.exr has 16x16"]);
    folder.fails("compare a.exr b.exr --twin small.exr", &["small.exr: has 16x16", "b.exr has 32x32"]);
    folder.fails("compare a.exr none.exr", &["none.exr"]);
    folder.fails("compare a.exr cornell.obj", &["cornell.obj", "EXR"]);
    folder.fails("compare a.exr b.exr --tolerance nan", &["--tolerance"]);
    folder.fails("compare a.exr b.exr --heatmap none/h.png", &["none/h.png"]);
}
