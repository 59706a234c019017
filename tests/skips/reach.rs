//! What lies outside of a closed room is left out, and nothing else: a way out, or a doubt, keeps all.

use crate::common::random;
use crate::common::scenes::{Builder, emitter, glass};
use crate::common::twins::{self, EVERYTHING};
use crate::renders::{Side, both, is_alike, packed, plan, run, unresolved};
use glam::{DAffine3, DMat3, DVec3, Vec3};
use joton::film::Picture;
use joton::packed::{OutOfReach, PackedScene};
use joton::plan::Part;
use joton::scene::{Light, Scene, Triangle};
use proptest::prelude::*;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

const SIZE: u32 = 16;
/// Triangles of a box, and of a quad.
const BOX: usize = 12;
const QUAD: usize = 2;

/// A room two units wide with a lamp, and the camera in it; its walls come first.
fn room() -> Builder {
    let mut b = Builder::new([0.1, 0.2, 0.7], [0., 0., -1.], [0., 1., 0.], 0.5, SIZE);
    let (white, lamp) = (b.matte(0.6), b.material(emitter(5.0, 0.0)));
    b.room([-1.; 3], [1.; 3], white);
    b.quad([-0.2, 0.9, -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    b
}

/// A lamp far from the room.
fn add_lamp(b: &mut Builder) {
    let lamp = b.material(emitter(7.0, 0.2));
    b.quad([5., 0., 0.], [0., 1., 0.], [0., 0., 1.], lamp);
}

fn with_lamp(mut b: Builder) -> Scene {
    add_lamp(&mut b);
    b.scene
}

/// A box, a lamp, a point, a spot and a sun outside of a closed room leave no trace: all that is packed is what the room alone
/// gives, so that radii, odds and scale are those of the room.
#[test]
fn a_room_with_an_outside_is_the_room_alone() {
    let alone = room().scene;
    let mut b = Builder { scene: alone.clone() };
    let (position, intensity) = (DVec3::new(0.0, 3.0, 0.0), [9.0; 3]);
    let direction = DVec3::NEG_Y;
    b.scene.lights.extend([
        Light::Point { position, intensity },
        Light::Spot {
            position,
            direction,
            intensity,
            angle_inner: f64::acos(0.9),
            angle_outer: f64::acos(0.8),
        },
        Light::Sun { direction, irradiance: [3.0; 3] },
    ]);
    b.room([-9., -3., 2.], [-4., 4., 3.], 0);
    add_lamp(&mut b);
    let (room, rest) = (PackedScene::new(&alone), PackedScene::new(&b.scene));
    assert_eq!(rest.out_of_reach, OutOfReach { triangles: BOX + QUAD, lights: 3 });
    assert!(room.out_of_reach.is_empty());
    assert!(bytemuck::cast_slice::<_, u8>(&room.triangles) == bytemuck::cast_slice::<_, u8>(&rest.triangles));
    assert!(bytemuck::cast_slice::<_, u8>(&room.emitters) == bytemuck::cast_slice::<_, u8>(&rest.emitters));
    assert!(room.bvh.nodes() == rest.bvh.nodes());
    assert_eq!(
        (room.bounds, room.diffuse_area, room.world_scale, room.world_center),
        (rest.bounds, rest.diffuse_area, rest.world_scale, rest.world_center)
    );
    let whole = PackedScene::whole(&b.scene);
    assert_eq!(whole.triangles.len(), b.scene.mesh.triangles.len());
    assert_eq!(whole.emitters.len(), 2 * QUAD + 3);
}

/// Closed rooms that are no plain boxes.
#[test]
fn closed_rooms_of_all_kinds_are_found() {
    let lost = |name: &str, b: Builder, triangles: usize| {
        let found = PackedScene::new(&with_lamp(b)).out_of_reach.triangles;
        assert_eq!(found, triangles + QUAD, "{name}");
    };
    let mut turned = room();
    turned.scene.mesh.triangles[..BOX].iter_mut().step_by(5).for_each(|t| t.vertex.swap(0, 1));
    lost("walls that face in and out", turned, 0);

    let mut doubled = room();
    doubled.room([1.; 3], [-1.; 3], 0);
    lost("walls with a second face", doubled, 0);

    let mut house = room();
    house.room([-3.; 3], [3.; 3], 0);
    lost("a room in a room", house, BOX);

    let mut shelf = room();
    shelf.quad([-1., -1., -1.], [2., 0., 0.], [0., 0.3, 0.7], 0);
    lost("a shelf along an edge of the room", shelf, 0);

    let mut neighbour = room();
    // five walls more: what was the wall at x = 1 parts two rooms
    let wall = neighbour.scene.mesh.triangles.len();
    neighbour.room([1., -1., -1.], [4., 1., 1.], 0);
    let parts =
        |t: &Triangle, b: &Builder| t.vertex.iter().all(|&v| b.scene.mesh.positions[v as usize].x == 1.0);
    let own: Vec<Triangle> = neighbour.scene.mesh.triangles.clone();
    let kept = own.iter().enumerate().filter(|(i, t)| *i < wall || !parts(t, &neighbour)).map(|(_, t)| *t);
    neighbour.scene.mesh.triangles = kept.collect();
    // four of its walls begin where the first room ends, and only touch it
    lost("two rooms with one wall between", neighbour, QUAD);

    let mut cave = Builder::new([0.1, 0.2, 0.3], [0., 0., -1.], [0., 1., 0.], 0.5, SIZE);
    let rock = cave.matte(0.5);
    cave.icosphere([0.; 3], 1.0, 3, true, rock);
    let lamp = cave.material(emitter(5.0, 0.0));
    cave.quad([-0.2, 0.9, -0.2], [0.4, 0., 0.], [0., 0., 0.4], lamp);
    for i in 0..4 {
        // in the way of a look at the wall
        cave.icosphere([-0.5, -0.5 + 0.2 * f64::from(i), 0.], 0.05, 1, false, rock);
    }
    lost("a cave", cave, 0);
}

/// Rooms with a way out, cameras that may be outside, and what may be seen through a wall by rounding: all is kept.
#[test]
fn a_way_out_or_a_doubt_keeps_all() {
    let is_whole = |name: &str, b: Builder| {
        let found = PackedScene::new(&with_lamp(b)).out_of_reach;
        assert!(found.is_empty(), "{name}: {found:?}");
    };
    for triangle in 0..BOX {
        let mut gap = room();
        gap.scene.mesh.triangles.remove(triangle);
        is_whole("one triangle is missing", gap);

        let mut window = room();
        let pane = window.material(glass(1.5));
        window.scene.mesh.triangles[triangle].material = pane;
        is_whole("one triangle is of glass", window);

        let mut moved = room();
        let corner = moved.scene.mesh.triangles[triangle].vertex[1];
        moved.scene.mesh.positions[corner as usize].x *= 1.0 + f64::EPSILON;
        is_whole("one corner is a little off", moved);
    }
    let mut split = room();
    // a corner in the middle of the floor's edge, which the wall above does not have
    let t = split.scene.mesh.triangles.remove(0);
    let [a, b, c] = t.vertex.map(|v| split.scene.mesh.positions[v as usize]);
    let middle = 0.5 * (a + b);
    split.triangle([a, middle, c], 0);
    split.triangle([middle, b, c], 0);
    is_whole("a corner in an edge", split);

    let mut slabs = room();
    slabs.scene.mesh.triangles.drain(..BOX);
    for axis in DVec3::AXES {
        for side in [-1.0, 1.0] {
            let (center, half) = (axis * side, DVec3::ONE - axis * 0.9);
            slabs.room((center - half * 1.2).to_array(), (center + half * 1.2).to_array(), 0);
        }
    }
    is_whole("walls that are boxes of their own", slabs);

    let mut outside = room();
    outside.scene.camera.position = DVec3::new(0.0, 0.0, 1.5);
    is_whole("the camera is outside", outside);
    for off in [-1e-6, 0.0, 1e-6] {
        let mut on = room();
        on.scene.camera.position = DVec3::new(0.1, 0.2, 1.0 + off);
        is_whole("the camera is on a wall", on);
    }
    let mut furniture = room();
    furniture.scene.mesh.triangles.drain(..BOX);
    furniture.icosphere([0., 0., 3.], 1.0, 2, false, 0);
    is_whole("the camera is before a closed body", furniture);
}

/// What touches the room, reaches into its bounds or is as near as rounding is kept.
#[test]
fn what_is_at_the_wall_is_kept() {
    let lost = |name: &str, add: &dyn Fn(&mut Builder), triangles: usize, lights: usize| {
        let mut b = room();
        add(&mut b);
        // without it there is no need to look: all lies within the bounds of the room
        let found = PackedScene::new(&with_lamp(b)).out_of_reach;
        assert_eq!(found, OutOfReach { triangles: triangles + QUAD, lights }, "{name}");
    };
    let lamp_at = |x: f64| {
        move |b: &mut Builder| {
            let lamp = b.material(emitter(1.0, 0.0));
            b.quad([x, 0., 0.], [0., 1., 0.], [0., 0., 1.], lamp);
        }
    };
    lost("a lamp in the wall", &lamp_at(1.0), 0, 0);
    lost("a lamp nearly in the wall", &lamp_at(1.0 + 1e-7), 0, 0);
    lost("a lamp behind the wall", &lamp_at(1.01), QUAD, 0);
    lost("a beam through the wall", &|b| b.quad([0.5, 0., 0.], [3., 0., 0.], [0., 0., 0.1], 0), 0, 0);
    lost("a point in the room", &|b| b.point_light([0.9, 0.9, 0.9], 1.0), 0, 0);
    lost("a point in the wall", &|b| b.point_light([1.0, 0.0, 0.0], 1.0), 0, 0);
    lost("a point behind the wall", &|b| b.point_light([1.01, 0.0, 0.0], 1.0), 0, 1);
}

/// A box that a random room is made of, and what is around it.
#[derive(Debug)]
struct Recipe {
    /// Where the room stands, how it is turned, and how wide it is.
    turn: f64,
    half: [f64; 3],
    /// Wall that is missing or of glass.
    gap: Option<(usize, bool)>,
    /// Centres and half widths of boxes, in half widths of the room.
    boxes: Vec<([f64; 3], f64)>,
}

fn recipe() -> impl Strategy<Value = Recipe> {
    let boxes = prop::collection::vec((prop::array::uniform3(-4.0..4.0f64), 0.01..1.5f64), 1..12);
    let gap = prop::option::of((0..BOX, any::<bool>()));
    (0.0..6.0f64, prop::array::uniform3(0.2..3.0f64), gap, boxes)
        .prop_map(|(turn, half, gap, boxes)| Recipe { turn, half, gap, boxes })
}

/// Where the camera stands in the room, in its half widths.
const EYE: DVec3 = DVec3::new(-0.3, 0.1, 0.2);

/// The scene of a recipe, each triangle with a material of its own, so that it can be told again.
fn build(r: &Recipe) -> Scene {
    let place = DAffine3::from_mat3_translation(
        DMat3::from_axis_angle(DVec3::new(0.6, 0.64, 0.48), r.turn) * DMat3::from_diagonal(r.half.into()),
        DVec3::new(7.0, -3.0, 11.0),
    );
    let mut b = Builder::new([0.; 3], [0., 0., -1.], [0., 1., 0.], 0.5, SIZE);
    b.room([-1.; 3], [1.; 3], 0);
    for &(center, half) in &r.boxes {
        let c = DVec3::from(center);
        b.room((c - half).to_array(), (c + half).to_array(), 0);
    }
    b.point_light([0.1, 0.2, 0.3], 1.0);
    b.scene.mesh.positions.iter_mut().for_each(|p| *p = place.transform_point3(*p));
    for i in 0..b.scene.mesh.triangles.len() {
        let of_glass = r.gap.is_some_and(|(gap, pane)| pane && gap == i);
        b.scene.mesh.triangles[i].material = if of_glass { b.material(glass(1.5)) } else { b.matte(0.5) };
    }
    if let Some((gap, false)) = r.gap {
        b.scene.mesh.triangles.remove(gap);
    }
    let Light::Point { position, .. } = &mut b.scene.lights[0] else { unreachable!("a point") };
    *position = place.transform_point3(*position);
    b.scene.camera.position = place.transform_point3(EYE);
    b.scene.camera.target = place.transform_point3(DVec3::X);
    b.scene
}

/// Materials of all triangles that random walks from the camera meet.
fn met(scene: &PackedScene, walks: usize, steps: usize) -> std::collections::BTreeSet<u32> {
    let mut found = std::collections::BTreeSet::new();
    for walk in 0..walks {
        let mut origin = scene.camera.eye;
        let mut direction = crate::common::random_direction(1, walk);
        for step in 0..steps {
            let hit = scene.bvh.closest(&scene.triangles, origin, direction, f32::INFINITY);
            let Some(hit) = hit else { break };
            let t = &scene.triangles[hit.triangle as usize];
            found.insert(t.material);
            let number = walk * steps + step;
            let opaque = !scene.materials[t.material as usize].flags().is_dielectric();
            let back = if direction.dot(t.normal()) < 0.0 { t.normal() } else { -t.normal() };
            let passes = !opaque && random(2, number)[0] < 0.5;
            let side = if passes { -back } else { back };
            // far enough off the wall for rounding
            origin += direction * hit.t + side * 0.01;
            let next: Vec3 = crate::common::random_direction(3, number);
            direction = if next.dot(side) < 0.0 { -next } else { next };
        }
    }
    found
}

/// Random rooms, turned, with a gap, a pane or neither, and boxes in and around them: what is left out is met by no walk, and
/// where the room is closed all that is outside of its bounds is left out.
#[test]
fn random_walks_meet_nothing_that_is_left_out() {
    let check = |r: &Recipe| -> Result<(), TestCaseError> {
        let scene = build(r);
        let (whole, rest) = (PackedScene::whole(&scene), PackedScene::new(&scene));
        let kept: std::collections::BTreeSet<u32> = rest.triangles.iter().map(|t| t.material).collect();
        for material in met(&whole, 64, 32) {
            prop_assert!(kept.contains(&material), "triangle {material} is met");
        }
        let corners = |t: &Triangle| t.vertex.map(|v| scene.mesh.positions[v as usize]);
        // what the camera stands in: the room, where it is closed, and boxes about it
        let first = if matches!(r.gap, Some((_, false))) { BOX - 1 } else { BOX };
        let holds_camera =
            |&(center, half): &([f64; 3], f64)| (DVec3::from(center) - EYE).abs().max_element() < half;
        let boxes = (0..r.boxes.len()).filter(|&i| holds_camera(&r.boxes[i])).map(|i| first + i * BOX);
        let about = r.gap.is_none().then_some(0).into_iter().chain(boxes).map(|i| {
            let walls = scene.mesh.triangles[i..i + BOX].iter().flat_map(corners);
            walls.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(lo, hi), p| (lo.min(p), hi.max(p)))
        });
        let about: Vec<(DVec3, DVec3)> = about.collect();
        let outside = |t: &&Triangle| {
            let [a, b, c] = corners(t);
            let is_off = |(lo, hi): &(DVec3, DVec3)| {
                a.min(b).min(c).cmpgt(*hi).any() || a.max(b).max(c).cmplt(*lo).any()
            };
            about.iter().any(is_off)
        };
        let expected = scene.mesh.triangles.iter().filter(outside).count();
        prop_assert_eq!(rest.out_of_reach.triangles, expected);
        prop_assert_eq!(rest.out_of_reach.lights, 0);
        Ok(())
    };
    let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &[7; 32]);
    let config = Config { cases: 64, failure_persistence: None, ..Config::default() };
    let result = TestRunner::new_with_rng(config, rng).run(&recipe(), |r| check(&r));
    result.unwrap_or_else(|e| panic!("{e}"));
}

/// What is left out gives no light: with it the image is the same in the mean, on the host, at one radius for both.
#[test]
fn what_is_out_of_reach_gives_no_light() {
    const RENDERS: u32 = 6;
    let twin = twins::all(24).into_iter().find(|t| t.part == Part::OutOfReach).expect("twins");
    let mut first = 0;
    let mut radius = None;
    let [without, with] = [&[][..], &[Part::OutOfReach]].map(|keep| {
        let scene = packed(&twin.without.scene, keep);
        let mut plan = unresolved(plan(&scene, EVERYTHING, 0, keep));
        plan.diffuse.base = *radius.get_or_insert(plan.diffuse.base * scene.world_scale) / scene.world_scale;
        first += RENDERS;
        let render = |seed| {
            let mut plan = plan.clone();
            plan.settings.seed = seed;
            run(Side::Host, &scene, plan, 2).picture
        };
        (first..first + RENDERS).map(render).collect::<Vec<Picture>>()
    });
    is_alike("out of reach", &without, &with, &[3, 24]);
}

/// A closed room under a sun, and no other light: it is dark whether the sun is there or not, on both sides.
#[test]
fn a_room_without_a_window_is_dark() {
    let mut b = Builder::new([0.1, 0.2, 0.7], [0., 0., -1.], [0., 1., 0.], 0.5, SIZE);
    let white = b.matte(0.6);
    b.room([-1.; 3], [1.; 3], white);
    b.scene.lights.push(Light::Sun { direction: DVec3::NEG_Y, irradiance: [3.0; 3] });
    for keep in [&[][..], &[Part::OutOfReach]] {
        let scene = packed(&b.scene, keep);
        assert_eq!(scene.emitters.len(), keep.len());
        for side in both().into_iter().chain([Side::PathTracer]) {
            let picture = run(side, &scene, plan(&scene, EVERYTHING, 1, keep), 1).picture;
            assert!(picture.whole.pixels.iter().flatten().all(|x| *x == 0.0), "{side:?}, {keep:?}");
        }
    }
}

/// `joton plan` tells what is out of reach and what would bring it back; with `--no-skip out-of-reach` it is there.
#[test]
fn the_command_line_tells_and_keeps() {
    let scene = with_lamp(room());
    let folder = tempfile::tempdir().expect("a folder");
    let mut obj = String::from("mtllib room.mtl\n");
    for t in &scene.mesh.triangles {
        obj += &format!("usemtl m{}\n", t.material);
        for p in t.vertex.map(|v| scene.mesh.positions[v as usize]) {
            obj += &format!("v {} {} {}\n", p.x, p.y, p.z);
        }
        obj += "f -3 -2 -1\n";
    }
    let materials = scene.materials.iter().enumerate();
    let mtl = materials.map(|(i, m)| format!("newmtl m{i}\nKd .5 .5 .5\nKe {0} {0} {0}\n", m.emission[0]));
    let view = "[camera]\nposition = [0.1, 0.2, 0.7]\ntarget = [0.0, 0.0, -1.0]\nfov_x = 50.0\n\
                [film]\nwidth = 8\nheight = 8\n[[mesh]]\nfile = \"room.obj\"\n";
    for (name, text) in [("room.obj", obj), ("room.mtl", mtl.collect()), ("room.toml", view.into())] {
        std::fs::write(folder.path().join(name), text).expect("a file");
    }
    let run = |words: &[&str]| {
        let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_joton"));
        let ended = command.args(words).current_dir(folder.path()).output().expect("joton runs");
        assert!(ended.status.success(), "{words:?}: {}", String::from_utf8_lossy(&ended.stderr));
        String::from_utf8(ended.stdout).expect("text")
    };
    let json = |words: &[&str]| -> serde_json::Value { serde_json::from_str(&run(words)).expect("JSON") };
    let is_told = |value: &serde_json::Value| {
        let skipped = value["skipped"].as_array().expect("a list");
        skipped.iter().any(|s| s["name"] == "out-of-reach" && s["reason"] == "closed-room")
    };
    let plan = json(&["plan", "room.toml", "--json"]);
    assert!(
        is_told(&plan) && plan["out_of_reach"]["triangles"] == QUAD && plan["emitters"] == QUAD,
        "{plan}"
    );
    let text = run(&["plan", "room.toml"]);
    assert!(text.contains("out of reach: 2 triangles") && text.contains("back with an opening"), "{text}");
    let kept = json(&["plan", "room.toml", "--json", "--no-skip", "out-of-reach"]);
    assert!(
        !is_told(&kept) && kept["out_of_reach"]["triangles"] == 0 && kept["emitters"] == 2 * QUAD,
        "{kept}"
    );
    let render =
        ["render", "room.toml", "--device", "cpu", "--passes", "1", "-o", "o.exr", "--report", "r.json"];
    for (words, told) in [(&[][..], true), (&["--no-skip", "all"], false)] {
        run(&[&render[..], words].concat());
        let report = std::fs::read_to_string(folder.path().join("r.json")).expect("a report");
        assert_eq!(is_told(&serde_json::from_str(&report).expect("JSON")), told);
    }
}
