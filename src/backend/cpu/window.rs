//! Window: which jotons and area points are near enough to a gather point to count for it.

use super::eye::GatherPoint;
use super::maps::{AreaMap, Four};
use crate::packed::constants::{GATHER_NORMAL_COS, GATHER_PLANE_SHARE, GATHER_SHEET_SHARE};
use crate::sampling::distributions::basis;
use glam::{BVec4A, Vec3, Vec4};

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
    /// Jotons are near the plane where the plane of their own surface is near the centre: all of a flat face is, or nothing.
    by_own_plane: bool,
    /// Likewise for area points of the opposite orientation.
    sheet_max: f32,
    /// Jotons of the other side count, too: what is scattered through \[E55\].
    both_sides: bool,
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
            by_own_plane: false,
            sheet_max: GATHER_SHEET_SHARE * radius,
            both_sides: g.bsdf.scatter.crosses(),
            walls: None,
        }
    }

    /// The part of it before walls: their normals, and offsets from the centre; all of it where there are none.
    pub(super) fn before(mut self, walls: Option<[(Vec3, f32); 2]>) -> Self {
        self.walls = walls;
        self
    }

    /// For a disc that is measured face by face.
    pub(super) fn by_own_plane(mut self) -> Self {
        self.by_own_plane = true;
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
        let (near, d, mut height) = self.near(four);
        let facing = dot(&four.normal, self.normal);
        let facing = if self.both_sides { facing.abs() } else { facing };
        let facing = facing.cmpgt(Vec4::splat(GATHER_NORMAL_COS));
        if self.by_own_plane {
            let [x, y, z] = four.normal;
            height = (d[0] * x + d[1] * y + d[2] * z).abs();
        }
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
