//! `plan`, and `--memory`, which the plan keeps to.

use crate::folder::{Folder, number};
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
/// fewer jotons, and an error with need, limit and remedy where nothing helps.
#[test]
fn memory_is_kept_to() {
    let folder = Folder::new();
    let plan = |memory: &str| -> Value {
        let words = format!("plan ring.toml --json --memory {memory}");
        serde_json::from_str(&folder.done(&words).stdout).expect("JSON")
    };
    let (ample, cut, scarce) = (plan("1G"), plan("14M"), plan("5M"));
    assert_eq!(number(&ample["strips"]), 1.0);
    assert!(number(&ample["bytes"]) > 14.0 * 1048576.0 && number(&cut["bytes"]) <= 14.0 * 1048576.0);
    assert!(number(&cut["strips"]) > 1.0 && cut["caustic_jotons"] == ample["caustic_jotons"]);
    assert!(number(&scarce["bytes"]) <= 5.0 * 1048576.0);
    assert!(number(&scarce["caustic_jotons"]) < number(&ample["caustic_jotons"]));
    folder.fails("plan ring.toml --memory 100K", &["bytes", "102400", "--memory"]);
    folder.fails("render ring.toml --memory 12", &["--memory", "512M"]);
}

/// What `plan` tells of memory is kept by a render, on the device's side and the host's: the largest that it ever was lies below
/// what is told and what a render of a few pixels takes for driver and program.
#[test]
fn memory_that_is_told_is_kept() {
    let folder = Folder::new();
    let read = |path| std::fs::read_to_string(path).expect("a report");
    let peak = |size: &str| {
        folder.done(&format!(
            "render cornell.toml --size {size} --passes 1 --memory 48M -o a.exr --report a.json --quiet"
        ));
        let report: Value = serde_json::from_str(&read(folder.path("a.json"))).expect("JSON");
        number(&report["peak_memory_bytes"])
    };
    let plan: Value =
        serde_json::from_str(&folder.done("plan cornell.toml --size 800x800 --json --memory 48M").stdout)
            .expect("JSON");
    assert!(number(&plan["strips"]) > 1.0 && number(&plan["bytes"]) <= 48.0 * 1048576.0);
    let told = number(&plan["bytes"]) + number(&plan["host_bytes"]);
    assert!(
        (number(&plan["host_bytes_per_pixel"]) * 640_000.0 / number(&plan["host_bytes"]) - 1.0).abs() < 1e-6
    );
    let (small, large) = (peak("8x8"), peak("800x800"));
    assert!(large < small + told, "{large} bytes, {told} were told, {small} without");
}
