//! CSV: rows and summaries as tables that spreadsheets and scripts read (RFC 4180).

use super::{KernelRow, Row, Summary};
use crate::spectrum::NAMES;

/// One line for each picture; cells are empty where there was no reference, no estimate yet, or
/// where a renderer does not tell.
pub fn runs_csv(rows: &[Row]) -> String {
    let ratios = NAMES.map(|b| format!("mean_ratio_{b}")).join(",");
    let mut text = format!(
        "scene,device,device_name,seed,step,seconds,cpu_seconds,passes,rays,jotons,rays_per_second,\
         jotons_per_second,device_bytes,error_estimate,\
         rel_mse,rel_mse_trimmed,{ratios}\n"
    );
    for r in rows {
        let c = r.comparison.as_ref();
        let mut cells = vec![
            quoted(&r.scene),
            quoted(&r.device),
            quoted(&r.device_name),
            r.seed.to_string(),
            r.step.to_string(),
            format!("{:.4}", r.seconds),
            format!("{:.4}", r.cpu_seconds),
            r.passes.to_string(),
            counted(r.rays),
            counted(r.jotons),
            optional(r.rays.map(|n| n as f64 / r.seconds)),
            optional(r.jotons.map(|n| n as f64 / r.seconds)),
            counted(r.device_bytes),
            optional(r.error_estimate),
            optional(c.map(|c| c.rel_mse)),
            optional(c.map(|c| c.rel_mse_trimmed)),
        ];
        cells.extend((0..NAMES.len()).map(|b| optional(c.map(|c| c.mean_ratio[b]))));
        text += &(cells.join(",") + "\n");
    }
    text
}

/// One line for each scene, device and step: means over the seeds, bias and variance apart.
pub fn summary_csv(summaries: &[Summary]) -> String {
    let mut text = String::from(
        "scene,device,step,seeds,seconds,cpu_seconds,passes,rel_mse,estimated_rel_mse,rel_bias_squared,rel_variance\n",
    );
    for s in summaries {
        let cells = [
            quoted(&s.scene),
            quoted(&s.device),
            s.step.to_string(),
            s.seeds.to_string(),
            format!("{:.4}", s.seconds),
            format!("{:.4}", s.cpu_seconds),
            format!("{:.1}", s.passes),
            optional(s.rel_mse),
            optional(s.estimated_rel_mse),
            optional(s.rel_bias_squared),
            optional(s.rel_variance),
        ];
        text += &(cells.join(",") + "\n");
    }
    text
}

/// One line for each kernel of a device, scene and seed.
pub fn kernels_csv(kernels: &[KernelRow]) -> String {
    let mut text = String::from("scene,device,seed,passes,kernel,seconds,dispatches\n");
    for k in kernels {
        let cells = [
            quoted(&k.scene),
            quoted(&k.device),
            k.seed.to_string(),
            k.passes.to_string(),
            quoted(&k.kernel),
            format!("{:.6}", k.seconds),
            k.dispatches.to_string(),
        ];
        text += &(cells.join(",") + "\n");
    }
    text
}

fn optional(value: Option<f64>) -> String {
    value.map_or(String::new(), |v| format!("{v:.6e}"))
}

fn counted(value: Option<u64>) -> String {
    value.map_or(String::new(), |v| v.to_string())
}

/// A cell with quotes where its text needs them.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into()
    }
}

#[cfg(test)]
mod tests {
    use super::quoted;

    /// Names of drivers hold commas, and of files anything.
    #[test]
    fn commas_and_quotes_stay_in_their_cell() {
        assert_eq!(quoted("cpu"), "cpu");
        assert_eq!(quoted("llvmpipe (LLVM 15, 256 bits)"), "\"llvmpipe (LLVM 15, 256 bits)\"");
        assert_eq!(quoted("a \"b\""), "\"a \"\"b\"\"\"");
    }
}
