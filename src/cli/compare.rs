//! `joton compare IMAGE REFERENCE`.

use super::{DONE, OUT_OF_TOLERANCE, say};
use clap::Args;
use joton::output::{self, compare, exr};
use joton::{Error, Result};
use std::path::PathBuf;

/// Arguments of `joton compare`.
#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// The image, an EXR of linear radiance.
    image: PathBuf,
    /// What it should be.
    reference: PathBuf,
    /// Write the relative error of each pixel in false colour.
    #[arg(long, value_name = "FILE.png")]
    heatmap: Option<PathBuf>,
    /// Exit with status 1 where relMSE is larger.
    #[arg(long, value_name = "RELMSE")]
    tolerance: Option<f64>,
    /// Print the ratio of means for N × N regions of the image.
    #[arg(long, value_name = "N")]
    regions: Option<u32>,
}

pub(super) fn run(a: &CompareArguments) -> Result<u8> {
    if a.tolerance.is_some_and(|t| t.is_nan() || t < 0.0) {
        return Err(Error::usage("--tolerance must be 0 or larger", "give the largest relMSE to accept"));
    }
    if let Some(path) = &a.heatmap {
        output::check_not_read([path], &[a.image.clone(), a.reference.clone()])?;
        output::check_writable(path)?;
    }
    let (image, reference) = (exr::read_image(&a.image)?, exr::read_image(&a.reference)?);
    let c = compare::compare(&image, &reference)?;
    let ratios: Vec<String> = c.mean_ratio.iter().map(|r| format!("{r:.4}")).collect();
    say(format_args!(
        "relMSE {:.4e} trimmed {:.4e} MSE {:.4e} mean/ref {}",
        c.rel_mse,
        c.rel_mse_trimmed,
        c.mse,
        ratios.join(" ")
    ));
    if c.non_finite > 0 {
        say(format_args!("{} pixels are not finite", c.non_finite));
    }
    if let Some(n) = a.regions {
        for row in compare::region_ratios(&image, &reference, n)?.chunks(n.max(1) as usize) {
            let cells: Vec<String> = row
                .iter()
                .map(|r| r.ratio.iter().map(|x| format!("{x:.3}")).collect::<Vec<_>>().join("/"))
                .collect();
            say(cells.join("  "));
        }
    }
    if let Some(path) = &a.heatmap {
        compare::write_heatmap(path, &image, &reference)?;
    }
    let out = c.non_finite > 0 || a.tolerance.is_some_and(|most| c.rel_mse > most || c.rel_mse.is_nan());
    Ok(if out { OUT_OF_TOLERANCE } else { DONE })
}
