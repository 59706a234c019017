//! Claims about what the scene readers accept, repair and refuse.

use glam::{DVec3, Vec3};
use joton::Error;
use joton::bands::Bands;
use joton::scene::{self, Light, Material, Scene};
use std::path::{Path, PathBuf};

/// A folder with files that vanishes with the test.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, bytes) in files {
            std::fs::write(folder.path(name), bytes).unwrap();
        }
        folder
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn load(&self, name: &str) -> Result<Scene, Error> {
        scene::load(&self.path(name))
    }
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

fn load_obj(obj: impl AsRef<[u8]>) -> Result<Scene, Error> {
    Folder::new(&[("a.obj", obj.as_ref())]).load("a.obj")
}

/// A scene with one triangle of material `m`, defined by `mtl`.
fn with_mtl(mtl: impl AsRef<[u8]>) -> Result<Scene, Error> {
    let obj = format!("mtllib m.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    Folder::new(&[("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_ref())]).load("a.obj")
}

fn material(statements: &str) -> Material {
    with_mtl(format!("newmtl m\n{statements}\n")).unwrap().materials.remove(0)
}

fn warnings(statements: &str) -> String {
    with_mtl(format!("newmtl m\n{statements}\n")).unwrap().warnings.join("\n")
}

/// A scene file beside an OBJ with one triangle of material `m`, which emits.
fn load_toml(toml: &str) -> Result<Scene, Error> {
    let obj = format!("mtllib m.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let mtl = b"newmtl m\nKd .2 .2 .2\nKe 1 1 1\n";
    Folder::new(&[("a.obj", obj.as_bytes()), ("m.mtl", mtl), ("s.toml", toml.as_bytes())]).load("s.toml")
}

/// Asserts where an error is and which words it has.
#[track_caller]
fn refused(result: Result<Scene, Error>, at: &str, words: &str) {
    let error = result.expect_err(words).to_string();
    assert!(error.contains(&format!("/{at}: ")), "not at {at}: {error}");
    assert!(error.contains(words), "without \"{words}\": {error}");
}

/// Asserts that some warning is at a place and has some words.
#[track_caller]
fn warned(scene: &Scene, at: &str, words: &str) {
    let found = scene.warnings.iter().any(|w| w.contains(&format!("/{at}: ")) && w.contains(words));
    assert!(found, "no \"{at}: … {words}\" in {:#?}", scene.warnings);
}

fn near(a: Bands, b: Bands) -> bool {
    // One rounding of f32 in each of a few operations.
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

// ---- formats and encodings

/// A format without a reader is an error that names those with one.
#[test]
fn unknown_formats_are_refused() {
    let error = scene::load(Path::new("scene.blend")).unwrap_err().to_string();
    assert!(error.contains("scene.blend") && error.contains(".toml") && error.contains(".obj"), "{error}");
}

/// A file that does not exist is an error that names it.
#[test]
fn missing_files_are_named() {
    let error = scene::load(Path::new("nowhere/a.obj")).unwrap_err();
    assert!(matches!(error, Error::Io { .. }) && error.to_string().contains("nowhere"), "{error}");
}

/// The same text in UTF-8, Latin-1 and UTF-16, with LF, CRLF or CR, is the same scene.
#[test]
fn encodings_and_line_ends_do_not_matter() {
    let text = format!("# Würfel\n{TRIANGLE}usemtl grün\nf 1 2 \\\n 3\n");
    for end in ["\n", "\r\n", "\r"] {
        let text = text.replace('\n', end);
        let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let utf16 = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            "\u{feff}".encode_utf16().chain(text.encode_utf16()).flat_map(bytes).collect()
        };
        let marked = [b"\xEF\xBB\xBF", text.as_bytes()].concat();
        let (little, big) = (utf16(u16::to_le_bytes), utf16(u16::to_be_bytes));
        for bytes in [text.as_bytes(), &latin1, &marked, &little, &big] {
            let scene = load_obj(bytes).unwrap();
            assert_eq!(scene.mesh.triangles.len(), 1);
            assert_eq!(scene.materials[0].name, "grün");
            warned(&scene, "a.obj:6", "\"grün\" is not defined");
        }
    }
}

/// NUL and Ctrl-Z after the end are passed over.
#[test]
fn trailing_garbage_is_survived() {
    assert_eq!(load_obj(format!("{TRIANGLE}f 1 2 3\n\0\0\x1a")).unwrap().mesh.triangles.len(), 1);
}

// ---- meshes

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

// ---- materials

/// Missing libraries, materials and usemtl give grey and say where.
#[test]
fn missing_materials_are_grey() {
    let scene = load_obj(format!("mtllib no.mtl\n{TRIANGLE}f 1 2 3\nusemtl nix\nf 1 2 3\n")).unwrap();
    warned(&scene, "a.obj:1", "\"no.mtl\" is not found");
    warned(&scene, "a.obj:5", "without a material are matte grey 0.5");
    warned(&scene, "a.obj:7", "\"nix\" is not defined");
    assert!(scene.materials.iter().all(|m| m.diffuse == [0.5; 3]));
}

/// Names of libraries: with spaces, several, in the wrong case, with a backslash or a folder that is not there.
#[test]
fn libraries_are_found() {
    for (named, file) in [
        ("my own.mtl", "my own.mtl"),
        ("no.mtl m.mtl", "m.mtl"),
        ("M.MTL", "m.mtl"),
        (".\\m.mtl", "m.mtl"),
        ("C:\\tmp\\m.mtl", "m.mtl"),
    ] {
        let obj = format!("mtllib {named}\n{TRIANGLE}usemtl m\nf 1 2 3\n");
        let folder = Folder::new(&[("a.obj", obj.as_bytes()), (file, b"newmtl m\nKd .1 .2 .3\n")]);
        assert_eq!(folder.load("a.obj").unwrap().materials[0].diffuse, [0.1, 0.2, 0.3], "{named}");
    }
}

/// Tabs, comments after values and names, any case of keys, one value for all, a second definition: all are read.
#[test]
fn untidy_libraries_are_read() {
    for mtl in [
        "rubbish\n\tnewmtl m\n\tKd\t.25 .5 1. # Blue\n",
        "newmtl m # the wall\r\nKD .25 .5 1\r\n",
        "newmtl m\nKd 0 0 0\nnewmtl other\nnewmtl m\nKd .25 .5 1\n",
    ] {
        assert_eq!(with_mtl(mtl).unwrap().materials[0].diffuse, [0.25, 0.5, 1.0], "{mtl}");
    }
    assert_eq!(material("Kd .25").diffuse, [0.25; 3]);
}

/// Nameless materials are materials.
#[test]
fn nameless_materials_are_read() {
    let obj = format!("mtllib m.mtl\n{TRIANGLE}usemtl\nf 1 2 3\n");
    let folder = Folder::new(&[("a.obj", obj.as_bytes()), ("m.mtl", b"newmtl\nKd .1 .2 .3\n")]);
    assert_eq!(folder.load("a.obj").unwrap().materials[0].diffuse, [0.1, 0.2, 0.3]);
}

/// Statements that cannot be read are left out; values that are negative or not finite are refused where used.
#[test]
fn bad_values_are_named() {
    let scene = with_mtl("newmtl m\nKd x 0 0\n").unwrap();
    warned(&scene, "m.mtl:2", "not a number");
    assert_eq!(scene.materials[0].diffuse, [0.5; 3]);
    refused(with_mtl("newmtl m\nKd 0 -1 0\n"), "m.mtl:2", "Kd is negative");
    refused(with_mtl("newmtl m\n\nKe nan 0 0\n"), "m.mtl:3", "Ke is not finite");
    refused(with_mtl("newmtl m\nillum 7\nNi 100\n"), "m.mtl:3", "index of refraction");
    assert!(with_mtl("newmtl other\nKd -1 0 0\nnewmtl m\nKd 0 0 0\n").is_ok(), "not used");
}

/// Rule 1: Ke is radiance and leaves Kd alone.
#[test]
fn ke_is_emission() {
    let m = material("Kd .7 .7 .7\nKe 17 12 4");
    assert_eq!((m.emission, m.diffuse), ([17.0, 12.0, 4.0], [0.7; 3]));
}

/// Rule 2: illum 4, 6, 7, 9 are glass; 5, 8, 10 if something transmits; 2 never, whatever Tf says.
#[test]
fn illum_tells_glass() {
    for illum in [4, 6, 7, 9] {
        let glass =
            material(&format!("illum {illum}\nNi 1.33\nKd .1 .1 .1\nTf .9 .8 .7")).dielectric.unwrap();
        let expected = (1.33, [1.0; 3], [0.9, 0.8, 0.7]);
        assert_eq!((glass.ior, glass.reflection_tint, glass.transmission_tint), expected);
    }
    for transmits in ["d 0.5", "Kt .5 .5 .5", "Tf .5 1 1"] {
        assert!(material(&format!("illum 5\n{transmits}")).dielectric.is_some(), "{transmits}");
        assert!(material(&format!("illum 2\n{transmits}")).dielectric.is_none(), "{transmits}");
    }
    assert!(material("illum 2\nTf 1 1 1\nd 1").dielectric.is_none());
    assert!(material("illum 5\nTf 1 1 1\nd 1").dielectric.is_none());
}

/// Rule 2: Ni 1 stays 1, absent it is 1.5; black filters mean none; Kd is ignored and reported where it shows.
#[test]
fn glass_defaults() {
    let glass = |s: &str| material(&format!("illum 7\n{s}")).dielectric.unwrap();
    assert_eq!((glass("Ni 1.0").ior, glass("").ior, glass("Ni 0").ior), (1.0, 1.5, 1.5));
    assert!(warnings("illum 7").contains("1.5 is used"));
    assert_eq!(glass("Tf 0 0 0\nKs 0 0 0").transmission_tint, [1.0; 3]);
    assert_eq!(glass("Tf 0 0 0\nKs 0 0 .5").reflection_tint, [0.0, 0.0, 0.5]);
    assert_eq!(glass("Tf 2 1 1").transmission_tint, [1.0; 3]);
    assert_eq!(material("illum 7\nKd .5 .5 .5").diffuse, [0.0; 3]);
    assert!(warnings("illum 7\nNi 1.5\nKd .5 .5 .5").contains("Kd of a glass is ignored"));
    assert!(!warnings("illum 7\nNi 1.5\nKd .01 .01 .01").contains("Kd"));
}

/// Rules 3 and 4: illum 3 and 5 mirror, 0 and 1 are matte.
#[test]
fn illum_tells_mirror_and_matte() {
    for illum in [3, 5] {
        let m = material(&format!("illum {illum}\nKd .01 .01 .01\nKs .95 .95 .95"));
        assert_eq!((m.specular, m.diffuse, m.glossy), ([0.95; 3], [0.01; 3], [0.0; 3]));
    }
    for illum in [0, 1] {
        let m = material(&format!("illum {illum}\nKd .3 .3 .3\nKs .5 .5 .5"));
        assert_eq!((m.specular, m.diffuse, m.glossy), ([0.0; 3], [0.3; 3], [0.0; 3]));
    }
}

/// Rule 5: illum 2 or none with Ks is glossy; the exponent is Ns, else from Pr, else 10, within 1 and 10⁶.
#[test]
fn ks_is_a_lobe() {
    for illum in ["", "illum 2\n"] {
        for (roughness, exponent) in [
            ("Ns 50", 50.0),
            ("Pr 0.5", 30.0),
            ("Ns 50\nPr 0.5", 50.0),
            ("", 10.0),
            ("Ns 0", 1.0),
            ("Ns 1e9", 1e6),
            ("Pr 0", 1e6),
            ("Pr 1", 1.0),
        ] {
            let m = material(&format!("{illum}Kd .3 .3 .3\nKs .5 .5 .5\n{roughness}"));
            assert_eq!(
                (m.glossy, m.glossy_exponent, m.diffuse),
                ([0.5; 3], exponent, [0.3; 3]),
                "{roughness}"
            );
        }
        assert_eq!(material(&format!("{illum}Kd .3 .3 .3\nKs 0 0 0\nNs 10")).glossy_exponent, 0.0);
    }
}

/// Rule 6: what Kd is where the file does not say.
#[test]
fn absent_kd() {
    assert_eq!(material("").diffuse, [0.5; 3]);
    assert_eq!(material("Ke 1 1 1").diffuse, [0.0; 3]);
    assert_eq!(material("illum 3\nKs 1 1 1").diffuse, [0.0; 3]);
    assert_eq!(material("Kd 0 0 0").diffuse, [0.0; 3]);
    assert_eq!(material("map_Kd a.png").diffuse, [0.5; 3]);
    assert_eq!(material("Kd 0 0 0\nmap_Kd a.png").diffuse, [0.5; 3]);
    assert_eq!(material("Kd .3 .3 .3\nmap_Kd a.png").diffuse, [0.3; 3]);
    assert!(warnings("map_Kd a.png").contains("textures are not supported"));
}

/// Rule 7: more than all light is scaled down in proportion; exactly all is allowed.
#[test]
fn reflectances_sum_to_one_at_most() {
    let m = material("Kd .5 .25 0\nKs 1 1 1\nNs 10");
    assert!(near(m.diffuse, [1.0 / 3.0, 1.0 / 6.0, 0.0]) && near(m.glossy, [2.0 / 3.0; 3]), "{m:?}");
    assert!(warnings("Kd .5 .25 0\nKs 1 1 1").contains("scaled down"));
    assert_eq!(material("Kd 1 1 1").diffuse, [1.0; 3]);
    assert!(!warnings("Kd 1 1 1").contains("scaled down"));
    assert!(!warnings("Kd .9 .9 .9\nKs .1 .1 .1").contains("scaled down"), "rounding is no fault");
}

/// Rule 8: cut-outs stay opaque with a warning, Tr 0 and 1 without.
#[test]
fn cutouts_are_opaque() {
    let cases = [("d 0.5", true), ("map_d a.png", true), ("Tr 0.5", true), ("d 1", false), ("Tr 0", false)];
    for (statement, expected) in cases.into_iter().chain([("Tr 1", false)]) {
        assert_eq!(warnings(&format!("Kd 1 1 1\n{statement}")).contains("cut-out"), expected, "{statement}");
    }
}

// ---- scene files

const MESH: &str = "[[mesh]]\nfile = \"a.obj\"\n";

/// All keys of the format arrive where they belong.
#[test]
fn scene_file_says_everything() {
    let scene = load_toml(
        r#"
        camera = { position = [0, 0, 5], target = [0, 0, 0], fov_y = 90 }
        [film]
        width = 20
        height = 10
        [[mesh]]
        file = "a.obj"
        scale = 2
        translate = [0, 0, 1.5]
        [[mesh]]
        file = "a.obj"
        [[light]]
        kind = "point"
        position = [1, 2, 3]
        intensity = 4
        [[light]]
        kind = "spot"
        position = [0, 2, 0]
        target = [0, 0, 0]
        intensity = [1, 2, 3]
        angle_inner = 0
        angle_outer = 60
        [[light]]
        kind = "sun"
        direction = [0, -2, 0]
        irradiance = 1.5
        [[material]]
        name = "m"
        kd = 0.75
        "#,
    )
    .unwrap();
    assert_eq!((scene.size, scene.camera.up), ([20, 10], DVec3::Y));
    let [tan_x, tan_y] = scene.camera.tan_half_fov;
    assert!((tan_x - 2.0).abs() < 1e-12 && (tan_y - 1.0).abs() < 1e-12, "{tan_x} {tan_y}");
    let corner = |t: usize| scene.mesh.positions[scene.mesh.triangles[t].vertex[1] as usize];
    assert_eq!((corner(0), corner(1)), (DVec3::new(2.0, 0.0, 1.5), DVec3::X));
    assert!(scene.materials.iter().all(|m| m.diffuse == [0.75; 3] && m.emission == [1.0; 3]));
    let point = Light::Point { position: DVec3::new(1.0, 2.0, 3.0), intensity: [4.0; 3] };
    let sun = Light::Sun { direction: DVec3::NEG_Y, irradiance: [1.5; 3] };
    assert_eq!((scene.lights[0], scene.lights[2]), (point, sun));
    let Light::Spot { direction, cos_inner, cos_outer, .. } = scene.lights[1] else { panic!("no spot") };
    assert_eq!((direction, cos_inner), (DVec3::NEG_Y, 1.0));
    assert!((cos_outer - 0.5).abs() < 1e-12);
}

/// Faults of a scene file are named with their line and, for slips, the word that was meant.
#[test]
fn scene_file_faults_have_lines() {
    let camera = |more: &str| format!("[camera]\nposition = [0, 0, 5]\ntarget = [0, 0, 0]\n{more}");
    let light = |kind: &str, more: &str| format!("[[light]]\nkind = \"{kind}\"\n{more}");
    for (toml, line, words) in [
        ("[camra]".to_owned(), 3, "did you mean \"camera\"?"),
        ("[film]\nwidht = 3".to_owned(), 4, "did you mean \"width\"?"),
        ("[film]\nwidth = 0".to_owned(), 4, "width of 0 pixels"),
        ("[film]\nwidth = 1.5".to_owned(), 4, "whole number"),
        ("[film]\nwidth = = 1".to_owned(), 4, "mend the TOML"),
        ("[camera]\nposition = [0, 0, 5]".to_owned(), 3, "has no target"),
        (camera("fov_x = 0"), 6, "field of view of 0 degrees"),
        (camera("fov_x = 180"), 6, "field of view of 180 degrees"),
        (camera("fov_x = nan"), 6, "finite number"),
        (camera("fov_x = 20\nfov_y = 20"), 7, "both fov_x and fov_y"),
        (camera("up = [0, 0, 1]"), 3, "parallel to the view"),
        (camera("up = [0, 0, 0]"), 3, "no length"),
        (camera("up = [0, 1]"), 6, "three finite numbers"),
        ("[camera]\nposition = [1, 1, 1]\ntarget = [1, 1, 1]".to_owned(), 3, "the same point"),
        ("[[mesh]]\nfile = \"b.obj\"".to_owned(), 4, "does not exist"),
        ("[[mesh]]\nfile = \"b.fbx\"".to_owned(), 4, "not of a known format"),
        ("[[mesh]]\nfile = \"a.obj\"\nscale = -1".to_owned(), 5, "scale -1"),
        (light("spott", ""), 4, "did you mean \"spot\"?"),
        (light("sun", "direction = [0, 0, 0]\nirradiance = 1"), 5, "without length"),
        (light("point", "position = [0, 0, 0]\nintensity = -1"), 6, "at least 0"),
        (light("point", "position = [0, 0, 0]\nintensity = 0"), 6, "light without intensity"),
        (light("point", "position = [0, 0, 0]"), 3, "has no intensity"),
        ("[[material]]\nname = \"mm\"\nkd = 1".to_owned(), 3, "did you mean \"m\"?"),
        ("[[material]]\nname = \"m\"\ntype = \"glas\"".to_owned(), 5, "did you mean \"glass\"?"),
        ("[[material]]\nname = \"m\"\nkd = [1, -1, 1]".to_owned(), 5, "at least 0"),
    ] {
        refused(load_toml(&format!("{MESH}{toml}\n")), &format!("s.toml:{line}"), words);
    }
    refused(load_toml("[film]\nwidth = 8\n"), "s.toml", "no [[mesh]]");
}

/// A material with a type is defined anew; without, single statements are replaced.
#[test]
fn scene_file_materials() {
    let of = |toml: &str| {
        let sun = "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n";
        load_toml(&format!("{MESH}{sun}[[material]]\nname = \"m\"\n{toml}\n")).unwrap().materials.remove(0)
    };
    assert_eq!(of("kd = 0.9").emission, [1.0; 3]);
    assert_eq!(of("type = \"matte\"\nkd = 0.9").emission, [0.0; 3]);
    assert_eq!(of("type = \"mirror\"").specular, [1.0; 3]);
    assert_eq!(of("type = \"mirror\"\nkd = 0.25").specular, [0.75; 3]);
    assert_eq!(of("type = \"glass\"").dielectric.unwrap().ior, 1.5);
    let glass = of("type = \"glass\"\nior = 1.33\ntint = [1, 0.5, 1]").dielectric.unwrap();
    assert_eq!((glass.ior, glass.transmission_tint), (1.33, [1.0, 0.5, 1.0]));
    let glossy = of("type = \"glossy\"\nkd = 0.1\nks = 0.4\nexponent = 100");
    assert_eq!((glossy.diffuse, glossy.glossy, glossy.glossy_exponent), ([0.1; 3], [0.4; 3], 100.0));
}

/// A scene file without light is refused with the remedy; an OBJ without light gets one at the camera.
#[test]
fn darkness() {
    let dark = load_toml(&format!("{MESH}[[material]]\nname = \"m\"\nke = 0\n"));
    refused(dark, "s.toml", "give a material Ke (radiance) or add a [[light]]");
    let scene = load_obj(format!("{TRIANGLE}f 1 2 3\n")).unwrap();
    let [Light::Point { position, .. }] = scene.lights[..] else { panic!("{:?}", scene.lights) };
    assert_eq!(position, scene.camera.position);
    warned(&scene, "a.obj", "point light is put at the camera");
}

// ---- the automatic camera

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
