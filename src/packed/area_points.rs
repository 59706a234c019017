//! Area points: an even sample of the diffuse surfaces, each point standing for the same area. Discs that lose a part of
//! themselves at edges and corners are measured with them.

use super::constants::{ONE_PLANE, ONE_SURFACE};
use super::{EmitterKind, PackedScene, PackedTriangle};
use crate::sampling::rng;
use crate::sampling::rng::purpose::{DIMENSION_AREA, DIMENSION_BURIED, DIMENSION_TRUST};
use glam::Vec3;
use std::f32::consts::TAU;

/// A point on a diffuse surface.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AreaPoint {
    /// Position, internal units.
    pub position: Vec3,
    /// Unit front normal of its triangle.
    pub normal: Vec3,
}

/// Steps of the R2 lattice (Roberts 2018): inverse powers of the plastic number.
const R2: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// Where a line through a point leaves the plane, in tangents: along the axes it would run in the bounds' faces.
const ASLANT: Vec3 = Vec3::new(0.031, 0.057, 0.043);

/// True for a point of triangle `index` that lies on an earlier diffuse triangle, too: doubled faces are one surface,
/// however they are cut. Light falls on them once.
fn is_doubled(scene: &PackedScene, index: usize, position: Vec3, normal: Vec3) -> bool {
    scene.bvh.any_near(position, (normal + ASLANT).normalize(), ONE_SURFACE, |other| {
        let t = &scene.triangles[other as usize];
        (other as usize) < index
            && scene.materials[t.material as usize].flags().stores()
            && t.normal().dot(normal).abs() > ONE_PLANE
            && (position - t.v0).dot(t.normal()).abs() < ONE_SURFACE
            && holds(t, position)
    })
}

/// True where a point of the triangle's plane lies in it; in f64, so that neighbours share no point but by the rounding of
/// the point itself.
fn holds(t: &PackedTriangle, point: Vec3) -> bool {
    let [e1, e2, s] = [t.e1, t.e2, point - t.v0].map(|v| v.as_dvec3());
    let n = e1.cross(e2);
    let (u, v) = (s.cross(e2).dot(n), e1.cross(s).dot(n));
    u >= 0.0 && v >= 0.0 && u + v <= n.length_squared()
}

/// About `count` points and the area of each, internal units². Systematic along the cumulative area, so that a
/// triangle's number of points is its area's share to within one; a shifted R2 lattice within a triangle.
pub fn scatter(scene: &PackedScene, count: usize, seed: u32) -> (Vec<AreaPoint>, f32) {
    let each = scene.diffuse_area / count.max(1) as f64;
    let mut points = Vec::with_capacity(count + 1);
    let solids = has_closed_solids(scene);
    if each <= 0.0 {
        return (points, 0.0);
    }
    let mut next = f64::from(rng::random4(seed, 0, u32::MAX, DIMENSION_AREA)[0]) * each;
    let mut before = 0.0;
    for (index, t) in scene.triangles.iter().enumerate() {
        if !scene.materials[t.material as usize].flags().stores() {
            continue;
        }
        let end = before + f64::from(t.area());
        if next < end {
            let normal = t.normal();
            let shift = rng::random4(seed, 0, index as u32, DIMENSION_AREA + 1);
            let mut i = 0.0;
            while next < end {
                let x = (f64::from(shift[0]) + i * R2[0]).fract() as f32;
                let y = (f64::from(shift[1]) + i * R2[1]).fract() as f32;
                let [u, v] = square_to_triangle([x, y]);
                let position = t.v0 + t.e1 * u + t.e2 * v;
                let number = points.len() as u32;
                let hidden = is_doubled(scene, index, position, normal)
                    || (solids && is_buried(scene, position, normal, number));
                if !hidden {
                    points.push(AreaPoint { position, normal });
                }
                next += each;
                i += 1.0;
            }
        }
        before = end;
    }
    (points, each as f32)
}

/// Rays that must all meet the inside of something for a point to be buried in it.
const BURIED_RAYS: u32 = 6;
/// Rays from the lights that tell whether fronts and backs can be trusted, and how many may meet a back.
const TRUST_RAYS: u32 = 512;
const TRUST_SHARE: f32 = 0.02;
/// Rays leave a surface this far above it; surfaces nearer than that are taken for the same.
const LIFT: f32 = 0.02;

/// True where light meets hardly any back of an opaque surface: then a back means the inside of a closed body.
fn has_closed_solids(scene: &PackedScene) -> bool {
    let backs = (0..TRUST_RAYS)
        .filter(|&i| {
            let u = rng::random4(0, 0, i, DIMENSION_TRUST);
            let v = rng::random4(0, 0, i, DIMENSION_TRUST + 1);
            let picked = scene.emitters.iter().find(|e| u[0] < e.cumulative).or(scene.emitters.last());
            let Some(e) = picked else { return false };
            let (origin, direction) = if e.kind == EmitterKind::Triangle as u32 {
                let [b, c] = square_to_triangle([u[1], u[2]]);
                let normal = e.e1.cross(e.e2).normalize_or_zero();
                (e.origin + e.e1 * b + e.e2 * c + normal * LIFT, cosine_direction(normal, v[0], v[1]))
            } else if e.kind == EmitterKind::Sun as u32 {
                let (x, y) = e.e1.any_orthonormal_pair();
                let (r, phi) = (u[1].sqrt() * e.e2.x, TAU * u[2]);
                (e.origin + (x * phi.cos() + y * phi.sin()) * r, e.e1)
            } else {
                let z = 1.0 - 2.0 * v[0];
                let (r, phi) = ((1.0 - z * z).max(0.0).sqrt(), TAU * v[1]);
                (e.position(), Vec3::new(r * phi.cos(), r * phi.sin(), z))
            };
            meets_back(scene, origin, direction)
        })
        .count();
    (backs as f32) < TRUST_SHARE * TRUST_RAYS as f32
}

/// True for a point whose front lies inside a closed body: the floor under a box that stands on it. No light gets there,
/// and a disc beside the box must not count it.
fn is_buried(scene: &PackedScene, position: Vec3, normal: Vec3, number: u32) -> bool {
    (0..BURIED_RAYS).all(|i| {
        let u = rng::random4(0, 0, number, DIMENSION_BURIED + i);
        meets_back(scene, position + normal * LIFT, cosine_direction(normal, u[0], u[1]))
    })
}

/// True where a ray first meets the back of a triangle through which no light comes.
fn meets_back(scene: &PackedScene, origin: Vec3, direction: Vec3) -> bool {
    scene.bvh.closest(&scene.triangles, origin, direction, f32::INFINITY).is_some_and(|h| {
        let t = &scene.triangles[h.triangle as usize];
        !scene.materials[t.material as usize].flags().passes_light() && direction.dot(t.normal()) > 0.0
    })
}

/// A direction about a normal, with probability proportional to the cosine.
fn cosine_direction(normal: Vec3, u: f32, v: f32) -> Vec3 {
    let (x, y) = normal.any_orthonormal_pair();
    let (r, phi) = (u.sqrt(), TAU * v);
    (x * phi.cos() + y * phi.sin()) * r + normal * (1.0 - u).max(0.0).sqrt()
}

/// The map of least distortion from the square to barycentric coordinates; keeps areas (Heitz 2019).
fn square_to_triangle([x, y]: [f32; 2]) -> [f32; 2] {
    if y > x { [0.5 * x, y - 0.5 * x] } else { [x - 0.5 * y, 0.5 * y] }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Both halves of the map keep areas: the first moments are those of the triangle.
    #[test]
    fn map_to_triangle_is_uniform() {
        let n = 1000;
        let mut sum = [0.0f64; 2];
        for i in 0..n * n {
            let p = square_to_triangle([(i % n) as f32 / n as f32, (i / n) as f32 / n as f32]);
            assert!(p[0] >= 0.0 && p[1] >= 0.0 && p[0] + p[1] <= 1.0 + 1e-6);
            sum = [sum[0] + f64::from(p[0]), sum[1] + f64::from(p[1])];
        }
        for s in sum {
            assert!((s / f64::from(n * n) - 1.0 / 3.0).abs() < 1e-3);
        }
    }
}
