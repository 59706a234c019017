//! The camera of a file that has none.

use crate::folder::{Folder, load_obj};
use glam::DVec3;
use joton::scene::Scene;

/// A unit cube whose fronts are inside or outside, a side left out if asked for.
fn cube(fronts_inside: bool, without: Option<usize>) -> String {
    let mut text = String::from("mtllib m.mtl\n");
    for i in 0..8 {
        text += &format!("v {} {} {}\n", i & 1, i >> 1 & 1, i >> 2 & 1);
    }
    // z = 0, z = 1, x = 0, x = 1, y = 0, y = 1
    let inward = [[1, 2, 4, 3], [5, 7, 8, 6], [1, 3, 7, 5], [2, 6, 8, 4], [1, 5, 6, 2], [3, 4, 8, 7]];
    for (_, mut face) in inward.into_iter().enumerate().filter(|(i, _)| Some(*i) != without) {
        if !fronts_inside {
            face.reverse();
        }
        text += &format!("usemtl m\nf {}\n", face.map(|i: i32| i.to_string()).join(" "));
    }
    text
}

/// A mesh with a light under the ceiling of the cube.
fn framed(obj: &str) -> Scene {
    let light = "usemtl l\nv .4 .99 .4\nv .6 .99 .4\nv .6 .99 .6\nv .4 .99 .6\nf -4 -3 -2 -1\n";
    let mtl = b"newmtl m\nKd .5 .5 .5\nnewmtl l\nKe 1 1 1\n";
    Folder::new(&[("a.obj", format!("{obj}{light}").as_bytes()), ("m.mtl", mtl)]).load("a.obj").unwrap()
}

/// The camera looks through the side of a room that is open, and stands inside a closed one.
#[test]
fn walls_do_not_block_the_view() {
    for (open, outside) in [(1, DVec3::Z), (0, DVec3::NEG_Z), (3, DVec3::X), (2, DVec3::NEG_X)] {
        let camera = framed(&cube(true, Some(open))).camera;
        let from_middle = (camera.position - DVec3::splat(0.5)).normalize();
        assert!(from_middle.dot(outside) > 0.99, "open at {outside}: looks from {from_middle}");
    }
    let inside = framed(&cube(true, None)).camera.position;
    assert!(inside.min_element() > 0.0 && inside.max_element() < 1.0, "{inside}");
}

/// All of a lone object is in view, seen from +z and a little above.
#[test]
fn objects_are_in_view() {
    let scene = load_obj(cube(false, None)).unwrap();
    let [right, up, forward] = scene.camera.basis();
    assert!(forward.z < -0.8 && forward.y < -0.1, "{forward}");
    for p in &scene.mesh.positions {
        let to = *p - scene.camera.position;
        let [tan_x, tan_y] = scene.camera.tan_half_fov;
        let depth = to.dot(forward);
        let (x, y) = (to.dot(right) / depth / tan_x, to.dot(up) / depth / tan_y);
        assert!(depth > 0.0 && x.abs() < 1.0 && y.abs() < 1.0, "{p} at {x} {y}");
    }
}
