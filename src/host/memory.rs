//! Memory: what this process has used and may still ask for, as far as the system tells (Linux).

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
