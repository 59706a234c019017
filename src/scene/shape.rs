//! Shapes: spheres, cubes and the like, as a scene file names them, made of triangles.
//!
//! Round ones are as fine as their `tolerance` says: their corners lie on the true surface, and no triangle is farther from it.

use super::Mesh;
use super::mtl::At;
use super::table::Table;
use super::tessellation::{FACES, corners, cube, cylinder, disc, levels, prism, quad, sides, sphere};
use crate::Result;
use glam::{DVec2, DVec3};

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Triangle;
    use std::f64::consts::{PI, TAU};

    /// How far the triangles come from the unit sphere.
    fn farthest(points: &[DVec3], faces: &[[u32; 3]]) -> f64 {
        let depth = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| points[v as usize]);
            1.0 - (b - a).cross(c - a).normalize().dot(a)
        };
        faces.iter().map(depth).fold(0.0, f64::max)
    }

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
