//! Costs grow as the input does: a hundred thousand of anything are read and packed in a moment. Each size here would take
//! minutes if it cost its square.

use crate::folder::{Folder, TRIANGLE};
use cpu_time::ThreadTime;
use joton::packed::PackedScene;
use joton::scene::Scene;
use std::fmt::Write;
use std::time::Duration;

/// What one load may take, on a slow machine, by the clock of its thread.
const LIMIT: Duration = Duration::from_secs(6);
const SUN: &str = "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0.2]\nirradiance = 1\n";
const MESH: &str = "[[mesh]]\nfile = \"a.obj\"\n";

/// Loads and packs; both within the limit.
fn timed(what: &str, obj: &str, mtl: &str, toml: &str) -> (Scene, PackedScene) {
    let files = [("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes()), ("s.toml", toml.as_bytes())];
    let folder = Folder::new(&files);
    let begin = ThreadTime::now();
    let scene = folder.load("s.toml").unwrap();
    let loaded = begin.elapsed();
    let packed = PackedScene::new(&scene);
    println!("{what}: {loaded:?}, packed {:?}", begin.elapsed() - loaded);
    assert!(begin.elapsed() < LIMIT, "{what}: {loaded:?}, packed {:?}", begin.elapsed() - loaded);
    (scene, packed)
}

/// The text of many parts.
fn many(count: usize, part: impl Fn(usize, &mut String)) -> String {
    let mut text = String::new();
    (0..count).for_each(|i| part(i, &mut text));
    text
}

/// A triangle in a place of its own.
fn apart(i: usize, text: &mut String) {
    let (x, z) = (i % 200, i / 200);
    let _ = write!(text, "v {x} 0 {z}\nv {x} 0 {z}.5\nv {x}.5 0 {z}\nf -3 -2 -1\n");
}

/// Triangles in one place, each with a material of its own, flat and smooth: one of them is kept.
#[test]
fn coincident_triangles() {
    let n = 30_000;
    for corners in ["1 2 3", "1//1 2//2 3//3"] {
        let faces = many(n, |i, text| {
            let _ = write!(text, "usemtl m{i}\nf {corners}\n");
        });
        let obj = format!("mtllib m.mtl\n{TRIANGLE}vn 0 .1 1\nvn .1 0 1\nvn 0 0 1\n{faces}");
        let mtl = many(n, |i, text| {
            let _ = write!(text, "newmtl m{i}\nKd .5 .5 .5\n");
        });
        let (scene, packed) = timed("coincident", &obj, &mtl, &format!("{MESH}{SUN}"));
        assert_eq!((scene.mesh.triangles.len(), packed.triangles.len()), (n, 1));
        assert_eq!(packed.triangles[0].material, 0, "the first of the file");
    }
}

/// A fan of pages about one edge: boxes that all hold each other.
#[test]
fn pages_of_a_book() {
    let obj = many(100_000, |i, text| {
        let angle = i as f64 / 20_000.0;
        let _ = write!(text, "v {} 0 {}\nf 1 2 -1\n", angle.cos(), angle.sin());
    });
    let (_, packed) = timed("pages", &format!("v 0 -1 0\nv 0 1 0\n{obj}"), "", &format!("{MESH}{SUN}"));
    assert!(packed.bvh.depth() < 40, "{}", packed.bvh.depth());
}

/// Names that no library defines, beside a large library that defines others: told in one line, with a hint for the first.
#[test]
fn undefined_names() {
    let n = 20_000;
    let obj = many(n, |i, text| {
        let _ = writeln!(text, "usemtl undefined_{i}");
        apart(i, text);
    });
    let mtl = many(n, |i, text| {
        let _ = writeln!(text, "newmtl defined_{i}");
    });
    let (scene, _) = timed("undefined", &format!("mtllib m.mtl\n{obj}"), &mtl, &format!("{MESH}{SUN}"));
    let [line] = &scene.warnings[..] else { panic!("{} lines", scene.warnings.len()) };
    for words in ["materials \"undefined_0\" (did you mean \"", "and 19997 more are not defined"] {
        assert!(line.contains(words), "{line}");
    }
}

/// Statements of the scene file: materials, meshes inline and as entries of one file, lights.
#[test]
fn entries_of_a_scene_file() {
    let n = 20_000;
    let obj = many(n, |i, text| {
        let _ = writeln!(text, "usemtl m{i}");
        apart(i, text);
    });
    let materials = many(n, |i, text| {
        let _ = write!(text, "[[material]]\nname = \"m{i}\"\ntype = \"matte\"\nkd = 0.25\n");
    });
    let (scene, _) = timed("materials", &obj, "", &format!("{MESH}{SUN}{materials}"));
    assert!(scene.materials.iter().all(|m| m.diffuse == [0.25; 3]));
    let entry = |i: usize, text: &mut String| {
        let _ = writeln!(text, "{{ file = \"a.obj\", translate = [{}, 0, {}] }},", i % 100, i / 100);
    };
    let one = format!("mtllib m.mtl\nusemtl m\n{TRIANGLE}f 1 2 3\n");
    let mtl = many(1000, |i, text| {
        let _ = writeln!(text, "newmtl m{i}\nKd .5 .5 .5");
    });
    let (scene, _) = timed("inline", &one, &mtl, &format!("mesh = [{}]\n{SUN}", many(n, entry)));
    assert_eq!(scene.mesh.triangles.len(), n);
    assert_eq!(scene.materials.len(), 1, "a file that is placed often is read once");
    let entries = many(n, |i, text| {
        let _ = write!(text, "[[mesh]]\nfile = \"a.obj\"\ntranslate = [{}, 0, {}]\n", i % 100, i / 100);
    });
    let lights = many(n, |i, text| {
        let _ = write!(text, "[[light]]\nkind = \"point\"\nposition = [{i}, 2, 0]\nintensity = 1\n");
        let _ = write!(text, "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n");
    });
    let (scene, _) = timed("entries and lights", &one, &mtl, &format!("{entries}{lights}"));
    assert_eq!(scene.lights.len(), 2 * n);
}

/// Polygons of a hundred thousand corners: a star, a circle; on lines that continue each other.
#[test]
fn large_polygons() {
    let n = 100_000;
    for (inner, way) in [(0.2, " "), (1.0, " \\\n")] {
        let corners = many(n, |i, text| {
            let (r, a) = (if i % 2 == 0 { 1.0 } else { inner }, std::f64::consts::TAU * i as f64 / n as f64);
            let _ = writeln!(text, "v {} 0 {}", r * a.sin(), r * a.cos());
        });
        let face = many(n, |i, text| {
            let _ = write!(text, "{}{way}", i + 1);
        });
        let (scene, _) = timed("polygon", &format!("{corners}f {face}\n"), "", &format!("{MESH}{SUN}"));
        assert_eq!(scene.mesh.triangles.len(), n - 2);
        let area = |t: &joton::scene::Triangle| {
            let [a, b, c] = t.vertex.map(|v| scene.mesh.positions[v as usize]);
            (b - a).cross(c - a).y / 2.0
        };
        let (parts, step) = (scene.mesh.triangles.iter().map(area), std::f64::consts::TAU / n as f64);
        let want = n as f64 / 2.0 * inner * step.sin();
        assert!((parts.sum::<f64>() / want - 1.0).abs() < 1e-6);
    }
}

/// Libraries that are named again and again, or are not there.
#[test]
fn libraries_named_often() {
    let n = 50_000;
    let names = many(n, |i, text| {
        let _ = write!(text, "mtllib m.mtl\nmtllib no{i}.mtl\n");
    });
    let mtl = many(2000, |i, text| {
        let _ = writeln!(text, "newmtl m{i}\nKd .25 .25 .25");
    });
    let obj = format!("{names}usemtl m7\n{TRIANGLE}f 1 2 3\n");
    let (scene, _) = timed("libraries", &obj, &mtl, &format!("{MESH}{SUN}"));
    assert_eq!(scene.materials[0].diffuse, [0.25; 3]);
    assert_eq!(scene.warnings.len(), 1, "{:#?}", scene.warnings);
    assert!(scene.warnings[0].contains("and 49997 more are not found"), "{}", scene.warnings[0]);
}
