//! Comparison of an image with a reference: how far, by how much too bright, and where.
//!
//! relMSE = mean over pixels and bands of (I − R)² / (R² + 0.01)                 [Rousselle et al. 2011]

use super::heatmap;
use crate::error::{Error, Result};
use crate::film::{Image, RELATIVE_OFFSET};
use crate::spectrum::BANDS;
use std::path::Path;

/// The share of the pixels, the worst, that the trimmed error leaves out.
const TRIMMED: f64 = 1e-3;

/// What a comparison finds. Pixels where the reference is not finite count as free of error.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Comparison {
    /// Mean of (I − R)²/(R² + 0.01) over pixels and bands. Infinite where the image holds a value that is not
    /// finite, so that no tolerance accepts it; the same holds for the next two.
    pub rel_mse: f64,
    /// The same without the 0.1 % (rounded up) worst pixels: what remains when fireflies are forgiven. An image of
    /// one pixel has nothing to leave out.
    pub rel_mse_trimmed: f64,
    /// Mean of (I − R)² over pixels and bands, (W/(m² sr))².
    pub mse: f64,
    /// Mean of the image over mean of the reference, per band; not finite where the reference is black.
    pub mean_ratio: [f64; BANDS],
    /// Pixels of the image that are not finite.
    pub non_finite: usize,
}

/// Compare an image with its reference.
pub fn compare(image: &Image, reference: &Image) -> Result<Comparison> {
    let pairs = pairs(image, reference)?;
    let non_finite = image.pixels.iter().filter(|p| !finite(p)).count();
    if non_finite > 0 {
        let worst = f64::INFINITY;
        let mean_ratio = region_ratio(pairs);
        return Ok(Comparison { rel_mse: worst, rel_mse_trimmed: worst, mse: worst, mean_ratio, non_finite });
    }
    let mut errors = relative_errors(image, reference)?;
    let count = errors.len() as f64;
    let rel_mse = errors.iter().sum::<f64>() / count;
    errors.sort_by(f64::total_cmp);
    let kept = &errors[..errors.len() - (count * TRIMMED).ceil() as usize];
    let rel_mse_trimmed =
        if kept.is_empty() { rel_mse } else { kept.iter().sum::<f64>() / kept.len() as f64 };
    let square = |(i, r): ([f64; BANDS], [f64; BANDS])| -> f64 {
        (0..BANDS).map(|b| (i[b] - r[b]).powi(2)).sum::<f64>() / BANDS as f64
    };
    let mse = pairs.clone().map(square).sum::<f64>() / count;
    Ok(Comparison { rel_mse, rel_mse_trimmed, mse, mean_ratio: region_ratio(pairs), non_finite })
}

/// What two images of one scene, rendered with different seeds, have in common against a reference: bias of the images,
/// or bias and noise of the reference. Their own noise is not in it.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct CommonError {
    /// Mean of (I − R)(T − R)/(R² + 0.01) over pixels and bands, T the twin of I; may come out below zero where it is
    /// nothing but noise.
    pub rel_mse: f64,
    /// Standard deviation of that mean, from its spread over the pixels.
    pub deviation: f64,
}

/// Compare an image and its twin with their reference.
pub fn common_error(image: &Image, twin: &Image, reference: &Image) -> Result<CommonError> {
    check_sizes(twin, image)?;
    let twins = pairs(twin, reference)?;
    let products: Vec<f64> = pairs(image, reference)?
        .zip(twins)
        .map(|((i, r), (t, _))| {
            let band = |b: usize| (i[b] - r[b]) * (t[b] - r[b]) / (r[b] * r[b] + RELATIVE_OFFSET);
            (0..BANDS).map(band).sum::<f64>() / BANDS as f64
        })
        .collect();
    // where the reference is not finite there is no error, as in `relative_errors`
    let count = image.pixels.len() as f64;
    let mean = products.iter().sum::<f64>() / count;
    let square = products.iter().map(|p| p * p).sum::<f64>() / count;
    Ok(CommonError { rel_mse: mean, deviation: ((square - mean * mean).max(0.0) / count).sqrt() })
}

/// Mean over the bands of (I − R)²/(R² + 0.01), for each pixel; 0 where the reference is not finite.
pub fn relative_errors(image: &Image, reference: &Image) -> Result<Vec<f64>> {
    check_sizes(image, reference)?;
    let error = |(i, r): (&[f32; BANDS], &[f32; BANDS])| {
        if !finite(r) {
            return 0.0;
        }
        let band = |b: usize| {
            let (i, r) = (f64::from(i[b]), f64::from(r[b]));
            (i - r).powi(2) / (r * r + RELATIVE_OFFSET)
        };
        (0..BANDS).map(band).sum::<f64>() / BANDS as f64
    };
    Ok(image.pixels.iter().zip(&reference.pixels).map(error).collect())
}

/// One block of an image and how bright it is against the reference.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Region {
    /// Left column and top row, in pixels.
    pub origin: [u32; 2],
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Mean of the image over mean of the reference, per band; NaN where both are black.
    pub ratio: [f64; BANDS],
}

/// The ratio of the means in n×n blocks, row by row: a bias has a place, and this shows it before any pixel does.
/// Images of fewer than `n` pixels in a direction have as many blocks as pixels there.
pub fn region_ratios(image: &Image, reference: &Image, n: u32) -> Result<Vec<Region>> {
    check_sizes(image, reference)?;
    let [across, down] = [image.width, image.height].map(|size| n.clamp(1, size));
    let edge = |i: u32, blocks: u32, size: u32| (u64::from(size) * u64::from(i) / u64::from(blocks)) as u32;
    let region = |block: u32| {
        let (column, row) = (block % across, block / across);
        let origin = [edge(column, across, image.width), edge(row, down, image.height)];
        let end = [edge(column + 1, across, image.width), edge(row + 1, down, image.height)];
        let indices = (origin[1]..end[1])
            .flat_map(|y| (origin[0]..end[0]).map(move |x| y as usize * image.width as usize + x as usize));
        let pairs = indices
            .filter(|&p| finite(&reference.pixels[p]))
            .map(|p| (image.pixels[p].map(f64::from), reference.pixels[p].map(f64::from)));
        Region { origin, size: [end[0] - origin[0], end[1] - origin[1]], ratio: region_ratio(pairs) }
    };
    Ok((0..across * down).map(region).collect())
}

/// Write the relative error of each pixel in false colour, from 1e-4 (black) to 10 (white), with its scale below.
pub fn write_heatmap(path: &Path, image: &Image, reference: &Image) -> Result<()> {
    heatmap::write(path, image.width, &relative_errors(image, reference)?)
}

fn finite(pixel: &[f32; BANDS]) -> bool {
    pixel.iter().all(|x| x.is_finite())
}

/// Pixels of both images where the reference is finite, in f64.
fn pairs<'a>(
    image: &'a Image,
    reference: &'a Image,
) -> Result<impl Iterator<Item = ([f64; BANDS], [f64; BANDS])> + Clone + 'a> {
    check_sizes(image, reference)?;
    let both = image.pixels.iter().zip(&reference.pixels);
    Ok(both.filter(|(_, r)| finite(r)).map(|(i, r)| (i.map(f64::from), r.map(f64::from))))
}

fn region_ratio(pairs: impl Iterator<Item = ([f64; BANDS], [f64; BANDS])>) -> [f64; BANDS] {
    let mut sums = [[0.0; BANDS]; 2];
    for (i, r) in pairs {
        for b in 0..BANDS {
            sums[0][b] += i[b];
            sums[1][b] += r[b];
        }
    }
    std::array::from_fn(|b| sums[0][b] / sums[1][b])
}

fn check_sizes(image: &Image, reference: &Image) -> Result<()> {
    let size = |i: &Image| format!("{}x{}", i.width, i.height);
    if (image.width, image.height) != (reference.width, reference.height) {
        return Err(Error::usage(
            format!("the image has {} pixels, the reference {}", size(image), size(reference)),
            "compare images of one size",
        ));
    }
    if image.pixels.is_empty() {
        return Err(Error::usage("the images have no pixels", "compare images with at least one"));
    }
    Ok(())
}
