//! The bounding volume hierarchy: a compressed wide BVH (Ylitie et al. 2017), built by obvhs.
//!
//! The only file that names obvhs. Triangles are reordered to leaf order on the way, so that a leaf's
//! primitive index is a triangle's index.

mod split;

use glam::{UVec2, Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::{Bvh2, node::Bvh2Node};
use obvhs::cwbvh::{CwBvh, builder::build_cwbvh_from_tris, bvh2_to_cwbvh::bvh2_to_cwbvh};
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

/// Origin and edges of a triangle, as `intersect_triangle` wants them.
pub trait Edges {
    /// First vertex, and the edges from it to the second and third.
    fn edges(&self) -> [Vec3; 3];
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
    pub fn nodes(&self) -> Vec<Node> {
        self.wide.nodes.iter().map(|n| bytemuck::cast::<_, Node>(*n)).collect()
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

    /// The nearest triangle with distance in `(0, t_max)`; `direction` is a unit vector (see [`Bvh::occluded`]).
    pub fn closest<T: Edges>(
        &self,
        triangles: &[T],
        origin: Vec3,
        direction: Vec3,
        t_max: f32,
    ) -> Option<Hit> {
        let ray = ray(origin, direction, t_max);
        let (mut hit, mut uv) = (RayHit::none(), (0.0, 0.0));
        let found = self.wide.ray_traverse(ray, &mut hit, |ray, id| {
            match intersect_triangle(ray.origin, ray.direction, &triangles[id]) {
                Some((t, u, v)) if t < ray.tmax => {
                    uv = (u, v);
                    t
                }
                _ => f32::INFINITY,
            }
        });
        found.then_some(Hit { triangle: hit.primitive_id, t: hit.t, u: uv.0, v: uv.1 })
    }

    /// True where some triangle lies in `(0, t_max)`, in units of the ray's direction.
    pub fn occluded<T: Edges>(&self, triangles: &[T], origin: Vec3, direction: Vec3, t_max: f32) -> bool {
        // obvhs leaves out boxes that end before t = 1e-4, whatever the direction's length: a shadow ray to the sun, 4096
        // units long, would not see what stands within 0.4
        let length = direction.length();
        let ray = ray(origin, direction / length, t_max * length);
        !self.wide.ray_traverse_miss(ray, |ray, id| {
            intersect_triangle(ray.origin, ray.direction, &triangles[id]).map_or(f32::INFINITY, |h| h.0)
        })
    }

    /// Ask `visit` to look at every triangle whose bounds come within `reach` of a point along each axis, and at some others.
    pub fn near(&self, point: Vec3, reach: f32, mut visit: impl FnMut(u32)) {
        let about = Aabb::new((point - reach).into(), (point + reach).into());
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
        let ray = ray(point - along * reach, along, 2.0 * reach);
        !self.wide.ray_traverse_miss(ray, |_, id| if accept(id as u32) { 0.0 } else { f32::INFINITY })
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

/// A ray without negative zeros: obvhs takes their sign for the reciprocal and not for the octant, and misses everything.
fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> Ray {
    // −0 + 0 is 0
    Ray::new(origin.into(), (direction + Vec3::ZERO).into(), 0.0, t_max)
}

/// Barycentric slack: rays that meet an edge hit one triangle or the other, never neither …
const EDGE_SLACK: f32 = 1e-6;
/// … and part of |origin − v0| |edge| / |determinant| by which the rounding of f32 moves a weight, eight half units in the
/// last place: small triangles far from the ray's origin have seams that no constant closes.
const EDGE_ROUNDING: f32 = 8.0 / (1 << 24) as f32;
/// A ray that lies in the triangle's plane, but for rounding, has no weights: the slack ends here.
const EDGE_SLACK_MAX: f32 = 1.0;

/// Distance and barycentric weights where a ray meets a triangle from either side (Möller & Trumbore 1997).
#[inline(always)]
fn intersect_triangle<T: Edges>(origin: Vec3A, direction: Vec3A, triangle: &T) -> Option<(f32, f32, f32)> {
    let [v0, e1, e2] = triangle.edges().map(Vec3A::from);
    let p = direction.cross(e2);
    let det = e1.dot(p);
    let inv_det = 1.0 / det;
    let s = origin - v0;
    let u = s.dot(p) * inv_det;
    let q = s.cross(e1);
    let v = direction.dot(q) * inv_det;
    let t = e2.dot(q) * inv_det;
    let rounding = EDGE_ROUNDING * s.abs().max_element() * inv_det.abs();
    let slack = |edge: Vec3A| (EDGE_SLACK + rounding * edge.abs().max_element()).min(EDGE_SLACK_MAX);
    let (slack_u, slack_v) = (slack(e2), slack(e1));
    (u >= -slack_u && v >= -slack_v && u + v <= 1.0 + slack_u.max(slack_v) && t > 0.0 && det != 0.0)
        .then_some((t, u, v))
}
