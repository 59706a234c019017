//! Boundary: the weights that make a radiance estimate right where its disc loses area at edges and corners.
//!
//! Area points stand for the surface. From their moments in the disc, weights c0 + c1 x + c2 y with
//! Σ a (c0 + c1 x + c2 y)(1, x, y) = (1, 0, 0): a linear irradiance is then estimated without bias [E11]
//! (local linear regression, Fan & Gijbels 1996). Where the disc is whole they are 1/(π r²), 0, 0.

use super::gather::Window;
use super::maps::AreaMap;
use glam::Vec4;
use std::f32::consts::PI;

/// A disc with at least this share of its area …
const WHOLE_AREA: f32 = 0.95;
/// … and its centroid within this part of the radius is taken as whole.
const WHOLE_CENTROID: f32 = 0.05;
/// Smallest determinant of the normalised moments (1 for a whole disc) that is solved: a sliver has no slope.
const DETERMINANT_MIN: f32 = 0.02;

/// Weight of a joton at tangent coordinates (x, y): `constant + slope · (x, y)`, 1/area.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Weights {
    pub(super) constant: f32,
    pub(super) slope: [f32; 2],
}

impl Weights {
    /// The plain estimate: 1/(π r²).
    pub(super) fn plain(radius_squared: f32) -> Self {
        Self { constant: 1.0 / (PI * radius_squared), slope: [0.0; 2] }
    }
}

/// The weights at a gather point, and whether its disc is whole.
pub(super) fn weights(map: &AreaMap, w: &Window) -> (Weights, bool) {
    let mut sums = [Vec4::ZERO; 6];
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for four in &map.fours[quads] {
            let (inside, d) = w.accept_either_side(four);
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
    solve(sums.map(|s| s.element_sum() * map.area_each), w.radius_squared)
}

/// Weights from the moments A, Ax, Ay, Axx, Axy, Ayy.
fn solve(moments: [f32; 6], radius_squared: f32) -> (Weights, bool) {
    let plain = Weights::plain(radius_squared);
    let disc = PI * radius_squared;
    let radius = radius_squared.sqrt();
    let area = moments[0] / disc;
    if area <= 0.0 {
        return (plain, false);
    }
    // in units of the radius and the disc's area, about the centroid, where the system falls apart
    let [x, y] = [moments[1], moments[2]].map(|m| m / (disc * radius) / area);
    if area >= WHOLE_AREA && x * x + y * y <= WHOLE_CENTROID * WHOLE_CENTROID {
        return (plain, true);
    }
    let second = |m: f32, a: f32, b: f32| m / (disc * radius_squared) / area - a * b;
    let (xx, xy, yy) = (second(moments[3], x, x), second(moments[4], x, y), second(moments[5], y, y));
    let determinant = xx * yy - xy * xy;
    let constant = plain.constant / area;
    // a whole disc has xx = yy = 1/4
    if determinant * 16.0 < DETERMINANT_MIN {
        return (Weights { constant, slope: [0.0; 2] }, false);
    }
    // slope = −C⁻¹ centroid, so that the weights vanish against x and y
    let slope = [-(yy * x - xy * y) / determinant, -(xx * y - xy * x) / determinant];
    let at_center = 1.0 - slope[0] * x - slope[1] * y;
    (
        Weights { constant: constant * at_center, slope: slope.map(|s| constant * s / radius) },
        false,
    )
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

    fn moments(points: &[[f32; 2]], area_each: f32) -> [f32; 6] {
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
            let (w, whole) = solve(moments(&points, a), 9.0);
            assert!(!whole);
            let (mut one, mut x_moment) = (0.0, 0.0);
            for [x, y] in &points {
                let weight = w.constant + w.slope[0] * x + w.slope[1] * y;
                one += f64::from(weight * a);
                x_moment += f64::from(weight * a * x);
            }
            assert!((one - 1.0).abs() < 1e-3 && x_moment.abs() < 3e-3, "cut {cut}: {one} {x_moment}");
        }
    }

    #[test]
    fn whole_disc_is_plain() {
        let (points, a) = cut_disc(3.0, 4.0);
        assert_eq!(solve(moments(&points, a), 9.0), (Weights::plain(9.0), true));
    }
}
