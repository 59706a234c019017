//! Shapes of a scene file, where they and meshes stand, and what they are made of.

use crate::folder::{Folder, TRIANGLE, refused};
use glam::{DVec3, Vec3};
use joton::Error;
use joton::scene::Scene;

const SUN: &str = "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n";
/// A square that faces up, of two objects and two groups, and a library.
const OBJ: &str = "mtllib m.mtl\nv 0 0 0\nv 0 0 1\nv 1 0 0\nv 1 0 1\nusemtl a\no Left half\nf 1 2 3\n\
                   o Right\ng wood oak\nf 2 4 3\n";
const MTL: &[u8] = b"newmtl a\nKd .2 .2 .2\nKe 1 1 1\n";

fn load(toml: &str) -> Result<Scene, Error> {
    let files = [("a.obj", OBJ.as_bytes()), ("m.mtl", MTL), ("s.toml", toml.as_bytes())];
    Folder::new(&files).load("s.toml")
}

/// A scene of one shape under the sun.
fn shape(keys: &str) -> Result<Scene, Error> {
    load(&format!("[[shape]]\n{keys}\n{SUN}"))
}

/// Corners of a triangle.
fn corners(scene: &Scene, triangle: usize) -> [DVec3; 3] {
    scene.mesh.triangles[triangle].vertex.map(|v| scene.mesh.positions[v as usize])
}

fn front(scene: &Scene, triangle: usize) -> DVec3 {
    let [a, b, c] = corners(scene, triangle);
    (b - a).cross(c - a).normalize()
}

/// Least and largest coordinates.
fn extent(scene: &Scene) -> [DVec3; 2] {
    let all = || scene.mesh.positions.iter().copied();
    [all().fold(DVec3::INFINITY, DVec3::min), all().fold(DVec3::NEG_INFINITY, DVec3::max)]
}

fn is_near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-9
}

/// Shapes have the place and the size that they are said to have, or those that SCENE.md tells.
#[test]
fn shapes_stand_where_they_are_said_to() {
    for (keys, least, largest) in [
        ("kind = \"cube\"", DVec3::splat(-0.5), DVec3::splat(0.5)),
        (
            "kind = \"cube\"\nsize = [1, 2, 4]\ncenter = [1, 1, 2]",
            DVec3::new(0.5, 0., 0.),
            DVec3::new(1.5, 2., 4.),
        ),
        ("kind = \"rectangle\"\nsize = [2, 4]", DVec3::new(-1., 0., -2.), DVec3::new(1., 0., 2.)),
        (
            "kind = \"rectangle\"\nsize = [2, 4]\nfacing = [3, 0, 0]",
            DVec3::new(0., -2., -1.),
            DVec3::new(0., 2., 1.),
        ),
        ("kind = \"disc\"\nradius = 2\ncenter = [0, 1, 0]", DVec3::new(-2., 1., -2.), DVec3::new(2., 1., 2.)),
        ("kind = \"cylinder\"\nheight = 3", DVec3::new(-0.5, -1.5, -0.5), DVec3::new(0.5, 1.5, 0.5)),
        (
            "kind = \"cylinder\"\naxis = [0, 0, 2]\nradius = 1",
            DVec3::new(-1., -1., -0.5),
            DVec3::new(1., 1., 0.5),
        ),
        (
            "kind = \"cube\"\nscale = [1, 2, 3]\ntranslate = [0, 0, 5]",
            DVec3::new(-0.5, -1., 3.5),
            DVec3::new(0.5, 1., 6.5),
        ),
        (
            "kind = \"cube\"\ncenter = [1, 0, 0]\nrotate = [0, 90, 0]",
            DVec3::new(-0.5, -0.5, -1.5),
            DVec3::new(0.5, 0.5, -0.5),
        ),
        // about x first, then z
        (
            "kind = \"cube\"\ncenter = [0, 0, 1]\nrotate = [90, 0, 90]",
            DVec3::new(0.5, -0.5, -0.5),
            DVec3::new(1.5, 0.5, 0.5),
        ),
        (
            "kind = \"cube\"\nmatrix = [[2, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]",
            DVec3::new(0., -0.5, -0.5),
            DVec3::new(2., 0.5, 0.5),
        ),
    ] {
        let scene = shape(keys).unwrap();
        let [found_least, found_largest] = extent(&scene);
        assert!(
            is_near(found_least, least) && is_near(found_largest, largest),
            "{keys}: {found_least} {found_largest}"
        );
        assert!(scene.warnings.is_empty(), "{keys}: {:?}", scene.warnings);
    }
    let ball = shape("kind = \"sphere\"\nradius = 2\ncenter = [0, 2, 0]").unwrap();
    assert_eq!(ball.mesh.triangles.len(), 20480);
    assert!(ball.mesh.positions.iter().all(|p| ((*p - DVec3::Y * 2.0).length() - 2.0).abs() < 1e-12));
    let coarse = shape("kind = \"sphere\"\ntolerance = 0.01").unwrap();
    assert_eq!(coarse.mesh.triangles.len(), 1280);
}

/// Squeezed and mirrored, a ball looks out still, with normals of the squeezed surface; a mesh that is mirrored keeps its front.
#[test]
fn fronts_and_normals_follow() {
    for keys in ["scale = [1, 0.25, 1]", "matrix = [[-1, 0, 0, 0], [0, 0.25, 0, 0], [0, 0, 1, 0]]"] {
        let scene = shape(&format!("kind = \"sphere\"\nradius = 1\n{keys}")).unwrap();
        for (i, t) in scene.mesh.triangles.iter().enumerate() {
            let [a, ..] = corners(&scene, i);
            assert!(front(&scene, i).dot(a) > 0.0, "{keys}");
            // x² + (4 y)² + z² = 1
            let wanted = DVec3::new(a.x, 16.0 * a.y, a.z).normalize().as_vec3();
            let normal = scene.mesh.normals[t.normal.unwrap()[0] as usize];
            assert!((normal - wanted).length() < 1e-5, "{keys}: {normal} {wanted}");
        }
    }
    let mesh = "[[mesh]]\nfile = \"a.obj\"\n";
    let mirrored = load(&format!("{mesh}matrix = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]")).unwrap();
    assert!(is_near(front(&mirrored, 0), DVec3::Y));
    assert!(mirrored.mesh.positions.iter().all(|p| p.x <= 0.0));
    let turned = load(&format!("{mesh}rotate = [90, 0, 0]")).unwrap();
    assert!(is_near(front(&turned, 0), DVec3::Z));
}

/// Normals of a mesh turn with it, and those of a mirrored one look to its front.
#[test]
fn normals_of_a_mesh_follow() {
    let obj = format!("{TRIANGLE}vn 1 0 1\nvn 0 0 1\nvn 0 1 1\nf 1//1 2//2 3//3\n");
    let load = |keys: &str| {
        let toml = format!("[[mesh]]\nfile = \"b.obj\"\n{keys}\n{SUN}");
        Folder::new(&[("b.obj", obj.as_bytes()), ("s.toml", toml.as_bytes())]).load("s.toml").unwrap()
    };
    let first = |scene: &Scene| {
        let t = &scene.mesh.triangles[0];
        let corner = t.vertex.iter().position(|v| scene.mesh.positions[*v as usize] == DVec3::ZERO).unwrap();
        scene.mesh.normals[t.normal.unwrap()[corner] as usize]
    };
    for (keys, wanted) in [
        ("", [1., 0., 1.]),
        ("rotate = [0, 90, 0]", [1., 0., -1.]),
        ("scale = [2, 1, 1]", [0.5, 0., 1.]),
        ("matrix = [[-1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]", [-1., 0., 1.]),
    ] {
        let scene = load(keys);
        let wanted = Vec3::from(wanted).normalize();
        assert!((first(&scene) - wanted).length() < 1e-6, "{keys}: {}", first(&scene));
        let only = ["faces without a material are matte grey 0.5"];
        assert!(
            scene.warnings.iter().zip(only).all(|(w, o)| w.contains(o)) && scene.warnings.len() == 1,
            "{:?}",
            scene.warnings
        );
    }
}

/// What a shape is made of: grey, a material of the file, or what it says itself. A name that is used twice is one material.
#[test]
fn shapes_are_made_of_something() {
    let toml = format!(
        "shape = [
            {{ kind = \"cube\" }},
            {{ kind = \"cube\", material = \"red\" }},
            {{ kind = \"disc\", material = \"red\" }},
            {{ kind = \"sphere\", material = {{ type = \"glass\", ior = 1.25 }} }},
            {{ kind = \"disc\", center = [0, 5, 0], material = {{ ke = 3 }} }},
        ]
        [[material]]
        name = \"red\"
        kd = [0.5, 0, 0]
        {SUN}"
    );
    let scene = load(&toml).unwrap();
    let diffuse: Vec<[f32; 3]> = scene.materials.iter().map(|m| m.diffuse).collect();
    assert_eq!(diffuse, [[0.5; 3], [0.5, 0., 0.], [0.; 3], [0.; 3]]);
    assert_eq!(scene.materials[2].dielectric.unwrap().ior, 1.25);
    assert_eq!(scene.materials[3].emission, [3.0; 3]);
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
}

/// A mesh as a whole is made of what its table says; its own materials are not asked.
#[test]
fn a_mesh_is_made_of_what_its_table_says() {
    let toml = format!(
        "[[mesh]]\nfile = \"a.obj\"\n[[mesh]]\nfile = \"a.obj\"\nmaterial = {{ type = \"mirror\" }}\n{SUN}"
    );
    let scene = load(&toml).unwrap();
    let materials: Vec<u32> = scene.mesh.triangles.iter().map(|t| t.material).collect();
    assert_eq!(materials, [0, 0, 1, 1]);
    assert_eq!((scene.materials[0].emission, scene.materials[1].specular), ([1.0; 3], [1.0; 3]));
}

/// A `[[material]]` of an object or a group counts for its faces, over that of their material; names with spaces are names.
#[test]
fn objects_and_groups_have_materials() {
    let mesh = "[[mesh]]\nfile = \"a.obj\"\n";
    let entry = |of: &str, more: &str| format!("[[material]]\n{of}\n{more}\n");
    let of = |toml: String| {
        let scene = load(&toml).unwrap();
        let each = |t: usize| scene.materials[scene.mesh.triangles[t].material as usize].clone();
        [each(0), each(1)]
    };
    let [left, right] = of(format!("{mesh}{}", entry("object = \"Left half\"", "kd = 0.75")));
    assert_eq!((left.diffuse, right.diffuse), ([0.75; 3], [0.2; 3]));
    assert_eq!(left.emission, [1.0; 3], "what is not stated stays");
    let [left, right] = of(format!("{mesh}{}", entry("object = \"oak\"", "type = \"mirror\"")));
    assert_eq!((left.specular, right.specular, right.emission), ([0.0; 3], [1.0; 3], [0.0; 3]));
    // the group counts over the object, and either over the material
    let said = |of: &str, kd: f32| entry(of, &format!("kd = {kd}"));
    let all =
        [said("name = \"a\"", 0.1), said("object = \"wood oak\"", 0.3), said("object = \"Right\"", 0.6)];
    let [left, right] = of(format!("{mesh}{}", all.concat()));
    assert_eq!((left.diffuse, right.diffuse), ([0.1; 3], [0.3; 3]));
    let parts = ["object = \"Right\"\nke = 5", "object = \"oak\"\nkd = 0.7"].map(|of| entry(of, ""));
    let [_, right] = of(format!("{mesh}{}", parts.concat()));
    assert_eq!((right.diffuse, right.emission), ([0.7; 3], [5.0; 3]));
}

/// Faults name their line and what was meant.
#[test]
fn faults_of_shapes_have_lines() {
    for (keys, line, words) in [
        ("radius = 1", 1, "has no kind"),
        (
            "kind = \"ball\"",
            2,
            "unknown kind of shape \"ball\"; known are sphere, cube, rectangle, disc, cylinder, prism",
        ),
        ("kind = \"spere\"", 2, "did you mean \"sphere\"?"),
        ("kind = \"cube\"\nradius = 1", 3, "unknown key in [[shape]]: \"radius\""),
        ("kind = \"sphere\"\nradius = 0", 3, "radius 0; give a number above 0"),
        ("kind = \"cube\"\nsize = [1, -1, 1]", 3, "size -1; give a number above 0"),
        ("kind = \"rectangle\"\nsize = [1, 1, 1]", 3, "two finite numbers"),
        ("kind = \"disc\"\nfacing = [0, 0, 0]", 3, "facing without length"),
        ("kind = \"sphere\"\ntolerance = 1e-9", 3, "tolerance 0.000000001"),
        ("kind = \"cylinder\"\ncaps = 1", 3, "true or false"),
        ("kind = \"prism\"\nsides = 2", 3, "prism of 2 sides; give 3 to 1024"),
        ("kind = \"cube\"\nscale = -1", 3, "matrix can mirror"),
        ("kind = \"cube\"\nmatrix = [[1, 0, 0, 0]]", 3, "three rows of four"),
        ("kind = \"cube\"\nmatrix = [[1, 0, 0, 0], [2, 0, 0, 0], [0, 0, 1, 0]]", 3, "flattens everything"),
        (
            "kind = \"cube\"\nscale = 2\nmatrix = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]]",
            4,
            "one or the other",
        ),
        (
            "kind = \"cube\"\nmaterial = \"red\"",
            3,
            "no [[material]] is called \"red\"; add [[material]] with name = \"red\"",
        ),
        ("kind = \"cube\"\nmaterial = { colour = 1 }", 3, "unknown key in material: \"colour\""),
        ("kind = \"cube\"\nmaterial = 1", 3, "a name in quotes, or a table"),
    ] {
        refused(shape(keys), &format!("s.toml:{line}"), words);
    }
    let mesh = "[[mesh]]\nfile = \"a.obj\"\n[[material]]\n";
    refused(
        load(&format!("{mesh}object = \"Rigth\"")),
        "s.toml:3",
        "no mesh has an object or group \"Rigth\"; did you mean \"Right\"?",
    );
    refused(load(&format!("{mesh}name = \"a\"\nobject = \"Right\"")), "s.toml:5", "both name and object");
    let near = "[[shape]]\nkind = \"cube\"\nmaterial = \"redd\"\n[[material]]\nname = \"red\"\n";
    refused(load(&format!("{near}{SUN}")), "s.toml:3", "did you mean \"red\"?");
    refused(load(SUN), "s.toml", "no [[mesh]] and no [[shape]]");
}
