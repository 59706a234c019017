//! Regression: irradiance at a place from what its surroundings in the image found on the same surface: the value at the place of a
//! plane through the nodes of a level, by weighted least squares [E29].

use super::pyramid::{Level, VALUES};
use super::surfaces::Patch;
use crate::sampling::distributions::basis;
use crate::spectrum::{BANDS, Bands};
use glam::Vec2;

/// Blocks from the place to the end of the kernel.
pub(super) const REACH: f32 = 2.5;
/// Added to the moments of the plane's slopes, relative to those of a whole kernel: places in a row have no slope across.
const RIDGE: f32 = 0.01;
/// Second moment of the kernel along an axis, relative to its radius.
const KERNEL_MOMENT: f32 = 0.125;
/// Least weight, pixels.
const LEAST: f32 = 1e-4;

/// Irradiance at a patch whose pixel has its middle at `at`, as each half of the passes tells it; none where nothing near is known.
pub(super) fn fit(level: &Level, patch: &Patch, at: Vec2) -> Option<[Bands; 2]> {
    let width = level.width as f32;
    let radius = REACH * width;
    let (low, high) = ((at - radius) / width, (at + radius) / width);
    let range = |low: f32, high: f32, n: u32| (low.max(0.0) as u32)..((high.max(0.0) as u32) + 1).min(n);
    let (across, down) = basis(patch.place.normal);
    let scale = 1.0 / (patch.place.footprint * radius);
    let over = 1.0 / (radius * radius);
    let (mut s, mut su, mut sv, mut suu, mut suv, mut svv) = (0.0f32, 0.0f32, 0.0f32, 0.0f32, 0.0f32, 0.0f32);
    let mut sums = [[0.0f32; VALUES]; 3];
    for y in range(low.y, high.y, level.size[1]) {
        for x in range(low.x, high.x, level.size[0]) {
            for node in level.of(x, y) {
                let away = node.at.distance_squared(at);
                let near = 1.0 - away * over;
                if near <= 0.0 {
                    continue;
                }
                let like = patch.place.likeness(&node.place, away.sqrt());
                let w = node.count * near * near * like;
                if w <= 0.0 {
                    continue;
                }
                let d = node.place.position - patch.place.position;
                let (u, v) = (d.dot(across) * scale, d.dot(down) * scale);
                let (wu, wv) = (w * u, w * v);
                s += w;
                su += wu;
                sv += wv;
                suu += wu * u;
                suv += wu * v;
                svv += wv * v;
                for (sums, w) in sums.iter_mut().zip([w, wu, wv]) {
                    for (sum, value) in sums.iter_mut().zip(&node.values) {
                        *sum += w * value;
                    }
                }
            }
        }
    }
    if s < LEAST {
        return None;
    }
    // value at the origin: the first row of the inverse of the moments
    let ridge = RIDGE * KERNEL_MOMENT * s;
    let (suu, svv) = (suu + ridge, svv + ridge);
    let minor = [suu * svv - suv * suv, suv * sv - su * svv, su * suv - suu * sv];
    let det = s * minor[0] + su * minor[1] + sv * minor[2];
    if det <= 0.0 {
        return None;
    }
    let c = minor.map(|m| m / det);
    let value = |i: usize| c[0] * sums[0][i] + c[1] * sums[1][i] + c[2] * sums[2][i];
    Some(std::array::from_fn(|half| std::array::from_fn(|band| value(half * BANDS + band))))
}
