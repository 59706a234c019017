//! Targets: bounding spheres of the specular bodies. Light of class L S+ D must go there first.

use super::surfaces::{PackedMaterial, PackedTriangle};
use crate::packed::gpu_struct::gpu_struct;
use glam::Vec3;
use rustc_hash::FxHashMap;

/// Most targets that emission aims at; bodies beyond are merged with their nearest neighbours.
pub const MAX_TARGETS: usize = 16;

gpu_struct! {
    /// A sphere that holds a specular body, 16 bytes.
    pub struct Target {
        /// Centre, internal units.
        pub center: Vec3,
        /// Radius, internal units, rounded up.
        pub radius: f32,
    }
}

/// Slack of the radius: f32 rounding of positions must not leave a sliver outside.
const RADIUS_SLACK: f32 = 1.0005;

/// Spheres around the connected components (by shared corners) of all triangles with a mirror or dielectric lobe.
pub(super) fn find(triangles: &[PackedTriangle], materials: &[PackedMaterial]) -> Vec<Target> {
    let specular: Vec<&PackedTriangle> =
        triangles.iter().filter(|t| materials[t.material as usize].flags().has_delta()).collect();
    let mut parent: Vec<usize> = (0..specular.len()).collect();
    let mut first_at: FxHashMap<[i32; 3], usize> = FxHashMap::default();
    for (i, t) in specular.iter().enumerate() {
        for v in t.vertices() {
            let key = v.to_array().map(|x| (x * QUANTUM).round() as i32);
            let j = *first_at.entry(key).or_insert(i);
            let (a, b) = (root(&mut parent, i), root(&mut parent, j));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut bodies: FxHashMap<usize, (Vec3, Vec3)> = FxHashMap::default();
    for (i, t) in specular.iter().enumerate() {
        let body = bodies.entry(root(&mut parent, i)).or_insert((Vec3::INFINITY, Vec3::NEG_INFINITY));
        for v in t.vertices() {
            *body = (body.0.min(v), body.1.max(v));
        }
    }
    let mut keys: Vec<usize> = bodies.keys().copied().collect();
    keys.sort_unstable();
    let mut spheres: Vec<Target> = keys
        .iter()
        .map(|k| {
            let center = 0.5 * (bodies[k].0 + bodies[k].1);
            Target { center, radius: 0.0 }
        })
        .collect();
    let slot: FxHashMap<usize, usize> = keys.iter().enumerate().map(|(s, &k)| (k, s)).collect();
    for (i, t) in specular.iter().enumerate() {
        let s = &mut spheres[slot[&root(&mut parent, i)]];
        for v in t.vertices() {
            s.radius = s.radius.max((v - s.center).length());
        }
    }
    for s in &mut spheres {
        s.radius *= RADIUS_SLACK;
    }
    merge(spheres)
}

/// Corners nearer than 1/QUANTUM internal units are one: the scene's radius is 512 to 1024 units.
const QUANTUM: f32 = 1024.0;

fn root(parent: &mut [usize], mut i: usize) -> usize {
    while parent[i] != i {
        parent[i] = parent[parent[i]];
        i = parent[i];
    }
    i
}

/// Merge the pair that grows least until at most [`MAX_TARGETS`] are left; thousands of bodies become one first.
fn merge(mut spheres: Vec<Target>) -> Vec<Target> {
    if spheres.len() > MAX_TARGETS * MAX_TARGETS {
        return vec![spheres.into_iter().reduce(union).expect("not empty")];
    }
    while spheres.len() > MAX_TARGETS {
        let mut best = (f32::INFINITY, 0, 1);
        for i in 0..spheres.len() {
            for j in i + 1..spheres.len() {
                let grown = union(spheres[i], spheres[j]).radius;
                if grown < best.0 {
                    best = (grown, i, j);
                }
            }
        }
        let b = spheres.swap_remove(best.2);
        spheres[best.1] = union(spheres[best.1], b);
    }
    spheres
}

/// The smallest sphere around two.
fn union(a: Target, b: Target) -> Target {
    let offset = b.center - a.center;
    let distance = offset.length();
    if distance + b.radius <= a.radius {
        return a;
    }
    if distance + a.radius <= b.radius {
        return b;
    }
    let radius = 0.5 * (distance + a.radius + b.radius);
    Target { center: a.center + offset * ((radius - a.radius) / distance), radius: radius * RADIUS_SLACK }
}
