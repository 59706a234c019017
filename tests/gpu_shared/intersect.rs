//! accel/intersect.wgsl against a search over all triangles in f64, and against the host's hierarchy; shading/surface.wgsl.

use crate::common::scenes::icosphere;
use crate::common::world::{Ray, T_SCALE, World, trace};
use crate::common::{Row, Snippet, floats, random, random_direction, row3, vec3};
use crate::device_or_return;
use glam::{DVec3, Vec3};
use joton::backend::gpu::Context;
use joton::backend::gpu::harness::pack_normals;
use joton::packed::PackedTriangle;

/// Weights of the device may be off by this much: f32 cross products of coordinates near 1000.
const SLACK: f64 = 2e-5;

/// Every ray's closest hit lies between those of the triangles a little grown and a little shrunk; the host agrees.
fn check_closest(context: &Context, name: &str, world: &World, rays: &[Ray]) {
    let found = trace(context, world, rays, &[1e30], false);
    let mut hits = 0;
    for (&[o, d], (triangle, [t, u, v])) in rays.iter().zip(&found) {
        let (o64, d64) = (o.as_dvec3(), d.as_dvec3());
        let (grown, shrunk) = (world.nearest(o64, d64, SLACK), world.nearest(o64, d64, -SLACK));
        let host = world.bvh.closest(&world.triangles, o, d, 1e30);
        if *triangle == u32::MAX {
            assert!(shrunk.is_infinite(), "{name}: {o} {d} misses what lies at {shrunk}");
            assert!(host.is_none_or(|h| world.nearest(o64, d64, -SLACK).is_infinite() || h.t > 0.0));
            continue;
        }
        hits += 1;
        let t = f64::from(*t);
        let tolerance = 1e-5 * t.max(T_SCALE) / grazing(world, *triangle, d64);
        assert!(t > grown - tolerance, "{name}: {o} {d} at {t}, nothing is before {grown}");
        assert!(t < shrunk + tolerance, "{name}: {o} {d} at {t}, there is something at {shrunk}");
        let [rt, ru, rv] = world.meet(*triangle as usize, o64, d64).expect("a hit triangle is not edge-on");
        assert!((t - rt).abs() < tolerance, "{name}: the triangle is at {rt}, not {t}");
        let off = (f64::from(*u) - ru).abs().max((f64::from(*v) - rv).abs());
        assert!(off < 1e-3 / grazing(world, *triangle, d64), "{name}: weights {u} {v}, not {ru} {rv}");
        if let Some(h) = host
            && h.triangle == *triangle
        {
            assert!((f64::from(h.t) - t).abs() < tolerance, "{name}: the host says {}, the device {t}", h.t);
        }
    }
    assert!(
        hits * 20 > rays.len() || name == "one triangle",
        "{name}: only {hits} of {} rays hit",
        rays.len()
    );
}

/// |cosine| between ray and triangle, bounded: rays along a surface lose digits.
fn grazing(world: &World, triangle: u32, d: DVec3) -> f64 {
    let t = &world.triangles[triangle as usize];
    let n = t.e1.as_dvec3().cross(t.e2.as_dvec3());
    (n.dot(d).abs() / n.length().max(1e-30)).max(1e-3)
}

fn soup(count: usize, size: f32) -> Vec<[Vec3; 3]> {
    (0..count)
        .map(|i| {
            let [x, y, z, s] = random(40, i);
            let c = (Vec3::new(x, y, z) - 0.5) * 1000.0;
            // sizes over three decades, every tenth a sliver
            let s = size * 10f32.powf(2.0 * s - 2.0);
            let a = random_direction(41, i) * s;
            let b = random_direction(42, i) * if i % 10 == 0 { s * 0.01 } else { s };
            [c, c + a, c + b]
        })
        .collect()
}

fn ball(levels: u32, radius: f64, center: Vec3) -> Vec<[Vec3; 3]> {
    icosphere(levels).iter().map(|t| t.map(|p| (p * radius).as_vec3() + center)).collect()
}

fn random_rays(count: usize, spread: f32) -> Vec<Ray> {
    (0..count)
        .map(|i| {
            let [x, y, z, _] = random(43, i);
            [(Vec3::new(x, y, z) - 0.5) * spread, random_direction(44, i)]
        })
        .collect()
}

#[test]
fn closest_hits_are_those_of_a_search_over_all() {
    let context = device_or_return!();
    let rays = random_rays(2000, 1500.0);
    check_closest(context, "soup", &World::new(&soup(600, 300.0)), &rays);
    check_closest(context, "ball, from anywhere", &World::new(&ball(2, 400.0, Vec3::ZERO)), &rays);
    check_closest(
        context,
        "ball, from inside",
        &World::new(&ball(3, 500.0, Vec3::ZERO)),
        &random_rays(1000, 500.0),
    );
    let one =
        [[Vec3::new(-300.0, -200.0, 50.0), Vec3::new(400.0, -100.0, 0.0), Vec3::new(0.0, 300.0, -80.0)]];
    check_closest(context, "one triangle", &World::new(&one), &rays);
}

/// Squares in the planes of the axes: bounds without thickness, directions with zeros of either sign.
#[test]
fn axis_parallel_rays_hit_axis_parallel_walls() {
    let context = device_or_return!();
    let mut walls = Vec::new();
    for axis in 0..3 {
        for k in 0..6 {
            let at = [-500.0, -130.5, 0.0, 64.0, 200.25, 500.0][k];
            let corner = |u: f32, v: f32| {
                let mut p = [0.0; 3];
                (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (at, u, v);
                Vec3::from(p)
            };
            let s = 100.0 + 60.0 * k as f32;
            walls.push([corner(-s, -s), corner(s, -s), corner(s, s)]);
            walls.push([corner(-s, -s), corner(s, s), corner(-s, s)]);
        }
    }
    let world = World::new(&walls);
    let mut rays = Vec::new();
    for i in 0..600 {
        let [x, y, z, _] = random(45, i);
        let o = (Vec3::new(x, y, z) - 0.5) * 900.0;
        let zero = if i % 2 == 0 { 0.0 } else { -0.0 };
        for s in [1.0f32, -1.0] {
            rays.extend([
                [o, Vec3::new(s, zero, zero)],
                [o, Vec3::new(zero, s, zero)],
                [o, Vec3::new(zero, zero, s)],
            ]);
        }
        rays.push([o, Vec3::new(zero, 0.6, -0.8)]);
        rays.push([o, Vec3::new(1e-25, 0.6, 0.8)]);
    }
    check_closest(context, "walls", &world, &rays);
}

/// From inside a closed surface every ray hits, above all those that aim at edges and corners exactly.
#[test]
fn edges_and_corners_leak_nothing() {
    let context = device_or_return!();
    let center = Vec3::new(37.0, -11.0, 5.0);
    let triangles = ball(3, 500.0, center);
    let world = World::new(&triangles);
    let mut rays = Vec::new();
    for (i, &[a, b, c]) in triangles.iter().enumerate() {
        let [s, x, y, z] = random(46, i);
        let o = center + (Vec3::new(x, y, z) - 0.5) * 300.0;
        for target in [a, b, c, 0.5 * (a + b), a + (b - a) * s, c + (a - c) * s] {
            rays.push([o, (target - o).normalize()]);
            rays.push([center, (target - center).normalize()]);
        }
    }
    let found = trace(context, &world, &rays, &[1e30], false);
    let leaked = found.iter().filter(|h| h.0 == u32::MAX).count();
    assert_eq!(leaked, 0, "of {} rays", rays.len());
    for ([o, d], (_, [t, ..])) in rays.iter().zip(&found) {
        let r = (*o + *d * *t - center).length();
        assert!((485.0..500.1).contains(&r), "{o} {d} ends at radius {r}");
    }
}

/// Shadow rays: something in (0, limit), by a search over all.
#[test]
fn occlusion_is_a_search_over_all() {
    let context = device_or_return!();
    let worlds = [World::new(&soup(400, 300.0)), World::new(&ball(2, 400.0, Vec3::ZERO))];
    let limits = [50.0f32, 200.0, 700.0, 1e30];
    let rays = random_rays(2000, 1500.0);
    for world in &worlds {
        let mut blocked = 0;
        for (i, (&[o, d], (triangle, [t, ..]))) in
            rays.iter().zip(trace(context, world, &rays, &limits, true)).enumerate()
        {
            let limit = f64::from(limits[i % limits.len()]);
            let (grown, shrunk) = (
                world.nearest(o.as_dvec3(), d.as_dvec3(), SLACK),
                world.nearest(o.as_dvec3(), d.as_dvec3(), -SLACK),
            );
            if triangle == u32::MAX {
                assert!(
                    shrunk > limit * (1.0 - 1e-5) - 1e-2,
                    "{o} {d} is blocked at {shrunk} before {limit}"
                );
            } else {
                blocked += 1;
                assert!(
                    grown < limit * (1.0 + 1e-5) + 1e-2 && f64::from(t) < limit,
                    "{o} {d} is free until {limit}"
                );
            }
            let host = world.bvh.occluded(&world.triangles, o, d, limit as f32);
            if host != (triangle != u32::MAX) {
                let near_edge = (grown - shrunk).abs() > 1e-6 || (shrunk - limit).abs() < 1e-2;
                assert!(near_edge, "host and device differ on {o} {d} until {limit}");
            }
        }
        assert!((100..1900).contains(&blocked), "{blocked} of {} rays are blocked", rays.len());
    }
}

/// Positions, normals and offsets at hits.
#[test]
fn surfaces_lie_where_rays_hit() {
    let context = device_or_return!();
    let world = World::new(&ball(2, 400.0, Vec3::ZERO));
    let mut harness = world.harness(context);
    let smooth: Vec<PackedTriangle> =
        world.triangles.iter().map(|t| PackedTriangle { flags: joton::packed::SMOOTH, ..*t }).collect();
    harness.scene("triangles", &smooth);
    let radial = |t: &PackedTriangle| pack_normals(t.vertices().map(|p| p.normalize()));
    harness.scene("normals", &smooth.iter().map(radial).collect::<Vec<_>>());
    let rays = random_rays(2000, 400.0);
    let inputs: Vec<[Row; 2]> = rays.iter().map(|r| [row3(r[0], 0.0), row3(r[1], 0.0)]).collect();
    let code = "let h = traverse(in_f(0u).xyz, in_f(1u).xyz, 1e30, false);
        let s = surface_at(h);
        out_f(0u, vec4(s.position, h.t)); out_f(1u, vec4(s.front, select(0.0, 1.0, s.is_smooth)));
        out_f(2u, vec4(s.shading, 0.0)); out_f(3u, vec4(departure(s, -s.front, true).origin, s.lift));
        // from the offset origin the same wall is not met again along its own plane and inward
        let again = traverse(departure(s, -s.front, true).origin, -s.front, 1.0, true);
        out_u(4u, vec4(h.triangle, again.triangle, 0u, 0u));";
    let snippet = Snippet::new(
        &["scene/features.wgsl", "scene/scene.wgsl", "sampling/sampling.wgsl", "shading/surface.wgsl"],
        code,
    );
    let pass = crate::common::pass_info();
    let out: Vec<[Row; 5]> =
        snippet.run_in(context, &mut harness, &[("pass_info", bytemuck::bytes_of(&pass))], &inputs);
    for ([o, d], [position, front, shading, off, ids]) in rays.iter().zip(out) {
        assert_ne!(ids[0], u32::MAX);
        let p = vec3(position);
        assert!((p - (*o + *d * floats(position)[3])).length() < 2e-3);
        let flat = smooth[ids[0] as usize].normal();
        assert!((vec3(front) - flat).length() < 1e-5 && floats(front)[3] == 1.0);
        assert!(flat.dot(p) > 0.0, "counter-clockwise is outward");
        assert!(
            (vec3(shading) - p.normalize()).length() < 0.01,
            "interpolated normals of a sphere are radial"
        );
        let step = (vec3(off) - p).dot(-vec3(front));
        // eight half units in the last place, of 400 and the edges
        assert!(step > 1e-4 && step < 6e-4, "a lift of {step} at coordinates of 400");
        assert_eq!(ids[1], u32::MAX, "a ray that leaves the wall meets it again");
    }
}

/// A turned cube whose faces are cut unevenly into many triangles.
fn cut_cube() -> Vec<[Vec3; 3]> {
    let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, 0.4, 1.1);
    let cuts = [-1.0, -0.999, -0.7, -0.1, 0.0, 0.55, 0.9, 1.0];
    let mut triangles = Vec::new();
    for axis in 0..3 {
        for side in [-1.0, 1.0] {
            for (x, y) in (0..7).flat_map(|x| (0..7).map(move |y| (x, y))) {
                let corner = |i: usize, j: usize| {
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, cuts[i], cuts[j]);
                    (turn * DVec3::from(p) * 400.0).as_vec3()
                };
                let [a, b, c, d] = [corner(x, y), corner(x + 1, y), corner(x + 1, y + 1), corner(x, y + 1)];
                triangles.extend(if side > 0.0 { [[a, b, c], [a, c, d]] } else { [[c, b, a], [d, c, a]] });
            }
        }
    }
    triangles
}

/// What leaves a convex body meets nothing; what goes back into it meets no triangle of the face that it left. Grazing rays,
/// too, on faces of many triangles, turned so that every coordinate is rounded.
#[test]
fn rays_leave_a_surface_without_meeting_it_again() {
    let context = device_or_return!();
    let code = "let h = traverse(vec3(0.0), in_f(0u).xyz, 1e30, false);
        let s = surface_at(h);
        let d = in_f(1u).xyz;
        let outward = d * select(-1.0, 1.0, dot(d, s.front) >= 0.0);
        let out = departure(s, outward, true);
        let inside = departure(s, -outward, false);
        let through = departure(s, outward, false);
        let a = trace_ray(out.origin, outward, 1e30, out.t_back, false, vec3(0.0));
        let b = trace_ray(inside.origin, -outward, 1e30, inside.t_back, false, vec3(0.0));
        let c = trace_ray(through.origin, outward, 1e30, through.t_back, false, vec3(0.0));
        var same = false;
        if b.triangle != MISS {
            same = dot(surface_at(b).front, s.front) > 0.99;
        }
        out_u(0u, vec4(h.triangle, a.triangle, select(0u, 1u, same), c.triangle));";
    let snippet = Snippet::new(
        &["scene/features.wgsl", "scene/scene.wgsl", "sampling/sampling.wgsl", "shading/surface.wgsl"],
        code,
    );
    for (name, triangles) in [("cube", cut_cube()), ("ball", ball(3, 500.0, Vec3::ZERO))] {
        let world = World::new(&triangles);
        let inputs: Vec<[Row; 2]> = (0..100_000)
            .map(|i| {
                let normal = random_direction(50, i);
                let near = random_direction(51, i);
                // a third of the rays graze what they leave, wherever that is
                let d =
                    if i % 3 == 0 { (near - normal * near.dot(normal) * 0.999).normalize() } else { near };
                [row3(normal, 0.0), row3(d, 0.0)]
            })
            .collect();
        let pass = crate::common::pass_info();
        let mut harness = world.harness(context);
        let out: Vec<[Row; 1]> =
            snippet.run_in(context, &mut harness, &[("pass_info", bytemuck::bytes_of(&pass))], &inputs);
        let count = |bad: &dyn Fn(&Row) -> bool| out.iter().filter(|r| bad(&r[0])).count();
        assert_eq!(count(&|r| r[0] == u32::MAX), 0, "{name}: rays that leak");
        assert_eq!(count(&|r| r[1] != u32::MAX), 0, "{name}: rays that leave and meet it again");
        assert_eq!(count(&|r| r[3] != u32::MAX), 0, "{name}: rays through it that meet it again");
        let on_curved = name != "cube";
        assert!(on_curved || count(&|r| r[2] == 1) == 0, "{name}: rays inward that meet the face they left");
    }
}
