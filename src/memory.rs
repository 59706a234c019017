//! Memory: what this process has used and may still ask for, as far as the system tells (Linux).

/// Largest resident set of this process so far, bytes.
pub fn peak() -> Option<u64> {
    kib_of("/proc/self/status", "VmHWM:")
}

/// Bytes that can still be allocated before the machine swaps or the process is killed: the least of what is free
/// and of what its control group leaves.
pub fn available() -> Option<u64> {
    let group = || {
        let number = |file: &str| std::fs::read_to_string(file).ok()?.trim().parse::<u64>().ok();
        Some(number("/sys/fs/cgroup/memory.max")?.saturating_sub(number("/sys/fs/cgroup/memory.current")?))
    };
    [kib_of("/proc/meminfo", "MemAvailable:"), group()].into_iter().flatten().min()
}

/// The bytes in a line like "VmHWM:   1234 kB".
fn kib_of(file: &str, key: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix(key))?;
    let kib: u64 = line.trim().trim_end_matches("kB").trim().parse().ok()?;
    Some(kib * 1024)
}
