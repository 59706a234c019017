//! Reach: what lies outside of a closed room that the camera stands in is never met by a path from it.
//!
//! Who starts on one side of a wall and crosses its edges, turning about each to the side that comes next, covers a surface
//! without border: over every edge as many sides are left as entered, and over an open edge one comes to the other side of
//! the same triangle. Such a surface winds about a point a whole number of times, the two sides of a triangle against each
//! other. A point that it winds about at all is cut off by it from everything outside its bounds, however its triangles lie.

use super::PackedScene;
use crate::scene::{Light, LightPlace, Mesh, Scene, Triangle, Wavelengths};
use glam::{DVec3, Vec3};
use rustc_hash::{FxHashMap, FxHashSet};
use std::f64::consts::PI;

/// What is nearer to the walls than this, in internal units, is not told from them: 32 units in the last place of the
/// largest coordinates.
const NEAR: f64 = 1.0 / 512.0;
/// Walls are followed over so many sides, and one for so many triangles of the scene: a search that finds nothing must cost
/// nothing beside the hierarchy.
const SIDES: usize = 4096;
/// See [`SIDES`].
const TRIANGLES_PER_SIDE: usize = 512;
/// Triangles behind each other that are looked for, from the camera along an axis.
const CROSSINGS: usize = 16;

/// A triangle of the scene, and whether its front is meant.
type Side = (u32, bool);
/// An edge's ends, bit by bit, the lesser first.
type EdgeBits = [[u64; 3]; 2];

/// A triangle at an edge.
struct Flap {
    triangle: u32,
    /// Its corners run from the edge's first end to the second: its front looks the way that angles grow.
    forward: bool,
    /// Angle about the edge, rad.
    angle: f64,
}

/// A scene in its hierarchy.
struct Walls<'a> {
    scene: &'a Scene,
    packed: &'a PackedScene,
    /// Triangle of the scene in each leaf slot.
    order: &'a [u32],
}

/// The scene without what cannot be reached from its camera; none where all of it may be.
pub(super) fn within_reach(scene: &Scene, packed: &PackedScene, order: &[u32]) -> Option<Scene> {
    let walls = Walls { scene, packed, order };
    // rooms within rooms: what is outside of any is out of reach
    let crossed = walls.fewest_crossed();
    let most = (SIDES + order.len() / TRIANGLES_PER_SIDE) / crossed.len().max(1);
    let rooms = crossed.into_iter().filter_map(|side| walls.room(side, most));
    let [lo, hi] = rooms.reduce(|[lo, hi], [a, b]| [lo.max(a), hi.min(b)])?;
    let near = NEAR * packed.world_scale;
    let is_outside = |a: DVec3, b: DVec3| a.cmpgt(hi + near).any() || b.cmplt(lo - near).any();
    let is_lost = |light: &Light| match light.place() {
        LightPlace::At(position) => is_outside(position, position),
        LightPlace::Infinity(_) => true,
    };
    // most rooms are the whole scene
    let [a, b] = packed.bounds.map(|p| packed.world_center + p.as_dvec3() * packed.world_scale);
    let all_inside = a.cmpge(lo - near).all() && b.cmple(hi + near).all();
    if all_inside && !scene.lights.iter().any(is_lost) {
        return None;
    }
    let positions = &scene.mesh.positions;
    let is_kept = |t: &&Triangle| {
        let [a, b, c] = t.vertex.map(|v| positions[v as usize]);
        !is_outside(a.min(b).min(c), a.max(b).max(c))
    };
    let triangles: Vec<Triangle> = scene.mesh.triangles.iter().filter(is_kept).copied().collect();
    let kept: Vec<usize> = (0..scene.lights.len()).filter(|&i| !is_lost(&scene.lights[i])).collect();
    let lights: Vec<Light> = kept.iter().map(|&i| scene.lights[i]).collect();
    if triangles.len() == scene.mesh.triangles.len() && lights.len() == scene.lights.len() {
        return None;
    }
    let mesh = Mesh { triangles, ..scene.mesh.without_triangles() };
    let (materials, warnings) = (scene.materials.clone(), scene.warnings.clone());
    let files = scene.files.clone();
    let wavelengths = Wavelengths {
        lights: kept.iter().map(|&i| scene.spectrum_of_light(i).cloned()).collect(),
        ..scene.wavelengths
    };
    let (camera, size) = (scene.camera, scene.size);
    Some(Scene { camera, size, mesh, materials, lights, wavelengths, warnings, files })
}

impl Walls<'_> {
    /// The sides of walls that face the camera along the axis with the fewest, nearest first; none where some axis meets
    /// no wall, since then there is a way out.
    fn fewest_crossed(&self) -> Vec<Side> {
        let mut fewest = Vec::new();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z].into_iter().flat_map(|a| [a, -a]) {
            let crossed = self.crossed(axis);
            if crossed.is_empty() {
                return crossed;
            }
            if fewest.is_empty() || crossed.len() < fewest.len() {
                fewest = crossed;
            }
        }
        fewest
    }

    /// The sides of walls that face the camera along a direction.
    fn crossed(&self, direction: Vec3) -> Vec<Side> {
        let mut sides = Vec::new();
        let mut origin = self.packed.camera.eye;
        let eye = self.scene.camera.position;
        for _ in 0..CROSSINGS {
            let met = self.packed.bvh.closest(&self.packed.triangles, origin, direction, f32::INFINITY);
            let Some(hit) = met else { break };
            let triangle = self.order[hit.triangle as usize];
            if self.is_wall(triangle) {
                let [a, b, c] = self.corners(triangle);
                sides.push((triangle, (b - a).cross(c - a).dot(eye - a) > 0.0));
            }
            origin += direction * (hit.t + NEAR as f32);
        }
        sides
    }

    /// Bounds of the walls that are covered from one side on, world units, where they enclose the camera and have at most so
    /// many sides.
    fn room(&self, start: Side, most: usize) -> Option<[DVec3; 2]> {
        let mut edges: FxHashMap<EdgeBits, Vec<Flap>> = FxHashMap::default();
        let (mut covered, mut known) = (vec![start], FxHashSet::from_iter([start]));
        let mut next = 0;
        while let Some(&side) = covered.get(next) {
            let corners = self.corners(side.0);
            for k in 0..3 {
                let ends = [corners[k], corners[(k + 1) % 3]];
                let (edge, forward) = sorted(ends);
                let flaps = edges.entry(edge.map(bits)).or_insert_with(|| self.flaps(edge));
                let beyond = turn(flaps, side, forward);
                if known.insert(beyond) {
                    covered.push(beyond);
                }
            }
            if covered.len() > most {
                return None;
            }
            next += 1;
        }
        let eye = self.scene.camera.position;
        let near = NEAR * self.packed.world_scale;
        let (mut winding, mut lo, mut hi) = (0.0, DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &(triangle, front) in &covered {
            let [a, b, c] = self.corners(triangle);
            let (low, high) = (a.min(b).min(c), a.max(b).max(c));
            let normal = (b - a).cross(c - a).normalize_or_zero();
            let in_bounds = eye.cmpge(low - near).all() && eye.cmple(high + near).all();
            if in_bounds && (eye - a).dot(normal).abs() < near {
                // the camera may be on either side once it is rounded
                return None;
            }
            let angle = solid_angle([a - eye, b - eye, c - eye]);
            winding += if front { angle } else { -angle };
            (lo, hi) = (lo.min(low), hi.max(high));
        }
        // 0 or at least 4π
        (winding.abs() > 2.0 * PI).then_some([lo, hi])
    }

    /// True where no light passes (nor through what is there in part), and the triangle has three corners.
    fn is_wall(&self, triangle: u32) -> bool {
        let material = self.scene.mesh.triangles[triangle as usize].material;
        let [a, b, c] = self.corners(triangle);
        let material = &self.packed.materials[material as usize];
        let is_whole = !material.flags().passes_light() && material.opacity_texture().is_none();
        is_whole && a != b && b != c && c != a
    }

    fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.scene.mesh.triangles[triangle as usize].vertex.map(|v| self.scene.mesh.positions[v as usize])
    }

    /// The walls at an edge, by their angles about it.
    fn flaps(&self, edge: [DVec3; 2]) -> Vec<Flap> {
        let [p, q] = edge;
        let (x, y) = (q - p).normalize().any_orthonormal_pair();
        let middle = ((0.5 * (p + q) - self.packed.world_center) / self.packed.world_scale).as_vec3();
        let mut flaps = Vec::new();
        self.packed.bvh.near(middle, NEAR as f32, |leaf| {
            let triangle = self.order[leaf as usize];
            let corners = self.corners(triangle);
            let found = (0..3).find(|&k| sorted([corners[k], corners[(k + 1) % 3]]).0 == edge);
            if let Some(k) = found.filter(|_| self.is_wall(triangle)) {
                let to_apex = corners[(k + 2) % 3] - p;
                let angle = to_apex.dot(y).atan2(to_apex.dot(x));
                flaps.push(Flap { triangle, forward: corners[k] == p, angle });
            }
        });
        // of two that lie upon each other the backs touch
        let order = |f: &Flap| (f.forward, f.triangle);
        flaps.sort_by(|a, b| a.angle.total_cmp(&b.angle).then(order(a).cmp(&order(b))));
        flaps
    }
}

/// The side that one comes to from `side` over an edge; `forward` as in [`Flap`].
fn turn(flaps: &[Flap], (triangle, front): Side, forward: bool) -> Side {
    let Some(at) = flaps.iter().position(|f| f.triangle == triangle) else { return (triangle, !front) };
    let upward = front == forward;
    let step = if upward { 1 } else { flaps.len() - 1 };
    let next = &flaps[(at + step) % flaps.len()];
    // it looks back at where one comes from
    (next.triangle, next.forward != upward)
}

/// The ends of an edge in an order of their own, and whether that is the one given.
fn sorted([p, q]: [DVec3; 2]) -> ([DVec3; 2], bool) {
    if bits(p) <= bits(q) { ([p, q], true) } else { ([q, p], false) }
}

/// A place, bit by bit; one zero for both.
fn bits(p: DVec3) -> [u64; 3] {
    (p + DVec3::ZERO).to_array().map(f64::to_bits)
}

/// Solid angle of a triangle from the origin, sr; its sign tells the side (Van Oosterom & Strackee 1983).
fn solid_angle([a, b, c]: [DVec3; 3]) -> f64 {
    let lengths = [a, b, c].map(DVec3::length);
    let across = a.dot(b) * lengths[2] + b.dot(c) * lengths[0] + c.dot(a) * lengths[1];
    2.0 * a.dot(b.cross(c)).atan2(lengths.iter().product::<f64>() + across)
}
