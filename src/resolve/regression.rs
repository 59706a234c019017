//! Regression: irradiance at a place from what its surroundings in the image found on the same surface: the value at the place of a
//! plane through the nodes of a level, by weighted least squares [E29].

use super::patch::Patch;
use super::pyramid::Level;
use super::surfaces::Surfaces;
use super::told::{Values, halves};
use super::window::Window;
use crate::sampling::distributions::basis;
use crate::spectrum::Bands;
use glam::Vec2;

/// Blocks from the place to the end of the kernel.
pub(super) const REACH: f32 = 2.5;
/// Added to the moments of the plane's slopes, relative to those of a whole kernel: places in a row have no slope across.
const RIDGE: f32 = 0.01;
/// Second moment of the kernel along an axis, relative to its radius.
const KERNEL_MOMENT: f32 = 0.125;
/// Nodes that a kernel usually has, at most.
const NODES: usize = 64;
/// Least weight, pixels.
const LEAST: f32 = 1e-4;

/// Weights of nodes of a level.
pub(super) struct Kernel(Vec<(u32, f32)>);

impl Kernel {
    /// That gives the value at a patch whose pixel has its middle at `at`; none where nothing near is known.
    pub(super) fn at(level: &Level, surfaces: &Surfaces, patch: &Patch, at: Vec2) -> Option<Self> {
        let width = level.width as f32;
        let radius = REACH * width;
        let (low, high) = ((at - radius) / width, (at + radius) / width);
        let range = |low: f32, high: f32, n: u32| (low.max(0.0) as u32)..((high.max(0.0) as u32) + 1).min(n);
        let (across, down) = basis(patch.place.normal);
        let scale = 1.0 / (patch.place.footprint * radius);
        let over = 1.0 / (radius * radius);
        let (mut s, mut su, mut sv) = (0.0f32, 0.0f32, 0.0f32);
        let (mut suu, mut suv, mut svv) = (0.0f32, 0.0f32, 0.0f32);
        // weight, and the same times the coordinates on the surface
        let mut near: Vec<(u32, [f32; 3])> = Vec::with_capacity(NODES);
        let columns = range(low.x, high.x, level.size[0]);
        for y in range(low.y, high.y, level.size[1]) {
            level.for_each(surfaces, y, columns.clone(), |id, node| {
                let away = node.at.distance_squared(at);
                let inside = 1.0 - away * over;
                if inside <= 0.0 {
                    return;
                }
                let like = patch.place.likeness(&node.place, away.sqrt());
                let w = node.count * inside * inside * like;
                if w <= 0.0 {
                    return;
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
                near.push((id as u32, [w, wu, wv]));
            });
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
        let weight = |[w, wu, wv]: [f32; 3]| c[0] * w + c[1] * wu + c[2] * wv;
        Some(Self(near.into_iter().map(|(id, w)| (id, weight(w))).collect()))
    }

    /// Irradiance of what the nodes found, as each half of the passes tells it.
    pub(super) fn of(&self, values: &Window<Values>) -> [Bands; 2] {
        let mut sums = Values::default();
        for &(id, weight) in &self.0 {
            sums.iter_mut().zip(&values[id as usize]).for_each(|(sum, value)| *sum += weight * value);
        }
        halves(&sums)
    }
}
