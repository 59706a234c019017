//! Materials: libraries of MTL, and the rule that decides what a material is.

use crate::folder::{Folder, TRIANGLE, load_obj, refused, warned, with_mtl};
use joton::scene::{FacetKind, Material};
use joton::spectrum::Bands;

fn material(statements: &str) -> Material {
    with_mtl(format!("newmtl m\n{statements}\n")).unwrap().materials.remove(0)
}

fn warnings(statements: &str) -> String {
    with_mtl(format!("newmtl m\n{statements}\n")).unwrap().warnings.join("\n")
}

fn near(a: Bands, b: Bands) -> bool {
    // One rounding of f32 in each of a few operations.
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6)
}

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
    assert!(!warnings("illum 7\nNi 1.5\nKd .01 .01 .01").contains("Kd of"));
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

/// Rule 5: illum 2 or none with Ks is glossy; the exponent is Ns, else 10, within 1 and 10⁶; with Pr the lobe is of microfacets.
#[test]
fn ks_is_a_lobe() {
    for illum in ["", "illum 2\n"] {
        for (roughness, exponent) in [("Ns 50", 50.0), ("", 10.0), ("Ns 0", 1.0), ("Ns 1e9", 1e6)] {
            let m = material(&format!("{illum}Kd .3 .3 .3\nKs .5 .5 .5\n{roughness}"));
            assert_eq!(
                (m.glossy, m.glossy_exponent, m.diffuse),
                ([0.5; 3], exponent, [0.3; 3]),
                "{roughness}"
            );
        }
        assert_eq!(material(&format!("{illum}Kd .3 .3 .3\nKs 0 0 0\nNs 10")).glossy_exponent, 0.0);
        for (roughness, alpha) in
            [("Pr 0.5", 0.25), ("Ns 50\nPr 0.5", 0.25), ("Pr 0", 0.0), ("Pr 1", 1.0), ("Pr 9", 1.0)]
        {
            let m = material(&format!("{illum}Kd .3 .3 .3\nKs .25 .25 .25\n{roughness}"));
            let facets = m.facets.expect("microfacets");
            assert_eq!((m.glossy, m.diffuse, facets.alpha), ([0.25; 3], [0.3; 3], alpha), "{roughness}");
            assert_eq!(facets.kind, FacetKind::Schlick { ior: 3.0 }, "a coat that reflects as much head on");
        }
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
    assert!(warnings("map_Kd a.png").contains("\"a.png\" is not found; the plain colour is used"));
}

/// Warnings of one kind about many materials are one line with the first names and a count; of two, both; others stay apart.
#[test]
fn warnings_of_one_kind_are_one_line() {
    let told = |count: usize| {
        let names: Vec<String> = (0..count).map(|i| format!("m{i}")).collect();
        let faces: String = names.iter().map(|n| format!("usemtl {n}\nf 1 2 3\n")).collect();
        let mtl: String = names.iter().map(|n| format!("newmtl {n}\ndisp {n}.png\nKd .5 .5 .5\n")).collect();
        let obj = format!("mtllib m.mtl\n{TRIANGLE}{faces}usemtl n\nf 1 2 3\n");
        let mtl = format!("{mtl}newmtl n\nKd 1 1 1\nd .5\n");
        let files = [("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes())];
        let mut lines = Folder::new(&files).load("a.obj").unwrap().warnings;
        lines.retain(|line| !line.contains("point light"));
        assert_eq!(lines.len(), 2, "{lines:#?}");
        assert!(lines[1].ends_with("material \"n\": d and Tr are no cut-outs; it is opaque"));
        lines.swap_remove(0)
    };
    let rest = ": disp is not read; its plain value is used";
    let one = told(1);
    assert!(one.ends_with(&format!("m.mtl:2: material \"m0\"{rest}")), "{one}");
    let two = told(2);
    assert!(two.ends_with(&format!("m.mtl:2: materials \"m0\" and \"m1\"{rest}")), "{two}");
    let many = told(45);
    assert!(
        many.ends_with(&format!("m.mtl:2: materials \"m0\", \"m1\", \"m2\" and 42 more{rest}")),
        "{many}"
    );
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

/// Rule 8: d and Tr alone cut nothing out, which a warning says; Tr 0 and 1 are opaque without one.
#[test]
fn d_and_tr_are_no_cutouts() {
    let cases = [("d 0.5", true), ("map_d a.png", false), ("Tr 0.5", true), ("d 1", false), ("Tr 0", false)];
    for (statement, expected) in cases.into_iter().chain([("Tr 1", false)]) {
        assert_eq!(warnings(&format!("Kd 1 1 1\n{statement}")).contains("cut-out"), expected, "{statement}");
    }
}

/// What Blender's exporter writes means what it meant there: Ks is a level of reflection, illum 3 is metal of the colour Kd, Tf is glass,
/// Ns is a roughness. The same statements in a file of another program mean what they say.
#[test]
fn blender_means_what_it_says_there() {
    let load = |header: &str, statements: &str| {
        with_mtl(format!("{header}\nnewmtl m\n{statements}\nNi 1.45\nd 1\nKe 1 1 1\n")).unwrap().materials[0]
            .clone()
    };
    let blender = |statements: &str| load("# Blender 4.2.0 MTL File: 'a.blend'", statements);
    let is_near = |a: [f32; 3], b: [f32; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5);
    let plastic = blender("Kd .8 .4 .2\nKs .5 .5 .5\nillum 2\nPr .5\nPm 0");
    assert!(is_near(plastic.diffuse, [0.8, 0.4, 0.2]) && is_near(plastic.glossy, [0.04; 3]), "{plastic:?}");
    let alpha = |m: &Material| m.facets.expect("microfacets").alpha;
    assert_eq!(alpha(&plastic), 0.25, "roughness squared");
    let head_on = |ior: f32| ((ior - 1.0) / (ior + 1.0)).powi(2);
    let of_ks = |m: &Material| matches!(m.facets.unwrap().kind, FacetKind::Schlick { ior } if (head_on(ior) - 0.04).abs() < 1e-6);
    assert!(of_ks(&plastic), "the coat is that of Ks: {plastic:?}");
    let by_ns = blender("Kd .8 .4 .2\nKs .5 .5 .5\nillum 2\nNs 250");
    assert!((alpha(&by_ns) - 0.25).abs() < 1e-5, "{by_ns:?}");
    for metal in ["Pr .25\nPm 1", "Ka 1 1 1\nNs 562.5"] {
        let gold = blender(&format!("Kd 1 .77 .34\nKs .5 .5 .5\nillum 3\n{metal}"));
        assert!(is_near(gold.glossy, [1.0, 0.77, 0.34]) && is_near(gold.diffuse, [0.0; 3]), "{gold:?}");
        assert!((alpha(&gold) - 0.0625).abs() < 1e-5, "{gold:?}");
    }
    let mirror = blender("Kd 1 .77 .34\nKs .5 .5 .5\nillum 3\nPr 0\nPm 1");
    assert!(is_near(mirror.glossy, [1.0, 0.77, 0.34]) && alpha(&mirror) == 0.0, "{mirror:?}");
    let cloudy = blender("Kd 1 .81 1\nKs .5 .5 .5\nNi 1.45\nillum 2\nPr .2\nPm 0\nTf .4 .4 .4");
    let mixture = cloudy.mixture.as_ref().expect("glass in part");
    assert!(mixture.transmission == 0.4 && cloudy.dielectric.expect("glass").ior == 1.45, "{cloudy:?}");
    assert!((mixture.rest.glossy[0] - (0.45f32 / 2.45).powi(2)).abs() < 1e-6, "{mixture:?}");
    let glass = blender("Kd 1 .81 1\nKs .5 .5 .5\nillum 2\nPr 0\nPm 0\nTf 1 1 1").dielectric.expect("glass");
    assert!(glass.ior == 1.45 && is_near(glass.transmission_tint, [1.0, 0.9, 1.0]), "{glass:?}");
    let other = load("# by hand", "Kd .4 .4 .2\nKs .5 .5 .5\nillum 2\nNs 250");
    assert!(is_near(other.glossy, [0.5; 3]) && other.glossy_exponent == 250.0, "{other:?}");
}
