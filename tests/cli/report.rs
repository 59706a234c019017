//! The report in JSON.

use crate::folder::{Folder, QUICK, number};

/// The report holds what the contract names, and its numbers agree with each other and with what was asked.
#[test]
fn report_is_complete_and_consistent() {
    let folder = Folder::new();
    let ended = folder.done(&format!("{RING} --passes 24 --no-skip diffuse-map -o a.exr --report r.json"));
    assert_eq!(ended.stdout, "");
    let r = folder.report("r.json");
    assert!(ended.stderr.contains(r["device"].as_str().expect("a device")), "{}", ended.stderr);
    assert_eq!(r["passes"], 24);
    for key in [
        "seconds",
        "setup_seconds",
        "cpu_seconds",
        "rays",
        "jotons_emitted",
        "jotons_stored",
        "error_estimate",
    ] {
        assert!(number(&r[key]) > 0.0, "{key} is {}", r[key]);
    }
    if cfg!(target_os = "linux") {
        assert!(number(&r["peak_memory_bytes"]) > 1e6);
    }
    assert!(number(&r["jotons_emitted"]) >= 24.0, "at least one joton a pass");
    assert!(number(&r["rays"]) >= 24.0 * 32.0 * 32.0, "at least a ray for each pixel and pass");
    for skip in r["skipped"].as_array().expect("a list") {
        assert!(skip["what"].is_string() && skip["why"].is_string(), "{skip}");
    }
    let [first, last] = [0, 1].map(|i| number(&r["radius"]["diffuse"][i]));
    assert!(0.0 < last && last < first, "the radius shrinks: {first}, {last}");
    let flux = |key: &str| -> f64 { (0..3).map(|b| number(&r["energy"][key][b])).sum() };
    let (emitted, absorbed, escaped) = (flux("emitted"), flux("absorbed"), flux("escaped"));
    // the roulette is fair on average only: five standard errors of its own spread
    let allowed = 5.0 * number(&r["energy"]["standard_error"]) * emitted;
    assert!(emitted > 0.0 && absorbed > 0.0 && escaped > 0.0, "an open scene loses light: {}", r["energy"]);
    assert!((emitted - absorbed - escaped).abs() <= allowed.max(1e-6 * emitted), "{}", r["energy"]);
    assert!(allowed < 0.2 * emitted, "the balance means something");
}

const RING: &str = "render ring.toml --size 32x32 --device cpu";

/// Jotons of the diffuse map tell where light goes. Without them nothing is known of it: no flux, no balance, no radius.
#[test]
fn report_without_a_diffuse_map_tells_no_balance() {
    let folder = Folder::new();
    folder.done(&format!("{RING} --passes 4 -o a.exr --report r.json"));
    let r = folder.report("r.json");
    let skips = r["skipped"].as_array().expect("a list");
    assert!(skips.iter().any(|s| s["name"] == "diffuse-map" && s["reason"] == "paths-serve"), "{r}");
    for key in ["emitted", "absorbed", "escaped"] {
        assert_eq!(r["energy"][key], serde_json::json!([0.0, 0.0, 0.0]), "{key}");
    }
    for key in ["imbalance", "standard_error"] {
        assert!(r["energy"][key].is_null(), "{key}: {}", r["energy"]);
    }
    assert!(r["radius"]["diffuse"].is_null() && r["radius"]["caustic"].is_array(), "{}", r["radius"]);
    assert!(number(&r["jotons_emitted"]) > 0.0 && number(&r["error_estimate"]) > 0.0, "{r}");
}

/// A report is also written where no error can be estimated; what is not known is null, and no key is missing.
#[test]
fn report_of_one_pass_has_every_key() {
    let folder = Folder::new();
    folder.done(&format!("{QUICK} --passes 1 -o a.exr --report r.json"));
    let r = folder.report("r.json");
    let keys = "device passes seconds setup_seconds cpu_seconds rays jotons_emitted jotons_stored energy skipped \
                radius peak_memory_bytes error_estimate host setup";
    for key in keys.split_whitespace() {
        assert!(r.get(key).is_some(), "no {key}");
    }
    // all that takes time is named
    let sum = |of: &serde_json::Value| of.as_object().map_or(0.0, |o| o.values().map(number).sum::<f64>());
    for (parts, whole) in [("host", "seconds"), ("setup", "setup_seconds")] {
        let (parts, whole) = (sum(&r[parts]), number(&r[whole]));
        assert!(parts <= whole && parts > 0.95 * whole - 0.005, "{parts} s of {whole} s: {r}");
    }
    for key in ["emitted", "absorbed", "escaped"] {
        assert_eq!(r["energy"][key].as_array().map(Vec::len), Some(3), "{key}");
    }
    assert_eq!(r["passes"], 1);
}
