//! Gather: the radiance that leaves a gather point, from the jotons around it. L = throughput Σ f Φ w, w = 1/(π r²) or
//! corrected for the boundary [E7, E15].

use super::boundary::Weights;
use super::clip::Walls;
use super::eye::GatherPoint;
use super::kd_tree::{EMPTY, LANES};
use super::maps::{AreaMap, Four, JotonMap};
use crate::bands::{BANDS, Bands, add, mul, scale};
use crate::layout::{GATHER_NORMAL_COS, GATHER_PLANE_SHARE, GATHER_SHEET_SHARE};
use crate::optics::bsdf::eval_d;
use crate::optics::sampling::basis;
use glam::{BVec4A, Vec3, Vec4};
use std::f32::consts::FRAC_1_PI;

/// What is near enough to a gather point: within the radius, near its plane, facing its side.
#[derive(Debug, Clone, Copy)]
pub(super) struct Window {
    pub(super) center: Vec3,
    pub(super) radius_squared: f32,
    normal: Vec3,
    /// Unit front normal of the gather point's triangle, `normal` or its opposite.
    front: Vec3,
    tangents: [Vec3; 2],
    plane_max: f32,
    /// Likewise for area points of the opposite orientation.
    sheet_max: f32,
    /// Walls: normals, and offsets from the centre.
    walls: Option<[(Vec3, f32); 2]>,
}

fn dot(a: &[Vec4; 3], b: Vec3) -> Vec4 {
    a[0] * b.x + a[1] * b.y + a[2] * b.z
}

impl Window {
    pub(super) fn new(g: &GatherPoint, radius_squared: f32) -> Self {
        let (t0, t1) = basis(g.ng);
        let radius = radius_squared.sqrt();
        Self {
            center: g.position,
            radius_squared,
            normal: g.ng,
            front: if g.front { g.ng } else { -g.ng },
            tangents: [t0, t1],
            plane_max: GATHER_PLANE_SHARE * radius,
            sheet_max: GATHER_SHEET_SHARE * radius,
            walls: None,
        }
    }

    /// The part of it before the walls.
    pub(super) fn before(mut self, walls: &Walls) -> Self {
        self.walls = walls.from(self.center);
        self
    }

    /// True where no wall cuts it.
    pub(super) fn is_open(&self) -> bool {
        self.walls.is_none()
    }

    /// True where surface of another direction reaches into the ball about the centre.
    pub(super) fn sees_others(&self, map: &AreaMap) -> bool {
        let mut others = false;
        map.tree.visit(self.center, self.radius_squared, |quads| {
            for four in &map.fours[quads] {
                let facing = dot(&four.normal, self.normal).abs();
                others |= (self.near(four).0 & facing.cmple(Vec4::splat(GATHER_NORMAL_COS))).any();
            }
        });
        others
    }

    /// Offsets, which are within the radius, and their distances from the plane.
    #[inline(always)]
    fn near(&self, four: &Four) -> (BVec4A, [Vec4; 3], Vec4) {
        let d: [Vec4; 3] = std::array::from_fn(|c| four.position[c] - Vec4::splat(self.center[c]));
        let distance_squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        let mut near = distance_squared.cmplt(Vec4::splat(self.radius_squared));
        for (normal, offset) in self.walls.iter().flatten() {
            near &= dot(&d, *normal).cmpge(Vec4::splat(*offset));
        }
        (near, d, dot(&d, self.normal).abs())
    }

    /// Which of four jotons count, and their offsets.
    #[inline(always)]
    pub(super) fn accept(&self, four: &Four) -> (BVec4A, [Vec4; 3]) {
        let (near, d, height) = self.near(four);
        let facing = dot(&four.normal, self.normal).cmpgt(Vec4::splat(GATHER_NORMAL_COS));
        (near & height.cmplt(Vec4::splat(self.plane_max)) & facing, d)
    }

    /// Which of four area points count: they stand for both sides of their surface. Of the opposite orientation only in
    /// the plane itself: a neighbour wound the other way round counts, the other sheet of a thin board does not.
    #[inline(always)]
    pub(super) fn accept_area(&self, four: &Four) -> (BVec4A, [Vec4; 3]) {
        let (near, d, height) = self.near(four);
        let facing = dot(&four.normal, self.front);
        let same = facing.cmpgt(Vec4::splat(GATHER_NORMAL_COS)) & height.cmplt(Vec4::splat(self.plane_max));
        let opposite =
            facing.cmplt(Vec4::splat(-GATHER_NORMAL_COS)) & height.cmplt(Vec4::splat(self.sheet_max));
        (near & (same | opposite), d)
    }

    /// Tangent coordinates of offsets.
    #[inline(always)]
    pub(super) fn tangent(&self, d: &[Vec4; 3]) -> (Vec4, Vec4) {
        (dot(d, self.tangents[0]), dot(d, self.tangents[1]))
    }
}

/// Number of jotons that count.
pub(super) fn count(map: &JotonMap, w: &Window) -> u32 {
    let mut found = 0;
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for four in &map.fours[quads] {
            found += w.accept(four).0.bitmask().count_ones();
        }
    });
    found
}

/// Radiance toward the eye, times the throughput. `accepted` masks the automaton's states, None where every path is
/// wanted.
pub(super) fn radiance(
    map: &JotonMap,
    g: &GatherPoint,
    w: &Window,
    weights: Weights,
    accepted: Option<u32>,
) -> Bands {
    let sum = if g.material.flags().has_glossy() || accepted.is_some() {
        one_by_one(map, g, w, weights, accepted.unwrap_or(u32::MAX))
    } else {
        scale(&mul(&irradiance(map, w, weights), &g.material.diffuse), FRAC_1_PI)
    };
    mul(&sum, &g.throughput)
}

/// Σ Φ w: f is the same for every joton.
fn irradiance(map: &JotonMap, w: &Window, weights: Weights) -> Bands {
    let mut sums = [Vec4::ZERO; BANDS];
    let constant = Vec4::splat(weights.constant);
    let sloped = weights.slope != [0.0; 2];
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for (four, flux) in map.fours[quads.clone()].iter().zip(&map.flux[quads]) {
            let (inside, d) = w.accept(four);
            if !inside.any() {
                continue;
            }
            let weight = if sloped {
                let (x, y) = w.tangent(&d);
                constant + x * weights.slope[0] + y * weights.slope[1]
            } else {
                constant
            };
            let weight = Vec4::select(inside, weight, Vec4::ZERO);
            for b in 0..BANDS {
                sums[b] += flux[b] * weight;
            }
        }
    });
    sums.map(|s| s.element_sum())
}

/// Σ f Φ w with f and the path's state of each joton.
fn one_by_one(map: &JotonMap, g: &GatherPoint, w: &Window, weights: Weights, accepted: u32) -> Bands {
    let mut sum = [0.0; BANDS];
    map.tree.visit(w.center, w.radius_squared, |quads| {
        for quad in quads {
            let (inside, d) = w.accept(&map.fours[quad]);
            let inside = inside.bitmask();
            if inside == 0 {
                continue;
            }
            let (x, y) = w.tangent(&d);
            for lane in (0..LANES).filter(|l| inside >> l & 1 == 1) {
                let slot = map.slots[quad * LANES + lane];
                debug_assert!(slot != EMPTY, "empty slots are far away");
                let joton = &map.jotons[slot as usize];
                if accepted >> joton.state & 1 == 0 {
                    continue;
                }
                let weight = weights.constant + weights.slope[0] * x[lane] + weights.slope[1] * y[lane];
                let f = eval_d(g.material, joton.wi, g.wo, g.ns);
                sum = add(&sum, &scale(&mul(&f, &joton.flux), weight));
            }
        }
    });
    sum
}
