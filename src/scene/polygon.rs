// Polygon: splits a face with any number of corners into triangles.
//
// Convex faces become a fan from the first corner (the split that exporters assume); others are cut by ears in
// the plane of their mean normal. Either way the triangles turn the way the face turns.

use super::ears;
use glam::{DVec2, DVec3};

/// Polygons of more corners are cut by ears in a time that does not grow as their square; convex ones, too, because a fan of
/// so many slivers makes every ray that comes near meet most of them.
const MANY: usize = 512;

/// Triangles, as indices into `corners`, of a face.
pub(crate) fn triangulate(corners: &[DVec3]) -> Vec<[usize; 3]> {
    let count = corners.len();
    let fan = || (2..count).map(|i| [0, i - 1, i]).collect();
    if count <= 3 {
        return fan();
    }
    let flat = project(corners);
    if count > MANY {
        let triangles = ears::cut(&flat);
        return if triangles.is_empty() { fan() } else { triangles };
    }
    if is_convex(&flat) {
        return fan();
    }
    let mut ears: Vec<usize> = Vec::new();
    earcut::Earcut::new().earcut(flat.iter().map(|p| [p.x, p.y]), &[], &mut ears);
    let turn = |&[a, b, c]: &[usize; 3]| (flat[b] - flat[a]).perp_dot(flat[c] - flat[a]);
    let triangles: Vec<[usize; 3]> =
        ears.as_chunks::<3>().0.iter().map(|t| if turn(t) < 0.0 { [t[0], t[2], t[1]] } else { *t }).collect();
    if triangles.is_empty() { fan() } else { triangles }
}

/// Coordinates in the plane across the face's mean normal (Newell), counter-clockwise.
fn project(corners: &[DVec3]) -> Vec<DVec2> {
    let origin = corners[0];
    let next = corners.iter().cycle().skip(1);
    let normal: DVec3 = corners.iter().zip(next).map(|(a, b)| (a - origin).cross(b - origin)).sum();
    let (u, v) = normal.try_normalize().unwrap_or(DVec3::Z).any_orthonormal_pair();
    corners.iter().map(|p| DVec2::new((p - origin).dot(u), (p - origin).dot(v))).collect()
}

fn is_convex(flat: &[DVec2]) -> bool {
    let count = flat.len();
    (0..count).all(|i| {
        let (a, b, c) = (flat[i], flat[(i + 1) % count], flat[(i + 2) % count]);
        (b - a).perp_dot(c - b) >= 0.0
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[DVec3]) -> f64 {
        let part = |[a, b, c]: [usize; 3]| (corners[b] - corners[a]).cross(corners[c] - corners[a]).y / 2.0;
        triangulate(corners).into_iter().map(part).inspect(|a| assert!(*a >= 0.0, "turned over")).sum()
    }

    /// A concave arrow head keeps its area, whichever corner comes first; a fan would cover ground outside it.
    #[test]
    fn concave_faces_keep_their_area() {
        let mut arrow = [(0., 0.), (-1., -1.), (2., 0.), (-1., 1.)].map(|(x, z)| DVec3::new(x, 7.0, -z));
        for _ in 0..4 {
            arrow.rotate_left(1);
            assert!((area(&arrow) - 2.0).abs() < 1e-12, "{}", area(&arrow));
        }
    }

    /// Convex faces are split as a fan from their first corner.
    #[test]
    fn convex_faces_are_fans() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        assert_eq!(triangulate(&square), [[0, 1, 2], [0, 2, 3]]);
    }
}
