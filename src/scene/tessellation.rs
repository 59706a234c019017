//! Tessellation: the triangles of shapes, about the origin, with the texture coordinates of pictures that lie on them. Fronts look out.

use super::{Mesh, Triangle};
use glam::{DVec2, DVec3};
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Unit vectors across, which is level, and along, at right angles to it; across × along is where both face.
pub(super) fn sides(facing: DVec3) -> [DVec3; 2] {
    let across = DVec3::Y.cross(facing).try_normalize().unwrap_or(DVec3::X);
    [across, facing.cross(across)]
}

/// Give a shape about the origin its places across an axis as texture coordinates: what is brushed goes around it by these.
pub(super) fn set_around(mesh: &mut Mesh, axis: DVec3) {
    let across = sides(axis);
    mesh.uvs = mesh.positions.iter().map(|p| across.map(|side| p.dot(side) as f32)).collect();
    mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
}

/// Corners of a polygon whose edges come so near to its circle.
pub(super) fn corners(tolerance: f64) -> u32 {
    let corners = (PI / (1.0 - tolerance).acos()).ceil().max(3.0) as u32;
    corners.next_multiple_of(4)
}

/// A flat parallelogram with these half edges; it faces `across` × `along`.
pub(super) fn quad(mesh: &mut Mesh, center: DVec3, across: DVec3, along: DVec3) {
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

pub(super) fn cube(half: DVec3) -> Mesh {
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
pub(super) fn disc(mesh: &mut Mesh, center: DVec3, facing: DVec3, radius: f64, corners: u32) {
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
pub(super) fn cylinder(radius: f64, half: DVec3, is_capped: bool, corners: u32) -> Mesh {
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
pub(super) fn prism(radius: f64, half: DVec3, sides: u32) -> Mesh {
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
pub(super) const FACES: u64 = 20;

/// How often they are cut in four until they are near enough to the unit sphere. The one in the middle is the largest each time.
pub(super) fn levels(tolerance: f64) -> u32 {
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
pub(super) fn sphere(radius: f64, tolerance: f64) -> Mesh {
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
