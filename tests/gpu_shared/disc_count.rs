//! What discs of the caustic map hold, by counts over lattices in f64 [E31]: nothing of it is joton's, but for the constants.

use glam::{DVec2, DVec3, Vec3};
use joton::packed::PackedScene;
use joton::packed::constants::{
    CLIP_LIFT, DISC_AREA_LEAST, DISC_HALVINGS, DISC_TRIANGLES, DISC_WHOLE, GATHER_NORMAL_COS,
    GATHER_PLANE_SHARE, GATHER_SHEET_SHARE, ONE_PLANE, ONE_SURFACE,
};
use std::f64::consts::PI;

/// Points across a circle that is counted.
const ACROSS: f64 = 400.0;
/// Walls no further than this before another one, in radii, stand behind it.
const SLACK: f64 = 0.01;
/// Distances that differ by less, in radii, are a tie, which rounding decides.
const TIE: f64 = 1e-4;

/// A triangle in f64.
pub(crate) struct Face {
    corners: [DVec3; 3],
    normal: DVec3,
    scatters: bool,
}

pub(crate) fn faces(scene: &PackedScene) -> Vec<Face> {
    let face = |t: &joton::packed::PackedTriangle| {
        let [v0, e1, e2] = [t.v0, t.e1, t.e2].map(|v| v.as_dvec3());
        let scatters = scene.materials[t.material as usize].diffuse[0] > 0.0;
        Face { corners: [v0, v0 + e1, v0 + e2], normal: e1.cross(e2).normalize(), scatters }
    };
    scene.triangles.iter().map(face).collect()
}

impl Face {
    /// How far a point of the plane lies inside of each edge.
    fn inside(&self, q: DVec3) -> [f64; 3] {
        [0, 1, 2].map(|k| {
            let [a, b] = [self.corners[k], self.corners[(k + 1) % 3]];
            self.normal.cross(b - a).normalize().dot(q - a)
        })
    }

    fn holds(&self, q: DVec3) -> bool {
        self.inside(q).iter().all(|h| *h >= 0.0)
    }
}

/// Where a disc lies: a point of a face, seen from one side.
#[derive(Clone, Copy)]
pub(crate) struct Place {
    pub(crate) triangle: u32,
    pub(crate) front: bool,
    pub(crate) position: Vec3,
}

/// A wall: its plane from the disc's middle, the ends of its foot, and how far that is.
#[derive(Clone)]
pub(crate) struct Wall {
    pub(crate) normal: DVec3,
    pub(crate) offset: f64,
    pub(crate) ends: [DVec3; 2],
    pub(crate) distance: f64,
}

impl Wall {
    fn is_behind(&self, other: &Self, slack: f64) -> bool {
        self.ends.iter().all(|end| other.normal.dot(*end) - other.offset < slack)
    }
}

/// What is true of a disc.
pub(crate) struct Truth {
    pub(crate) radius: f64,
    pub(crate) area: f64,
    pub(crate) walls: Vec<Wall>,
}

/// The line in which a plane above the surface meets a face, by what its edges leave of it.
fn wall(face: &Face, p: DVec3, normal: DVec3, radius: f64) -> Option<Wall> {
    if face.normal.dot(normal).abs() > f64::from(GATHER_NORMAL_COS) {
        return None;
    }
    let along = face.normal.cross(normal).normalize();
    let across = along.cross(normal);
    let lifted = p + normal * (f64::from(CLIP_LIFT) * radius);
    let s = face.normal.dot(face.corners[0] - lifted) / face.normal.dot(across);
    let (at_0, at_1) = (face.inside(lifted + across * s), face.inside(lifted + across * s + along));
    let mut range = [f64::NEG_INFINITY, f64::INFINITY];
    for (h, slope) in at_0.iter().zip(at_1).map(|(h, to)| (*h, to - h)) {
        match slope {
            k if k > 1e-12 => range[0] = range[0].max(-h / k),
            k if k < -1e-12 => range[1] = range[1].min(-h / k),
            _ if h < 0.0 => return None,
            _ => {}
        }
    }
    let distance = s.hypot(0f64.clamp(range[0].min(range[1]), range[1]));
    if range[0] >= range[1] || distance >= radius {
        return None;
    }
    let height = face.normal.dot(p - face.corners[0]);
    let ends = range.map(|t| across * s + along * t);
    let normal = face.normal * if height < 0.0 { -1.0 } else { 1.0 };
    Some(Wall { normal, offset: -height.abs(), ends, distance })
}

/// The two nearest walls; the second does not stand behind the first. No place is asked where rounding decides.
fn two_nearest(mut walls: Vec<Wall>, radius: f64) -> Vec<Wall> {
    walls.sort_by(|a, b| a.distance.total_cmp(&b.distance));
    let Some(first) = walls.first().cloned() else { return Vec::new() };
    let rest: Vec<_> = walls.iter().filter(|w| !w.is_behind(&first, SLACK * radius)).collect();
    let Some(second) = rest.first().map(|w| (*w).clone()) else { return vec![first] };
    let tie = TIE * radius;
    let is_other = |w: &&&Wall| w.distance < second.distance + tie && !w.is_behind(&second, tie);
    assert!(rest.iter().skip(1).find(is_other).is_none(), "two walls may be the second");
    vec![first, second]
}

/// Area of the surfaces in the ball before the walls, by points that lie on any of them.
fn count(surfaces: &[&Face], walls: &[Wall], p: DVec3, radius: f64) -> f64 {
    let mut area = 0.0;
    for (i, face) in surfaces.iter().enumerate() {
        let height = face.normal.dot(face.corners[0] - p);
        let rho = (radius * radius - height * height).max(0.0).sqrt();
        let step = 2.0 * rho / ACROSS;
        // axes at an odd angle to whatever the scene has
        let x = face.normal.cross(DVec3::new(0.36, -0.48, 0.8)).normalize();
        let y = face.normal.cross(x);
        let middle = p + face.normal * height;
        let flat = face.corners.map(|c| DVec2::new((c - middle).dot(x), (c - middle).dot(y)));
        let range = |k: usize| {
            let low = flat.iter().map(|c| c[k]).fold(f64::INFINITY, f64::min).max(-rho);
            let high = flat.iter().map(|c| c[k]).fold(f64::NEG_INFINITY, f64::max).min(rho);
            ((low / step).floor() as i64, (high / step).ceil() as i64)
        };
        let earlier: Vec<_> = surfaces[..i]
            .iter()
            .filter(|e| {
                e.normal.dot(face.normal).abs() > f64::from(ONE_PLANE)
                    && (e.corners[0] - face.corners[0]).dot(face.normal).abs() < f64::from(ONE_SURFACE)
            })
            .collect();
        for v in range(1).0..range(1).1 {
            for u in range(0).0..range(0).1 {
                let at = DVec2::new(u as f64 + 0.5, v as f64 + 0.5) * step;
                if at.length_squared() > rho * rho {
                    continue;
                }
                let q = middle + x * at.x + y * at.y;
                let is_before = walls.iter().all(|w| w.normal.dot(q - p) >= w.offset);
                if is_before && face.holds(q) && !earlier.iter().any(|e| e.holds(q)) {
                    area += step * step;
                }
            }
        }
    }
    area
}

/// The disc of one radius; none where its ball holds very many triangles.
fn measure(faces: &[Face], place: &Place, radius: f64) -> Option<Truth> {
    let p = place.position.as_dvec3();
    let front = faces[place.triangle as usize].normal;
    let normal = if place.front { front } else { -front };
    let is_near = |f: &&Face| {
        let low = f.corners.iter().fold(DVec3::INFINITY, |low, c| low.min(*c)) - p;
        let high = f.corners.iter().fold(DVec3::NEG_INFINITY, |high, c| high.max(*c)) - p;
        low.max_element() < radius
            && high.min_element() > -radius
            && f.normal.dot(f.corners[0] - p).abs() < radius
    };
    let near: Vec<&Face> = faces.iter().filter(is_near).collect();
    if near.len() > DISC_TRIANGLES as usize {
        return None;
    }
    let walls = two_nearest(near.iter().filter_map(|f| wall(f, p, normal, radius)).collect(), radius);
    let is_surface = |f: &&Face| {
        let facing = f.normal.dot(front);
        let share = if facing > 0.0 { GATHER_PLANE_SHARE } else { GATHER_SHEET_SHARE };
        f.scatters
            && facing.abs() > f64::from(GATHER_NORMAL_COS)
            && f.normal.dot(f.corners[0] - p).abs() < f64::from(share) * radius
    };
    let surfaces: Vec<&Face> = near.into_iter().filter(is_surface).collect();
    Some(Truth { radius, area: count(&surfaces, &walls, p, radius), walls })
}

pub(crate) fn truth(faces: &[Face], place: &Place, radius: f64) -> Truth {
    let whole = |r: f64| Truth { radius: r, area: PI * r * r, walls: Vec::new() };
    let mut last = whole(radius);
    for k in 0..=DISC_HALVINGS as i32 {
        let r = radius * 0.5f64.powi(k);
        let Some(disc) = measure(faces, place, r) else { continue };
        let least = f64::from(DISC_AREA_LEAST) * PI * r * r;
        if disc.area >= least {
            return disc;
        }
        last = Truth { area: least, ..disc };
    }
    last
}

/// Reach of whole surface: the radius, half of it, or none.
pub(crate) fn whole_reach(faces: &[Face], place: &Place, radius: f64) -> f64 {
    let is_whole = |r: &f64| {
        measure(faces, place, *r).is_some_and(|disc| {
            disc.walls.is_empty() && (disc.area / (PI * r * r) - 1.0).abs() < f64::from(DISC_WHOLE)
        })
    };
    [radius, radius / 2.0].into_iter().find(is_whole).unwrap_or(0.0)
}
