//! maps/disc.wgsl and the host's disc: radius, area and walls against a count over lattices in f64 [E31].

use crate::common::scenes::{Builder, glass};
use crate::common::{Row, Snippet, floats, pass_info, random, random_direction, row3, vec3};
use crate::device_or_return;
use crate::disc_count::{Place, faces, truth, whole_reach};
use glam::DVec3;
use joton::backend::cpu::harness;
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::Harness;
use joton::packed::PackedScene;
use std::f64::consts::PI;

/// What a count may be off, of the circle: a row of the lattice along an edge.
const TOLERANCE: f64 = 0.003;

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
