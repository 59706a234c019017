//! Shapes: spheres, cubes and the like, as a scene file names them, made of triangles.
//!
//! Round ones are as fine as their `tolerance` says: their corners lie on the true surface, and no triangle is farther from it.

use super::mtl::At;
use super::table::Table;
use super::{Mesh, Triangle};
use crate::Result;
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Distance of triangles from a round surface, at most, over its radius, where a file says nothing: a third of a pixel where the shape is
/// 2000 pixels wide.
const TOLERANCE: f64 = 3e-4;
/// Smallest that may be asked for: a sphere has 1.3 million triangles then.
const TOLERANCE_MIN: f64 = 4e-6;

/// A shape about its centre.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Sphere {
        radius: f64,
        tolerance: f64,
    },
    /// Edges along x, y and z.
    Cube {
        size: DVec3,
    },
    /// Level edges along the first of `size`, the others at right angles to them and to where it faces.
    Rectangle {
        size: DVec2,
        facing: DVec3,
    },
    Disc {
        radius: f64,
        facing: DVec3,
        tolerance: f64,
    },
    Cylinder {
        radius: f64,
        height: f64,
        axis: DVec3,
        is_capped: bool,
        tolerance: f64,
    },
    /// Flat sides about an axis through the middle, closed at both ends. `radius` is that of the corners.
    Prism {
        radius: f64,
        sides: u32,
        height: f64,
        axis: DVec3,
    },
}

/// Kinds of shapes, and the keys that each reads.
const KINDS: [(&str, &[&str]); 6] = [
    ("sphere", &["radius", "tolerance"]),
    ("cube", &["size"]),
    ("rectangle", &["size", "facing"]),
    ("disc", &["radius", "facing", "tolerance"]),
    ("cylinder", &["radius", "height", "axis", "caps", "tolerance"]),
    ("prism", &["radius", "sides", "height", "axis"]),
];

impl Shape {
    /// Read what a table says of a shape, and where its centre is; `more` keys are read by others.
    ///
    /// # Errors
    /// Line and remedy where the table says something else.
    pub(crate) fn read(table: &Table, more: &[&str]) -> Result<(Self, DVec3)> {
        let kind = table.string("kind")?;
        let Some((_, keys)) = KINDS.into_iter().find(|(name, _)| *name == kind.value) else {
            return Err(table.unknown(kind.line, "kind of shape", &kind.value, &KINDS.map(|(name, _)| name)));
        };
        table.allow(&[&["kind", "center"], keys, more].concat())?;
        let length = |key: &str, default: f64| positive(table, key, table.number(key)?, default);
        let radius = || length("radius", 0.5);
        let tolerance = || {
            let At { value, line } = table.number("tolerance")?.unwrap_or(At { value: TOLERANCE, line: 0 });
            let what = || {
                table.fault(line, &format!("tolerance {value}"), &format!("give {TOLERANCE_MIN:e} to 0.1"))
            };
            if (TOLERANCE_MIN..=0.1).contains(&value) { Ok(value) } else { Err(what()) }
        };
        let direction = |key: &str| match table.at_vector(key)? {
            None => Ok(DVec3::Y),
            Some(At { value, line }) => value.try_normalize().ok_or_else(|| {
                table.fault(line, &format!("{key} without length"), "give a direction: [x, y, z]")
            }),
        };
        let shape = match kind.value.as_str() {
            "sphere" => Self::Sphere { radius: radius()?, tolerance: tolerance()? },
            "cube" => {
                let size = table.factors("size")?.unwrap_or(At { value: DVec3::ONE, line: 0 });
                let least = At { value: size.value.min_element(), line: size.line };
                positive(table, "size", Some(least), 1.0)?;
                Self::Cube { size: size.value }
            }
            "rectangle" => {
                let size = table.sides("size")?.unwrap_or(At { value: DVec2::ONE, line: 0 });
                let least = At { value: size.value.min_element(), line: size.line };
                positive(table, "size", Some(least), 1.0)?;
                Self::Rectangle { size: size.value, facing: direction("facing")? }
            }
            "disc" => Self::Disc { radius: radius()?, facing: direction("facing")?, tolerance: tolerance()? },
            "prism" => Self::Prism {
                radius: radius()?,
                sides: sides_of_prism(table)?,
                height: length("height", 1.0)?,
                axis: direction("axis")?,
            },
            _ => Self::Cylinder {
                radius: radius()?,
                height: length("height", 1.0)?,
                axis: direction("axis")?,
                is_capped: table.boolean("caps")?.is_none_or(|caps| caps.value),
                tolerance: tolerance()?,
            },
        };
        Ok((shape, table.optional_vector("center")?.unwrap_or(DVec3::ZERO)))
    }

    /// The axis about which a round one turns; none of those with sides that texture coordinates go along.
    pub(crate) fn axis(&self) -> Option<DVec3> {
        match *self {
            Self::Sphere { .. } => Some(DVec3::Y),
            Self::Disc { facing, .. } => Some(facing),
            Self::Cylinder { axis, .. } | Self::Prism { axis, .. } => Some(axis),
            Self::Cube { .. } | Self::Rectangle { .. } => None,
        }
    }

    /// How many triangles it has.
    pub(crate) fn triangles(&self) -> u64 {
        match *self {
            Self::Sphere { tolerance, .. } => FACES << (2 * levels(tolerance)),
            Self::Cube { .. } => 12,
            Self::Rectangle { .. } => 2,
            Self::Disc { tolerance, .. } => corners(tolerance).into(),
            Self::Cylinder { is_capped, tolerance, .. } => {
                u64::from(corners(tolerance)) * if is_capped { 4 } else { 2 }
            }
            Self::Prism { sides, .. } => u64::from(sides) * 4,
        }
    }

    /// Its triangles, of material 0, about the origin. Fronts look out; a rectangle's and a disc's where it faces.
    pub(crate) fn mesh(&self) -> Mesh {
        match *self {
            Self::Sphere { radius, tolerance } => sphere(radius, tolerance),
            Self::Cube { size } => cube(size / 2.0),
            Self::Rectangle { size, facing } => {
                let [across, along] = sides(facing);
                let mut mesh = Mesh::default();
                quad(&mut mesh, DVec3::ZERO, across * (size.x / 2.0), along * (size.y / 2.0));
                mesh
            }
            Self::Disc { radius, facing, tolerance } => {
                let mut mesh = Mesh::default();
                disc(&mut mesh, DVec3::ZERO, facing, radius, corners(tolerance));
                mesh
            }
            Self::Cylinder { radius, height, axis, is_capped, tolerance } => {
                cylinder(radius, axis * (height / 2.0), is_capped, corners(tolerance))
            }
            Self::Prism { radius, sides, height, axis } => prism(radius, axis * (height / 2.0), sides),
        }
    }
}

/// Sides of a prism where a file gives none, and at most.
const PRISM_SIDES: [u32; 2] = [3, 1024];

fn sides_of_prism(table: &Table) -> Result<u32> {
    let [few, most] = PRISM_SIDES;
    let Some(At { value, line }) = table.integer("sides")? else { return Ok(few) };
    let fault = || table.fault(line, &format!("prism of {value} sides"), &format!("give {few} to {most}"));
    u32::try_from(value).ok().filter(|sides| (few..=most).contains(sides)).ok_or_else(fault)
}

/// A number above 0.
fn positive(table: &Table, key: &str, value: Option<At<f64>>, default: f64) -> Result<f64> {
    match value {
        Some(At { value, line }) if value <= 0.0 => {
            Err(table.fault(line, &format!("{key} {value}"), "give a number above 0"))
        }
        value => Ok(value.map_or(default, |v| v.value)),
    }
}

/// Unit vectors across, which is level, and along, at right angles to it; across × along is where both face.
fn sides(facing: DVec3) -> [DVec3; 2] {
    let across = DVec3::Y.cross(facing).try_normalize().unwrap_or(DVec3::X);
    [across, facing.cross(across)]
}

/// Give a shape about the origin its places across an axis as texture coordinates: what is brushed goes around it by these.
pub(crate) fn set_around(mesh: &mut Mesh, axis: DVec3) {
    let across = sides(axis);
    mesh.uvs = mesh.positions.iter().map(|p| across.map(|side| p.dot(side) as f32)).collect();
    mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
}

/// Corners of a polygon whose edges come so near to its circle.
fn corners(tolerance: f64) -> u32 {
    let corners = (PI / (1.0 - tolerance).acos()).ceil().max(3.0) as u32;
    corners.next_multiple_of(4)
}

/// A flat parallelogram with these half edges; it faces `across` × `along`.
fn quad(mesh: &mut Mesh, center: DVec3, across: DVec3, along: DVec3) {
    let first = mesh.positions.len() as u32;
    let corner = |x: f64, y: f64| center + across * x + along * y;
    mesh.positions.extend([corner(-1., -1.), corner(1., -1.), corner(1., 1.), corner(-1., 1.)]);
    let first_uv = mesh.uvs.len() as u32;
    mesh.uvs.extend(SQUARE);
    for corners in [[0, 1, 2], [0, 2, 3]] {
        let [vertex, uv] = [first, first_uv].map(|first| corners.map(|k| first + k));
        mesh.triangles.push(Triangle { vertex, normal: None, uv: Some(uv), material: 0 });
    }
}

/// Texture coordinates of the corners of a square, counter-clockwise.
const SQUARE: [[f32; 2]; 4] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];

fn cube(half: DVec3) -> Mesh {
    let mut mesh = Mesh::default();
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    mesh.uvs.extend(SQUARE);
    // corners are shared, so that the body is closed
    mesh.positions = (0..8u32)
        .map(|i| half * DVec3::from([0, 1, 2].map(|bit| if i >> bit & 1 == 1 { 1.0 } else { -1.0 })))
        .collect();
    for (k, _) in axes.iter().enumerate() {
        let [u, v] = [(k + 1) % 3, (k + 2) % 3];
        for side in [0u32, 1] {
            let corner = |a: u32, b: u32| side << k | a << u | b << v;
            let face = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            let [a, b, c, d] = if side == 1 { face } else { [face[0], face[3], face[2], face[1]] };
            for [i, j, k] in [[0, 1, 2], [0, 2, 3]] {
                let vertex = [i, j, k].map(|n| [a, b, c, d][n]);
                let uv = Some([i, j, k].map(|n| n as u32));
                mesh.triangles.push(Triangle { vertex, normal: None, uv, material: 0 });
            }
        }
    }
    mesh
}

/// Points of a circle about the origin, from `across` on, counter-clockwise as seen from where it faces.
fn circle(facing: DVec3, count: u32) -> impl Iterator<Item = DVec3> {
    let [across, along] = sides(facing);
    (0..count).map(move |i| {
        let (sin, cos) = (TAU * f64::from(i) / f64::from(count)).sin_cos();
        across * cos + along * sin
    })
}

/// A flat disc: triangles about its centre.
fn disc(mesh: &mut Mesh, center: DVec3, facing: DVec3, radius: f64, corners: u32) {
    let rim = mesh.positions.len() as u32;
    mesh.positions.extend(circle(facing, corners).map(|p| center + p * radius));
    let rim: Vec<u32> = (rim..rim + corners).collect();
    fan(mesh, center, facing, radius, &rim);
}

/// A flat disc whose rim, counter-clockwise as seen from where it faces, is there already: triangles about its centre. A picture on it
/// is as one on a rectangle around it.
fn fan(mesh: &mut Mesh, center: DVec3, facing: DVec3, radius: f64, rim: &[u32]) {
    let [across, along] = sides(facing);
    let [middle, middle_uv] = [mesh.positions.len(), mesh.uvs.len()].map(|n| n as u32);
    mesh.positions.push(center);
    mesh.uvs.push([0.5; 2]);
    for &i in rim {
        let from_center = (mesh.positions[i as usize] - center) / radius;
        mesh.uvs.push([across, along].map(|side| (0.5 + 0.5 * from_center.dot(side)) as f32));
    }
    for (i, k) in (0..rim.len()).map(|i| (i, (i + 1) % rim.len())) {
        mesh.triangles.push(Triangle {
            vertex: [middle, rim[i], rim[k]],
            normal: None,
            uv: Some([middle_uv, middle_uv + 1 + i as u32, middle_uv + 1 + k as u32]),
            material: 0,
        });
    }
}

/// The rims of a tube about the origin, the lower one first, counter-clockwise as seen from where `half` points.
fn rims(radius: f64, half: DVec3, corners: u32) -> Mesh {
    let rim = || circle(half.normalize(), corners).map(|p| p * radius);
    Mesh {
        positions: [-half, half].into_iter().flat_map(|end| rim().map(move |p| end + p)).collect(),
        ..Mesh::default()
    }
}

/// The flat ends of a tube: their rims are those of its side, so that the body is closed.
fn caps(mesh: &mut Mesh, radius: f64, half: DVec3, corners: u32) {
    let [lower, upper]: [Vec<u32>; 2] = [(0..corners).rev().collect(), (corners..2 * corners).collect()];
    let facing = half.normalize();
    fan(mesh, -half, -facing, radius, &lower);
    fan(mesh, half, facing, radius, &upper);
}

/// The two triangles between corner `i` of the rims and the next one; each corner as its place on the rim, counted on past the
/// last, and its end.
fn panel(i: u32) -> [[(u32, u32); 3]; 2] {
    [[(i, 0), (i + 1, 0), (i + 1, 1)], [(i, 0), (i + 1, 1), (i, 1)]]
}

/// A picture goes around it once, from its back on; the middle is where a sphere's is.
fn cylinder(radius: f64, half: DVec3, is_capped: bool, corners: u32) -> Mesh {
    let mut mesh = rims(radius, half, corners);
    mesh.normals = circle(half.normalize(), corners).map(|p| p.as_vec3()).collect();
    let around = |k: u32| (f64::from(k) / f64::from(corners)) as f32;
    mesh.uvs = (0..=corners).flat_map(|k| [0.0, 1.0].map(|up| [around(k), up])).collect();
    let back = corners / 4;
    for k in 0..corners {
        for panel in panel(k) {
            let on_rim = panel.map(|(k, end)| ((k + back) % corners, end));
            mesh.triangles.push(Triangle {
                vertex: on_rim.map(|(i, end)| end * corners + i),
                normal: Some(on_rim.map(|(i, _)| i)),
                uv: Some(panel.map(|(k, end)| 2 * k + end)),
                material: 0,
            });
        }
    }
    if is_capped {
        caps(&mut mesh, radius, half, corners);
    }
    mesh
}

/// Each of its sides has the whole of a picture.
fn prism(radius: f64, half: DVec3, sides: u32) -> Mesh {
    let mut mesh = rims(radius, half, sides);
    mesh.uvs.extend(SQUARE);
    for i in 0..sides {
        for (panel, uv) in panel(i).into_iter().zip([[0, 1, 2], [0, 2, 3]]) {
            let vertex = panel.map(|(i, end)| end * sides + i % sides);
            mesh.triangles.push(Triangle { vertex, normal: None, uv: Some(uv), material: 0 });
        }
    }
    caps(&mut mesh, radius, half, sides);
    mesh
}

/// Triangles of an icosahedron.
const FACES: u64 = 20;

/// How often they are cut in four until they are near enough to the unit sphere. The one in the middle is the largest each time.
fn levels(tolerance: f64) -> u32 {
    // its corners, of equal distances from each other, lie on a circle; an icosahedron's has this radius
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut radius = 2.0 / (1.0 + golden * golden).sqrt() / 3f64.sqrt();
    let mut levels = 0;
    while 1.0 - (1.0 - radius * radius).sqrt() > tolerance {
        // the middles of the sides lie on one of half the radius, and then come onto the sphere
        let middle = [radius / 2.0, (1.0 - radius * radius).sqrt()];
        radius = middle[0] / middle[0].hypot(middle[1]);
        levels += 1;
    }
    levels
}

/// An icosahedron whose triangles are cut in four until they are near enough to the sphere.
fn sphere(radius: f64, tolerance: f64) -> Mesh {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let mut points: Vec<DVec3> = Vec::new();
    for [a, b] in [[1.0, golden], [-1.0, golden], [1.0, -golden], [-1.0, -golden]] {
        points
            .extend([DVec3::new(0., a, b), DVec3::new(a, b, 0.), DVec3::new(b, 0., a)].map(DVec3::normalize));
    }
    let mut faces: Vec<[u32; 3]> = Vec::new();
    let edge = points[0].distance(points[3]).min(2.0 / (1.0 + golden * golden).sqrt()) * 1.01;
    let is_edge = |i: u32, k: u32| points[i as usize].distance(points[k as usize]) < edge;
    for i in 0..12 {
        for k in i + 1..12 {
            for l in k + 1..12 {
                if is_edge(i, k) && is_edge(k, l) && is_edge(i, l) {
                    let [a, b, c] = [i, k, l].map(|v| points[v as usize]);
                    let looks_out = (b - a).cross(c - a).dot(a) > 0.0;
                    faces.push(if looks_out { [i, k, l] } else { [i, l, k] });
                }
            }
        }
    }
    for _ in 0..levels(tolerance) {
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut finer = Vec::with_capacity(4 * faces.len());
        for [a, b, c] in faces {
            let mut middle = |i: u32, k: u32| {
                *middles.entry([i.min(k), i.max(k)]).or_insert_with(|| {
                    points.push((points[i as usize] + points[k as usize]).normalize());
                    points.len() as u32 - 1
                })
            };
            let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
            finer.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        faces = finer;
    }
    let mut mesh = Mesh {
        positions: points.iter().map(|p| *p * radius).collect(),
        normals: points.iter().map(|p| p.as_vec3()).collect(),
        uvs: Vec::with_capacity(points.len()),
        triangles: Vec::with_capacity(faces.len()),
    };
    let on_map: Vec<DVec2> = points.iter().map(|p| longitude_latitude(*p)).collect();
    mesh.uvs.extend(on_map.iter().map(|uv| uv.as_vec2().to_array()));
    for vertex in faces {
        let corners = vertex.map(|v| on_map[v as usize]);
        // where a triangle's corners lie on one side of the back, their places on the map are shared
        let mut uv = vertex;
        let settled = around_the_back(corners);
        for k in 0..3 {
            if settled[k] != corners[k] {
                uv[k] = mesh.uvs.len() as u32;
                mesh.uvs.push(settled[k].as_vec2().to_array());
            }
        }
        mesh.triangles.push(Triangle { vertex, normal: Some(vertex), uv: Some(uv), material: 0 });
    }
    mesh
}

/// Where a point of the unit sphere is on a map of the world, whose middle faces along z and whose upper edge is the pole along y.
fn longitude_latitude(p: DVec3) -> DVec2 {
    DVec2::new(0.5 + p.x.atan2(p.z) / TAU, 0.5 + p.y.atan2(p.x.hypot(p.z)) / PI)
}

/// Corners on the map whose triangle does not reach across all of it: those left of the middle go on beyond its right edge where
/// others lie far to the right. A pole has the longitude that is between the others.
fn around_the_back(corners: [DVec2; 3]) -> [DVec2; 3] {
    let is_pole = |c: DVec2| c.y < 1e-9 || c.y > 1.0 - 1e-9;
    let right = corners.into_iter().filter(|c| !is_pole(*c)).map(|c| c.x).fold(0.0, f64::max);
    let mut settled = corners.map(|c| if right - c.x > 0.5 { c + DVec2::X } else { c });
    if let Some(pole) = corners.into_iter().position(is_pole) {
        settled[pole].x = (settled[(pole + 1) % 3].x + settled[(pole + 2) % 3].x) / 2.0;
    }
    settled
}

/// How far the triangles come from the unit sphere.
#[cfg(test)]
fn farthest(points: &[DVec3], faces: &[[u32; 3]]) -> f64 {
    let depth = |face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| points[v as usize]);
        1.0 - (b - a).cross(c - a).normalize().dot(a)
    };
    faces.iter().map(depth).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn all() -> [Shape; 6] {
        let facing = DVec3::new(1., 2., -0.5).normalize();
        [
            Shape::Sphere { radius: 2.0, tolerance: TOLERANCE },
            Shape::Cube { size: DVec3::new(1., 2., 3.) },
            Shape::Cylinder { radius: 0.5, height: 3.0, axis: facing, is_capped: true, tolerance: TOLERANCE },
            Shape::Prism { radius: 2.0, sides: 3, height: 3.0, axis: facing },
            Shape::Rectangle { size: DVec2::new(2., 3.), facing },
            Shape::Disc { radius: 2.0, facing, tolerance: TOLERANCE },
        ]
    }

    /// Sum over the triangles of what each has of the volume in front of the origin, of the area, and of the area as a vector.
    fn measures(mesh: &Mesh) -> (f64, f64, DVec3) {
        let each = mesh.triangles.iter().map(|t| {
            let [a, b, c] = t.vertex.map(|v| mesh.positions[v as usize]);
            let cross = (b - a).cross(c - a) / 2.0;
            (a.dot(cross) / 3.0, cross.length(), cross)
        });
        each.fold((0.0, 0.0, DVec3::ZERO), |s, e| (s.0 + e.0, s.1 + e.1, s.2 + e.2))
    }

    /// Bodies are closed, look out and have the volume of their formula; flat ones have its area and look where they face.
    #[test]
    fn shapes_have_their_size() {
        let formulas = [4.0 / 3.0 * PI * 8.0, 6.0, PI * 0.25 * 3.0, 3.0 * 3f64.sqrt() / 4.0 * 4.0 * 3.0];
        for (shape, volume) in all().iter().zip(formulas) {
            let (found, _, sum) = measures(&shape.mesh());
            assert!((found / volume - 1.0).abs() < 2.0 * TOLERANCE, "{shape:?}: {found}, not {volume}");
            assert!(sum.length() < 1e-9, "{shape:?} is open: {sum}");
        }
        let Shape::Rectangle { facing, .. } = all()[4] else { panic!("a rectangle") };
        for (shape, area) in all()[4..].iter().zip([6.0, PI * 4.0]) {
            let (_, found, sum) = measures(&shape.mesh());
            assert!((found / area - 1.0).abs() < 2.0 * TOLERANCE, "{shape:?}: {found}, not {area}");
            assert!((sum / found - facing).length() < 1e-9, "{shape:?} faces {}", sum / found);
        }
    }

    /// Every triangle's normals look to its front; corners of round ones lie on them, and no triangle is farther in than it may be.
    #[test]
    fn round_surfaces_are_near_and_smooth() {
        for tolerance in [1e-2, TOLERANCE, 2e-5] {
            let mesh = sphere(1.0, tolerance);
            let faces: Vec<[u32; 3]> = mesh.triangles.iter().map(|t| t.vertex).collect();
            let points: Vec<DVec3> = mesh.positions.clone();
            assert!(points.iter().all(|p| (p.length() - 1.0).abs() < 1e-12));
            let far = farthest(&points, &faces);
            assert!(far <= tolerance && far > tolerance / 5.0, "{far} for {tolerance}");
            let circle = corners(tolerance);
            assert!(1.0 - (PI / f64::from(circle)).cos() <= tolerance, "{circle} corners");
        }
        assert_eq!(sphere(1.0, TOLERANCE).triangles.len(), 20 << 10);
        for tolerance in [0.1, 0.01, TOLERANCE, 2e-5] {
            let shape = Shape::Sphere { radius: 2.0, tolerance };
            assert_eq!(shape.triangles(), shape.mesh().triangles.len() as u64, "{tolerance}");
        }
        for shape in all() {
            let mesh = shape.mesh();
            assert_eq!(shape.triangles(), mesh.triangles.len() as u64, "{shape:?}");
            for t in &mesh.triangles {
                let [a, b, c] = t.vertex.map(|v| mesh.positions[v as usize]);
                let front = (b - a).cross(c - a).normalize().as_vec3();
                for n in t.normal.into_iter().flatten() {
                    let n = mesh.normals[n as usize];
                    assert!(front.dot(n) > 0.999 && (n.length() - 1.0).abs() < 1e-6, "{shape:?}");
                }
            }
        }
    }

    /// Pictures are not mirrored, and cover what they are said to: a sphere and the side of a cylinder once, each side of a prism and
    /// of a cube, what is around a disc. Their middles face along z, up is up.
    #[test]
    fn pictures_lie_on_shapes() {
        let at = |mesh: &Mesh, t: &Triangle| {
            let uv = t.uv.expect("coordinates").map(|i| mesh.uvs[i as usize].map(f64::from));
            (uv.map(DVec2::from), t.vertex.map(|v| mesh.positions[v as usize]))
        };
        let area = |[a, b, c]: [DVec2; 3]| (b - a).perp_dot(c - a) / 2.0;
        let disc = PI / 4.0;
        let triangle_ends = 2.0 * 3.0 * 3f64.sqrt() / 16.0;
        let areas = [1.0, 6.0, 1.0 + 2.0 * disc, 3.0 + triangle_ends, 1.0, disc];
        for (shape, area_of_all) in all().iter().zip(areas) {
            let mesh = shape.mesh();
            let areas: Vec<f64> = mesh.triangles.iter().map(|t| area(at(&mesh, t).0)).collect();
            assert!(areas.iter().all(|a| *a > 0.0), "{shape:?} mirrors");
            // the triangles at the poles of a sphere lack half of what is there
            let found = areas.iter().sum::<f64>();
            assert!((found / area_of_all - 1.0).abs() < 0.02, "{shape:?}: {found}, not {area_of_all}");
        }
        let sphere = all()[0].mesh();
        for (uv, p) in sphere.triangles.iter().map(|t| at(&sphere, t)) {
            let (uv, p) = ((uv[0] + uv[1] + uv[2]) / 3.0, (p[0] + p[1] + p[2]).normalize());
            let (east, up) = (TAU * (uv.x - 0.5), PI * (uv.y - 0.5));
            let there = DVec3::new(east.sin() * up.cos(), up.sin(), east.cos() * up.cos());
            assert!(there.distance(p) < 0.02, "{uv} is at {p}, not {there}");
        }
        // a can whose axis is upright, seen from in front: the picture's middle, the right of it to the right
        let can = cylinder(1.0, DVec3::Y, true, corners(1e-3));
        let side = can.triangles.iter().filter(|t| t.normal.is_some());
        let corner = |(uv, p): ([DVec2; 3], [DVec3; 3])| [0, 1, 2].map(|k| (uv[k], p[k]));
        for (uv, p) in side.flat_map(|t| corner(at(&can, t))) {
            let east = TAU * (uv.x - 0.5);
            let there = DVec3::new(east.sin(), 2.0 * uv.y - 1.0, east.cos());
            assert!(there.distance(p) < 1e-6, "{uv} is at {p}, not {there}");
        }
    }

    /// A wall's first side is level, wherever it faces.
    #[test]
    fn the_first_side_is_level() {
        for (facing, across) in [
            (DVec3::Y, DVec3::X),
            (DVec3::NEG_Y, DVec3::X),
            (DVec3::Z, DVec3::X),
            (DVec3::X, DVec3::NEG_Z),
            (DVec3::NEG_Z, DVec3::NEG_X),
        ] {
            let [u, v] = sides(facing);
            assert_eq!(u, across, "{facing}");
            assert!((u.cross(v) - facing).length() < 1e-12 && u.y == 0.0, "{facing}");
        }
    }
}
