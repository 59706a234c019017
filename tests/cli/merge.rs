//! Parts of a render: put together they are the render of all their passes.

use crate::folder::{Folder, QUICK, bits, devices};
use std::fs;

/// Parts in any order have the bits and the counts of a render of all their passes, on every device; of a scene whose lamp is seen through glass, where
/// paths are split by what the first passes saw. One part was stopped twice, also before its first pass.
#[test]
fn parts_make_the_whole() {
    let folder = Folder::new();
    for device in devices() {
        let render = format!("render spheres.toml --size 24x24 --seed 3 --device {device}");
        folder.done(&format!(
            "{render} --pass-range 0..70 --checkpoint whole.joton -o whole.exr --report whole.json"
        ));
        for (range, part) in [("0..16", "a"), ("16..48", "b"), ("48..70", "c")] {
            folder.done(&format!("{render} --pass-range {range} --checkpoint {part}.joton"));
        }
        folder.done("merge b.joton c.joton a.joton -o merged.exr -o merged.png --report merged.json");
        assert!(bits(&folder, "merged.exr") == bits(&folder, "whole.exr"), "{device}");
        let [merged, whole] = ["merged.json", "whole.json"].map(|name| folder.report(name));
        for key in ["passes", "rays", "jotons_stored", "truncated", "device"] {
            assert_eq!(merged[key], whole[key], "{device}: {key}");
        }
        let ratio =
            merged["error_estimate"].as_f64().zip(whole["error_estimate"].as_f64()).map(|(m, w)| m / w);
        assert!(ratio.is_some_and(|ratio| (0.5..2.0).contains(&ratio)), "{device}: {ratio:?}");
        // parts of parts
        folder.done("merge c.joton b.joton --checkpoint bc.joton");
        folder.done("merge bc.joton a.joton -o merged.exr --checkpoint abc.joton");
        assert!(bits(&folder, "merged.exr") == bits(&folder, "whole.exr"), "{device}");
        folder.done("merge abc.joton -o again.exr");
        assert!(bits(&folder, "again.exr") == bits(&folder, "whole.exr"), "{device}");
        // one part alone is a picture, too, where it begins with the first pass
        folder.done("merge a.joton -o first.exr");
        for part in ["whole", "a", "b", "c", "bc", "abc"] {
            fs::remove_file(folder.path(&format!("{part}.joton"))).expect("a file");
        }
    }
}

/// By wavelength passes have wavelengths by their numbers in the whole render: parts, and a render that ends and goes on, have the bits of
/// one that never ended, on every device.
#[test]
fn parts_by_wavelength_make_the_whole() {
    let folder = Folder::new();
    for device in devices() {
        let render = format!("render ring.toml --size 24x24 --seed 3 --spectral on --device {device}");
        folder.done(&format!("{render} --passes 20 -o whole.exr"));
        folder.done(&format!("{render} --passes 6 -o part.exr --checkpoint r.joton"));
        folder.done("resume r.joton --passes 20 -o part.exr");
        assert!(bits(&folder, "part.exr") == bits(&folder, "whole.exr"), "{device}");
        folder.done(&format!("{render} --pass-range 0..20 --checkpoint whole.joton -o whole.exr"));
        for (range, part) in [("0..16", "a"), ("16..20", "b")] {
            folder.done(&format!("{render} --pass-range {range} --checkpoint {part}.joton"));
        }
        folder.done("merge b.joton a.joton -o merged.exr");
        assert!(bits(&folder, "merged.exr") == bits(&folder, "whole.exr"), "{device}");
        for part in ["whole", "a", "b", "r"] {
            fs::remove_file(folder.path(&format!("{part}.joton"))).expect("a file");
        }
    }
}

/// A part that was killed, before its first pass, too, goes on to the same bits.
#[cfg(unix)]
#[test]
fn a_killed_part_goes_on() {
    let folder = Folder::new();
    let render = "render spheres.toml --size 24x24 --device cpu";
    folder.done(&format!("{render} --pass-range 0..48 --checkpoint whole.joton -o whole.exr"));
    folder.done(&format!("{render} --pass-range 0..32 --checkpoint a.joton"));
    let render = format!("{render} --pass-range 32..48 --checkpoint b.joton --every 1e-9");
    let kills = folder.done_though_killed(&render, "b.joton");
    folder.done("merge b.joton a.joton -o merged.exr");
    assert!(bits(&folder, "merged.exr") == bits(&folder, "whole.exr"), "after {kills} kills");
}

/// What does not belong together is refused by name, and nothing is written.
#[test]
fn what_does_not_fit_is_refused() {
    let folder = Folder::new();
    let part = |range: &str, more: &str, name: &str| {
        folder.done(&format!("{QUICK} --pass-range {range} {more} --checkpoint {name}.joton"));
    };
    part("0..16", "", "a");
    part("16..32", "", "b");
    part("32..33", "", "c");
    part("16..18", "--seed 1", "seed");
    part("16..18", "--resolve off", "resolve");
    folder.done(&format!("{QUICK} --passes 2 --checkpoint no-part.joton"));
    folder.done("render cornell.toml --size 16x16 --device cpu --pass-range 16..18 --checkpoint size.joton");
    folder.done("render ring.toml --size 32x32 --device cpu --pass-range 16..18 --checkpoint scene.joton");
    for (parts, told) in [
        ("a.joton c.joton", &["passes 16..32 are in no part", "--pass-range 16..32"][..]),
        ("b.joton c.joton", &["passes 0..16 are in no part"]),
        ("a.joton b.joton a.joton", &["a.joton (passes 0..16)", "passes in common"]),
        ("a.joton seed.joton", &["a.joton and seed.joton differ in --seed"]),
        ("a.joton resolve.joton", &["differ in --resolve"]),
        ("a.joton size.joton", &["differ in --size"]),
        ("a.joton scene.joton", &["differ in the scene"]),
        ("a.joton no-part.joton", &["no-part.joton: is no part of a render", "--pass-range"]),
        ("a.joton none.joton", &["none.joton"]),
        ("a.joton cornell.obj", &["cornell.obj: is no checkpoint"]),
    ] {
        folder.fails(&format!("merge {parts} -o x.exr"), told);
    }
    folder.fails("merge a.joton", &["--output"]);
    folder.fails("merge b.joton -o x.exr", &["passes 0..16 are in no part"]);
    folder.fails("merge a.joton b.joton --checkpoint a.joton", &["a.joton"]);
    folder.fails("merge a.joton -o x.jpg", &["x.jpg"]);
    folder.fails("merge a.joton -o a.joton", &["a.joton"]);
    folder.fails("merge a.joton -o cornell.toml", &["cornell.toml"]);
    folder.fails(&format!("{QUICK} --pass-range 0..16"), &["--checkpoint"]);
    folder.fails(&format!("{QUICK} --pass-range 10..16 --checkpoint x.joton"), &["multiple of 16"]);
    folder.fails(&format!("{QUICK} --pass-range 0..16 --passes 3 --checkpoint x.joton"), &["--passes"]);
    folder.fails("resume b.joton --passes 40", &["b.joton: has the passes 16..32", "leave out --passes"]);
    // damage behind the header
    let bytes = fs::read(folder.path("b.joton")).expect("a part");
    fs::write(folder.path("b.joton"), &bytes[..bytes.len() - 100]).expect("cut");
    folder.fails("merge a.joton b.joton -o x.exr", &["b.joton: is damaged"]);
    // another scene under the same name; elsewhere the right one
    let mtl = fs::read_to_string(folder.path("cornell.mtl")).expect("a library");
    fs::create_dir(folder.path("old")).expect("a folder");
    for file in ["cornell.toml", "cornell.obj", "cornell.mtl"] {
        fs::copy(folder.path(file), folder.path("old").join(file)).expect("a copy");
    }
    fs::write(folder.path("cornell.mtl"), mtl + "\n").expect("changed");
    folder.fails("merge a.joton -o x.exr", &["a.joton: the scene has changed since", "--scene"]);
    assert!(!folder.path("x.exr").exists());
    folder.done("merge a.joton -o x.exr --scene old/cornell.toml");
}
