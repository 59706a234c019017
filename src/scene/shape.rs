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
            Self::Prism { radius, sides, height, axis } => {
                let mut mesh = cylinder(radius, axis * (height / 2.0), true, sides);
                mesh.normals.clear();
                mesh.triangles.iter_mut().for_each(|t| t.normal = None);
                mesh
            }
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
    let first = mesh.positions.len() as u32;
    mesh.positions.push(center);
    mesh.positions.extend(circle(facing, corners).map(|p| center + p * radius));
    for i in 0..corners {
        let vertex = [first, first + 1 + i, first + 1 + (i + 1) % corners];
        mesh.triangles.push(Triangle { vertex, normal: None, uv: None, material: 0 });
    }
}

fn cylinder(radius: f64, half: DVec3, is_capped: bool, corners: u32) -> Mesh {
    let mut mesh = Mesh::default();
    let facing = half.normalize();
    let rim: Vec<DVec3> = circle(facing, corners).collect();
    for end in [-half, half] {
        mesh.positions.extend(rim.iter().map(|p| end + *p * radius));
    }
    mesh.normals = rim.iter().map(|p| p.as_vec3()).collect();
    for i in 0..corners {
        let next = (i + 1) % corners;
        for corner in [[(i, 0), (next, 0), (next, 1)], [(i, 0), (next, 1), (i, 1)]] {
            let vertex = corner.map(|(at, end)| end * corners + at);
            mesh.triangles.push(Triangle {
                vertex,
                normal: Some(corner.map(|(at, _)| at)),
                uv: None,
                material: 0,
            });
        }
    }
    if is_capped {
        // the rim is that of the side: the body is closed
        for (end, center) in [-half, half].into_iter().enumerate() {
            let middle = mesh.positions.len() as u32;
            mesh.positions.push(center);
            for i in 0..corners {
                let [a, b] = [i, (i + 1) % corners].map(|at| end as u32 * corners + at);
                let vertex = if end == 1 { [middle, a, b] } else { [middle, b, a] };
                mesh.triangles.push(Triangle { vertex, normal: None, uv: None, material: 0 });
            }
        }
    }
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
    Mesh {
        positions: points.iter().map(|p| *p * radius).collect(),
        normals: points.iter().map(|p| p.as_vec3()).collect(),
        uvs: Vec::new(),
        triangles: faces
            .into_iter()
            .map(|vertex| Triangle { vertex, normal: Some(vertex), uv: None, material: 0 })
            .collect(),
    }
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
