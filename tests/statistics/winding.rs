//! Winding: which way the faces of opaque bodies are turned says nothing. A closed ball, an open one, and the walls of a room
//! look the same with faces turned, some or all, and with each face doubled.

use crate::common::scenes::{Builder, emitter, glass};
use crate::renders::{EVERYTHING, Planner, Side, plan, plan_by_map, run};
use glam::DVec3;
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::sampling::rng::random4;
use joton::scene::{Scene, Triangle};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Part of the light by which two windings may differ: the lattices of area points and the order of sums do.
const SAME: f64 = 0.02;
/// … and a map of a few passes from the path tracer: its discs are a third of the ball wide.
const NEAR: f64 = 0.06;
const PASSES: u64 = 8;
const PASSES_OF_PATHS: u64 = 256;
const REFLECTANCE: f32 = 0.6;

/// How the faces of what is not a lamp are turned.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Turned {
    None,
    /// This part of them.
    Some(f32),
    /// Every face has a copy that looks the other way, cut along the other diagonal.
    Doubled,
}

/// A ball of quads, as open as its first rings are left out.
fn ball(b: &mut Builder, center: [f64; 3], radius: f64, from: usize, material: u32) {
    const RINGS: usize = 12;
    const AROUND: usize = 24;
    let at = |ring: usize, i: usize| {
        let (polar, around) = (PI * ring as f64 / RINGS as f64, TAU * (i % AROUND) as f64 / AROUND as f64);
        // the poles are one point each
        let off = if ring == 0 || ring == RINGS { 0.0 } else { polar.sin() };
        DVec3::from(center) + radius * DVec3::new(off * around.cos(), -polar.cos(), -off * around.sin())
    };
    for ring in from..RINGS {
        for i in 0..AROUND {
            let [p, q, r, s] = [at(ring, i), at(ring, i + 1), at(ring + 1, i + 1), at(ring + 1, i)];
            if ring > 0 {
                b.triangle([p, q, r], material);
            }
            if ring + 1 < RINGS {
                b.triangle([p, r, s], material);
            }
        }
    }
}

/// The ball in a room with a lamp, an eighth of it open where `from` is 2.
fn scene(from: usize) -> Scene {
    let mut b = Builder::new([0., 0.3, 0.95], [0., -0.3, 0.], [0., 1., 0.], 0.45, 24);
    let (walls, matte) = (b.matte(0.7), b.matte(REFLECTANCE));
    let lamp = b.material(emitter(10.0, 0.0));
    b.room([-1.; 3], [1.; 3], walls);
    b.quad([-0.25, 0.99, -0.25], [0.5, 0., 0.], [0., 0., 0.5], lamp);
    ball(&mut b, [0., -0.4, 0.], 0.4, from, matte);
    b.scene
}

/// Triangles of this material turned.
fn with_turned(scene: &Scene, material: u32, how: Turned) -> Scene {
    let mut scene = scene.clone();
    let turn = |t: &Triangle| Triangle { vertex: [0, 2, 1].map(|k| t.vertex[k]), ..*t };
    match how {
        Turned::None => {}
        Turned::Some(part) => {
            for (i, t) in (0u32..).zip(&mut scene.mesh.triangles) {
                if t.material == material && random4(1, 2, i, 3)[0] < part {
                    *t = turn(t);
                }
            }
        }
        Turned::Doubled => {
            let own = |t: &&Triangle| t.material == material;
            let mut more: Vec<Triangle> = scene.mesh.triangles.iter().filter(own).map(turn).collect();
            // halves of one quad follow each other: (p r q), (p s r) become (p s q), (q s r)
            let at = |v: u32| scene.mesh.positions[v as usize];
            for i in 1..more.len() {
                let ([p, r, q], [p2, s, r2]) = (more[i - 1].vertex, more[i].vertex);
                let diamond = at(p) == at(p2) && at(r) == at(r2) && at(s) != at(q);
                if diamond && (at(p) - at(q)).dot(at(s) - at(r)).abs() > 0.0 {
                    (more[i - 1].vertex, more[i].vertex) = ([p, s, q], [q, s, r]);
                }
            }
            scene.mesh.triangles.extend(more);
        }
    }
    scene
}

/// Diffuse light of the picture, mean of a band.
fn diffuse(side: Side, planner: Planner, scene: &Scene, passes: u64) -> f64 {
    let scene = Arc::new(PackedScene::whole(scene));
    let pixels = &run(side, &scene, planner(&scene, EVERYTHING, 7), passes).picture.layers
        [Layer::Diffuse as usize]
        .pixels;
    pixels.iter().map(|p| f64::from(p[0])).sum::<f64>() / pixels.len() as f64
}

/// Whatever way the faces of a ball or of the walls are turned, the diffuse light is that of the plain scene, which is near the
/// path tracer's. With a tenth of the faces turned the ball was three times too bright.
fn same_light(side: Side, planner: Planner) {
    for (from, truth) in [(0, true), (2, false)] {
        let plain = scene(from);
        let wanted = diffuse(side, planner, &plain, PASSES);
        if truth {
            let paths = diffuse(Side::PathTracer, plan, &plain, PASSES_OF_PATHS);
            assert!((wanted / paths - 1.0).abs() < NEAR, "{side:?}: {wanted}, path tracer {paths}");
        }
        for how in [Turned::Some(0.1), Turned::Some(0.5), Turned::Some(1.0), Turned::Doubled] {
            let found = diffuse(side, planner, &with_turned(&plain, 1, how), PASSES);
            assert!(
                (found / wanted - 1.0).abs() < SAME,
                "{side:?}, open {from}, {how:?}: {found}, not {wanted}"
            );
        }
        let found = diffuse(side, planner, &with_turned(&plain, 0, Turned::Some(0.5)), PASSES);
        assert!((found / wanted - 1.0).abs() < SAME, "{side:?}, open {from}, walls: {found}, not {wanted}");
    }
}

#[test]
fn turned_faces_look_the_same_on_the_host() {
    same_light(Side::Host, plan_by_map);
    same_light(Side::Host, plan);
}

#[test]
fn turned_faces_look_the_same_on_the_device() {
    if crate::common::device().is_some() {
        same_light(Side::Device, plan_by_map);
        same_light(Side::Device, plan);
    }
}

/// The path tracer never asks for the winding: the same picture, but for rounding.
#[test]
fn turned_faces_look_the_same_to_the_path_tracer() {
    let plain = scene(0);
    let [wanted, found] = [Turned::None, Turned::Some(0.5)]
        .map(|how| diffuse(Side::PathTracer, plan, &with_turned(&plain, 1, how), PASSES));
    assert!((found / wanted - 1.0).abs() < SAME, "{found}, not {wanted}");
}

/// Front normals of the packed triangles of a material, with their places, sorted.
fn fronts(scene: &Scene, material: u32) -> Vec<[i64; 6]> {
    let packed = PackedScene::whole(scene);
    let mut all: Vec<[i64; 6]> = packed
        .triangles
        .iter()
        .filter(|t| t.material == material)
        .map(|t| {
            let middle = t.v0 + (t.e1 + t.e2) / 3.0;
            let [a, b] = [middle, t.normal() * 100.0].map(|v| v.to_array().map(|x| x.round() as i64));
            [a[0], a[1], a[2], b[0], b[1], b[2]]
        })
        .collect();
    all.sort_unstable();
    all
}

/// Closed balls look outward and rooms toward the camera inside, however they come; copies are gone.
#[test]
fn bodies_are_turned_alike() {
    let plain = scene(0);
    let center = PackedScene::whole(&plain).world_center;
    for material in [0, 1] {
        let wanted = fronts(&plain, material);
        for how in [Turned::Some(0.1), Turned::Some(0.5), Turned::Some(1.0)] {
            assert_eq!(fronts(&with_turned(&plain, material, how), material), wanted, "{how:?}");
        }
        let mut copied = plain.clone();
        let turned = with_turned(&plain, material, Turned::Some(1.0)).mesh.triangles;
        copied.mesh.triangles.extend(turned.into_iter().filter(|t| t.material == material));
        assert_eq!(fronts(&copied, material), wanted, "copies");
    }
    let packed = PackedScene::whole(&plain);
    let middle = ((DVec3::new(0., -0.4, 0.) - center) / packed.world_scale).as_vec3();
    let outward = |m: u32| {
        let mut of = packed.triangles.iter().filter(|t| t.material == m);
        of.all(|t| (t.normal().dot(t.v0 - middle) > 0.0) == (m == 1))
    };
    assert!(outward(0) && outward(1));
}

/// Shading normals are of the front that a triangle comes to have: those of a smooth ball point outward, whichever way its
/// faces came, with normals of their own front as the reader of files leaves them.
#[test]
fn shading_normals_turn_with_their_faces() {
    let mut b = Builder::new([0., 0., 5.], [0.; 3], [0., 1., 0.], 0.5, 8);
    let matte = b.matte(0.5);
    b.icosphere([0.; 3], 1.0, 2, true, matte);
    for (i, t) in (0u32..).zip(&mut b.scene.mesh.triangles) {
        if random4(1, 2, i, 3)[0] < 0.4 {
            t.vertex.swap(1, 2);
            if let Some(n) = &mut t.normal {
                n.swap(1, 2);
                n.iter().for_each(|&n| b.scene.mesh.normals[n as usize] *= -1.0);
            }
        }
    }
    let packed = PackedScene::whole(&b.scene);
    for (t, normals) in packed.triangles.iter().zip(packed.shading_normals.iter()) {
        for (v, n) in t.vertices().into_iter().zip(normals) {
            assert!(n.dot(v.normalize()) > 0.9999 && n.dot(t.normal()) > 0.9, "{n} at {v}");
        }
    }
}

/// What a front means stays: light from a lamp's face, the inside of glass, one of two colours in one place.
#[test]
fn fronts_that_mean_something_stay() {
    let mut b = Builder::new([0., 0., 5.], [0.; 3], [0., 1., 0.], 0.5, 8);
    let materials = [b.material(emitter(1.0, 0.0)), b.material(glass(1.5)), b.matte(0.2), b.matte(0.8)];
    ball(&mut b, [-2., 0., 0.], 0.5, 0, materials[0]);
    ball(&mut b, [2., 0., 0.], 0.5, 0, materials[1]);
    // a sheet, red before and blue behind
    b.quad([-0.5, -0.5, 0.], [1., 0., 0.], [0., 1., 0.], materials[2]);
    b.quad([-0.5, -0.5, 0.], [0., 1., 0.], [1., 0., 0.], materials[3]);
    for material in materials {
        // a sheet's face that is turned would be a copy of the other one, and be there once
        let is_sheet = materials[2..].contains(&material);
        for how in
            if is_sheet { [Turned::None].to_vec() } else { [Turned::Some(0.5), Turned::Some(1.0)].to_vec() }
        {
            let scene = with_turned(&b.scene, material, how);
            let packed = PackedScene::whole(&scene);
            let count = |z: bool| {
                let of = packed.triangles.iter().filter(|t| t.material == material);
                of.filter(|t| (t.normal().dot(t.v0) > 0.0) == z && t.normal().z.abs() < 2.0).count()
            };
            let given = |z: bool| {
                let of = scene.mesh.triangles.iter().filter(|t| t.material == material);
                let normal = |t: &Triangle| {
                    let [p, q, r] = t.vertex.map(|v| scene.mesh.positions[v as usize]);
                    ((q - p).cross(r - p), p)
                };
                of.map(normal).filter(|(n, p)| (n.dot(*p - packed.world_center) > 0.0) == z).count()
            };
            assert_eq!([count(true), count(false)], [given(true), given(false)], "{material} {how:?}");
        }
    }
}
