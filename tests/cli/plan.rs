//! `plan`, and `--memory`, which the plan keeps to.

use crate::folder::{Folder, devices, number};
use serde_json::Value;

/// `plan --json` is JSON that tells what is done and what is skipped and why; without --json it is text.
#[test]
fn plan_can_be_read_by_programs() {
    let folder = Folder::new();
    let plan: Value = serde_json::from_str(&folder.done("plan cornell.toml --json").stdout).expect("JSON");
    assert!(number(&plan["triangles"]) > 0.0);
    assert_eq!((number(&plan["shadow_rays"]), number(&plan["warps"])), (2.0, 0.0));
    let skips = plan["skipped"].as_array().expect("a list");
    assert!(skips.iter().any(|s| s["what"] == "caustic map" && s["why"].is_string()), "{plan}");
    let sum = |list: &str, of: &str| -> f64 {
        plan[list].as_array().expect("a list").iter().map(|entry| number(&entry[of])).sum()
    };
    assert!(number(&plan["bytes"]) > 0.0 && number(&plan["bytes"]) == sum("buffers", "bytes"));
    let cost = number(&plan["milliseconds"]);
    assert!(cost > 0.0 && (sum("kernels", "milliseconds") / cost - 1.0).abs() < 1e-9);
    // it needs no device
    for (keep, kernel) in [("", "  indirect "), (" --no-skip diffuse-map", "gather (diffuse)")] {
        let ended = folder.run_without_vulkan(&format!("plan cornell.toml{keep}"));
        assert_eq!((ended.code, ended.stderr.as_str()), (Some(0), ""));
        for part in [kernel, "gather_points", "MiB together"] {
            assert!(ended.stdout.contains(part), "{part}: {}", ended.stdout);
        }
    }
    let text = folder.done("plan cornell.toml").stdout;
    assert!(
        text.contains(
            "skipped caustic map (caustic-map): no surface mirrors or refracts; back with a mirror"
        ),
        "{text}"
    );
    assert!(text.contains("direct light: 2 shadow rays"), "{text}");
}

/// `--memory` is understood or refused with what to write, and the plan keeps to it without a device: strips first, then
/// fewer jotons, and an error with need, limit and remedy where nothing helps. All that the process takes counts.
#[test]
fn memory_is_kept_to() {
    let folder = Folder::new();
    let plan = |memory: &str| -> Value {
        let words = format!("plan ring.toml --json --memory {memory}");
        serde_json::from_str(&folder.done(&words).stdout).expect("JSON")
    };
    let ample = plan("1G");
    let beside: f64 = ["program", "scene", "films"].map(|part| number(&ample["process"][part])).iter().sum();
    // with so many MiB for the buffers
    let with = |mebibytes: f64| plan(&format!("{}K", (beside / 1024.0 + mebibytes * 1024.0).ceil()));
    let (cut, scarce) = (with(14.0), with(5.0));
    assert_eq!(number(&ample["strips"]), 1.0);
    assert!(number(&ample["bytes"]) > 14.0 * 1048576.0 && number(&cut["bytes"]) <= 14.1 * 1048576.0);
    assert!(number(&cut["strips"]) > 1.0 && cut["caustic_jotons"] == ample["caustic_jotons"]);
    assert!(number(&scarce["bytes"]) <= 5.1 * 1048576.0);
    assert!(number(&scarce["caustic_jotons"]) < number(&ample["caustic_jotons"]));
    folder.fails("plan ring.toml --memory 140M", &["bytes", "146800640", "--memory", "--resolve off"]);
    folder.fails("render ring.toml --device cpu --memory 20M", &["bytes", "20971520", "--memory", "--size"]);
    folder.fails("render ring.toml --memory 12", &["--memory", "512M"]);
    // not even the scene is read
    folder.fails("render ring.toml --memory 1M", &["ring.toml", "bytes of memory", "--memory"]);
}

/// What `plan` tells of memory is kept by a render, on each device: the largest that the process ever was is no more than that, and no
/// less than half. The limit of `--memory` is kept to, too.
#[test]
fn memory_that_is_told_is_kept() {
    let folder = Folder::new();
    let read = |path| std::fs::read_to_string(path).expect("a report");
    let told = |options: &str| -> Value {
        let words = format!("plan cornell.toml --size 800x800 --json {options}");
        serde_json::from_str(&folder.done(&words).stdout).expect("JSON")
    };
    let free = told("");
    assert!(
        (number(&free["host_bytes_per_pixel"]) * 640_000.0 / number(&free["host_bytes"]) - 1.0).abs() < 1e-6
    );
    for device in devices() {
        let name = if device == "cpu" { "peak_bytes_on_cpu" } else { "peak_bytes" };
        // two thirds of the buffers
        let most = number(&free["peak_bytes"]) - number(&free["bytes"]) / 3.0;
        let limit = if device == "cpu" { number(&free[name]) } else { most };
        let options = format!("--memory {}K", (limit / 1024.0).ceil());
        let told = if device == "cpu" { free[name].clone() } else { told(&options)[name].clone() };
        folder.done(&format!(
            "render cornell.toml --device {device} --size 800x800 --passes 2 {options} -o a.exr --report a.json --quiet"
        ));
        let report: Value = serde_json::from_str(&read(folder.path("a.json"))).expect("JSON");
        let peak = number(&report["peak_memory_bytes"]);
        // a debug build's own code is larger, by far less
        let own = 64.0 * 1048576.0;
        assert!(peak < number(&told) + own && peak < limit + own, "{device}: {peak} bytes, {told} were told");
        assert!(peak > 0.5 * number(&told), "{device}: {peak} bytes, {told} were told");
    }
}

/// Pictures that do not fit are halved, the largest first, as far as must be, and a warning names them; a render does the same.
/// A picture that nobody can mean is refused by its size before it is decoded.
#[test]
fn pictures_are_made_smaller_to_fit() {
    let folder = Folder::empty();
    for (name, side) in [("big.bmp", 1024), ("small.bmp", 256)] {
        let picture = image::RgbImage::from_fn(side, side, |x, y| image::Rgb([x as u8, y as u8, 90]));
        picture.save(folder.path(name)).expect("a picture");
    }
    let scene = |picture: &str| {
        format!(
            "shape = [\n{{ kind = \"rectangle\", material = {{ kd = {{ texture = \"{picture}\" }} }} }},\n\
             {{ kind = \"cube\", material = {{ kd = {{ texture = \"small.bmp\" }} }} }},\n\
             {{ kind = \"disc\", center = [0, 3, 0], material = {{ ke = 4 }} }},\n]\n"
        )
    };
    std::fs::write(folder.path("s.toml"), scene("big.bmp")).expect("a scene");
    let plan = |options: &str| -> Value {
        let words = format!("plan s.toml --size 16x16 --paths LDE --json {options}");
        serde_json::from_str(&folder.done(&words).stdout).expect("JSON")
    };
    let told = |plan: &Value| -> String {
        let all = plan["warnings"].as_array().expect("a list").iter().filter_map(Value::as_str);
        all.filter(|w| w.contains("textures are made smaller")).collect::<Vec<_>>().join("; ")
    };
    let full = plan("");
    let process: f64 = ["program", "scene", "films"].map(|part| number(&full["process"][part])).iter().sum();
    let need = process + number(&full["bytes"]);
    let less = |kib: f64| plan(&format!("--memory {}K", (need / 1024.0 - kib).ceil()));
    assert_eq!((told(&full), told(&less(-16.0))), (String::new(), String::new()));
    // levels and all, the picture takes 5.3 MiB on the host and on the device: half of its side is 8 MiB less, a quarter 10
    for (kib, to) in [(64.0, "512 × 512"), (7900.0, "512 × 512"), (8300.0, "256 × 256")] {
        let wanted = format!("big.bmp from 1024 × 1024 to {to} texels; allow more (--memory)");
        let words = told(&less(kib));
        assert!(words.contains(&wanted) && !words.contains("small.bmp"), "{kib} KiB less: {words}");
    }
    // what the program and the image take leave no picture but a texel; less is refused with the figure that does
    let words =
        format!("plan s.toml --size 16x16 --paths LDE --memory {}K", (need / 1024.0 - 12288.0).ceil());
    let refused = folder.run(&words);
    refused.is_refusal(&words, &["the render needs", "--memory"]);
    let figure =
        refused.stderr.split_whitespace().find_map(|word| word.parse::<f64>().ok()).expect("a figure");
    let words = told(&plan(&format!("--memory {}K", (figure / 1024.0).ceil())));
    assert!(["big.bmp from 1024", "small.bmp from 256"].iter().all(|name| words.contains(name)), "{words}");
    // reading and packing take five times the picture
    let ended = folder.done("render s.toml --size 16x16 --passes 1 --device cpu --memory 28M -o a.exr");
    assert!(ended.stderr.contains("big.bmp from 1024 × 1024 to 512 × 512 texels"), "{}", ended.stderr);
    // too little for a device is enough for the processor, whose pictures stay as they were
    let ended = folder.done("render s.toml --size 16x16 --passes 1 --memory 120M -o b.exr");
    assert!(!ended.stderr.contains("made smaller"), "{}", ended.stderr);
    // a header and nothing else
    let bomb: Vec<u8> = [
        &b"\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\x01\x86\xa0\0\x01\x86\xa0\x08\x02\0\0\0"[..],
        &0x2730_9c9f_u32.to_be_bytes(),
        b"\0\0\0\0IDAT\x35\xaf\x06\x1e",
    ]
    .concat();
    std::fs::write(folder.path("bomb.png"), bomb).expect("a picture");
    std::fs::write(folder.path("bomb.toml"), scene("bomb.png")).expect("a scene");
    folder.fails("check bomb.toml", &["bomb.toml:2", "bomb.png", "100000 × 100000 texels", "16384"]);
}
