//! Kernel correction: the weights that make a radiance estimate right where its disc loses area at edges and corners.
//!
//! Area points stand for the surface. From their moments in the disc, weights c0 + c1 x + c2 y with
//! Σ a (c0 + c1 x + c2 y)(1, x, y) = (1, 0, 0): a linear irradiance is then estimated without bias [E15]
//! (local linear regression, Fan & Gijbels 1996). Where the disc is whole they are 1/(π r²), 0, 0.

use super::eye::GatherPoint;
use super::interior::Interior;
use super::maps::AreaMap;
use super::window::Window;
use crate::packed::constants::{DISC_DETERMINANT, FIT_AMPLIFICATION_MAX, FIT_DETERMINANT_MIN};
use glam::Vec4;
use std::f32::consts::PI;

/// A disc with at least this share of its area …
const WHOLE_AREA: f32 = 0.95;
/// … and its centroid within this part of the radius is taken as whole.
const WHOLE_CENTROID: f32 = 0.05;
/// A disc this much wider than the gather radius is surveyed: where it is whole, every gather disc well inside it is …
const SURVEY_RADIUS: f32 = 1.3;
/// … up to this part of its radius: an edge that costs it the 5 % that it may lack lies at 0.8 of its radius.
const SURVEY_REACH: f32 = 0.87;

/// Weight of a joton at tangent coordinates (x, y): `constant + slope · (x, y)`, 1/area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weights {
    pub(super) constant: f32,
    pub(super) slope: [f32; 2],
}

impl Weights {
    /// The plain estimate: 1/(π r²).
    pub(super) fn plain(radius_squared: f32) -> Self {
        Self::of_area(PI * radius_squared)
    }

    /// The plain estimate from a part of a disc of this area.
    pub(super) fn of_area(area: f32) -> Self {
        Self { constant: 1.0 / area, slope: [0.0; 2] }
    }
}

/// Look around a gather point, wider than its window: whether its disc is whole.
pub(super) fn survey(map: &AreaMap, g: &GatherPoint, radius: f32) -> Interior {
    let wide = SURVEY_RADIUS * radius;
    let w = Window::new(g, wide * wide);
    let [area, x, y, ..] = moments(map, &w).map(|m| m / (PI * wide * wide));
    // x and y are in internal units times the share of the area
    let limit = WHOLE_CENTROID * wide * area;
    let whole = area >= WHOLE_AREA && x * x + y * y <= limit * limit;
    Interior::new(g, if whole { SURVEY_REACH * wide } else { 0.0 })
}

/// The weights at a gather point. Always solved: a plain estimate wherever 95 % of the disc is there loses 0.1 % of the
/// Cornell box's diffuse light.
pub(super) fn weights(map: &AreaMap, w: &Window) -> Weights {
    solve(moments(map, w), w.radius_squared)
}

/// A, Ax, Ay, Axx, Axy, Ayy of the surface in a window.
fn moments(map: &AreaMap, w: &Window) -> [f32; 6] {
    let mut sums = [Vec4::ZERO; 6];
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for four in &map.fours[quads] {
            let (inside, d) = w.accept_area(four);
            if !inside.any() {
                continue;
            }
            let one = Vec4::select(inside, Vec4::ONE, Vec4::ZERO);
            let (x, y) = w.tangent(&d);
            let (x, y) = (x * one, y * one);
            for (sum, term) in sums.iter_mut().zip([one, x, y, x * x, x * y, y * y]) {
                *sum += term;
            }
        }
    });
    sums.map(|s| s.element_sum() * map.area_each)
}

/// Weights from the moments A, Ax, Ay, Axx, Axy, Ayy.
fn solve(moments: [f32; 6], radius_squared: f32) -> Weights {
    let plain = Weights::plain(radius_squared);
    let disc = PI * radius_squared;
    let radius = radius_squared.sqrt();
    let area = moments[0] / disc;
    if area <= 0.0 {
        return plain;
    }
    // in units of the radius and the disc's area, about the centroid, where the system falls apart
    let [x, y] = [moments[1], moments[2]].map(|m| m / (disc * radius) / area);
    let second = |m: f32, a: f32, b: f32| m / (disc * radius_squared) / area - a * b;
    let (xx, xy, yy) = (second(moments[3], x, x), second(moments[4], x, y), second(moments[5], y, y));
    let determinant = xx * yy - xy * xy;
    let constant = plain.constant / area;
    // slope = −C⁻¹ centroid, so that the weights vanish against x and y
    let slope = [-(yy * x - xy * y) / determinant, -(xx * y - xy * x) / determinant];
    let amplification = 1.0 - slope[0] * x - slope[1] * y;
    if determinant < FIT_DETERMINANT_MIN * DISC_DETERMINANT || amplification >= FIT_AMPLIFICATION_MAX {
        return Weights { constant, slope: [0.0; 2] };
    }
    Weights { constant: constant * amplification, slope: slope.map(|s| constant * s / radius) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of the part of a disc with x > −cut, by brute force.
    fn cut_disc(radius: f32, cut: f32) -> (Vec<[f32; 2]>, f32) {
        let n = 400;
        let step = 2.0 * radius / n as f32;
        let points = (0..n * n)
            .map(|i| [(i % n) as f32, (i / n) as f32].map(|k| (k + 0.5) * step - radius))
            .filter(|[x, y]| x * x + y * y < radius * radius && *x > -cut)
            .collect();
        (points, step * step)
    }

    fn sampled_moments(points: &[[f32; 2]], area_each: f32) -> [f32; 6] {
        let mut m = [0.0f64; 6];
        for &[x, y] in points {
            for (m, t) in m.iter_mut().zip([1.0, x, y, x * x, x * y, y * y]) {
                *m += f64::from(t * area_each);
            }
        }
        m.map(|m| m as f32)
    }

    /// At an edge the weights integrate to one and are blind to a slope: a linear irradiance comes out exact.
    #[test]
    fn linear_irradiance_is_exact_at_an_edge() {
        for cut in [0.0, 0.5, 1.0, 2.0] {
            let (points, a) = cut_disc(3.0, cut);
            let w = solve(sampled_moments(&points, a), 9.0);
            let (mut one, mut x_moment) = (0.0, 0.0);
            for [x, y] in &points {
                let weight = w.constant + w.slope[0] * x + w.slope[1] * y;
                one += f64::from(weight * a);
                x_moment += f64::from(weight * a * x);
            }
            assert!((one - 1.0).abs() < 1e-3 && x_moment.abs() < 3e-3, "cut {cut}: {one} {x_moment}");
        }
    }

    /// A sliver has no slope, at its end, too; a quarter of a disc has one.
    #[test]
    fn a_sliver_has_no_slope() {
        let (points, a) = cut_disc(3.0, 4.0);
        let part = |keep: &dyn Fn(f32, f32) -> bool| -> Vec<[f32; 2]> {
            points.iter().copied().filter(|[x, y]| keep(*x, *y)).collect()
        };
        for sliver in [part(&|_, y| y.abs() < 0.15), part(&|x, y| x > -0.1 && y.abs() < 0.15)] {
            let w = solve(sampled_moments(&sliver, a), 9.0);
            assert_eq!(w.slope, [0.0; 2]);
            assert!((w.constant * sliver.len() as f32 * a - 1.0).abs() < 1e-3, "{w:?}");
        }
        let quarter = part(&|x, y| x > 0.0 && y > 0.0);
        let w = solve(sampled_moments(&quarter, a), 9.0);
        let weight = |x: f32, y: f32| f64::from((w.constant + w.slope[0] * x + w.slope[1] * y) * a);
        let [one, x_moment, y_moment] = quarter.iter().fold([0.0; 3], |[one, mx, my], &[x, y]| {
            [one + weight(x, y), mx + weight(x, y) * f64::from(x), my + weight(x, y) * f64::from(y)]
        });
        assert!((one - 1.0).abs() < 1e-3 && x_moment.abs() < 3e-3 && y_moment.abs() < 3e-3, "{w:?}");
    }

    #[test]
    fn whole_disc_is_plain() {
        let (points, a) = cut_disc(3.0, 4.0);
        let w = solve(sampled_moments(&points, a), 9.0);
        let plain = Weights::plain(9.0).constant;
        assert!((w.constant / plain - 1.0).abs() < 1e-3, "{w:?}");
        assert!(w.slope.iter().all(|s| (s / plain).abs() < 1e-3), "{w:?}");
    }
}
