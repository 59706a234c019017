//! Scene files in TOML.

use crate::folder::{Folder, TRIANGLE, load_obj, refused, warned};
use glam::DVec3;
use joton::Error;
use joton::scene::{Light, Scene};

const MESH: &str = "[[mesh]]\nfile = \"a.obj\"\n";

/// A scene file beside an OBJ with one triangle of material `m`, which emits.
fn load_toml(toml: &str) -> Result<Scene, Error> {
    let obj = format!("mtllib m.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    let mtl = b"newmtl m\nKd .2 .2 .2\nKe 1 1 1\n";
    Folder::new(&[("a.obj", obj.as_bytes()), ("m.mtl", mtl), ("s.toml", toml.as_bytes())]).load("s.toml")
}

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
    let Light::Spot { direction, angle_inner, angle_outer, .. } = scene.lights[1] else { panic!("no spot") };
    assert_eq!((direction, angle_inner), (DVec3::NEG_Y, 0.0));
    assert!((angle_outer.cos() - 0.5).abs() < 1e-12);
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
