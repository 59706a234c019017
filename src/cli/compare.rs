//! `joton compare IMAGE REFERENCE`.

use super::{DONE, FAULTY, say, say_json, tell};
use clap::Args;
use joton::film::Image;
use joton::output::{self, compare, exr};
use joton::{Error, Result};
use std::path::{Path, PathBuf};

/// Arguments of `joton compare`.
#[derive(Debug, Args)]
pub(super) struct CompareArguments {
    /// The image, an EXR of linear radiance.
    image: PathBuf,
    /// What it should be.
    reference: PathBuf,
    /// The image once more with another seed: print the error that both have in common, without their noise.
    #[arg(long, value_name = "IMAGE.exr")]
    twin: Option<PathBuf>,
    /// Write the relative error of each pixel in false colour.
    #[arg(long, value_name = "FILE.png")]
    heatmap: Option<PathBuf>,
    /// Exit with status 1 where relMSE is larger.
    #[arg(long, value_name = "RELMSE")]
    tolerance: Option<f64>,
    /// Print the ratio of means for N × N regions of the image.
    #[arg(long, value_name = "N")]
    regions: Option<u32>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// Refuse images that differ in size, by their names.
fn check_size(path: &Path, image: &Image, other: &Path, reference: &Image) -> Result<()> {
    if (image.width, image.height) == (reference.width, reference.height) {
        return Ok(());
    }
    let size = |i: &Image| format!("{}x{}", i.width, i.height);
    let (path, other) = (path.display(), other.display());
    let what = format!("{path}: has {} pixels, {other} has {}", size(image), size(reference));
    Err(Error::usage(what, "compare images of one size"))
}

pub(super) fn run(a: &CompareArguments) -> Result<u8> {
    if a.tolerance.is_some_and(|t| t.is_nan() || t < 0.0) {
        return Err(Error::usage("--tolerance must be 0 or larger", "give the largest relMSE to accept"));
    }
    if let Some(path) = &a.heatmap {
        let read: Vec<PathBuf> = [&a.image, &a.reference].into_iter().chain(&a.twin).cloned().collect();
        output::check_not_read([path], &read)?;
        output::check_writable(path)?;
    }
    let (image, reference) = (exr::read_image(&a.image)?, exr::read_image(&a.reference)?);
    let twin = a.twin.as_deref().map(exr::read_image).transpose()?;
    for (path, other) in a.twin.iter().zip(&twin).chain([(&a.image, &image)]) {
        check_size(path, other, &a.reference, &reference)?;
    }
    let c = compare::compare(&image, &reference)?;
    let common = twin.map(|twin| compare::common_error(&image, &twin, &reference)).transpose()?;
    let regions = match a.regions {
        Some(n) => compare::region_ratios(&image, &reference, n)?,
        None => Vec::new(),
    };
    // there are no more across than pixels
    let across = a.regions.map_or(1, |n| n.clamp(1, image.width));
    let regions: Vec<_> = regions.chunks(across as usize).collect();
    if a.json {
        let rows: Vec<Vec<_>> = regions.iter().map(|row| row.iter().map(|r| r.ratio).collect()).collect();
        let mut value = serde_json::json!(c);
        value["region_ratios"] = serde_json::json!(rows);
        value["common"] = serde_json::json!(common);
        value["tolerance"] = serde_json::json!(a.tolerance);
        say_json(&value)?;
    } else {
        let ratios: Vec<String> = c.mean_ratio.iter().map(|r| format!("{r:.4}")).collect();
        say(format_args!(
            "relMSE {:.4e} trimmed {:.4e} MSE {:.4e} mean/ref {}",
            c.rel_mse,
            c.rel_mse_trimmed,
            c.mse,
            ratios.join(" ")
        ));
        if let Some(common) = common {
            say(format_args!("in common {:.4e} deviation {:.1e}", common.rel_mse, common.deviation));
        }
        for row in regions {
            let cell = |r: &compare::Region| r.ratio.map(|x| format!("{x:.3}")).join("/");
            say(row.iter().map(cell).collect::<Vec<_>>().join("  "));
        }
    }
    if let Some(path) = &a.heatmap {
        compare::write_heatmap(path, &image, &reference)?;
    }
    let is_far = |most: &f64| c.rel_mse > *most || c.rel_mse.is_nan();
    if c.non_finite > 0 {
        tell(format_args!("joton: {} pixels of {} are not finite", c.non_finite, a.image.display()));
    } else if let Some(most) = a.tolerance.filter(is_far) {
        tell(format_args!("joton: relMSE {:.4e} is above the tolerance of {most:.4e}", c.rel_mse));
    } else {
        return Ok(DONE);
    }
    Ok(FAULTY)
}
