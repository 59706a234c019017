//! Triangles and their hierarchy without a scene, and rays through them on the device.

use super::{Row, Snippet, row3};
use glam::{DVec3, Vec3};
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::Harness;
use joton::packed::accel::Bvh;
use joton::packed::{NO_EMITTER, PackedTriangle, first_corner};

/// Triangles in leaf order with their hierarchy.
pub struct World {
    /// The hierarchy.
    pub bvh: Bvh,
    /// Leaf order.
    pub triangles: Vec<PackedTriangle>,
}

impl World {
    /// From corners, counter-clockwise.
    pub fn new(vertices: &[[Vec3; 3]]) -> Self {
        let (bvh, order) = Bvh::build(vertices);
        let triangles = order
            .iter()
            .map(|&i| {
                let first = first_corner(vertices[i as usize]);
                let [a, b, c] = [0, 1, 2].map(|k| vertices[i as usize][(first + k) % 3]);
                PackedTriangle { v0: a, material: 0, e1: b - a, flags: 0, e2: c - a, emitter: NO_EMITTER }
            })
            .collect();
        Self { bvh, triangles }
    }

    /// The buffers of a scene that is nothing but these triangles.
    pub fn harness<'a>(&self, context: &'a Context) -> Harness<'a> {
        let mut harness = Harness::new(context);
        harness.scene("nodes", self.bvh.nodes());
        harness.scene("triangles", &self.triangles);
        harness
    }

    /// Distance and weights on triangle `i`, in f64, whether inside or not.
    pub fn meet(&self, i: usize, o: DVec3, d: DVec3) -> Option<[f64; 3]> {
        let t = &self.triangles[i];
        let [v0, e1, e2] = [t.v0, t.e1, t.e2].map(|v| v.as_dvec3());
        let p = d.cross(e2);
        let det = e1.dot(p);
        if det == 0.0 {
            return None;
        }
        let s = o - v0;
        let q = s.cross(e1);
        Some([e2.dot(q) / det, s.dot(p) / det, d.dot(q) / det])
    }

    /// Nearest distance where triangles are grown (or, negative, shrunk) by `slack` in their weights.
    pub fn nearest(&self, o: DVec3, d: DVec3, slack: f64) -> f64 {
        (0..self.triangles.len())
            .filter_map(|i| self.meet(i, o, d))
            .filter(|&[t, u, v]| t > -slack * T_SCALE && u >= -slack && v >= -slack && u + v <= 1.0 + slack)
            .map(|h| h[0])
            .fold(f64::INFINITY, f64::min)
    }
}

/// Coordinates are of this size: what is 1e-5 in weights is this much more in distances.
pub const T_SCALE: f64 = 100.0;

/// Origin and direction of a ray.
pub type Ray = [Vec3; 2];

/// The device's hit for each ray: triangle, t, u, v.
pub fn trace(
    context: &Context,
    world: &World,
    rays: &[Ray],
    limits: &[f32],
    any: bool,
) -> Vec<(u32, [f32; 3])> {
    let inputs: Vec<[Row; 2]> = rays
        .iter()
        .enumerate()
        .map(|(i, r)| [row3(r[0], limits[i % limits.len()]), row3(r[1], 0.0)])
        .collect();
    let code = format!(
        "let h = traverse(in_f(0u).xyz, in_f(1u).xyz, in_f(0u).w, {any});
         out_u(0u, vec4(h.triangle, bitcast<vec3<u32>>(vec3(h.t, h.u, h.v))));
         out_u(1u, vec4(steps, 0u, 0u, 0u));"
    );
    let snippet = Snippet::new(&["scene/scene.wgsl", "accel/intersect.wgsl"], &code);
    let pass = super::pass_info();
    let mut harness = world.harness(context);
    let out: Vec<[Row; 2]> =
        snippet.run_in(context, &mut harness, &[("pass_info", bytemuck::bytes_of(&pass))], &inputs);
    out.iter()
        .map(|[h, steps]| {
            assert!(steps[0] > 0, "a traversal counts its steps");
            (h[0], [h[1], h[2], h[3]].map(f32::from_bits))
        })
        .collect()
}
