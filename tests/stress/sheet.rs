//! The sheet on which stresses write what they found, and the table that is made of it.

use crate::common::device;
use libtest_mimic::Failed;
use std::fmt::Write;
use std::sync::{Mutex, PoisonError};

/// One stress.
#[derive(Clone, Copy)]
pub struct Stress {
    /// What is stressed; also the name of the test.
    pub name: &'static str,
    /// Tries it and writes rows.
    pub run: fn(&mut Sheet),
}

/// A line of the table.
struct Row {
    stress: &'static str,
    tried: String,
    backend: String,
    worst: String,
    limit: String,
}

/// Where a stress writes.
pub struct Sheet {
    rows: Vec<Row>,
    stress: &'static str,
    failures: Vec<String>,
}

/// Names the file that the table is written to; "-" prints it.
const TABLE: &str = "JOTON_STRESS_TABLE";

static ROWS: Mutex<Vec<Row>> = Mutex::new(Vec::new());

/// True where the long sizes are asked for.
pub fn is_long() -> bool {
    std::env::var("JOTON_STRESS").is_ok_and(|v| v == "long")
}

/// True where a table is asked for: then rows are printed as they come.
fn is_told() -> bool {
    std::env::var_os(TABLE).is_some()
}

/// The size for every day, or the long one.
pub fn sized<T>(short: T, long: T) -> T {
    if is_long() { long } else { short }
}

impl Sheet {
    /// A number that must not exceed its limit.
    pub fn at_most(
        &mut self,
        tried: impl Into<String>,
        backend: impl ToString,
        unit: &str,
        worst: f64,
        limit: f64,
    ) {
        // NaN exceeds everything
        let holds = worst <= limit;
        self.row(tried, backend, format!("{} {unit}", short(worst)), short(limit), holds);
    }

    /// A count that must be zero.
    pub fn none(&mut self, tried: impl Into<String>, backend: impl ToString, unit: &str, count: u64) {
        self.row(tried, backend, format!("{count} {unit}"), "0", count == 0);
    }

    /// Any other finding.
    pub fn row(
        &mut self,
        tried: impl Into<String>,
        backend: impl ToString,
        worst: impl Into<String>,
        limit: impl Into<String>,
        holds: bool,
    ) {
        let row = Row {
            stress: self.stress,
            tried: tried.into(),
            backend: backend.to_string(),
            worst: worst.into().trim_end().to_string(),
            limit: limit.into(),
        };
        let line = format!("{} on {}: {} (limit {})", row.tried, row.backend, row.worst, row.limit);
        if is_told() {
            println!("    {}{line}", if holds { "" } else { "FAILED " });
        }
        if !holds {
            self.failures.push(line);
        }
        self.rows.push(row);
    }
}

/// A number with as many digits as it is worth.
fn short(x: f64) -> String {
    if x == 0.0 || (0.001..100_000.0).contains(&x.abs()) {
        let digits = if x.abs() >= 100.0 || x.fract() == 0.0 { 0 } else { 4 };
        format!("{x:.digits$}")
    } else {
        format!("{x:.1e}")
    }
}

/// Run a stress; what it wrote is kept for the table.
pub fn run(stress: Stress) -> Result<(), Failed> {
    let mut sheet = Sheet { rows: Vec::new(), stress: stress.name, failures: Vec::new() };
    let start = std::time::Instant::now();
    (stress.run)(&mut sheet);
    if is_told() {
        println!("    {} rows in {:.1} s", sheet.rows.len(), start.elapsed().as_secs_f64());
    }
    ROWS.lock().unwrap_or_else(PoisonError::into_inner).append(&mut sheet.rows);
    if sheet.failures.is_empty() { Ok(()) } else { Err(sheet.failures.join("\n").into()) }
}

/// Write the table where the environment says.
///
/// # Errors
/// What the file system says.
pub fn write(stresses: &[Stress]) -> std::io::Result<()> {
    let Ok(path) = std::env::var(TABLE) else { return Ok(()) };
    let rows = ROWS.lock().unwrap_or_else(PoisonError::into_inner);
    let mut text = String::from(concat!("# Numerical stress\n\n", include_str!("summary.md")));
    let sizes = if is_long() { "the long sizes" } else { "the sizes for every day" };
    let device =
        device().map_or_else(|| "none".to_string(), |c| format!("{} ({})", c.info.name, c.info.driver_info));
    let _ = writeln!(
        text,
        "Written by `JOTON_STRESS=long JOTON_STRESS_TABLE=docs/STRESS.md cargo test --release --test stress`; here: \
         {sizes}. Device: {device}. A stress fails where its worst error is beyond the limit.\n\n\
         | Stress | Tried | Backend | Worst error | Limit |\n|---|---|---|---|---|"
    );
    let looked_at = crate::shoot::values_looked_at();
    for stress in stresses {
        for row in rows.iter().filter(|r| r.stress == stress.name) {
            let _ = writeln!(
                text,
                "| {} | {} | {} | {} | {} |",
                row.stress, row.tried, row.backend, row.worst, row.limit
            );
        }
    }
    let _ = writeln!(
        text,
        "\nAll values of all films, {looked_at} of them, were looked at by their bits: not one was NaN or infinite, and \
         none was left out for it. What single kernels do at the limits of their sizes is in `tests/gpu_kernels`."
    );
    if path == "-" {
        print!("{text}");
        return Ok(());
    }
    std::fs::write(path, text)
}
