//! Soak: a long render on the device takes no more memory than a short one, and its passes no longer.
//!
//! A test binary of its own, with this one test: what other tests allocate would count, too.

mod common;

use joton::backend::Backend;
use joton::backend::gpu::{Context, GpuBackend};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Settings};
use std::path::Path;
use std::sync::Arc;

/// Passes after which nothing may grow, and until which; also how many are looked at together.
const WARM: usize = 100;
const LAST: usize = 1000;
/// Part by which memory may grow.
const GROWTH: f64 = 0.02;
/// Factor by which passes may get slower; the machine has other things to do.
const SLOWER: f64 = 1.5;
/// Bytes for the buffers: an eighth may be area points, which are then as many in the first passes as in the last.
const MEMORY: u64 = 8 << 20;
/// Jotons of a map in a pass: few, so that many passes are quick.
const JOTONS: u32 = 512;

/// Resident bytes of this process, where the system tells.
fn resident() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/statm").ok()?;
    let pages: f64 = text.split_whitespace().nth(1)?.parse().ok()?;
    Some(pages * 4096.0)
}

/// A thousand passes with every kernel that there is, diffuse light by paths and by its map: what the process holds beside the buffers that the backend tells of
/// stays the same to 2 % after the first 100, and the second half takes no longer than the first. A kernel that Mesa's
/// software device compiles at each dispatch adds a megabyte a pass. New area points lie about for a while: the least that
/// is held in a hundred passes counts.
#[test]
fn long_renders_take_no_more_memory() {
    device_or_return!();
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/pool.toml");
    let mut scene = joton::scene::load(&file).unwrap_or_else(|e| panic!("{e}"));
    scene.resize([32, 32]);
    let scene = Arc::new(PackedScene::new(&scene));
    for keep in [vec![], vec![Part::DiffuseMap]] {
        soak(&scene, Settings { memory: Some(MEMORY), keep, ..Settings::default() });
    }
}

fn soak(scene: &Arc<PackedScene>, settings: Settings) {
    let mut plan = Plan::new(scene, settings);
    for jotons in [&mut plan.caustic_jotons, &mut plan.diffuse_jotons] {
        *jotons = (*jotons).min(JOTONS);
    }
    let context = Context::open(None).unwrap_or_else(|e| panic!("{e}"));
    let mut backend = GpuBackend::new(context, Arc::clone(scene), plan).unwrap_or_else(|e| panic!("{e}"));
    let (mut held, mut seconds) = (Vec::new(), Vec::new());
    for pass in 0..LAST as u64 {
        let begin = cpu_time::ProcessTime::now();
        backend.render(pass, 1).unwrap_or_else(|e| panic!("{e}"));
        seconds.push(begin.elapsed().as_secs_f64());
        held.push(resident().map(|bytes| bytes - backend.device_bytes().unwrap_or(0) as f64));
    }
    let least = |part: &[Option<f64>]| part.iter().flatten().copied().reduce(f64::min);
    if let (Some(before), Some(after)) = (least(&held[WARM..2 * WARM]), least(&held[LAST - WARM..])) {
        assert!(after < before * (1.0 + GROWTH), "{before} bytes after {WARM} passes, {after} after {LAST}");
    }
    let median = |part: &[f64]| {
        let mut part = part.to_vec();
        part.sort_by(f64::total_cmp);
        part[part.len() / 2]
    };
    let half = (WARM + LAST) / 2;
    let (early, late) = (median(&seconds[WARM..half]), median(&seconds[half..]));
    assert!(late < early * SLOWER, "a pass took {early} s, later {late} s");
}
