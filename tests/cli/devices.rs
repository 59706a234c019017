//! Devices: which there are, which is taken, and that they agree.

use crate::folder::{Folder, without_gpu};
use joton::output::compare::compare;

/// The device is chosen by name; a name that no device has is refused with those that there are.
#[test]
fn unknown_device_lists_the_known_ones() {
    let folder = Folder::new();
    let words = "render cornell.toml --size 8x8 --passes 1 --device abacus -o a.exr";
    folder.fails(words, &["abacus", "choose one of", "cpu"]);
    folder.run_without_vulkan(words).is_refusal(words, &["abacus", "choose one of", "cpu"]);
    assert!(!folder.path("a.exr").exists());
}

/// Without Vulkan `auto` renders on the CPU, says so in one line, and succeeds; `gpu` fails and says what to install.
#[cfg(target_os = "linux")]
#[test]
fn auto_falls_back_to_the_cpu() {
    let folder = Folder::new();
    let ended =
        folder.run_without_vulkan("render cornell.toml --size 32x32 --passes 2 -o a.exr --report r.json");
    assert_eq!(ended.code, Some(0), "{}", ended.stderr);
    let said = ended.stderr.lines().filter(|l| l.contains("CPU") && l.contains("no Vulkan")).count();
    assert_eq!(said, 1, "{}", ended.stderr);
    assert!(folder.report("r.json")["device"].as_str().is_some_and(|d| d.starts_with("CPU")));
    let words = "render cornell.toml --size 32x32 --passes 2 -o b.exr --device gpu";
    folder.run_without_vulkan(words).is_refusal(words, &["no Vulkan", "--device cpu"]);
    let devices = folder.run_without_vulkan("devices");
    assert!(devices.stdout.lines().any(|l| l.starts_with("cpu") && l.contains("auto")), "{}", devices.stdout);
}

/// The GPU's picture is the CPU's: means within 5 %, which noise of 16 passes at this size does not exceed.
#[test]
fn gpu_renders_what_the_cpu_renders() {
    if without_gpu() {
        return;
    }
    let folder = Folder::new();
    let words = "render cornell.toml --size 32x32 --passes 16";
    let ended = folder.run(&format!("{words} --device gpu -o gpu.exr"));
    assert_eq!(ended.code, Some(0), "no device? Set JOTON_TEST_NO_GPU=1 to leave this out. {}", ended.stderr);
    folder.done(&format!("{words} --device cpu -o cpu.exr"));
    let c = compare(&folder.image("gpu.exr"), &folder.image("cpu.exr")).expect("a comparison");
    assert!(c.mean_ratio.iter().all(|r| (r - 1.0).abs() < 0.05), "{c:?}");
}

/// `devices` lists at least the processor, and says of exactly one device that auto picks it.
#[test]
fn devices_are_listed() {
    let folder = Folder::new();
    let text = folder.done("devices").stdout;
    assert!(text.lines().any(|l| l.starts_with("cpu")), "{text}");
    assert_eq!(text.matches("auto").count(), 1, "{text}");
    let told: serde_json::Value = serde_json::from_str(&folder.done("devices --json").stdout).expect("JSON");
    let devices = told.as_array().expect("a list");
    assert_eq!(devices.iter().filter(|d| d["is_auto"] == true).count(), 1, "{told}");
    assert!(devices.last().is_some_and(|d| d["name"] == "cpu" && d["threads"].as_u64() > Some(0)), "{told}");
}
