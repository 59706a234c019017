//! Memory: what this process has used and may still ask for, as far as the system tells (Linux).

use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

/// Bytes that this process may take, as its user said.
static LIMIT: AtomicU64 = AtomicU64::new(u64::MAX);

/// Bound what this process takes while it reads a scene and builds its hierarchy, bytes: what would need more is refused. How
/// much the render takes then follows from [`crate::plan::Settings::memory`].
pub fn set_limit(bytes: u64) {
    LIMIT.store(bytes, Ordering::Relaxed);
}

/// What [`set_limit`] said; none where nothing was.
pub(crate) fn limit() -> Option<u64> {
    Some(LIMIT.load(Ordering::Relaxed)).filter(|bytes| *bytes < u64::MAX)
}

/// Bytes that may still be taken: what is available, and what [`set_limit`] leaves.
pub(crate) fn allowed() -> Option<u64> {
    let taken = || kib_of("/proc/self/status", "VmRSS:").unwrap_or(0);
    let left = limit().map(|bytes| bytes.saturating_sub(taken()));
    [available(), left].into_iter().flatten().min()
}

/// Gives what is free back to the system.
static GIVE_BACK: OnceLock<fn()> = OnceLock::new();

/// How memory that is free is given back to the system, where the program knows how.
pub fn set_give_back(give_back: fn()) {
    GIVE_BACK.set(give_back).ok();
}

/// Give memory that is free back to the system: after a driver has compiled a kernel.
pub(crate) fn give_back() {
    if let Some(give_back) = GIVE_BACK.get() {
        give_back();
    }
}

/// Largest resident set of this process so far, bytes.
pub fn peak() -> Option<u64> {
    kib_of("/proc/self/status", "VmHWM:")
}

/// Bytes that can still be allocated before the machine swaps, the process is killed or allocation fails: the least of what
/// is free and of what its control group and the limit of its address space (`ulimit -v`) leave.
pub(crate) fn available() -> Option<u64> {
    let group = || {
        let number = |file: &str| std::fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
        Some(number("/sys/fs/cgroup/memory.max")?.saturating_sub(number("/sys/fs/cgroup/memory.current")?))
    };
    let addresses = || Some(address_limit()?.saturating_sub(kib_of("/proc/self/status", "VmSize:")?));
    [kib_of("/proc/meminfo", "MemAvailable:"), group(), addresses()].into_iter().flatten().min()
}

/// Bytes of address space that the process may have, where there is a limit.
fn address_limit() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/self/limits").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The bytes in a line like "VmHWM:   1234 kB".
fn kib_of(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib * 1024)
}
