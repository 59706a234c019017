//! The bounding volume hierarchy: a compressed wide BVH (Ylitie et al. 2017), built by obvhs.
//!
//! The only file that names obvhs. Triangles are reordered to leaf order on the way, so that a leaf's
//! primitive index is a triangle's index.

mod split;

use glam::{UVec2, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris, bvh2_to_cwbvh::bvh2_to_cwbvh, node::CwBvhNode};
use obvhs::ray::{Ray, RayHit};
use obvhs::{BvhBuildParams, traverse, triangle::Triangle};
use std::time::Duration;

/// Leaves hold at most this many triangles: the format has three bits for the count.
const TRIANGLES_PER_LEAF: u32 = 3;

/// Above this many triangles a cheaper build is used: set-up must not outlast the render.
const FAST_BUILD_ABOVE: usize = 2_000_000;

/// One node as the kernels read it: five `vec4<u32>`. Words: origin xyz and exponents with the inner mask;
/// child base, triangle base, meta ×2; quantised bounds of x, y, z (min ×2, max ×2 each).
pub type Node = [[u32; 4]; 5];

/// A hierarchy over triangles; see [`Bvh::build`] for their order.
#[derive(Debug, Clone)]
pub struct Bvh {
    wide: CwBvh,
}

/// Where a ray met a triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// Index of the triangle, leaf order.
    pub triangle: u32,
    /// Distance in units of the ray's direction.
    pub t: f32,
    /// Barycentric weight of the second vertex.
    pub u: f32,
    /// Barycentric weight of the third vertex.
    pub v: f32,
}

/// What a traversal asks of a triangle.
pub trait Face {
    /// First vertex, and the edges from it to the second and third.
    fn edges(&self) -> [Vec3; 3];

    /// Which of several faces in one place a ray meets: the one of the highest rank. `is_front`: the ray comes from the side
    /// where the vertices run counter-clockwise.
    fn rank(&self, is_front: bool) -> u32;
}

impl Bvh {
    /// Build over `vertices`; also returns for each leaf slot the index of the triangle that belongs there.
    pub fn build(vertices: &[[Vec3; 3]]) -> (Self, Vec<u32>) {
        let triangles: Vec<Triangle> =
            vertices.iter().map(|v| Triangle { v0: v[0].into(), v1: v[1].into(), v2: v[2].into() }).collect();
        let mut params = if triangles.len() > FAST_BUILD_ABOVE {
            BvhBuildParams::fast_build()
        } else {
            BvhBuildParams::medium_build()
        };
        params.max_prims_per_leaf = TRIANGLES_PER_LEAF;
        let boxes: Vec<[Vec3; 2]> =
            vertices.iter().map(|[a, b, c]| [a.min(*b).min(*c), a.max(*b).max(*c)]).collect();
        let mut wide = if split::stalls(&boxes) {
            widened(split::tree(&boxes))
        } else {
            build_cwbvh_from_tris(&triangles, params, &mut Duration::default())
        };
        let order = std::mem::take(&mut wide.primitive_indices);
        (Self { wide }, order)
    }

    /// The nodes in the layout of the kernels.
    pub fn nodes(&self) -> &[Node] {
        bytemuck::cast_slice(&self.wide.nodes)
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.wide.nodes.len()
    }

    /// Levels of inner nodes.
    pub fn depth(&self) -> u32 {
        let mut deepest = 0;
        let mut open = vec![(0usize, 1u32)];
        while let Some((index, level)) = open.pop() {
            let Some(node) = self.wide.nodes.get(index) else { continue };
            deepest = deepest.max(level);
            let children = node.imask.count_ones() as usize;
            let first = node.child_base_idx as usize;
            open.extend((first..first + children).map(|child| (child, level + 1)));
        }
        deepest
    }

    /// The nearest triangle with distance in `(0, t_max)`; `direction` is a unit vector. Of faces in one place the one of the
    /// highest [`Face::rank`].
    pub fn closest<T: Face>(
        &self,
        triangles: &[T],
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
    ) -> Option<Hit> {
        self.closest_from_within(triangles, origin, direction, t_max, 0.0, |_, _, _| true)
    }

    /// The same for a ray out of a body, which starts a little inside of it: back faces nearer than `t_back` do not count (front faces where it
    /// is negative), nor does what
    /// does not stop it: it is asked for a triangle and the weights of its second and third vertex.
    pub(crate) fn closest_from_within<T: Face>(
        &self,
        triangles: &[T],
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
        t_back: f32,
        stops: impl Fn(u32, f32, f32) -> bool,
    ) -> Option<Hit> {
        let mut nearest: Option<(Hit, f32)> = None;
        let (from, along) = (Vec3A::from(origin), Vec3A::from(direction));
        self.wide.ray_traverse(ray(origin, direction, t_max), &mut RayHit::none(), |_, id| {
            let Some(m) = meet(from, along, &triangles[id]) else { return f32::INFINITY };
            if m.t >= t_max || m.t <= if m.is_front { -t_back } else { t_back } {
                return f32::INFINITY;
            }
            let hit = Hit { triangle: id as u32, t: m.t, u: m.u, v: m.v };
            let is_first = nearest.is_none_or(|(best, error)| {
                let apart = m.t - best.t;
                if apart.abs() > m.t_error + error {
                    return apart < 0.0;
                }
                let near = origin + direction * best.t;
                let [new, old] =
                    [id, best.triangle as usize].map(|i| Crossing::of(near, direction, &triangles[i]));
                new.comes_before(&old).unwrap_or(hit.triangle < best.triangle)
            });
            if !is_first || !stops(id as u32, m.u, m.v) {
                return f32::INFINITY;
            }
            nearest = Some((hit, m.t_error));
            // what lies in the same place is looked at, too
            (m.t + m.t_error) * OBVHS_UNITS
        });
        nearest.map(|(hit, _)| hit)
    }

    /// True where some triangle lies in `(0, t_max)`, in units of the ray's direction.
    pub fn occluded<T: Face>(&self, triangles: &[T], origin: Vec3, direction: Vec3, t_max: f32) -> bool {
        let (from, along) = (Vec3A::from(origin), Vec3A::from(direction));
        !self.wide.ray_traverse_miss(ray(origin, direction, t_max), |_, id| {
            match meet(from, along, &triangles[id]) {
                Some(m) if m.t < t_max => 0.0,
                _ => f32::INFINITY,
            }
        })
    }

    /// True where some triangle lies between two points.
    pub fn stands_between<T: Face>(&self, triangles: &[T], from: Vec3, to: Vec3) -> bool {
        self.stops_between(triangles, from, to, 0.0, |_, _, _| true)
    }

    /// True where some triangle that stops a ray lies between two points: it is asked for a triangle and the weights of its second and
    /// third vertex. `t_back` is as in [`Bvh::closest_from_within`], a part of the way.
    pub(crate) fn stops_between<T: Face>(
        &self,
        triangles: &[T],
        from: Vec3,
        to: Vec3,
        t_back: f32,
        stops: impl Fn(u32, f32, f32) -> bool,
    ) -> bool {
        let direction = to - from;
        let (origin, along) = (Vec3A::from(from), Vec3A::from(direction));
        !self.wide.ray_traverse_miss(ray(from, direction, 1.0), |_, id| {
            let Some(m) = meet(origin, along, &triangles[id]) else { return f32::INFINITY };
            if m.t <= if m.is_front { -t_back } else { t_back } {
                return f32::INFINITY;
            }
            let apart = m.t - 1.0;
            let is_before = if apart.abs() > m.t_error + END_ROUNDING {
                apart < 0.0
            } else {
                Crossing::of(to, direction, &triangles[id]).t < 0.0
            };
            if is_before && stops(id as u32, m.u, m.v) { 0.0 } else { f32::INFINITY }
        })
    }

    /// Nodes and triangles that a kernel looks at to find the nearest triangle in `(0, t_max)`, or just any; `direction` is a unit
    /// vector.
    pub fn steps<T: Face>(
        &self,
        triangles: &[T],
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
        any: bool,
    ) -> u32 {
        let mut ray = ray(origin, direction, t_max);
        let (from, along) = (Vec3A::from(origin), Vec3A::from(direction));
        let mut state = self.wide.new_traversal(ray.direction);
        let mut node;
        let mut steps = 0;
        let node_hits = |node: &CwBvhNode, ray: &Ray, steps: &mut u32, oct_inv4| {
            *steps += 1;
            node.intersect_ray(ray, oct_inv4)
        };
        traverse!(self.wide, node, state, node_hits(node, &ray, &mut steps, state.oct_inv4), {
            steps += 1;
            let hit = meet(from, along, &triangles[state.primitive_id as usize]);
            if let Some(m) = hit.filter(|m| m.t * OBVHS_UNITS < ray.tmax) {
                ray.tmax = m.t * OBVHS_UNITS;
                if any {
                    return steps;
                }
            }
        });
        steps
    }

    /// Ask `visit` to look at every triangle whose bounds come within `reach` of a point along each axis, and at some others.
    pub fn near(&self, point: Vec3, reach: f32, visit: impl FnMut(u32)) {
        self.within([point - reach, point + reach], visit);
    }

    /// Ask `visit` to look at every triangle whose bounds meet a box, and at some others.
    pub fn within(&self, [low, high]: [Vec3; 2], mut visit: impl FnMut(u32)) {
        let about = Aabb::new(low.into(), high.into());
        let mut state = self.wide.new_traversal(Vec3A::ONE);
        let mut node;
        traverse!(self.wide, node, state, node.intersect_aabb(&about, state.oct_inv4), {
            visit(state.primitive_id);
        });
    }

    /// True where `accept` takes a triangle near a point: it is asked for all whose bounds the line through the point meets
    /// within `reach` of it, until it takes one.
    pub fn any_near(
        &self,
        point: Vec3,
        along: Vec3,
        reach: f32,
        mut accept: impl FnMut(u32) -> bool,
    ) -> bool {
        let line = ray(point - along * reach, along, 2.0 * reach);
        !self.wide.ray_traverse_miss(line, |_, id| if accept(id as u32) { 0.0 } else { f32::INFINITY })
    }
}

/// A compressed wide hierarchy from a binary one.
fn widened((nodes, order): (Vec<split::SplitNode>, Vec<u32>)) -> CwBvh {
    let node = |n: &split::SplitNode| {
        let [low, high] = n.bounds;
        Bvh2Node::new(Aabb { min: low.into(), max: high.into() }, n.count, n.first)
    };
    let binary = Bvh2 {
        nodes: nodes.iter().map(node).collect(),
        primitive_indices: order,
        children_are_ordered_after_parents: true,
        ..Bvh2::default()
    };
    bvh2_to_cwbvh(&binary, TRIANGLES_PER_LEAF, true, false)
}

/// obvhs leaves out boxes that end before t = 1e-4. Its rays get a direction this many times shorter, a power of two, so that
/// no box of a scene ends there: what lies at a distance t has this many times as much of it.
const OBVHS_UNITS: f32 = (1 << 20) as f32;

/// Smallest divisor of a ray's direction.
const TINY: f32 = 1e-20;

/// A ray for the boxes of obvhs. Its own divides by nothing smaller than 1e-7, and takes the sign of a negative zero for the
/// reciprocal and not for the octant.
fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> Ray {
    let divisor = |x: f32| if x.abs() >= TINY { x } else { TINY.copysign(x + 0.0) };
    let [x, y, z] = direction.to_array().map(divisor);
    let safe = Vec3A::new(x, y, z);
    Ray {
        origin: origin.into(),
        direction: safe / OBVHS_UNITS,
        inv_direction: safe.recip() * OBVHS_UNITS,
        tmin: 0.0,
        tmax: t_max * OBVHS_UNITS,
    }
}

/// Barycentric slack: rays that meet an edge hit one triangle or the other, never neither …
pub(crate) const EDGE_SLACK: f32 = 1e-6;
/// … and part of |origin − v0| |edge| / |determinant| by which the rounding of f32 moves a weight, eight half units in the
/// last place: small triangles far from the ray's origin have seams that no constant closes.
pub(crate) const EDGE_ROUNDING: f32 = 8.0 / (1 << 24) as f32;
/// A ray that lies in the triangle's plane, but for rounding, has no weights: the slack ends here.
pub(crate) const EDGE_SLACK_MAX: f32 = 1.0;

/// Where a ray meets a triangle.
struct Meeting {
    /// Distance in units of the ray's direction, and how far rounding may move it.
    t: f32,
    t_error: f32,
    /// Barycentric weights of the second and third vertex.
    u: f32,
    v: f32,
    /// The ray comes from the side where the vertices run counter-clockwise.
    is_front: bool,
}

/// Where a ray meets a triangle from either side (Möller & Trumbore 1997).
#[inline(always)]
fn meet<T: Face>(origin: Vec3A, direction: Vec3A, triangle: &T) -> Option<Meeting> {
    let [v0, e1, e2] = triangle.edges().map(Vec3A::from);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    let inv_det = 1.0 / det;
    let s = origin - v0;
    let u = s.dot(p) * inv_det;
    let q = s.cross(e1);
    let v = direction.dot(q) * inv_det;
    let t = e2.dot(q) * inv_det;
    let largest = |edge: Vec3A| edge.abs().max_element();
    let rounding = EDGE_ROUNDING * largest(s) * inv_det.abs();
    let [long_1, long_2] = [largest(e1), largest(e2)];
    let slack = |long: f32| (EDGE_SLACK + rounding * long).min(EDGE_SLACK_MAX);
    let (slack_u, slack_v) = (slack(long_2), slack(long_1));
    let is_met = u >= -slack_u && v >= -slack_v && u + v <= 1.0 + slack_u.max(slack_v);
    (is_met && t > 0.0 && det != 0.0).then_some(Meeting {
        t,
        t_error: rounding * long_1 * long_2,
        u,
        v,
        is_front: det > 0.0,
    })
}

/// Part of the distance between two points by which its rounding, and that of the direction, moves the end of a ray.
pub(crate) const END_ROUNDING: f32 = 8.0 / (1 << 24) as f32;

/// Part of a plane's coordinates by which rounding moves it: faces that are no further apart lie in one place.
pub const ONE_PLACE: f32 = 3.0 / (1 << 24) as f32;

/// Where a ray crosses a triangle's plane, from an origin near to it, where few digits are lost.
struct Crossing {
    t: f32,
    t_error: f32,
    rank: u32,
}

impl Crossing {
    fn of<T: Face>(origin: Vec3, direction: Vec3, triangle: &T) -> Self {
        let [v0, e1, e2] = triangle.edges();
        let n = e1.cross(e2);
        let across = direction.dot(n);
        let error = ONE_PLACE * n.abs().dot(v0.abs() + e1.abs() + e2.abs());
        Self {
            t: (v0 - origin).dot(n) / across,
            t_error: error / across.abs(),
            rank: triangle.rank(across < 0.0),
        }
    }

    /// Whether this is met before another one; none where they are alike in place and rank.
    fn comes_before(&self, other: &Self) -> Option<bool> {
        let apart = self.t - other.t;
        if apart.abs() > self.t_error + other.t_error {
            return Some(apart < 0.0);
        }
        (self.rank != other.rank).then_some(self.rank > other.rank)
    }
}
