//! maps/disc.wgsl and the host's disc: radius, area and walls against a count over lattices in f64 [E31].

use crate::common::scenes::{Builder, glass};
use crate::common::{Row, Snippet, floats, pass_info, random, random_direction, row3, vec3};
use crate::device_or_return;
use glam::{DVec2, DVec3, Vec3};
use joton::backend::cpu::harness;
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::Harness;
use joton::packed::PackedScene;
use joton::packed::constants::{
    CLIP_LIFT, DISC_AREA_LEAST, DISC_HALVINGS, DISC_TRIANGLES, DISC_WHOLE, GATHER_NORMAL_COS,
    GATHER_PLANE_SHARE, GATHER_SHEET_SHARE, ONE_PLANE, ONE_SURFACE,
};
use std::f64::consts::PI;

/// Points across a circle that is counted.
const ACROSS: f64 = 400.0;
/// What a count may be off, of the circle: a row of the lattice along an edge.
const TOLERANCE: f64 = 0.003;
/// Walls no further than this before another one, in radii, stand behind it.
const SLACK: f64 = 0.01;
/// Distances that differ by less, in radii, are a tie, which rounding decides.
const TIE: f64 = 1e-4;

/// A triangle in f64.
struct Face {
    corners: [DVec3; 3],
    normal: DVec3,
    scatters: bool,
}

fn faces(scene: &PackedScene) -> Vec<Face> {
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
struct Place {
    triangle: u32,
    front: bool,
    position: Vec3,
}

/// A wall: its plane from the disc's middle, the ends of its foot, and how far that is.
#[derive(Clone)]
struct Wall {
    normal: DVec3,
    offset: f64,
    ends: [DVec3; 2],
    distance: f64,
}

impl Wall {
    fn is_behind(&self, other: &Self, slack: f64) -> bool {
        self.ends.iter().all(|end| other.normal.dot(*end) - other.offset < slack)
    }
}

/// What is true of a disc.
struct Truth {
    radius: f64,
    area: f64,
    walls: Vec<Wall>,
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

fn truth(faces: &[Face], place: &Place, radius: f64) -> Truth {
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
fn whole_reach(faces: &[Face], place: &Place, radius: f64) -> f64 {
    let is_whole = |r: &f64| {
        measure(faces, place, *r).is_some_and(|disc| {
            disc.walls.is_empty() && (disc.area / (PI * r * r) - 1.0).abs() < f64::from(DISC_WHOLE)
        })
    };
    [radius, radius / 2.0].into_iter().find(is_whole).unwrap_or(0.0)
}

/// A disc as one side finds it.
#[derive(Debug)]
struct Found {
    radius: f64,
    area: f64,
    walls: Vec<(DVec3, f64)>,
}

fn on_the_host(scene: &PackedScene, place: &Place, radius: f32) -> Found {
    let (radius, area, walls) = harness::disc(scene, place.triangle, place.front, place.position, radius);
    let walls = walls.iter().map(|(n, offset)| (n.as_dvec3(), f64::from(*offset))).collect();
    Found { radius: radius.into(), area: area.into(), walls }
}

/// The disc about each place, and how far the surface is whole there.
fn on_the_device(context: &Context, scene: &PackedScene, places: &[Place], radius: f32) -> Vec<(Found, f64)> {
    let inputs: Vec<[Row; 3]> = places
        .iter()
        .flat_map(|p| {
            let front = scene.triangles[p.triangle as usize].normal();
            let normal = if p.front { front } else { -front };
            [0.0, 1.0].map(|whole| [row3(p.position, radius), row3(normal, whole), row3(front, 0.0)])
        })
        .collect();
    let mut harness = Harness::new(context);
    harness.scene("nodes", scene.bvh.nodes());
    harness.scene("triangles", &scene.triangles);
    harness.scene("materials", &scene.materials);
    let contacts = if scene.has_contacts { 1.0 } else { 0.0 };
    let snippet = Snippet {
        overrides: &[("HAS_CONTACTS", contacts)],
        ..Snippet::new(
            &["maps/disc.wgsl"],
            "let place = DiscPlace(in_f(0u).xyz, in_f(1u).xyz, in_f(2u).xyz);
             let disc = true_disc(place, in_f(0u).w, in_f(1u).w > 0.0);
             out_f(0u, vec4(disc.radius, disc.area, 0.0, 0.0));
             out_f(1u, disc.first);
             out_f(2u, disc.second);",
        )
    };
    let pass = pass_info();
    let at: [(&str, &[u8]); 1] = [("pass_info", bytemuck::bytes_of(&pass))];
    let out: Vec<[Row; 3]> = snippet.run_in(context, &mut harness, &at, &inputs);
    out.chunks_exact(2)
        .map(|pair| {
            let [[disc, walls @ ..], [whole, ..]] = [pair[0], pair[1]];
            let [radius, area, ..] = floats(disc).map(f64::from);
            let walls = walls.map(|w| (vec3(w).as_dvec3(), f64::from(floats(w)[3])));
            let walls = walls.into_iter().filter(|(normal, _)| *normal != DVec3::ZERO).collect();
            (Found { radius, area, walls }, f64::from(floats(whole)[0]))
        })
        .collect()
}

/// Hold both sides against the count at places of a scene: points above or below a face, and the way to it; lengths in world units.
fn check(context: &Context, name: &str, b: Builder, radius: f64, places: &[[DVec3; 2]]) -> Vec<Found> {
    let scene = PackedScene::whole(&b.scene);
    let faces = faces(&scene);
    let places: Vec<Place> = places
        .iter()
        .map(|[at, way]| {
            let lift = 1e-3 * radius / scene.world_scale;
            let way = way.normalize();
            let origin = (((*at - scene.world_center) / scene.world_scale) - way * lift).as_vec3();
            let hit = scene.bvh.closest(&scene.triangles, origin, way.as_vec3(), 1e30);
            let hit = hit.unwrap_or_else(|| panic!("{name}: nothing lies at {at}"));
            let front = scene.triangles[hit.triangle as usize].normal().dot(way.as_vec3()) < 0.0;
            Place { triangle: hit.triangle, front, position: origin + way.as_vec3() * hit.t }
        })
        .collect();
    let radius = radius / scene.world_scale;
    let device = on_the_device(context, &scene, &places, radius as f32);
    let mut all = Vec::new();
    for (i, (place, (on_device, reach))) in places.iter().zip(device).enumerate() {
        let truth = truth(&faces, place, radius);
        let on_host = on_the_host(&scene, place, radius as f32);
        for (side, found) in [("host", &on_host), ("device", &on_device)] {
            let what = format!("{name}, place {i}, {side}: {found:?}");
            assert!((found.radius / truth.radius - 1.0).abs() < 1e-6, "{what}, radius {}", truth.radius);
            let circle = PI * truth.radius * truth.radius;
            let off = (found.area - truth.area) / circle;
            println!("{name}, place {i}, {side}: {:.5} {off:+.5}", truth.area / circle);
            assert!(
                off.abs() < TOLERANCE,
                "{what}: {} of a circle against {}",
                found.area / circle,
                truth.area / circle
            );
            assert_eq!(found.walls.len(), truth.walls.len(), "{what}");
            for w in &truth.walls {
                let is_it = |(n, offset): &(DVec3, f64)| {
                    n.dot(w.normal) > 1.0 - 1e-6 && (offset - w.offset).abs() < 1e-3 * truth.radius
                };
                assert!(found.walls.iter().any(is_it), "{what}: no wall {} {}", w.normal, w.offset);
            }
        }
        let whole = whole_reach(&faces, place, radius);
        assert!((reach - whole).abs() < 1e-5 * radius, "{name}, place {i}: whole up to {reach}, not {whole}");
        all.extend([on_host, on_device]);
    }
    all
}

const DOWN: DVec3 = DVec3::NEG_Y;

fn at(x: f64, z: f64) -> [DVec3; 2] {
    [DVec3::new(x, 0.0, z), DOWN]
}

/// A scene that begins with a matte material, number 0, and glass, number 1.
fn scene() -> Builder {
    let mut b = Builder::new([0., 8., 0.], [0.; 3], [0., 0., 1.], 0.5, 8);
    b.matte(0.5);
    b.material(glass(1.5));
    b
}

/// A horizontal rectangle that looks up.
fn plate(b: &mut Builder, low: [f64; 2], high: [f64; 2], y: f64) {
    b.quad([low[0], y, low[1]], [0., 0., high[1] - low[1]], [high[0] - low[0], 0., 0.], 0);
}

/// A floor of ±5 about the origin.
fn floor() -> Builder {
    let mut b = scene();
    plate(&mut b, [-5., -5.], [5., 5.], 0.0);
    b
}

/// A wall from `from` that goes so far in a direction, in degrees from x to z, between two heights.
fn stand(b: &mut Builder, from: [f64; 2], degrees: f64, length: f64, [low, high]: [f64; 2]) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    b.quad([from[0], low, from[1]], [length * cos, 0., length * sin], [0., high - low, 0.], 0);
}

/// The six outward sides of a box of a material.
fn block(b: &mut Builder, low: [f64; 3], high: [f64; 3], material: u32) {
    let [x, y, z] = low;
    let [dx, dy, dz] = [high[0] - x, high[1] - y, high[2] - z];
    b.quad(low, [dx, 0., 0.], [0., 0., dz], material);
    b.quad([x, y + dy, z], [0., 0., dz], [dx, 0., 0.], material);
    b.quad(low, [0., 0., dz], [0., dy, 0.], material);
    b.quad([x + dx, y, z], [0., dy, 0.], [0., 0., dz], material);
    b.quad(low, [0., dy, 0.], [dx, 0., 0.], material);
    b.quad([x, y, z + dz], [dx, 0., 0.], [0., dy, 0.], material);
}

/// Part of a circle of radius 1 within a straight line at this distance of its middle.
fn within(distance: f64) -> f64 {
    let d = distance.clamp(-1.0, 1.0);
    1.0 - (d.acos() - d * (1.0 - d * d).sqrt()) / PI
}

fn claim_parts(found: &[Found], parts: &[f64]) {
    for (i, (pair, part)) in found.chunks(2).zip(parts).enumerate() {
        for f in pair {
            let got = f.area / (PI * f.radius * f.radius);
            assert!((got - part).abs() < 2e-5, "place {i}: {got} of a circle, not {part}");
        }
    }
}

#[test]
fn a_plane_fills_the_circle() {
    let context = device_or_return!();
    let found = check(context, "plane", floor(), 1.0, &[at(0.3, 0.1), at(0.0, 0.0), at(-2.1, 3.3)]);
    claim_parts(&found, &[1.0; 3]);
}

/// Free edges: what strips narrower than a disc and the corner of a plate hold of it.
#[test]
fn free_edges_end_a_disc() {
    let context = device_or_return!();
    for width in [0.1, 0.4, 1.3] {
        let mut b = scene();
        plate(&mut b, [0.0, -4.0], [width, 4.0], 0.0);
        plate(&mut b, [3.0, -4.0], [3.0 + width, 4.0], 0.0);
        let shares = [0.5, 0.2];
        let found = check(context, "strip", b, 1.0, &shares.map(|s| at(s * width, 0.3)));
        let part = |s: &f64| within(s * width) + within((1.0 - s) * width) - 1.0;
        claim_parts(&found, &shares.iter().map(part).collect::<Vec<_>>());
    }
    let mut b = scene();
    plate(&mut b, [0., 0.], [5., 5.], 0.0);
    let places = [at(1e-4, 1e-4), at(0.3, 0.2), at(0.7, 0.9), at(1.5, 0.5), at(0.01, 2.0)];
    check(context, "corner", b, 1.0, &places);
}

/// The back of a plate is seen, or of a plate that faces the other way.
#[test]
fn either_side_has_a_disc() {
    let context = device_or_return!();
    let mut b = scene();
    plate(&mut b, [0., 0.], [5., 5.], 0.0);
    let up = |x: f64, z: f64| [DVec3::new(x, 0.0, z), DVec3::Y];
    check(context, "back", b, 1.0, &[up(0.3, 0.2), up(2.0, 0.1), up(2.5, 2.5)]);
    // a board: its other side counts where it is very thin
    for thickness in [0.02, 0.005] {
        let mut b = scene();
        block(&mut b, [0., -thickness, 0.], [2., 0., 2.], 0);
        check(context, "board", b, 1.0, &[at(0.3, 0.2), at(1.0, 1.2)]);
    }
}

/// Walls at any angle, and two at once; what does not come down to the surface is none.
#[test]
fn walls_end_a_disc() {
    let context = device_or_return!();
    for degrees in [0.0, 30.0, 77.0] {
        let mut b = floor();
        stand(&mut b, [-1.0, 0.5], degrees, 3.0, [0.0, 2.0]);
        let places = [at(0.0, 0.0), at(0.4, 0.3), at(-0.6, 1.4), at(1.0, -0.2)];
        check(context, &format!("wall at {degrees}"), b, 1.0, &places);
    }
    for degrees in [90.0, 60.0, 130.0] {
        let mut b = floor();
        stand(&mut b, [0., 0.], 0.0, 3.0, [0.0, 2.0]);
        stand(&mut b, [0., 0.], degrees, 3.0, [-1.0, 2.0]);
        let (sin, cos) = f64::to_radians(degrees / 2.0 - 7.0).sin_cos();
        let inside = [0.1, 0.4, 0.9, 1.5].map(|d| at(d * cos, d * sin));
        check(context, &format!("two walls at {degrees}"), b, 1.0, &inside);
    }
    for bottom in [0.0, 0.04, 0.06, 0.5] {
        let mut b = floor();
        stand(&mut b, [-2.0, 0.4], 10.0, 4.0, [bottom, 2.0]);
        let found = check(context, &format!("wall {bottom} above"), b, 1.0, &[at(0.0, 0.0), at(0.5, 1.0)]);
        assert!(found.iter().all(|f| f.walls.is_empty() == (bottom > 0.05)));
    }
}

/// Many short walls: whatever the order in which they are met, the second is the nearest one that does not stand behind the first.
#[test]
fn what_stands_behind_a_wall_hides_no_other() {
    let context = device_or_return!();
    let mut b = floor();
    for i in 0..160 {
        let [x, z, turn, length] = random(94, i).map(f64::from);
        stand(&mut b, [8.0 * x - 4.0, 8.0 * z - 4.0], 360.0 * turn, 0.2 + 0.4 * length, [0.0, 1.0]);
    }
    let places: Vec<[DVec3; 2]> = (0..60)
        .map(|i| {
            let [x, z, ..] = random(95, i).map(f64::from);
            at(7.0 * x - 3.5, 7.0 * z - 3.5)
        })
        .collect();
    let found = check(context, "short walls", b, 0.8, &places);
    assert!(found.iter().filter(|f| f.walls.len() == 2).count() > 60);
}

/// Glass that stands on a floor, or reaches into it, parts what lies beside it from what lies below.
#[test]
fn glass_is_a_wall_and_no_surface() {
    let context = device_or_return!();
    for bottom in [0.0, -0.3, 0.01] {
        let mut b = floor();
        block(&mut b, [0.0, bottom, -2.0], [2.5, 0.8, 2.0], 1);
        let places = [at(-0.3, 0.1), at(0.2, -1.4), at(0.6, 0.4), at(1.3, 0.2)];
        check(context, &format!("glass from {bottom}"), b, 1.0, &places);
    }
}

/// Two faces in one place are one surface, however they wind and are cut.
#[test]
fn doubled_faces_count_once() {
    let context = device_or_return!();
    for (name, flipped, low, high) in [
        ("same", false, [0.0, 0.0], [3.0, 3.0]),
        ("flipped", true, [0.0, 0.0], [3.0, 3.0]),
        ("larger", false, [-1.0, -0.7], [2.1, 2.3]),
        ("larger, flipped", true, [-1.0, -0.7], [2.1, 2.3]),
    ] {
        let mut b = scene();
        plate(&mut b, [0., 0.], [3., 3.], 0.0);
        // cut along the other diagonal
        let (dx, dz) = (high[0] - low[0], high[1] - low[1]);
        let corner = [high[0], 0., low[1]];
        if flipped {
            b.quad(corner, [-dx, 0., 0.], [0., 0., dz], 0);
        } else {
            b.quad(corner, [0., 0., dz], [-dx, 0., 0.], 0);
        }
        assert!(PackedScene::whole(&b.scene).has_contacts);
        let places = [at(1.0, 1.1), at(0.2, 0.3), at(1.5, 1.5), at(1.9, 2.2)];
        check(context, &format!("doubled, {name}"), b, 0.8, &places);
    }
}

/// Steps nearer to the plane than what a joton may be off are of the same disc; the lower one ends at the riser.
#[test]
fn low_steps_belong_together() {
    let context = device_or_return!();
    for (rise, riser) in [(0.15, true), (0.15, false), (0.25, true), (0.03, true)] {
        let mut b = scene();
        plate(&mut b, [-4., -4.], [0., 4.], 0.0);
        plate(&mut b, [0., -4.], [4., 4.], rise);
        if riser {
            stand(&mut b, [0., -4.], 90.0, 8.0, [0.0, rise]);
        }
        let places = [at(-0.3, 0.1), at(-0.8, 0.2), [DVec3::new(0.4, rise, 0.3), DOWN]];
        check(context, &format!("step of {rise}"), b, 1.0, &places);
    }
}

/// On a sphere a disc is a cap, of the area π r².
#[test]
fn curved_surfaces_have_their_area() {
    let context = device_or_return!();
    let mut b = scene();
    b.icosphere([0.; 3], 2.0, 3, true, 0);
    let places: Vec<[DVec3; 2]> = (0..12)
        .map(|i| {
            let d = random_direction(90, i).as_dvec3();
            [d * 2.0, -d]
        })
        .collect();
    let found = check(context, "sphere", b, 0.5, &places);
    for f in &found {
        // triangles as wide as the disc
        let got = f.area / (PI * f.radius * f.radius);
        assert!((got - 1.0).abs() < 0.05, "{got} of π r²");
    }
}

/// More triangles than a disc is measured with: it is halved, as often as it takes.
#[test]
fn discs_with_many_triangles_are_halved() {
    let context = device_or_return!();
    let mut b = scene();
    let height = |i: i32, j: i32| 0.04 * f64::from(random(91, (i * 100 + j) as usize)[0]);
    let n = 60;
    let corner =
        |i: i32, j: i32| DVec3::new(f64::from(i) * 0.1 - 3.0, height(i, j), f64::from(j) * 0.1 - 3.0);
    for i in 0..n {
        for j in 0..n {
            // some are missing
            if random(92, (i * 100 + j) as usize)[0] > 0.1 {
                b.triangle([corner(i, j), corner(i + 1, j + 1), corner(i + 1, j)], 0);
                b.triangle([corner(i, j), corner(i, j + 1), corner(i + 1, j + 1)], 0);
            }
        }
    }
    let places: Vec<[DVec3; 2]> = (0..12)
        .map(|i| {
            let [x, z, ..] = random(93, i);
            [DVec3::new(f64::from(x) * 4.0 - 2.0, 0.5, f64::from(z) * 4.0 - 2.0), DOWN]
        })
        .collect();
    let scale = PackedScene::whole(&b.scene).world_scale;
    let found = check(context, "rough floor", b, 1.0, &places);
    assert!(found.iter().all(|f| f.radius * scale <= 0.25 + 1e-6));
}

/// Slivers and crumbs: less than the least part of a circle. The disc is halved until there is enough, or it gets the least.
#[test]
fn next_to_nothing_is_no_weight_without_bound() {
    let context = device_or_return!();
    for width in [0.03, 0.01, 1e-4] {
        let mut b = floor();
        plate(&mut b, [0.0, -0.5 * width], [4.0, 0.5 * width], 2.0);
        check(context, "sliver", b, 1.0, &[[DVec3::new(1.3, 2.0, 0.0), DOWN]]);
    }
}

/// Triangles two thousand times as wide as the disc: near their shared diagonal, and near a wall whose foot is an edge.
#[test]
fn huge_triangles_keep_their_edges() {
    let context = device_or_return!();
    let mut b = scene();
    plate(&mut b, [-500., -500.], [500., 500.], 0.0);
    plate(&mut b, [500., -500.], [900., 500.], 0.0);
    stand(&mut b, [500., -500.], 90.0, 1000.0, [0.0, 100.0]);
    let places = [
        at(123.4, 123.41),
        at(-311.7, -311.9),
        at(499.9, 37.3),
        at(499.7, -401.0),
        at(500.2, 12.9),
        at(-499.8, 333.0),
    ];
    let found = check(context, "huge floor", b, 0.5, &places);
    assert_eq!(found.iter().filter(|f| f.walls.len() == 1).count(), 6);
}
