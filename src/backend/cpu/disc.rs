//! Disc: what a disc of the caustic map holds of the surface that its middle lies on. Its triangles are clipped by the walls that
//! stand on the surface, and their area inside the ball is summed in closed form [E31].

use super::eye::GatherPoint;
use super::interior::Interior;
use crate::packed::PackedScene;
use crate::packed::constants::{
    CLIP_LIFT, DISC_AREA_LEAST, DISC_HALVINGS, DISC_TRIANGLES, DISC_WALL_SLACK, DISC_WHOLE,
    GATHER_NORMAL_COS, GATHER_PLANE_SHARE, GATHER_SHEET_SHARE, ONE_PLANE, ONE_SURFACE,
};
use crate::sampling::distributions::basis;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Half a space: points at `d` from the disc's middle with `normal · d` ≥ `offset`. The middle lies in it: `offset` ≤ 0.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
struct HalfSpace {
    normal: Vec3,
    offset: f32,
}

impl HalfSpace {
    fn is_wall(&self) -> bool {
        self.normal != Vec3::ZERO
    }

    fn height(&self, d: Vec3) -> f32 {
        self.normal.dot(d) - self.offset
    }
}

/// A disc about a gather point.
#[derive(Debug, Clone, Copy)]
pub(super) struct Disc {
    pub(super) radius: f32,
    /// Area of the surface before the walls, internal units².
    pub(super) area: f32,
    /// The two nearest walls.
    walls: [HalfSpace; 2],
}

/// Corners of a triangle that five half spaces have clipped, at most.
const CORNERS: usize = 8;

/// A convex polygon, by the places of its corners from the disc's middle.
#[derive(Debug, Clone, Copy)]
struct Polygon {
    corners: [Vec3; CORNERS],
    count: usize,
}

impl Polygon {
    fn triangle(corners: [Vec3; 3]) -> Self {
        let mut all = [Vec3::ZERO; CORNERS];
        all[..3].copy_from_slice(&corners);
        Self { corners: all, count: 3 }
    }

    fn corners(&self) -> &[Vec3] {
        &self.corners[..self.count]
    }

    /// The part in a half space (Sutherland & Hodgman 1974).
    fn clipped(&self, half: &HalfSpace) -> Self {
        if self.corners().iter().all(|c| half.height(*c) >= 0.0) {
            return *self;
        }
        let mut kept = Self { corners: [Vec3::ZERO; CORNERS], count: 0 };
        for (i, to) in self.corners().iter().enumerate() {
            let from = self.corners[(i + self.count - 1) % self.count];
            let [h_from, h_to] = [from, *to].map(|c| half.height(c));
            if (h_from < 0.0) != (h_to < 0.0) {
                kept.push(from + (*to - from) * (h_from / (h_from - h_to)));
            }
            if h_to >= 0.0 {
                kept.push(*to);
            }
        }
        kept
    }

    fn push(&mut self, corner: Vec3) {
        if self.count < CORNERS {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    /// Area of the part within `radius` of the middle; `normal` is the polygon's.
    fn area_in_ball(&self, normal: Vec3, radius: f32) -> f32 {
        let Some(first) = self.corners().first() else { return 0.0 };
        let height = normal.dot(*first);
        let radius_squared = radius * radius - height * height;
        if radius_squared <= 0.0 {
            return 0.0;
        }
        let (x, y) = basis(normal);
        let flat = |c: &Vec3| Vec2::new(c.dot(x), c.dot(y));
        let mut corners = [Vec2::ZERO; CORNERS];
        for (flat_corner, corner) in corners.iter_mut().zip(self.corners()) {
            *flat_corner = flat(corner);
        }
        area_in_circle(&corners[..self.count], radius_squared)
    }
}

/// Area of a convex polygon's part in a circle about the origin.
fn area_in_circle(corners: &[Vec2], radius_squared: f32) -> f32 {
    let before = |i: usize| corners[(i + corners.len() - 1) % corners.len()];
    let edges = || corners.iter().enumerate().map(|(i, to)| [before(i), *to]).filter(|[from, to]| from != to);
    let twice_area: f32 = edges().map(|[from, to]| from.perp_dot(to)).sum();
    if twice_area == 0.0 {
        return 0.0;
    }
    // how far the origin lies inside of the edges, at least; rounding may turn very short ones, so that it does not tell where the
    // origin lies outside
    let inside = edges()
        .map(|[from, to]| from.perp_dot((to - from).normalize_or_zero()))
        .fold(f32::INFINITY, |least, distance| least.min(distance.copysign(distance * twice_area)));
    if inside > 0.0 && inside * inside >= radius_squared {
        return PI * radius_squared;
    }
    if corners.iter().all(|c| c.length_squared() <= radius_squared) {
        return 0.5 * twice_area.abs();
    }
    edges().map(|[from, to]| fan_area(from, to, radius_squared)).sum::<f32>().abs()
}

/// Signed area of the triangle between the origin and two points, within a circle about the origin.
fn fan_area(from: Vec2, to: Vec2, radius_squared: f32) -> f32 {
    let along = (to - from).normalize_or_zero();
    // distance of the line; its sign is that of the area
    let distance = from.perp_dot(along);
    let near = distance.abs();
    let half_chord = (radius_squared - near * near).max(0.0).sqrt();
    // from the foot of the perpendicular to a point of the line: a triangle up to the circle, a sector beyond
    let part = |at: f32| {
        let s = at.abs();
        if s <= half_chord {
            return near * at;
        }
        // angle between the end of the chord and the point, as seen from the origin
        let sector = (near * (s - half_chord)).atan2(near * near + half_chord * s);
        (near * half_chord + radius_squared * sector).copysign(at)
    };
    (0.5 * (part(to.dot(along)) - part(from.dot(along)))).copysign(distance)
}

/// A triangle near a disc, about its middle.
#[derive(Debug, Clone, Copy)]
struct Near {
    corners: [Vec3; 3],
    /// Unit front normal.
    normal: Vec3,
    takes_jotons: bool,
}

/// The triangles whose bounds and planes meet a ball; none where there are more than are looked at.
fn near_ball(scene: &PackedScene, center: Vec3, radius: f32) -> Option<Vec<Near>> {
    let mut all = Vec::with_capacity(8);
    let mut count = 0;
    scene.bvh.near(center, radius, |i| {
        let t = &scene.triangles[i as usize];
        let corners = t.vertices().map(|v| v - center);
        let [a, b, c] = corners;
        let across = t.e1.cross(t.e2);
        let length_squared = across.length_squared();
        let height = across.dot(a);
        // the hierarchy shows some triangles beside
        let is_near = a.min(b).min(c).max_element() < radius
            && a.max(b).max(c).min_element() > -radius
            && height * height < radius * radius * length_squared;
        if !is_near {
            return;
        }
        count += 1;
        if count <= DISC_TRIANGLES {
            let takes_jotons = scene.materials[t.material as usize].flags().stores();
            all.push(Near { corners, normal: across / length_squared.sqrt(), takes_jotons });
        }
    });
    (count <= DISC_TRIANGLES).then_some(all)
}

impl Near {
    /// It as a wall, where it stands on the surface of a disc: where a plane a little above the surface meets it within the radius.
    /// Glass is a wall, too: light on its other side has come another way.
    fn wall(&self, normal: Vec3, radius: f32) -> Option<Wall> {
        if self.normal.dot(normal).abs() > GATHER_NORMAL_COS {
            return None;
        }
        let lift = CLIP_LIFT * radius;
        let heights = self.corners.map(|c| c.dot(normal) - lift);
        let mut ends = [Vec3::ZERO; 2];
        let mut count = 0;
        for (i, j) in [(0, 1), (1, 2), (2, 0)] {
            let (from, to) = (heights[i], heights[j]);
            if (from < 0.0) != (to < 0.0) && count < 2 {
                let at = self.corners[i] + (self.corners[j] - self.corners[i]) * (from / (from - to));
                ends[count] = at - normal * lift;
                count += 1;
            }
        }
        if count < 2 {
            return None;
        }
        let [a, along] = [ends[0], ends[1] - ends[0]];
        let t = (-a.dot(along) / along.length_squared().max(f32::MIN_POSITIVE)).clamp(0.0, 1.0);
        let distance = (a + along * t).length();
        if distance >= radius {
            return None;
        }
        let offset = self.normal.dot(self.corners[0]);
        let sign = if offset > 0.0 { -1.0 } else { 1.0 };
        let before = HalfSpace { normal: self.normal * sign, offset: offset * sign };
        Some(Wall { before, foot: ends, distance })
    }

    /// What of it counts as the surface of a disc: what jotons that count there can lie on.
    fn surface(&self, g: &GatherPoint, walls: &[HalfSpace; 2], radius: f32) -> Option<Polygon> {
        let front = if g.front { g.ng } else { -g.ng };
        let facing = self.normal.dot(front);
        if !self.takes_jotons || facing.abs() <= GATHER_NORMAL_COS {
            return None;
        }
        let share = if facing > 0.0 { GATHER_PLANE_SHARE } else { GATHER_SHEET_SHARE };
        if self.normal.dot(self.corners[0]).abs() >= share * radius {
            return None;
        }
        let mut part = Polygon::triangle(self.corners);
        for wall in walls.iter().filter(|w| w.is_wall()) {
            part = part.clipped(wall);
        }
        (part.count > 2).then_some(part)
    }
}

/// A triangle that stands on a disc.
#[derive(Debug, Clone, Copy, Default)]
struct Wall {
    /// What lies on the middle's side of it.
    before: HalfSpace,
    /// The ends of the line on which it stands.
    foot: [Vec3; 2],
    /// Distance of the middle from that line.
    distance: f32,
}

impl Wall {
    /// True where this stands wholly behind another wall, or in its plane.
    fn is_behind(&self, other: &Self, slack: f32) -> bool {
        self.foot.iter().all(|end| other.before.height(*end) < slack)
    }
}

/// The wall nearest to the middle, and the nearest that does not stand behind it: in whatever order they come.
fn nearest(walls: &[Wall], slack: f32) -> [HalfSpace; 2] {
    let nearest = |walls: &mut dyn Iterator<Item = &Wall>| {
        walls.min_by(|a, b| a.distance.total_cmp(&b.distance)).copied().unwrap_or_default()
    };
    let first = nearest(&mut walls.iter());
    let second = nearest(&mut walls.iter().filter(|w| !w.is_behind(&first, slack)));
    [first.before, second.before]
}

impl Disc {
    /// A disc on nothing but flat surface.
    pub(super) fn whole(radius: f32) -> Self {
        Self { radius, area: PI * radius * radius, walls: Default::default() }
    }

    /// The disc about a gather point; a smaller one where its ball holds very many triangles, or next to nothing is left of it.
    pub(super) fn about(scene: &PackedScene, g: &GatherPoint, radius: f32) -> Self {
        let mut last = Self::whole(radius);
        for k in 0..=DISC_HALVINGS as i32 {
            let radius = radius * 0.5f32.powi(k);
            let Some(near) = near_ball(scene, g.position, radius) else { continue };
            let disc = Self::of(&near, g, radius, scene.has_contacts);
            let least = DISC_AREA_LEAST * PI * radius * radius;
            if disc.area >= least {
                return disc;
            }
            last = Self { area: least, ..disc };
        }
        last
    }

    fn of(near: &[Near], g: &GatherPoint, radius: f32, has_contacts: bool) -> Self {
        let standing: Vec<Wall> = near.iter().filter_map(|t| t.wall(g.ng, radius)).collect();
        let walls = nearest(&standing, DISC_WALL_SLACK * radius);
        let parts = || near.iter().filter_map(|t| Some((t, t.surface(g, &walls, radius)?)));
        let mut area: f32 = parts().map(|(t, part)| part.area_in_ball(t.normal, radius)).sum();
        if has_contacts {
            area -= doubled_area(&parts().collect::<Vec<_>>(), radius);
        }
        Self { radius, area, walls }
    }

    /// The walls' normals, and offsets from the middle; none where there are no walls.
    pub(super) fn walls(&self) -> Option<[(Vec3, f32); 2]> {
        self.walls[0].is_wall().then(|| self.walls.map(|w| (w.normal, w.offset)))
    }

    /// True where no wall and no edge is in it.
    fn is_whole(&self) -> bool {
        !self.walls[0].is_wall() && (self.area / (PI * self.radius * self.radius) - 1.0).abs() < DISC_WHOLE
    }
}

/// How far the surface about a gather point is whole: up to a radius, half of it, or not at all.
pub(super) fn survey(scene: &PackedScene, g: &GatherPoint, radius: f32) -> Interior {
    let is_whole = |reach: &f32| {
        near_ball(scene, g.position, *reach)
            .is_some_and(|near| Disc::of(&near, g, *reach, scene.has_contacts).is_whole())
    };
    Interior::new(g, [radius, 0.5 * radius].into_iter().find(is_whole).unwrap_or(0.0))
}

/// Area that two triangles in one plane share within the radius: light falls on it once. Exact where no three do.
fn doubled_area(parts: &[(&Near, Polygon)], radius: f32) -> f32 {
    let mut sum = 0.0;
    for (i, (t, part)) in parts.iter().enumerate() {
        for (other, _) in &parts[..i] {
            let lies_in_plane = other.normal.dot(t.normal).abs() > ONE_PLANE
                && (other.corners[0] - t.corners[0]).dot(t.normal).abs() < ONE_SURFACE;
            if lies_in_plane {
                sum += other.clip(part).area_in_ball(t.normal, radius);
            }
        }
    }
    sum
}

impl Near {
    /// The part of a polygon in the same plane that lies in this triangle.
    fn clip(&self, part: &Polygon) -> Polygon {
        (0..3).fold(*part, |part, k| {
            let [a, b] = [self.corners[k], self.corners[(k + 1) % 3]];
            let inward = self.normal.cross(b - a);
            part.clipped(&HalfSpace { normal: inward, offset: inward.dot(a) })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    /// Area within a circle of radius 2 about the origin, in every order and winding of the corners.
    fn assert_area(what: &str, corners: &[[f64; 2]], want: f64) {
        let count = corners.len();
        for first in 0..count {
            for is_turned in [false, true] {
                let corner = |i: usize| corners[(first + if is_turned { count - i } else { i }) % count];
                let flat: Vec<Vec2> =
                    (0..count).map(|i| corner(i).map(|x| x as f32)).map(Vec2::from).collect();
                let got = f64::from(area_in_circle(&flat, 4.0));
                assert!(
                    (got - want).abs() < 4e-6 * 4.0 * PI,
                    "{what} from corner {first}: {got}, not {want}"
                );
            }
        }
    }

    /// Area between a chord at this distance of the middle and the arc beyond, radius 2.
    fn segment(distance: f64) -> f64 {
        4.0 * (distance / 2.0).acos() - distance * (4.0 - distance * distance).sqrt()
    }

    #[test]
    fn polygons_have_their_area_in_a_circle() {
        let far = 50.0;
        let rectangle = |x: [f64; 2], y: [f64; 2]| [[x[0], y[0]], [x[1], y[0]], [x[1], y[1]], [x[0], y[1]]];
        assert_area("whole", &rectangle([-far, far], [-far, far]), 4.0 * PI);
        assert_area("whole, of a triangle", &[[-far, -9.0], [far, -9.0], [1.0, far]], 4.0 * PI);
        assert_area("half", &rectangle([0.0, far], [-far, far]), 2.0 * PI);
        assert_area("quarter", &rectangle([0.0, far], [0.0, far]), PI);
        // an angle of 60 degrees at the middle
        assert_area("sixth", &[[0.0, 0.0], [far, 0.0], [far, far * 3f64.sqrt()]], 4.0 * PI / 6.0);
        for distance in [0.1, 1.0, 1.9, 1.999] {
            let name = format!("segment beyond {distance}");
            assert_area(&name, &rectangle([distance, far], [-far, far]), segment(distance));
            let name = format!("all but the segment beyond {distance}");
            assert_area(&name, &rectangle([-far, distance], [-far, far]), 4.0 * PI - segment(distance));
        }
        let strip = 4.0 * PI - segment(0.3) - segment(0.5);
        assert_area("strip", &rectangle([-0.3, 0.5], [-far, far]), strip);
        assert_area("inside", &rectangle([-0.5, 0.75], [0.25, 1.0]), 1.25 * 0.75);
        assert_area("inside, beside the middle", &[[1.0, 0.0], [1.5, 0.0], [1.0, 0.5]], 0.125);
        // corners on the circle
        assert_area("inscribed square", &[[2.0, 0.0], [0.0, 2.0], [-2.0, 0.0], [0.0, -2.0]], 8.0);
    }

    #[test]
    fn polygons_beside_a_circle_have_no_area_in_it() {
        assert_area("beside", &[[2.5, -9.0], [9.0, 0.0], [2.5, 9.0]], 0.0);
        // every edge's line but one meets the circle, or none does
        assert_area("beyond a corner", &[[1.6, 1.6], [9.0, 1.6], [1.6, 9.0]], 0.0);
        assert_area("round the corner", &[[2.1, 0.0], [90.0, 1.0], [90.0, -1.0]], 0.0);
        assert_area("far", &[[900.0, 0.0], [901.0, 0.0], [900.0, 1.0]], 0.0);
    }

    /// Clipping leaves polygons of no area: their long edges pass by the circle, or through it, there and back.
    #[test]
    fn polygons_of_no_area_have_none_in_a_circle() {
        for y in [0.0, 0.5, 2.5] {
            assert_area("edge, there and back", &[[-90.0, y], [90.0, y], [90.0, y], [-90.0, y]], 0.0);
            assert_area("edge, by a corner between", &[[-90.0, y], [3.0, y], [90.0, y]], 0.0);
        }
        assert_area("point", &[[0.5, 0.5]; 3], 0.0);
        assert_eq!(area_in_circle(&[], 4.0), 0.0);
    }

    /// Corners that are there twice change nothing.
    #[test]
    fn corners_may_be_there_twice() {
        let twice = [[0.0, -9.0], [9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [0.0, 9.0], [0.0, 9.0]];
        assert_area("half, corners twice", &twice, 2.0 * PI);
        let beside = [[3.0, -9.0], [9.0, 0.0], [9.0, 0.0], [3.0, 9.0], [3.0, 9.0]];
        assert_area("beside, corners twice", &beside, 0.0);
        let around = [[-9.0, -9.0], [-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
        assert_area("whole, a corner twice", &around, 4.0 * PI);
        // rounding turns the way between them
        let blunt = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [9.000001, 9.0], [-9.0, 9.0]];
        assert_area("whole, a corner all but twice", &blunt, 4.0 * PI);
        let cut = [[0.5, -9.0], [9.0, -9.0], [9.0, 9.0], [9.000001, 9.0], [0.5, 9.0]];
        assert_area("segment, a corner all but twice", &cut, segment(0.5));
    }
}
