//! Winding: which way the faces of opaque bodies are turned, made alike over each body.
//!
//! A matte face scatters on both sides, so its winding says nothing about the picture; meshes mix it, and double faces with
//! both. But what measures discs asks on which side of a sheet a point lies, and what is buried in a body asks for its
//! outside. So faces that share an edge are turned alike here, closed bodies outward, and rooms toward the camera. Fronts
//! that mean something stay: those that emit, those of glass, and faces of different materials in one place.

use crate::scene::{Scene, Triangle};
use crate::spectrum::is_black;
use glam::DVec3;
use rustc_hash::FxHashMap;
use std::f64::consts::TAU;

/// Part of the sphere of directions that a closed body covers, seen from within, is one; seen from outside none.
const INSIDE: f64 = 0.5;
/// Faces at an edge whose angles about it differ by less, radians, lie in one place: files round positions to six digits.
const ONE_PLACE: f64 = 1e-3;

/// Index of corner `k` of a triangle, where it is turned: its second and third change places.
pub(super) fn corner(turned: bool, k: usize) -> usize {
    if turned { [0, 2, 1][k] } else { k }
}

/// For each triangle of a scene whether its opposite winding is the one to use.
pub(super) fn turned(scene: &Scene) -> Vec<bool> {
    let corners = welded(scene);
    let mut joined = Joined::new(corners.len());
    let mut open = vec![false; corners.len()];
    let mut free: Vec<bool> = scene.mesh.triangles.iter().map(|t| is_free(scene, t)).collect();
    let mut flaps = flaps(&corners);
    for edge in flaps.chunk_by_mut(|a, b| a.edge == b.edge) {
        join(scene, edge, &mut joined, &mut open, &mut free);
    }
    let mut bodies: FxHashMap<u32, Body> = FxHashMap::default();
    for triangle in 0..corners.len() as u32 {
        let (root, against) = joined.root(triangle);
        let body = bodies.entry(root).or_insert(Body { triangles: Vec::new(), closed: true });
        body.closed &= !open[triangle as usize];
        body.triangles.push((triangle, against));
    }
    let mut turned = vec![false; corners.len()];
    for body in bodies.into_values() {
        let all = body.is_against(scene);
        for (triangle, against) in body.triangles {
            turned[triangle as usize] = free[triangle as usize] && against != all;
        }
    }
    turned
}

/// True for a face whose winding says nothing by itself: opaque, and dark.
fn is_free(scene: &Scene, t: &Triangle) -> bool {
    let m = &scene.materials[t.material as usize];
    m.dielectric.is_none() && is_black(&m.emission)
}

/// Corners of each triangle, with one number for all vertices of one position.
fn welded(scene: &Scene) -> Vec<[u32; 3]> {
    let mut known: FxHashMap<[u64; 3], u32> = FxHashMap::default();
    let number = |p: &DVec3| {
        let next = known.len() as u32;
        // minus zero is zero
        *known.entry(p.to_array().map(|x| (x + 0.0).to_bits())).or_insert(next)
    };
    let numbers: Vec<u32> = scene.mesh.positions.iter().map(number).collect();
    scene.mesh.triangles.iter().map(|t| t.vertex.map(|v| numbers[v as usize])).collect()
}

/// A triangle at one of its edges.
struct Flap {
    /// The edge's corners, the lesser first.
    edge: [u32; 2],
    triangle: u32,
    /// Which of its edges.
    side: u8,
    /// The triangle runs along it from the lesser corner to the greater.
    along: bool,
    /// Angle about the edge, radians.
    angle: f64,
}

/// Every triangle at each of its edges, edge by edge.
fn flaps(corners: &[[u32; 3]]) -> Vec<Flap> {
    let mut all = Vec::with_capacity(3 * corners.len());
    for (triangle, c) in (0u32..).zip(corners) {
        for side in 0..3u8 {
            let (a, b) = (c[side as usize], c[(side as usize + 1) % 3]);
            if a != b {
                let edge = [a.min(b), a.max(b)];
                all.push(Flap { edge, triangle, side, along: a < b, angle: 0.0 });
            }
        }
    }
    all.sort_unstable_by_key(|f| (f.edge, f.triangle));
    all
}

/// Join the triangles at an edge: those in one place, and the two places where there are no more.
fn join(scene: &Scene, edge: &mut [Flap], joined: &mut Joined, open: &mut [bool], free: &mut [bool]) {
    let mesh = &scene.mesh;
    let place = |f: &Flap, k: u8| {
        mesh.positions[mesh.triangles[f.triangle as usize].vertex[((f.side + k) % 3) as usize] as usize]
    };
    if edge.len() > 1 {
        let f = &edge[0];
        let (from, to) = if f.along { (place(f, 0), place(f, 1)) } else { (place(f, 1), place(f, 0)) };
        let axis = (to - from).normalize_or_zero();
        let x = (place(f, 2) - from).reject_from_normalized(axis).normalize_or_zero();
        let y = axis.cross(x);
        for f in edge.iter_mut() {
            let d = place(f, 2) - from;
            // the first triangle's place is not cut in two
            f.angle = (d.dot(y).atan2(d.dot(x)) + ONE_PLACE).rem_euclid(TAU);
        }
        edge.sort_by(|a, b| a.angle.total_cmp(&b.angle));
    }
    let mut places: Vec<&Flap> = Vec::new();
    for here in edge.chunk_by(|a, b| b.angle - a.angle < ONE_PLACE) {
        let first = &here[0];
        for other in &here[1..] {
            joined.join(first.triangle, other.triangle, first.along != other.along);
        }
        // fronts of different materials in one place are fronts
        let material = |f: &Flap| mesh.triangles[f.triangle as usize].material;
        if here.iter().any(|f| material(f) != material(first)) {
            here.iter().for_each(|f| free[f.triangle as usize] = false);
        }
        places.push(first);
    }
    match places[..] {
        [a, b] => joined.join(a.triangle, b.triangle, a.along == b.along),
        _ => edge.iter().for_each(|f| open[f.triangle as usize] = true),
    }
}

/// Triangles that share edges.
struct Body {
    /// Triangles, and whether turning them makes all alike.
    triangles: Vec<(u32, bool)>,
    /// Every edge has two sides.
    closed: bool,
}

impl Body {
    /// True where all faces, made alike, show the camera or the outside their backs. Open bodies go with most of
    /// their area.
    fn is_against(&self, scene: &Scene) -> bool {
        let mesh = &scene.mesh;
        let eye = scene.camera.position;
        let vertices = |triangle: u32, flipped: bool| {
            let v = mesh.triangles[triangle as usize].vertex;
            [0, 1, 2].map(|k| mesh.positions[v[corner(flipped, k)] as usize])
        };
        // volume about a point of the body, the sphere that it covers from the eye, and who agrees
        let origin = self.triangles.first().map_or(DVec3::ZERO, |&(i, _)| vertices(i, false)[0]);
        let (mut volume, mut covered, mut agrees) = (0.0, 0.0, 0.0);
        for &(i, flipped) in &self.triangles {
            let [a, b, c] = vertices(i, flipped);
            let normal = (b - a).cross(c - a);
            volume += (a - origin).dot(normal);
            covered += solid_angle([a, b, c].map(|p| p - eye));
            agrees += if flipped { -normal.length() } else { normal.length() };
        }
        let covered = covered / (2.0 * TAU);
        if !self.closed {
            agrees < 0.0
        } else if covered.abs() > INSIDE {
            covered > 0.0
        } else {
            volume < 0.0
        }
    }
}

/// Signed solid angle of a triangle from the origin, positive where its back is seen (Van Oosterom & Strackee 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let [la, lb, lc] = [a, b, c].map(DVec3::length);
    let numerator = a.dot(b.cross(c));
    let denominator = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    2.0 * numerator.atan2(denominator)
}

/// Faces that are joined, and which of them are wound against each other (union-find with parity).
struct Joined {
    parent: Vec<(u32, bool)>,
}

impl Joined {
    fn new(faces: usize) -> Self {
        Self { parent: (0..faces as u32).map(|i| (i, false)).collect() }
    }

    /// The root of a face, and whether the face is wound against it.
    fn root(&mut self, face: u32) -> (u32, bool) {
        let (mut at, mut against) = (face, false);
        while self.parent[at as usize].0 != at {
            let (next, turned) = self.parent[at as usize];
            // halve the way for those that follow
            let (after, further) = self.parent[next as usize];
            self.parent[at as usize] = (after, turned != further);
            against ^= turned != further;
            at = after;
        }
        (at, against)
    }

    /// Two faces share an edge; `against`: both run along it the same way. A strip with one side only keeps a seam.
    fn join(&mut self, a: u32, b: u32, against: bool) {
        let ((a, a_against), (b, b_against)) = (self.root(a), self.root(b));
        if a != b {
            self.parent[b as usize] = (a, against ^ a_against ^ b_against);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From its middle a tetrahedron covers the whole sphere, from outside nothing; inside out the sign is the other.
    #[test]
    fn bodies_cover_the_sphere_from_within() {
        let v = [[1., 1., 1.], [1., -1., -1.], [-1., 1., -1.], [-1., -1., 1.]].map(DVec3::from_array);
        let faces = [[0, 1, 2], [0, 2, 3], [0, 3, 1], [1, 3, 2]];
        for (eye, wanted) in [(DVec3::splat(0.1), 1.0), (DVec3::new(2.0, 0.3, 0.1), 0.0)] {
            let sum = |turn: bool| -> f64 {
                let of = |f: &[usize; 3]| solid_angle([0, 1, 2].map(|k| v[f[corner(turn, k)]] - eye));
                faces.iter().map(of).sum::<f64>() / (2.0 * TAU)
            };
            assert!((sum(false) - wanted).abs() < 1e-12 && (sum(true) + wanted).abs() < 1e-12, "{eye}");
        }
    }
}
