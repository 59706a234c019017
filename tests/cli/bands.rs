//! `--bands`: a file for who measures.

use crate::folder::{Folder, devices, names, number};
use exr::prelude::{FlatSamples, read_all_flat_layers_from_file};
use std::fs;
use std::path::Path;

/// A name and values.
type Channel = (String, Vec<f32>);

/// Channels of a file by name, as the reader of another library has them, and what the file says of its spectra.
fn channels(path: &Path) -> (Vec<Channel>, [Option<String>; 2]) {
    let image = read_all_flat_layers_from_file(path).expect("an EXR");
    let layer = &image.layer_data[0];
    let value = |channel: &exr::prelude::AnyChannel<FlatSamples>| match &channel.sample_data {
        FlatSamples::F32(values) => (channel.name.to_string(), values.clone()),
        other => panic!("{} is no float32: {other:?}", channel.name),
    };
    let said = |name: &str| {
        let all = image.attributes.other.iter().chain(&layer.attributes.other);
        all.filter(|(key, _)| **key == *name).find_map(|(_, value)| match value {
            exr::prelude::AttributeValue::Text(text) => Some(text.to_string()),
            _ => None,
        })
    };
    let all = layer.channel_data.list.iter().map(value).collect();
    (all, [said("spectralLayoutVersion"), said("emissiveUnits")])
}

/// Bands have names that other programs know, a file of them is the file without them else, bands are the same whatever the
/// order of the list is, and the report tells of each render.
#[test]
fn bands_stand_beside_the_picture() {
    let folder = Folder::new();
    for device in devices() {
        let render = format!("render cornell.toml --size 16x16 --passes 2 --device {device}");
        folder.done(&format!("{render} --spectral on -o plain.exr -o plain.png"));
        folder.done(&format!("{render} --bands 600,450,650.25,550 -o a.exr -o a.png --report r.json"));
        folder.done(&format!("{render} --bands 650.25,600,550,450 -o b.exr"));
        let bytes = |name: &str| fs::read(folder.path(name)).expect("a file");
        assert!(bytes("a.exr") == bytes("b.exr"), "{device}: the order of the list");
        assert!(bytes("a.png") == bytes("plain.png"), "{device}");
        let [(all, said), (plain, unsaid)] = ["a.exr", "plain.exr"].map(|name| channels(&folder.path(name)));
        let units = "W.m^-2.sr^-1.nm^-1";
        assert_eq!((said, unsaid), ([Some("1.0".into()), Some(units.into())], [None, None]));
        let (bands, colours): (Vec<_>, Vec<_>) =
            all.into_iter().partition(|(name, _)| name.starts_with("S0."));
        assert!(colours == plain, "{device}: the rest is what it is without bands");
        let told: Vec<&str> = bands.iter().map(|(name, _)| name.as_str()).collect();
        let named = ["S0.450,000000nm", "S0.550,000000nm", "S0.600,000000nm", "S0.650,250000nm"];
        assert_eq!(told, named);
        // the lamp is reddish, and weak at the far end
        let means: Vec<f32> = bands.iter().map(|(_, values)| values.iter().sum()).collect();
        assert!(means[0] > 0.0 && means[..3].is_sorted() && means[3] > means[0], "{means:?}");
        let report = folder.report("r.json");
        let renders = report["bands"].as_array().expect("a list");
        let wavelengths: Vec<_> = renders.iter().map(|r| r["wavelengths"].to_string()).collect();
        assert_eq!(wavelengths, ["[450.0,550.0,600.0]", "[650.25]"]);
        assert!(renders.iter().all(|r| r["passes"] == 2 && number(&r["rays"]) > 0.0), "{report}");
    }
}

/// All renders together keep to the time, and each to the error.
#[test]
fn renders_of_bands_share_the_limits() {
    let folder = Folder::new();
    let render = "render cornell.toml --size 16x16 --device cpu --bands 4 -o a.exr --report r.json";
    folder.done(&format!("{render} --time 0.9"));
    let report = folder.report("r.json");
    let seconds = |report: &serde_json::Value| -> Vec<f64> {
        let renders = report["bands"].as_array().expect("a list").iter();
        renders.map(|r| number(&r["seconds"])).chain([number(&report["seconds"])]).collect()
    };
    let found = seconds(&report);
    assert!((0.6..1.2).contains(&found.iter().sum::<f64>()) && found.len() == 3, "{found:?}");
    folder.done(&format!("{render} --error 0.5"));
    let report = folder.report("r.json");
    for render in report["bands"].as_array().expect("a list") {
        assert!(render["stopped_by"] == "error" && number(&render["error_estimate"]) <= 0.5, "{render}");
    }
}

/// What goes with no bands is refused in a line, with what to do, and `plan` tells what they take.
#[test]
fn what_does_not_go_with_bands_is_refused() {
    let folder = Folder::new();
    let files = names(&folder);
    for (words, parts) in [
        ("--checkpoint c.joton -o a.exr", &["--bands", "--checkpoint"][..]),
        ("--checkpoint c.joton --pass-range 0..16", &["--bands", "--pass-range", "one run"]),
        ("--spectral off -o a.exr", &["--spectral"]),
        ("-o a.png", &[".exr"]),
    ] {
        folder.fails(&format!("render cornell.toml --device cpu --bands 3 {words}"), parts);
    }
    for (list, part) in [("900", "360 to 830"), ("500,500", "once"), ("0", "1 to 301"), ("red", "450,550")] {
        folder.fails(&format!("render cornell.toml --device cpu --bands {list} -o a.exr"), &[part]);
    }
    folder.fails("slurm cornell.toml --tasks 2 --passes 32 -- --bands 3", &["--bands", "--pass-range"]);
    assert_eq!(names(&folder), files, "nothing is left behind");

    let films = |words: &str| -> f64 {
        let plan = folder.done(&format!("plan cornell.toml --size 100x100 --json {words}")).stdout;
        number(&serde_json::from_str::<serde_json::Value>(&plan).expect("JSON")["process"]["films"])
    };
    assert_eq!(films("--bands 31") - films("--bands 30"), 40_000.0, "four bytes a pixel");
    assert!(films("--bands 1") > films(""));
    let told = folder.done("plan cornell.toml --bands 31").stdout;
    assert!(told.contains("31 bands from 400 to 700 nm, in 11 renders more"), "{told}");
}

/// Light in lines has no radiance per nm: it is black in bands, and that is said.
#[test]
fn lines_are_in_no_band() {
    let folder = Folder::new();
    let scene = fs::read_to_string(folder.path("cornell.toml")).expect("a scene");
    let lamp =
        "[[light]]\nkind = \"point\"\nposition = [0.278, 0.3, 0.2]\nintensity = { lamp = \"sodium\" }\n";
    fs::write(folder.path("sodium.toml"), format!("{scene}\n{lamp}")).expect("a scene");
    let ended = folder.done("render sodium.toml --size 8x8 --passes 1 --device cpu --bands 589 -o a.exr");
    assert!(ended.stderr.contains("lines has no radiance per nm"), "{}", ended.stderr);
}
