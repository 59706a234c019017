//! Contacts: whether some faces lie in one place, or so near each other that rounded distances do not tell which of them a ray
//! meets first. Where there are none, kernels do not ask [E27].

use super::PackedTriangle;
use crate::packed::accel::Bvh;
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Planes nearer to each other than this, internal units, are asked about: more than f32 rounds a distance across the scene.
const NEAR: f32 = 1.0 / 128.0;
/// Cosine between the normals of faces that lie in one plane.
const ALONG: f32 = 0.9;
/// Faces overlap by more than this part of their extent; neighbours share an edge, but for rounding.
const OVERLAP: f32 = 1e-4;
/// Candidates looked at for each triangle, on average. Where more are close to each other the answer is yes: asking too much
/// costs a little time, nothing else.
const CANDIDATES: usize = 256;

/// True where two of `triangles`, in the order of `bvh`, may lie in one place.
pub(super) fn any(bvh: &Bvh, triangles: &[PackedTriangle]) -> bool {
    let looked_at = AtomicUsize::new(0);
    let most = CANDIDATES * triangles.len();
    (0..triangles.len() as u32).into_par_iter().any(|i| {
        let t = &triangles[i as usize];
        let [a, b, c] = t.vertices();
        let normal = t.normal();
        let bounds = [a.min(b).min(c) - NEAR, a.max(b).max(c) + NEAR];
        let (mut count, mut found) = (0, false);
        bvh.within(bounds, |j| {
            count += 1;
            found = found || (j > i && is_contact(t, normal, &triangles[j as usize]));
        });
        found || looked_at.fetch_add(count, Ordering::Relaxed) + count > most
    })
}

/// True where a triangle with its unit normal and another one lie in one plane and overlap.
fn is_contact(t: &PackedTriangle, normal: Vec3, other: &PackedTriangle) -> bool {
    let offset = (other.v0 - t.v0).dot(normal);
    let [rise_1, rise_2] = [other.e1.dot(normal), other.e2.dot(normal)];
    // the plane of `t` passes by the other one, or through it
    let heights = [offset, offset + rise_1, offset + rise_2];
    let nearest = if heights.iter().any(|h| *h > 0.0) && heights.iter().any(|h| *h < 0.0) {
        0.0
    } else {
        heights.iter().fold(f32::INFINITY, |least, h| least.min(h.abs()))
    };
    if nearest > NEAR {
        return false;
    }
    let across = other.e1.cross(other.e2);
    if across.dot(normal).abs() < ALONG * across.length() {
        return false;
    }
    let (x, y) = normal.any_orthonormal_pair();
    let flat = |p: Vec3| Vec2::new((p - t.v0).dot(x), (p - t.v0).dot(y));
    let [p, q] = [t, other].map(|t| t.vertices().map(flat));
    !is_apart(&p, &q) && !is_apart(&q, &p)
}

/// True where a line along an edge of `p` lies between the triangles, or all but does.
fn is_apart(p: &[Vec2; 3], q: &[Vec2; 3]) -> bool {
    (0..3).any(|k| {
        let across = (p[(k + 1) % 3] - p[k]).perp();
        let range = |t: &[Vec2; 3]| {
            t.iter()
                .map(|v| (*v - p[k]).dot(across))
                .fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), d| (low.min(d), high.max(d)))
        };
        let ((p_low, p_high), (q_low, q_high)) = (range(p), range(q));
        let extent = (p_high - p_low).min(q_high - q_low);
        p_high.min(q_high) - p_low.max(q_low) <= OVERLAP * extent
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::packed::NO_EMITTER;

    fn triangle([a, b, c]: [Vec3; 3]) -> PackedTriangle {
        PackedTriangle { v0: a, material: 0, e1: b - a, flags: 0, e2: c - a, emitter: NO_EMITTER }
    }

    fn any_of(vertices: &[[Vec3; 3]]) -> bool {
        let (bvh, order) = Bvh::build(vertices);
        let triangles: Vec<_> = order.iter().map(|&i| triangle(vertices[i as usize])).collect();
        any(&bvh, &triangles)
    }

    /// Doubled faces, turned ones, cut otherwise and partly over each other touch; neighbours, and faces apart, do not.
    #[test]
    fn faces_that_overlap_in_one_plane_touch() {
        let turn = glam::Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.9, 1.3);
        for turn in [glam::Quat::IDENTITY, turn] {
            let at = |x: f32, y: f32, z: f32| turn * Vec3::new(100.0 * x, 100.0 * y, 100.0 * z);
            let square = |x: f32, y: f32, z: f32| {
                let [a, b, c, d] = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(u, v)| at(x + u, y + v, z));
                [[a, b, c], [a, c, d]]
            };
            let base = square(0.0, 0.0, 0.0);
            let with = |more: &[[Vec3; 3]]| any_of(&[&base[..], more].concat());
            assert!(!with(&[]), "one square");
            assert!(!with(&square(1.0, 0.0, 0.0)), "its neighbour");
            assert!(!with(&square(0.0, 0.0, 0.01)), "one unit apart");
            assert!(!with(&[[at(0., 0., 0.), at(1., 0., 0.), at(0.5, 0., 1.)]]), "a wall on it");
            assert!(with(&base), "a copy");
            assert!(with(&square(0.5, 0.5, 0.0)), "partly");
            assert!(with(&square(0.2, 0.1, 5e-6)), "nearly");
            assert!(with(&[[at(0.4, 0.4, 0.), at(0.4, 0.5, 0.), at(0.5, 0.4, 0.)]]), "a small one, turned");
        }
    }
}
