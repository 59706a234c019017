//! `joton export`: the XML says what the scene is, the meshes hold its triangles, and what others cannot do is refused.

mod looks;

use glam::{DVec3, Vec3};
use joton::output::export::{Exported, Fidelity, write_mitsuba};
use joton::scene::{Scene, load};
use roxmltree::{Document, Node};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;

/// Corners of a triangle with their normals, if any.
type Corners = [(Vec3, Option<Vec3>); 3];

/// A scene of this repository and its export.
struct Written {
    folder: TempDir,
    scene: Scene,
    exported: Exported,
    text: String,
}

impl Written {
    fn of(scene: Scene, source: &Path) -> Self {
        Self::with(scene, source, Fidelity::Exact)
    }

    fn with(scene: Scene, source: &Path, fidelity: Fidelity) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("out.xml");
        let exported = write_mitsuba(&scene, source, &out, fidelity).unwrap_or_else(|e| panic!("{e}"));
        let text = fs::read_to_string(out).expect("a scene file");
        Self { folder, scene, exported, text }
    }

    fn scene(name: &str) -> Self {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
        Self::of(load(&path).unwrap_or_else(|e| panic!("{e}")), &path)
    }

    fn xml(&self) -> Document<'_> {
        Document::parse(&self.text).unwrap_or_else(|e| panic!("well-formed: {e}\n{}", self.text))
    }

    fn mesh(&self, shape: Node<'_, '_>) -> Vec<Corners> {
        let file = named(shape, "filename").attribute("value").expect("a file");
        read_ply(&fs::read(self.folder.path().join(file)).expect("a mesh beside the scene file"))
    }
}

/// A scene in a folder of its own: the text of its scene file after a camera, and of its OBJ and MTL.
fn small(toml: &str, obj: &str, mtl: &str) -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().expect("a folder");
    let scene = "[camera]\nposition = [0, 0, 3]\ntarget = [0, 0, 0]\n[[mesh]]\nfile = \"m.obj\"\n";
    fs::write(folder.path().join("s.toml"), format!("{scene}{toml}")).expect("written");
    fs::write(folder.path().join("m.obj"), format!("mtllib m.mtl\n{obj}")).expect("written");
    fs::write(folder.path().join("m.mtl"), mtl).expect("written");
    let path = folder.path().join("s.toml");
    (folder, path)
}

fn export_small(toml: &str, obj: &str, mtl: &str) -> Written {
    export_small_as(toml, obj, mtl, Fidelity::Exact)
}

fn export_small_as(toml: &str, obj: &str, mtl: &str, fidelity: Fidelity) -> Written {
    let (_folder, path) = small(toml, obj, mtl);
    Written::with(load(&path).unwrap_or_else(|e| panic!("{e}")), &path, fidelity)
}

/// A flat triangle, and a matte material that shines.
const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\n";
const SHINING: &str = "newmtl a\nKd 0.5 0.5 0.5\nKe 3 2 1\nillum 1\n";
/// The same triangle with normals that are not its own.
const SMOOTH: &str =
    "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nvn 0.3 0 1\nvn 0 0.3 1\nusemtl a\nf 1//1 2//2 3//3\n";
const POINT: &str = "[[light]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = [3, 2, 1]\n";

fn named<'a, 'i>(node: Node<'a, 'i>, name: &str) -> Node<'a, 'i> {
    let found = node.children().find(|c| c.attribute("name") == Some(name));
    found.unwrap_or_else(|| panic!("{} has no {name}", node.tag_name().name()))
}

fn child<'a, 'i>(node: Node<'a, 'i>, tag: &str) -> Node<'a, 'i> {
    node.children().find(|c| c.has_tag_name(tag)).unwrap_or_else(|| panic!("no {tag} in {node:?}"))
}

fn numbers(text: &str) -> Vec<f64> {
    text.split(',').map(|x| x.trim().parse().unwrap_or_else(|_| panic!("{x:?} is no number"))).collect()
}

fn values(node: Node<'_, '_>, name: &str) -> Vec<f64> {
    numbers(named(node, name).attribute("value").expect("a value"))
}

fn look_at(node: Node<'_, '_>) -> [DVec3; 3] {
    let at = child(named(node, "to_world"), "lookat");
    ["origin", "target", "up"].map(|key| DVec3::from_slice(&numbers(at.attribute(key).expect("a point"))))
}

/// The triangles of a binary PLY of this program's making.
fn read_ply(bytes: &[u8]) -> Vec<Corners> {
    let end = b"end_header\n";
    let at = bytes.windows(end.len()).position(|w| w == end).expect("a header") + end.len();
    let head = std::str::from_utf8(&bytes[..at]).expect("text");
    assert!(head.starts_with("ply\nformat binary_little_endian 1.0\n"), "{head}");
    let count = |element: &str| -> usize {
        let line = head.lines().find_map(|l| l.strip_prefix(element)).expect("an element");
        line.trim().parse().expect("a count")
    };
    let floats = head.matches("property float").count();
    assert!(floats == 3 || (floats == 6 && head.contains("nx")), "{head}");
    let mut rest = &bytes[at..];
    let mut take = |n: usize| {
        let (taken, left) = rest.split_at(n);
        rest = left;
        taken.to_vec()
    };
    let vertices: Vec<Vec<f32>> = (0..count("element vertex"))
        .map(|_| take(4 * floats).as_chunks::<4>().0.iter().map(|&b| f32::from_le_bytes(b)).collect())
        .collect();
    let corner = |i: u32| {
        let v = &vertices[i as usize];
        (Vec3::from_slice(v), v.get(3..).filter(|n| !n.is_empty()).map(Vec3::from_slice))
    };
    let triangles = (0..count("element face"))
        .map(|_| {
            assert_eq!(take(1), [3]);
            let indices = take(12);
            let indices: Vec<u32> =
                indices.as_chunks::<4>().0.iter().map(|&b| u32::from_le_bytes(b)).collect();
            [0, 1, 2].map(|k| corner(indices[k]))
        })
        .collect();
    assert!(rest.is_empty(), "{} bytes after the last triangle", rest.len());
    triangles
}

/// Every triangle of a scene stands in the mesh of its material, same turn, same normals, in the same order, and nothing
/// else does.
fn check_meshes(written: &Written) {
    let (scene, xml) = (&written.scene, written.xml());
    let root = xml.root_element();
    let mut found = 0;
    for shape in root.children().filter(|c| c.has_tag_name("shape")) {
        assert_eq!(shape.attribute("type"), Some("ply"));
        let id = child(shape, "ref").attribute("id").expect("a material");
        assert!(root.children().any(|b| b.has_tag_name("bsdf") && b.attribute("id") == Some(id)), "{id}");
        let (index, name) = id.split_once(' ').expect("index and name");
        let index: u32 = index.parse().expect("an index");
        assert_eq!(scene.materials[index as usize].name, name);
        let flat = named(shape, "face_normals").attribute("value") == Some("true");
        let wanted =
            scene.mesh.triangles.iter().filter(|t| t.material == index && t.normal.is_none() == flat);
        let wanted: Vec<Corners> = wanted
            .map(|t| {
                [0, 1, 2].map(|k| {
                    let normal = t.normal.map(|n| scene.mesh.normals[n[k] as usize]);
                    (scene.mesh.positions[t.vertex[k] as usize].as_vec3(), normal)
                })
            })
            .collect();
        let got = written.mesh(shape);
        assert_eq!(got, wanted, "{id}");
        found += got.len();
    }
    assert_eq!(found, scene.mesh.triangles.len());
}

/// Camera, film and integrator of the Cornell box are the scene's, to the last digit; its meshes hold all triangles; its
/// light alone emits; its materials have their reflectances on both sides.
#[test]
fn the_cornell_box_is_written_whole() {
    let mut written = Written::scene("cornell.toml");
    // across and down differ, and f32 does not hold all digits
    written.scene.resize([64, 32]);
    written.scene.camera.position.x = 1.0 / 3.0;
    let written = Written::of(written.scene, Path::new("cornell.toml"));
    check_meshes(&written);
    let (scene, xml) = (&written.scene, written.xml());
    let root = xml.root_element();
    assert_eq!(root.attribute("version"), Some("3.0.0"));
    assert_eq!(values(child(root, "integrator"), "max_depth"), [-1.0], "paths of any length");

    let sensor = child(root, "sensor");
    assert_eq!(look_at(sensor), [scene.camera.position, scene.camera.target, scene.camera.up]);
    assert_eq!(named(sensor, "fov_axis").attribute("value"), Some("x"));
    let tangent = (values(sensor, "fov")[0].to_radians() / 2.0).tan();
    // rounding of tan, atan and degrees in f64
    assert!((tangent / scene.camera.tan_half_fov[0] - 1.0).abs() < 1e-14, "{tangent}");
    let distances = || scene.mesh.positions.iter().map(|p| (*p - scene.camera.position).length());
    assert!(values(sensor, "near_clip")[0] < 1e-3 * distances().fold(f64::INFINITY, f64::min));
    assert!(values(sensor, "far_clip")[0] > distances().fold(0.0, f64::max));
    let film = child(sensor, "film");
    assert_eq!(values(film, "width"), [f64::from(scene.size[0])]);
    assert_eq!(values(film, "height"), [f64::from(scene.size[1])]);
    assert_eq!(child(film, "rfilter").attribute("type"), Some("box"));
    assert_eq!(named(film, "component_format").attribute("value"), Some("float32"));

    let shapes: Vec<Node<'_, '_>> = root.children().filter(|c| c.has_tag_name("shape")).collect();
    for shape in &shapes {
        let id = child(*shape, "ref").attribute("id").expect("a material");
        let index: usize = id.split(' ').next().and_then(|i| i.parse().ok()).expect("an index");
        let material = &scene.materials[index];
        let emitter = shape.children().find(|c| c.has_tag_name("emitter"));
        let radiance = emitter.map_or(vec![0.0; 3], |e| values(e, "radiance"));
        assert_eq!(radiance, material.emission.map(|e| e.to_string().parse::<f64>().expect("a number")));
        let bsdf = root.children().find(|b| b.attribute("id") == Some(id)).expect("a material");
        assert_eq!(bsdf.attribute("type"), Some("twosided"));
        let lobe = child(bsdf, "bsdf");
        assert_eq!(lobe.attribute("type"), Some("diffuse"));
        let reflectance = values(lobe, "reflectance");
        assert_eq!(reflectance.iter().map(|x| *x as f32).collect::<Vec<_>>(), material.diffuse);
    }
    assert_eq!(shapes.iter().filter(|s| s.children().any(|c| c.has_tag_name("emitter"))).count(), 1);
    assert!(!written.exported.specular && !written.exported.spots);
}

/// Glass and mirror of the spheres, with their normals.
#[test]
fn smooth_bodies_keep_normals_and_index() {
    let written = Written::scene("spheres.toml");
    assert!(written.scene.mesh.triangles.iter().any(|t| t.normal.is_some()), "a scene for this test");
    check_meshes(&written);
    assert!(written.exported.specular);
    let xml = written.xml();
    let of_type =
        |kind| xml.descendants().find(|n| n.has_tag_name("bsdf") && n.attribute("type") == Some(kind));
    let glass = of_type("dielectric").expect("glass");
    let dielectric = written.scene.materials.iter().find_map(|m| m.dielectric).expect("glass");
    assert_eq!(values(glass, "int_ior")[0] as f32, dielectric.ior);
    assert_eq!(values(glass, "ext_ior"), [1.0]);
    let mirror = of_type("conductor").expect("a mirror");
    assert_eq!(mirror.parent().and_then(|p| p.attribute("type")), Some("twosided"));
    assert_eq!(named(mirror, "material").attribute("value"), Some("none"), "no metal's colour");
    // what a box of this size measures
    let extent = (0..3).map(|axis| {
        let axis = written.scene.mesh.positions.iter().map(|p| p[axis]);
        axis.clone().fold(f64::NEG_INFINITY, f64::max) - axis.fold(f64::INFINITY, f64::min)
    });
    assert_eq!(written.exported.extent, extent.fold(0.0, f64::max));
}

/// Along a crease, a vertex has a normal for each side.
#[test]
fn a_vertex_may_have_two_normals() {
    let second = "v 1 1 0\nvn -0.3 0 1\nf 2//2 4//1 3//4\n";
    let written = export_small(POINT, &format!("{SMOOTH}{second}"), "newmtl a\nKd 0.5 0.5 0.5\nillum 1\n");
    assert!(written.scene.mesh.triangles.iter().all(|t| t.normal.is_some()), "a scene for this test");
    check_meshes(&written);
}

/// Tints of glass: what reflects and what crosses are told apart.
#[test]
fn tints_of_glass_are_told_apart() {
    let glass = "newmtl a\nNi 1.4\nTf 0.9 0.7 0.8\nKs 0.5 0.25 0.75\nillum 7\n";
    let written = export_small(POINT, TRIANGLE, glass);
    let xml = written.xml();
    let glass = child(xml.root_element(), "bsdf");
    assert_eq!(values(glass, "specular_transmittance"), [0.9, 0.7, 0.8]);
    assert_eq!(values(glass, "specular_reflectance"), [0.5, 0.25, 0.75]);
}

/// Lights without a surface: kind, place and direction, and quantity.
#[test]
fn lights_keep_their_quantities() {
    let lights = format!(
        "{POINT}[[light]]\nkind = \"spot\"\nposition = [1, 2, 3]\ntarget = [1, 0, 3]\nintensity = 4\nangle_inner = 20\n\
         angle_outer = 20\n[[light]]\nkind = \"sun\"\ndirection = [0, -2, 0]\nirradiance = [5, 6, 7]\n"
    );
    let written = export_small(&lights, TRIANGLE, "newmtl a\nKd 0.5 0.5 0.5\nillum 1\n");
    let xml = written.xml();
    let emitters: Vec<Node<'_, '_>> =
        xml.root_element().children().filter(|c| c.has_tag_name("emitter")).collect();
    let kinds: Vec<Option<&str>> = emitters.iter().map(|e| e.attribute("type")).collect();
    assert_eq!(kinds, [Some("point"), Some("spot"), Some("directional")]);
    let vector =
        |node: Node<'_, '_>| ["x", "y", "z"].map(|axis| numbers(node.attribute(axis).expect("a number"))[0]);
    assert_eq!(vector(named(emitters[0], "position")), [0.0, 0.0, 2.0]);
    assert_eq!(values(emitters[0], "intensity"), [3.0, 2.0, 1.0]);
    let [origin, target, up] = look_at(emitters[1]);
    assert_eq!(origin, DVec3::new(1.0, 2.0, 3.0));
    assert!((target - origin).normalize().dot(DVec3::NEG_Y) > 1.0 - 1e-15);
    assert!((target - origin).cross(up).length() > 0.5, "up is not along the axis");
    assert_eq!(values(emitters[1], "intensity"), [4.0; 3]);
    for edge in ["cutoff_angle", "beam_width"] {
        // rounding of cosine and its inverse
        assert!((values(emitters[1], edge)[0] - 20.0).abs() < 1e-12, "{edge}");
    }
    assert_eq!(vector(named(emitters[2], "direction")), [0.0, -1.0, 0.0]);
    assert_eq!(values(emitters[2], "irradiance"), [5.0, 6.0, 7.0]);
    assert!(written.exported.spots && !written.exported.specular);
}

/// A name may hold what XML and Mitsuba give a meaning to.
#[test]
fn names_are_escaped() {
    let mtl = SHINING.replace("newmtl a", "newmtl <a & \"b\">$c");
    let written = export_small("", &TRIANGLE.replace("usemtl a", "usemtl <a & \"b\">$c"), &mtl);
    let xml = written.xml();
    let bsdf = child(xml.root_element(), "bsdf").attribute("id");
    assert_eq!(bsdf, Some("0 <a & \"b\">_c"));
    let shape = child(xml.root_element(), "shape");
    assert_eq!(child(shape, "ref").attribute("id"), bsdf);
}

/// Two triangles in one place are one surface here; elsewhere a lamp would shine twice.
#[test]
fn copies_are_written_once() {
    let written = export_small("", &format!("{TRIANGLE}f 2 3 1\n"), SHINING);
    assert_eq!(written.scene.mesh.triangles.len(), 2);
    assert_eq!(written.mesh(child(written.xml().root_element(), "shape")).len(), 1);
}

/// A lamp that reflects nothing has no use for normals, and others would take its cosine from them.
#[test]
fn black_lamps_are_flat() {
    let written = export_small("", SMOOTH, &SHINING.replace("Kd 0.5 0.5 0.5", "Kd 0 0 0"));
    assert!(written.scene.mesh.triangles[0].normal.is_some(), "a scene for this test");
    let xml = written.xml();
    let shape = child(xml.root_element(), "shape");
    assert_eq!(named(shape, "face_normals").attribute("value"), Some("true"));
    assert!(written.mesh(shape)[0].iter().all(|(_, normal)| normal.is_none()));
}

/// What has no exact counterpart is an error that names the scene, the culprit and what to do; nothing is written. The
/// same in a material that nothing uses is none.
#[test]
fn what_others_cannot_do_is_refused() {
    let glossy = "newmtl a\nKd 0.5 0.5 0.5\nKs 0.2 0.2 0.2\nNs 20\nillum 2\n";
    let rough = "newmtl a\nKd 0.5 0.5 0.5\nPr 0.4\n";
    let blend = "newmtl a\nKd 0.4 0.3 0.2\nKs 0.3 0.3 0.3\nillum 3\n";
    let soft = "[[light]]\nkind = \"spot\"\nposition = [0, 0, 2]\ndirection = [0, 0, -1]\nintensity = 1\n\
                angle_inner = 20\nangle_outer = 30\n";
    let far = "v 1e5 0 0\nv 100001 0 0\nv 1e5 1 0\nusemtl a\nf 1 2 3\n";
    let of = |keys: &str| format!("{POINT}[[material]]\nname = \"a\"\n{keys}\n");
    let board = "{ checkerboard = [[0, 0, 0], [1, 1, 1]] }";
    let glowing = of(&format!("ke = {board}"));
    let varying = of(&format!("type = \"metal\"\nroughness = {board}"));
    let bumped = of("bump = { checkerboard = [[0, 0, 0], [1, 1, 1]], height = 0.1 }");
    let coloured = of("type = \"metal\"\nks = [0.9, 0.5, 0.2]");
    let tough = of("type = \"plastic\"\nroughness = 0.5");
    let coat = of("type = \"principled\"\nclearcoat = 1");
    let saturated = of(&format!("type = \"plastic\"\nsaturated = true\nkd = {board}"));
    let paper = of("transmit = 0.2");
    let cloudy = of("type = \"principled\"\ntransmission = 0.5");
    let stained = of(&format!("type = \"principled\"\ntransmission = 1\nkd = {board}"));
    let frosted = of("type = \"glass\"\nthin = true\nroughness = 0.5");
    let flint = of("type = \"glass\"\nior = \"sf10\"");
    let spectral = of("kd = { spectrum = [[400, 0.1], [700, 0.2]] }");
    let pictured = format!("{spectral}[[shape]]\nkind = \"cube\"\nmaterial = {{ kd = {board} }}\n");
    let laser = "[[light]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = { lines = [[532, 1.0]] }\n";
    let matte = "newmtl a\nKd 0.5 0.5 0.5\n";
    let glass = |key: &str| format!("{POINT}[[material]]\nname = \"a\"\ntype = \"glass\"\n{key}\n");
    let (dark, first) = (glass("absorption = 2"), glass("priority = 1"));
    for (toml, obj, mtl, culprit, remedy) in [
        (&dark[..], TRIANGLE, matte, "material \"a\": what its inside absorbs", "a tint"),
        (&first, TRIANGLE, matte, "material \"a\": its priority", "an index over"),
        (&glowing, TRIANGLE, matte, "material \"a\": light from pictures", "a plain ke"),
        (&varying, TRIANGLE, matte, "material \"a\": roughness that varies", "one roughness"),
        (&bumped, TRIANGLE, matte, "material \"a\": its normals or bumps", "leave its normal"),
        (&coloured, TRIANGLE, matte, "material \"a\": metal by its colour", "eta and k"),
        (&tough, TRIANGLE, matte, "material \"a\": other renderers shadow rough surfaces", "--near"),
        (&coat, TRIANGLE, matte, "material \"a\": its layers", "make it plastic"),
        (&saturated, TRIANGLE, matte, "material \"a\": a texture under a coat", "leave saturated out"),
        (&paper, TRIANGLE, matte, "material \"a\": what it scatters through", "leave its transmit out"),
        (&cloudy, TRIANGLE, matte, "material \"a\": what is glass in part", "0 or 1"),
        (&stained, TRIANGLE, matte, "material \"a\": glass with a picture", "a plain"),
        (&frosted, TRIANGLE, matte, "material \"a\": rough panes", "make it smooth"),
        (&flint, TRIANGLE, matte, "material \"a\": glass that parts colours", "one number as ior"),
        (&pictured, TRIANGLE, matte, "between colours of a texture", "--spectral off"),
        (laser, TRIANGLE, matte, "light of lines", "peaks of some width"),
        (POINT, TRIANGLE, rough, "material \"a\": metal by its colour, and what is matte", "make it plastic"),
        (POINT, TRIANGLE, glossy, "material \"a\": its glossy lobe", "make it matte"),
        (POINT, TRIANGLE, blend, "material \"a\": its sum of a matte and a mirror lobe", "make it matte"),
        (soft, TRIANGLE, SHINING, "light 1: the soft edge of a spot", "angle_inner = angle_outer"),
        ("", SMOOTH, SHINING, "material \"a\": emits, reflects", "Kd 0"),
        ("", far, SHINING, "far from the origin", "translate"),
    ] {
        let (folder, path) = small(toml, obj, mtl);
        let scene = load(&path).unwrap_or_else(|e| panic!("{e}"));
        let before = fs::read_dir(folder.path()).expect("a folder").count();
        let e = {
            let out = folder.path().join("out.xml");
            write_mitsuba(&scene, &path, &out, Fidelity::Exact).expect_err(culprit).to_string()
        };
        assert!(e.contains("s.toml") && e.contains(culprit) && e.contains(remedy), "{culprit}: {e}");
        assert_eq!(fs::read_dir(folder.path()).expect("a folder").count(), before, "{culprit}");
    }
    let unused = format!("{SHINING}{}", glossy.replace("newmtl a", "newmtl b"));
    export_small("", TRIANGLE, &unused);
    // a hundredth as far is near enough
    export_small("", &far.replace("1e5", "1e2").replace("100001", "101"), SHINING);
}

/// The command: files and exit status.
#[test]
fn the_command_writes_or_says_why() {
    let (folder, _) = small("", TRIANGLE, SHINING);
    let run = |words: &str| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_joton"));
        let ended =
            command.args(words.split_whitespace()).current_dir(folder.path()).output().expect("joton runs");
        (ended.status.code(), String::from_utf8_lossy(&ended.stderr).into_owned())
    };
    let (code, stderr) = run("export s.toml --size 20x10 -o o.xml");
    assert_eq!(code, Some(0), "{stderr}");
    assert!(folder.path().join("o.0.ply").is_file());
    let text = fs::read_to_string(folder.path().join("o.xml")).expect("a file");
    assert!(text.contains("name=\"width\" value=\"20\"") && text.contains("name=\"height\" value=\"10\""));
    for (words, part) in [
        ("export s.toml -o o.obj", ".xml"),
        ("export s.toml -o none/o.xml", "none"),
        ("export none.toml -o o.xml", "none.toml"),
        ("export s.toml -o o$spp.xml", "without $"),
        ("export s.toml", "--output"),
    ] {
        let (code, stderr) = run(words);
        assert_eq!(code, Some(2), "joton {words}: {stderr}");
        assert!(stderr.contains(part), "joton {words}: {stderr}");
    }
}
