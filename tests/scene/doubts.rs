//! What cannot be meant is said, and nothing else is.

use crate::folder::Folder;
use joton::packed::{PackedScene, doubts};

const MTL: &str = "newmtl wall\nKd .5 .5 .5\nnewmtl lamp\nKd 0 0 0\nKe 5 5 5\nnewmtl glass\nillum 7\nNi 1.5\n\
                   newmtl drink\nillum 7\nNi 1.33\nnewmtl over\nillum 7\nNi .887\n";

/// A box of material `m`, fronts outward unless `inward`, without the sides that are left out.
fn cuboid(m: &str, low: [f64; 3], high: [f64; 3], inward: bool, without: &[usize]) -> String {
    let mut text = format!("usemtl {m}\n");
    for i in 0..8usize {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        text += &format!("v {} {} {}\n", pick(0), pick(1), pick(2));
    }
    // -z, +z, -x, +x, -y, +y
    let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 5, 7, 3], [2, 4, 8, 6], [1, 2, 6, 5], [3, 7, 8, 4]];
    for (_, mut face) in faces.into_iter().enumerate().filter(|(side, _)| !without.contains(side)) {
        if inward {
            face.reverse();
        }
        text += &format!("f {}\n", face.map(|i: i32| (i - 9).to_string()).join(" "));
    }
    text
}

/// The doubts about a scene seen from a place, with these lights.
fn about(obj: &str, eye: [f64; 3], lights: &str) -> Vec<String> {
    let obj = format!("mtllib m.mtl\n{obj}");
    let [x, y, z] = eye;
    let toml = format!(
        "[camera]\nposition = [{x}, {y}, {z}]\ntarget = [{x}, {y}, {}]\n[film]\nwidth = 8\nheight = 8\n\
         [[mesh]]\nfile = \"a.obj\"\n{lights}",
        z - 1.0
    );
    let files = [("a.obj", obj.as_bytes()), ("m.mtl", MTL.as_bytes()), ("s.toml", toml.as_bytes())];
    let scene = Folder::new(&files).load("s.toml").unwrap();
    doubts(&scene, &PackedScene::new(&scene))
}

fn point(at: [f64; 3]) -> String {
    format!("[[light]]\nkind = \"point\"\nposition = {at:?}\nintensity = 1\n")
}

const SUN: &str = "[[light]]\nkind = \"sun\"\ndirection = [0.1, -1, 0.2]\nirradiance = 1\n";

#[track_caller]
fn only(doubts: &[String], words: &[&str]) {
    assert_eq!(doubts.len(), usize::from(!words.is_empty()), "{doubts:#?}");
    for word in words {
        assert!(doubts[0].contains(word), "{word}: {doubts:#?}");
    }
}

fn room(m: &str, inward: bool) -> String {
    cuboid(m, [-2.; 3], [2.; 3], inward, &[])
}

/// The sun and a lamp outside of a closed room are told, and that nothing is left; not where the room has an opening.
#[test]
fn lights_outside_a_closed_room() {
    let lights = format!("{SUN}{}{}", point([0., 1., 0.]), point([9., 0., 0.]));
    only(&about(&room("wall", true), [0.; 3], &lights), &["2 of 3 lights lie outside of the closed walls"]);
    only(&about(&room("wall", true), [0.; 3], SUN), &["the picture is black"]);
    let open = cuboid("wall", [-2.; 3], [2.; 3], true, &[5]);
    only(&about(&open, [0.; 3], &lights), &[]);
    let windowed = format!("{open}usemtl glass\nv -2 2 -2\nv -2 2 2\nv 2 2 2\nv 2 2 -2\nf -4 -3 -2 -1\n");
    only(&about(&windowed, [0.; 3], &lights), &[]);
}

/// A camera inside a body, not one in a room whose walls look outward.
#[test]
fn camera_inside_a_body() {
    let body = cuboid("wall", [-1., -1., -1.], [1., 1., 1.], false, &[4]);
    let floor = cuboid("wall", [-5., -2., -5.], [5., -1., 5.], false, &[]);
    let scene = format!("{body}{floor}");
    only(&about(&scene, [0., 0., 0.1], SUN), &[]);
    let closed = format!(
        "{}{}",
        cuboid("wall", [-1.; 3], [1.; 3], false, &[]),
        cuboid("wall", [2.; 3], [3.; 3], false, &[])
    );
    only(
        &about(&closed, [0., 0., 0.1], SUN),
        &["all light comes from outside of the closed walls of \"wall\" around the camera", "inside a body"],
    );
    only(&about(&room("wall", false), [0.; 3], &point([0., 1., 0.])), &[]);
}

/// Lamps that are inside out, that are in a closed housing or covered; not those that a camera among them sees, nor panels.
#[test]
fn lamps_that_face_themselves() {
    let floor = cuboid("wall", [-5., -2., -5.], [5., -1.5, 5.], false, &[]);
    let eye = [0., 0., 4.];
    let lamp = |inward: bool| format!("{floor}{}", cuboid("lamp", [-1.; 3], [1.; 3], inward, &[]));
    only(&about(&lamp(false), eye, ""), &[]);
    only(&about(&lamp(true), eye, ""), &["lamp \"lamp\": none of its light gets out"]);
    only(&about(&room("lamp", true), [0.; 3], ""), &[]);
    let panel = "usemtl lamp\nv -.5 0 .5\nv .5 0 .5\nv .5 0 -.5\nv -.5 0 -.5\nf -4 -3 -2 -1\n";
    only(&about(&format!("{floor}{panel}"), eye, ""), &[]);
    let housed = format!("{floor}{panel}{}", cuboid("wall", [-1.; 3], [1.; 3], false, &[]));
    only(&about(&housed, eye, SUN), &["lamp \"lamp\": none of its light"]);
    let shaded = format!("{floor}{panel}{}", cuboid("wall", [-1.; 3], [1.; 3], false, &[5]));
    only(&about(&shaded, eye, SUN), &[]);
    let ceiling = "usemtl wall\nv -5 .0005 -5\nv 5 .0005 -5\nv 5 .0005 5\nv -5 .0005 5\nf -4 -3 -2 -1\n";
    only(&about(&format!("{floor}{panel}{ceiling}"), eye, SUN), &["lamp \"lamp\": none of its light"]);
}

/// A point in a body lights nothing; one under a shade does.
#[test]
fn lights_inside_a_body() {
    let floor = cuboid("wall", [-5., -2., -5.], [5., -1.5, 5.], false, &[]);
    let body = |without: &[usize]| format!("{floor}{}", cuboid("wall", [-1.; 3], [1.; 3], false, without));
    let lights = format!("{SUN}{}", point([0.; 3]));
    only(&about(&body(&[]), [0., 0., 4.], &lights), &["a light is inside an opaque body", "\"wall\""]);
    only(&about(&body(&[4]), [0., 0., 4.], &lights), &[]);
}

/// A pane on a wall and a block on a floor touch; with a gap that f32 can tell, or edge to edge, they do not.
#[test]
fn glass_flush_on_a_wall() {
    let wall = cuboid("wall", [-5., -5., -1.], [5., 5., 0.], false, &[]);
    let pane =
        |z: f64| format!("{wall}usemtl glass\nv 4 0 {z}\nv 6 0 {z}\nv 6 1 {z}\nv 4 1 {z}\nf -4 -3 -2 -1\n");
    only(&about(&pane(0.0), [0., 0., 4.], SUN), &["glass \"glass\" lies flush on \"wall\""]);
    only(&about(&pane(1e-4), [0., 0., 4.], SUN), &[]);
    let block = |z: f64| format!("{wall}{}", cuboid("glass", [-1., -1., z], [1., 1., 2.], false, &[]));
    only(&about(&block(0.0), [0., 0., 4.], SUN), &["flush"]);
    only(&about(&block(1e-4), [0., 0., 4.], SUN), &[]);
    let tank = format!(
        "{}{}",
        cuboid("wall", [-5., -5., -1.], [-1., 5., 9.], false, &[]),
        cuboid("glass", [0.; 3], [1.; 3], false, &[])
    );
    only(&about(&tank, [0., 0., 4.], SUN), &[]);
}

/// Glass that overlaps or lies in glass with an index over air; not bubbles, indices over the outer one, glass beside glass.
#[test]
fn glass_in_glass() {
    let outer = cuboid("glass", [-1.; 3], [1.; 3], false, &[]);
    let floor = cuboid("wall", [-5., -3., -5.], [5., -2., 5.], false, &[]);
    let with = |inner: String| about(&format!("{floor}{outer}{inner}"), [0., 0., 4.], SUN);
    only(
        &with(cuboid("drink", [-0.5; 3], [0.5; 3], false, &[])),
        &["glass \"drink\" lies inside glass \"glass\""],
    );
    only(&with(cuboid("over", [-0.5; 3], [0.5; 3], false, &[])), &[]);
    only(&with(cuboid("glass", [-0.5; 3], [0.5; 3], true, &[])), &[]);
    only(
        &with(cuboid("drink", [-0.5; 3], [1.5; 3], false, &[])),
        &["bodies of glass overlap", "\"drink\"", "\"glass\""],
    );
    only(&with(cuboid("drink", [1.5; 3], [2.5; 3], false, &[])), &[]);
    only(&with(cuboid("drink", [1., -1., -1.], [2., 1., 1.], false, &[])), &[]);
    // in a bubble of air it is in air
    let hollow = cuboid("glass", [-0.75; 3], [0.75; 3], true, &[]);
    only(&with(format!("{hollow}{}", cuboid("drink", [-0.5; 3], [0.5; 3], false, &[]))), &[]);
}

/// With priorities bodies may overlap and lie in each other, but for those of one priority that overlap.
#[test]
fn glass_with_priorities() {
    let solid = |m: &str, low: f64, high: f64| cuboid(m, [low; 3], [high; 3], false, &[]);
    let floor = cuboid("wall", [-5., -3., -5.], [5., -2., 5.], false, &[]);
    let of = |inner: String, [glass, drink]: [i64; 2]| {
        let bodies = format!("{floor}{}{inner}", solid("glass", -1., 1.));
        let rank =
            |name: &str, number: i64| format!("[[material]]\nname = \"{name}\"\npriority = {number}\n");
        about(&bodies, [0., 0., 4.], &[SUN, &rank("glass", glass), &rank("drink", drink)].concat())
    };
    only(&of(solid("drink", -0.5, 0.5), [1, 2]), &[]);
    only(&of(solid("drink", -0.5, 1.5), [2, 1]), &[]);
    only(&of(solid("drink", -0.5, 0.5), [2, 2]), &[]);
    only(
        &of(solid("drink", -0.5, 1.5), [2, 2]),
        &["bodies of one priority overlap (\"drink\" and \"glass\")"],
    );
}

/// A pane without thickness absorbs nothing, whatever is said of it.
#[test]
fn panes_have_no_inside() {
    let pane = "usemtl glass\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf -4 -3 -2 -1\n";
    let wall = cuboid("wall", [-5., -3., -5.], [5., -2., 5.], false, &[]);
    let dark = format!("{SUN}[[material]]\nname = \"glass\"\nabsorption = 1\n");
    only(&about(&format!("{wall}{pane}"), [0., 0., 4.], SUN), &[]);
    only(&about(&format!("{wall}{pane}"), [0., 0., 4.], &dark), &["the thin pane \"glass\" has no inside"]);
}

/// What is beyond the last number that a body can have is told.
#[test]
fn bodies_have_a_number_each() {
    let (mut obj, mut keys) = (String::new(), String::new());
    for i in 0..257 {
        let x = f64::from(i) * 2.0;
        obj += &cuboid(&format!("g{i}"), [x, 0., 0.], [x + 1., 1., 1.], false, &[]);
        keys += &format!("[[material]]\nname = \"g{i}\"\ntype = \"glass\"\nabsorption = 1\n");
    }
    only(&about(&obj, [0., 0., 9.], &format!("{SUN}{keys}")), &["2 materials of glass beyond the first 255"]);
}
