//! Bodies: glass that lies in other glass, or overlaps it.
//!
//! Each boundary knows two indices, of its inside and of vacuum. Glass in glass is right where the inner index is given over
//! the outer one, or where the inner surface is turned inward: a bubble. Where bodies overlap, the light in both is lost track
//! of, unless one has a priority: then indices are over vacuum, and what is left to doubt are bodies of one priority that overlap.

use super::PackedScene;
use crate::packed::accel::{Bvh, Face};
use crate::scene::{GlassSurface, Scene, glass_surfaces, quoted};
use glam::Vec3;
use std::collections::BTreeSet;

/// Places that are looked at in all, and at most on one body.
const PLACES: usize = 4096;
const PLACES_EACH: usize = 16;
/// Surfaces behind each other that a ray is followed through.
const CROSSINGS: usize = 64;
/// What is nearer than this, in internal units, touches.
const NEAR: f32 = 1.0 / 512.0;
/// An inner index above this was hardly given over that of other glass.
const OVER_AIR: f32 = 1.2;
/// A line that no model has its edges along.
const ACROSS: Vec3 = Vec3::new(0.532_1, 0.618_7, 0.578_3);

/// A triangle of glass and its surface.
struct Flat {
    edges: [Vec3; 3],
    surface: u32,
}

impl Face for Flat {
    fn edges(&self) -> [Vec3; 3] {
        self.edges
    }

    fn rank(&self, _: bool) -> u32 {
        0
    }
}

/// What cannot be meant of bodies of glass, a line each.
pub(super) fn doubts(scene: &Scene, packed: &PackedScene) -> Vec<String> {
    let material =
        |s: &GlassSurface| &scene.materials[scene.mesh.triangles[s.triangles[0] as usize].material as usize];
    let has_priorities = packed.media.has_priorities;
    let mut surfaces = glass_surfaces(scene);
    surfaces.retain(|s| s.open_edges == 0 && !material(s).thin);
    if surfaces.len() < 2 {
        return Vec::new();
    }
    let corners = |i: u32| {
        let t = &scene.mesh.triangles[i as usize];
        t.vertex.map(|v| {
            ((scene.mesh.positions[v as usize] - packed.world_center) / packed.world_scale).as_vec3()
        })
    };
    let owned = surfaces
        .iter()
        .enumerate()
        .flat_map(|(s, found)| found.triangles.iter().map(move |&i| (s as u32, i)));
    let (owners, vertices): (Vec<u32>, Vec<[Vec3; 3]>) = owned.map(|(s, i)| (s, corners(i))).unzip();
    let (bvh, order) = Bvh::build(&vertices);
    let flat = |&k: &u32| {
        let [a, b, c] = vertices[k as usize];
        Flat { edges: [a, b - a, c - a], surface: owners[k as usize] }
    };
    let glass = Glass { bvh, triangles: order.iter().map(flat).collect() };
    let each = (PLACES / surfaces.len()).clamp(1, PLACES_EACH);
    let (mut inner, mut outer, mut mixed) = (BTreeSet::new(), BTreeSet::new(), BTreeSet::new());
    for (s, surface) in surfaces.iter().enumerate().take(PLACES).filter(|(_, s)| s.volume_outward > 0.0) {
        let step = surface.triangles.len().div_ceil(each);
        let places = surface.triangles.iter().step_by(step).map(|&i| corners(i)[0]);
        let found: Vec<Option<u32>> = places.filter_map(|p| glass.around(p, s as u32)).collect();
        let Some(holder) = found.iter().flatten().next() else { continue };
        let (name, holder) = (&material(surface).name, material(&surfaces[*holder as usize]));
        let is_decided = has_priorities && material(surface).interior.priority != holder.interior.priority;
        if is_decided {
            continue;
        }
        if found.contains(&None) {
            mixed.extend([name.as_str(), &holder.name]);
        } else if !has_priorities && material(surface).dielectric.is_some_and(|d| d.ior > OVER_AIR) {
            inner.insert(name.as_str());
            outer.insert(holder.name.as_str());
        }
    }
    let overlap = (!mixed.is_empty()).then(|| {
        let [which, what] = if has_priorities {
            [
                "bodies of one priority",
                "which counts depends on the way that light comes; give each a number of its own",
            ]
        } else {
            [
                "bodies of glass",
                "where two are in one place light goes astray; part them, or give each a priority",
            ]
        };
        format!("{which} overlap ({}): {what}", quoted(&mixed))
    });
    let nested = (!inner.is_empty()).then(|| {
        let what = "the index of inner glass counts over that of what is around it, not over air: divide it by the outer one";
        format!("glass {} lies inside glass {}: {what}", quoted(&inner), quoted(&outer))
    });
    overlap.into_iter().chain(nested).collect()
}

struct Glass {
    bvh: Bvh,
    triangles: Vec<Flat>,
}

impl Glass {
    /// The surface that holds a place, other than its own; `Some(None)` where none does, `None` where it touches another one
    /// or the two ways along a line do not agree.
    fn around(&self, place: Vec3, own: u32) -> Option<Option<u32>> {
        let line = ACROSS.normalize();
        let [(there, held), (back, _)] = [self.follow(place, line, own)?, self.follow(place, -line, own)?];
        match (there, back) {
            (0, 0) => Some(None),
            (a, b) if a == b && a > 0 => held.map(Some),
            _ => None,
        }
    }

    /// How many bodies, other than its own, a ray leaves more often than it enters them, and the first that it leaves.
    fn follow(&self, place: Vec3, direction: Vec3, own: u32) -> Option<(i32, Option<u32>)> {
        let (mut origin, mut travelled, mut depth, mut left) = (place, 0.0, 0, None);
        for _ in 0..CROSSINGS {
            let Some(hit) = self.bvh.closest(&self.triangles, origin, direction, f32::INFINITY) else {
                return Some((depth, left));
            };
            let Flat { edges: [_, e1, e2], surface } = &self.triangles[hit.triangle as usize];
            travelled += hit.t;
            if *surface != own {
                if travelled < NEAR {
                    return None;
                }
                let leaves = direction.dot(e1.cross(*e2)) > 0.0;
                depth += if leaves { 1 } else { -1 };
                if leaves && depth == 1 {
                    left = left.or(Some(*surface));
                }
            }
            let step = hit.t + 0.25 * NEAR;
            travelled += 0.25 * NEAR;
            origin += direction * step;
        }
        None
    }
}
