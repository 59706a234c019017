//! Configuration and form factors: what share of a hemisphere, or of another surface's light, a surface takes.

use crate::build::v;
use glam::DVec3;
use std::f64::consts::PI;

/// The part of a polygon on the side of a plane through the origin that its normal points to.
pub fn clip(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &p) in polygon.iter().enumerate() {
        let q = polygon[(i + 1) % polygon.len()];
        let (a, b) = (p.dot(normal), q.dot(normal));
        if a >= 0.0 {
            kept.push(p);
        }
        if (a >= 0.0) != (b >= 0.0) {
            kept.push(p + (q - p) * (a / (a - b)));
        }
    }
    kept
}

/// Irradiance at the origin, on a surface that looks along the unit vector `normal`, under a polygon of radiance 1 that
/// faces it: Lambert's sum over its edges [A3], after what lies below the horizon was cut off.
pub fn lambert(polygon: &[DVec3], normal: DVec3) -> f64 {
    let above = clip(polygon, normal);
    let edges = (0..above.len()).map(|i| {
        let (p, q) = (above[i], above[(i + 1) % above.len()]);
        p.angle_between(q) * p.cross(q).normalize_or_zero().dot(normal)
    });
    (edges.sum::<f64>() / 2.0).abs()
}

/// Form factor between equal, parallel, opposite rectangles of sides x and y in units of their distance [A13].
pub fn parallel_rectangles(x: f64, y: f64) -> f64 {
    let (rx, ry) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    let log = (rx * ry / (1.0 + x * x + y * y).sqrt()).ln();
    let across = x * ry * (x / ry).atan() + y * rx * (y / rx).atan();
    2.0 / (PI * x * y) * (log + across - x * x.atan() - y * y.atan())
}

/// The mean of `f` over the unit square, by its middles.
pub fn mean_over_square(f: impl Fn(f64, f64) -> f64) -> f64 {
    const N: u32 = 48;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(N);
    (0..N * N).map(|i| f(at(i % N), at(i / N))).sum::<f64>() / f64::from(N * N)
}

/// Lambert's sum has the textbook's value for a square right above: the point form factor of a unit square's corner. Its
/// mean over a square is the form factor of two squares.
#[test]
fn factors_are_the_textbooks() {
    // corner over the point, sides 1 and 1 at height 1: F = 1/(2π) · 2 · 1/√2 · atan(1/√2) (Howell, C-11)
    let square = [v(0., 0., 1.), v(1., 0., 1.), v(1., 1., 1.), v(0., 1., 1.)];
    let want = (1.0 / 2f64.sqrt()) * (1.0 / 2f64.sqrt()).atan() / PI;
    let got = lambert(&square, DVec3::Z) / PI;
    assert!((got - want).abs() < 1e-12, "{got} {want}");
    assert!((parallel_rectangles(1.0, 1.0) - 0.199_825).abs() < 1e-6, "{}", parallel_rectangles(1.0, 1.0));
    let mean = mean_over_square(|x, y| lambert(&square.map(|p| p - v(x, y, 0.)), DVec3::Z)) / PI;
    assert!((mean / parallel_rectangles(1.0, 1.0) - 1.0).abs() < 1e-3, "{mean}");
}
