//! Amounts of memory: `--memory 512M`, and how they are told.

/// Units by their letter, powers of 1024.
const UNITS: [(char, f64); 3] = [('K', 1024.0), ('M', 1_048_576.0), ('G', 1_073_741_824.0)];

/// Bytes from a number and a unit: 512M, 1.5G; upper or lower case, with or without B or iB at the end.
pub(super) fn parse(text: &str) -> Result<u64, String> {
    let upper = text.trim().to_uppercase();
    let short = upper.strip_suffix("IB").or_else(|| upper.strip_suffix('B')).unwrap_or(&upper);
    let unit = UNITS.iter().find_map(|(letter, bytes)| Some((short.strip_suffix(*letter)?, bytes)));
    let number = unit.and_then(|(number, bytes)| Some(number.trim().parse::<f64>().ok()? * bytes));
    match number {
        Some(bytes) if bytes >= 1.0 && bytes < u64::MAX as f64 => Ok(bytes as u64),
        _ => Err("give a number and a unit: 512M, 2G".into()),
    }
}

/// Keep this process to a limit, if there is one, from the first file that it reads.
pub(super) fn bound(limit: Option<u64>) {
    if let Some(bytes) = limit {
        joton::host::memory::set_limit(bytes);
    }
}

/// Bytes as MiB.
pub(super) fn mebibytes(bytes: u64) -> String {
    format!("{:.1} MiB", bytes as f64 / UNITS[1].1)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Units are powers of 1024, whatever their case; a bare number says nothing, and nothing is no memory.
    #[test]
    fn amounts_have_a_unit() {
        for (text, bytes) in
            [("512M", 512 << 20), ("2g", 2 << 30), ("1.5 GiB", 3 << 29), ("64kb", 64 << 10), ("0.5K", 512)]
        {
            assert_eq!(parse(text), Ok(bytes), "{text}");
        }
        for text in ["", "512", "M", "-1M", "0M", "1e400G", "nanG", "infG", "2T", "2MM", "0.0001K"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
