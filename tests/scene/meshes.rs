//! Vertices, faces and normals of OBJ.

use crate::folder::{TRIANGLE, load_obj, refused, warned};
use glam::{DVec3, Vec3};

/// Faults of vertices and faces that leave nothing to guess are errors at their line.
#[test]
fn broken_geometry_is_refused_at_its_line() {
    for (statement, words) in [
        ("v 0 zero 0", "\"zero\" is not a number"),
        ("v 0 nan 0", "coordinate nan is not finite"),
        ("v 0 1e999 0", "coordinate 1e999 is not finite"),
        ("v -inf 0 0", "coordinate -inf is not finite"),
        ("v 0 0", "2 of 3 coordinates"),
        ("f 0 1 2", "vertex index 0"),
        ("f 1 2 4", "vertex index 4 of 3 vertices"),
        ("f 1 2 -4", "vertex index -4 of 3 vertices"),
        ("f 1 2 x", "\"x\" is not a vertex index"),
        ("f 1 2 99999999999999999999", "is not a vertex index"),
    ] {
        let obj = format!("{TRIANGLE}\n# comment\n{statement}\n");
        refused(load_obj(obj), "a.obj:6", words);
    }
}

/// A mesh without any area is an error.
#[test]
fn nothing_to_see_is_refused() {
    for obj in ["", TRIANGLE, "v 0 0 0\nv 1 1 1\nf 1 2 1\n"] {
        refused(load_obj(obj), "a.obj", "no triangles");
    }
}

/// What adds nothing to the image is dropped, said once with its first line and its count.
#[test]
fn survivable_faults_are_counted() {
    let obj = format!("{TRIANGLE}v 2 0 0 1 0 0\nf 1 2 3\nf 1 2 4\nf 1 1 2\nf 1 2\nl 1 2\np 1\n");
    let scene = load_obj(obj).unwrap();
    assert_eq!(scene.mesh.triangles.len(), 1);
    warned(&scene, "a.obj:6", "triangle without area is dropped (… and 1 more)");
    warned(&scene, "a.obj:8", "fewer than three vertices");
    warned(&scene, "a.obj:9", "lines and points are ignored (… and 1 more)");
    warned(&scene, "a.obj:4", "vertex colours are ignored");
}

/// Corners in a line, but for the rounding of their decimals, span no triangle.
#[test]
fn rounding_makes_no_triangle() {
    let line = "v .1 .2 .3\nv .4 .5 .6\nv .7 .8 .9\nf 1 2 3\n";
    refused(load_obj(line), "a.obj", "no triangles");
}

/// Negative indices count from the last vertex so far; positive ones may point ahead.
#[test]
fn indices_count_both_ways() {
    let scene = load_obj(format!("{TRIANGLE}f -3 -2 -1\nf 1 2 4\nv 9 9 9\n")).unwrap();
    let corners = |i: usize| scene.mesh.triangles[i].vertex.map(|v| scene.mesh.positions[v as usize]);
    assert_eq!(corners(0), [DVec3::ZERO, DVec3::X, DVec3::Y]);
    assert_eq!(corners(1)[2], DVec3::splat(9.0));
}

/// Positions keep all digits of f64.
#[test]
fn positions_are_f64() {
    let scene = load_obj("v 1000000.0000001 0 0\nv 1000001 0 0\nv 1000000 1 0\nf 1 2 3\n").unwrap();
    assert_eq!(scene.mesh.positions[0].x, 1000000.0000001);
}

/// A concave polygon covers its own area, in either direction of turning.
#[test]
fn concave_polygons_keep_their_area() {
    for (order, sign) in [("1 2 3 4 5 6", 1.0), ("6 5 4 3 2 1", -1.0), ("3 4 5 6 1 2", 1.0)] {
        let corners = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
        let scene = load_obj(format!("{corners}f {order}\n")).unwrap();
        let mut area = 0.0;
        for t in &scene.mesh.triangles {
            let [a, b, c] = t.vertex.map(|v| scene.mesh.positions[v as usize]);
            let part = (b - a).cross(c - a).z / 2.0;
            assert!(part * sign > 0.0, "a part is turned over");
            area += part;
        }
        assert!((area - 3.0 * sign).abs() < 1e-12, "{area}");
    }
}

/// The normal of the first triangle's first corner, if it is smooth, and the warnings.
fn first_normal(obj: String) -> (Option<Vec3>, String) {
    let scene = load_obj(obj).unwrap();
    let normal = scene.mesh.triangles[0].normal.map(|n| scene.mesh.normals[n[0] as usize]);
    (normal, scene.warnings.join("\n"))
}

/// Normals that are absent, null or the face's own make it flat; others are kept at unit length.
#[test]
fn only_smooth_normals_are_kept() {
    let with = |normals: &str, face: &str| first_normal(format!("{TRIANGLE}{normals}\n{face}\n"));
    assert_eq!(with("", "f 1 2 3").0, None);
    assert_eq!(with("vn 0 0 2", "f 1//1 2//1 3//1").0, None);
    assert_eq!(with("vn 0 0 0", "f 1//1 2//1 3//1").0, None);
    assert_eq!(with("vn 3 0 4", "f 1//1 2//1 3").0, None, "a corner without");
    let (normal, _) = with("vn 3 0 4", "f 1//1 2//1 3//1");
    assert!((normal.unwrap() - Vec3::new(0.6, 0.0, 0.8)).length() < 1e-6);
    for (normals, face, words) in [
        ("vn 3 0 4\nvn 0 0 0", "f 1//1 2//2 3//1", "without length"),
        ("vn 3 0 4\nvn 3 0 -4", "f 1//1 2//2 3//1", "both sides"),
        ("vn 3 0 nan", "f 1//1 2//1 3//1", "not three finite numbers"),
        ("vn 3 0 4", "f 1//1 2//1 3//2", "do not exist"),
    ] {
        let (normal, warnings) = with(normals, face);
        assert_eq!(normal, None, "{normals}");
        assert!(warnings.contains(words), "{words}: {warnings}");
    }
}

/// Normals that all point to the back are turned over, with a warning: the winding decides the front.
#[test]
fn winding_decides_the_front() {
    let (normal, warnings) = first_normal(format!("{TRIANGLE}vn 3 0 -4\nf 1//1 2//1 3//1\n"));
    assert!((normal.unwrap() - Vec3::new(-0.6, 0.0, 0.8)).length() < 1e-6);
    assert!(warnings.contains("turned over"), "{warnings}");
}
