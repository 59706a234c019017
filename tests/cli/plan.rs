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
