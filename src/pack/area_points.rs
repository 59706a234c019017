//! Area points: places scattered evenly over the diffuse surfaces, each standing for the same area.
//!
//! They measure how much surface lies within a radius, where a disc reaches over an edge or into a corner.

use super::{PackedScene, PackedTriangle};
use glam::Vec3;

/// A place on a diffuse surface; stands for both of its sides.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct AreaPoint {
    /// Internal units.
    pub position: Vec3,
    /// Padding.
    pub pad0: f32,
    /// Unit geometric normal of the front.
    pub normal: Vec3,
    /// Padding.
    pub pad1: f32,
}

/// 1/ρ and 1/ρ² with ρ³ = ρ + 1: the R2 sequence (Roberts 2018).
const R2: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];

/// About `count` area points over all triangles with a diffuse or glossy lobe, and the area that each stands for.
///
/// Systematic along the cumulative area in leaf order, so every region gets its share to within one point; in the
/// triangle an R2 lattice shifted by `seed`.
pub fn scatter(scene: &PackedScene, count: u32, seed: u32) -> (Vec<AreaPoint>, f32) {
    let count = count.max(1);
    let area_each = scene.diffuse_area / f64::from(count);
    if area_each <= 0.0 {
        return (Vec::new(), 0.0);
    }
    let [start, x0, y0, _] = crate::rng::random4(seed, 0, 0, 0).map(f64::from);
    let mut points = Vec::with_capacity(count as usize + 1);
    let mut area_before = 0.0;
    let diffuse = |t: &&PackedTriangle| scene.materials[t.material as usize].flags().has_diffuse();
    for t in scene.triangles.iter().filter(diffuse) {
        let area_after = area_before + f64::from(t.area());
        let normal = t.normal();
        while (points.len() as f64 + start) * area_each < area_after {
            let i = points.len() as f64;
            let [b, c] = to_triangle([(x0 + i * R2[0]).fract(), (y0 + i * R2[1]).fract()]);
            let position = t.v0 + t.e1 * b + t.e2 * c;
            points.push(AreaPoint { position, pad0: 0.0, normal, pad1: 0.0 });
        }
        area_before = area_after;
    }
    (points, area_each as f32)
}

/// The unit square to barycentric weights, area-preserving and with little distortion (Heitz 2019).
fn to_triangle([mut x, mut y]: [f64; 2]) -> [f32; 2] {
    if y > x {
        x *= 0.5;
        y -= x;
    } else {
        y *= 0.5;
        x -= y;
    }
    [x as f32, y as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform over the triangle: E[b] = 1/3, E[b²] = 1/6, E[b c] = 1/12.
    #[test]
    fn lattice_covers_a_triangle_evenly() {
        let n = 10_000;
        let mut moments = [0.0f64; 5];
        for i in 0..n {
            let i = f64::from(i);
            let [b, c] = to_triangle([(i * R2[0]).fract(), (i * R2[1]).fract()]).map(f64::from);
            assert!(b >= 0.0 && c >= 0.0 && b + c <= 1.0 + 1e-6);
            for (m, x) in moments.iter_mut().zip([b, c, b * b, c * c, b * c]) {
                *m += x / f64::from(n);
            }
        }
        for (got, want) in moments.iter().zip([1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0, 1.0 / 6.0, 1.0 / 12.0]) {
            assert!((got - want).abs() < 1e-3, "{got} {want}");
        }
    }
}
