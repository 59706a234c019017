//! Clear coats, sheen, specular factors and transmission: what scene files and libraries say of them, and what is wrong.

use crate::folder::{Folder, with_mtl};
use joton::Error;
use joton::scene::{FacetKind, Layers, Material, Scene};

/// The scene of a cube under the sun.
fn scene(keys: &str) -> Result<Scene, Error> {
    let toml = format!(
        "[[shape]]\nkind = \"cube\"\nmaterial = {{ {keys} }}\n\
         [[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n"
    );
    Folder::new(&[("s.toml", toml.as_bytes())]).load("s.toml")
}

fn principled(keys: &str) -> Material {
    scene(&format!("type = \"principled\", {keys}")).unwrap_or_else(|e| panic!("{e}")).materials[0].clone()
}

fn is_near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

/// Keys of scene files; what says nothing makes no layer.
#[test]
fn scene_files_state_layers() {
    for keys in [
        "kd = 0.5",
        "clearcoat = 0, clearcoat_roughness = 0.5",
        "sheen_color = 0",
        "specular = 1, specular_color = 1",
    ] {
        assert_eq!(principled(keys).layers, None, "{keys}");
    }
    let coated = principled("clearcoat = 0.7, clearcoat_roughness = 0.5").layers.unwrap();
    assert_eq!((coated.clear_coat, coated.clear_coat_alpha, coated.sheen), (0.7, 0.25, [0.0; 3]));
    assert!(is_near(coated.head_on, [0.04; 3]) && coated.grazing == 1.0, "{coated:?}");
    let cloth = principled("sheen_color = [0.8, 0.4, 0.2]").layers.unwrap();
    assert_eq!((cloth.sheen, cloth.sheen_roughness), ([0.8, 0.4, 0.2], 0.5));
    assert_eq!(principled("sheen_color = 1, sheen_roughness = 0.1").layers.unwrap().sheen_roughness, 0.3);
}

/// glTF: R₀ = min(((n − 1)/(n + 1))² colour, 1) · specular, and `specular` at grazing angles; metal is not asked.
#[test]
fn specular_is_of_the_dielectric_part() {
    let m = principled("kd = [0.8, 0.4, 0.2], metallic = 0.5, specular = 0.5, specular_color = [1, 0.5, 30]");
    let layers = m.layers.unwrap();
    assert!(is_near(layers.head_on, [0.02, 0.01, 0.5]), "{layers:?}");
    assert_eq!((layers.grazing, layers.metallic), (0.5, 0.5));
    assert!(is_near(m.glossy, [0.41, 0.205, 0.35]), "{:?}", m.glossy);
    let FacetKind::Schlick { ior } = m.facets.unwrap().kind else { panic!("{m:?}") };
    assert!((((ior - 1.0) / (ior + 1.0)).powi(2) - 0.5).abs() < 1e-5, "the coat is grey: {ior}");
}

/// What transmits is glass, tinted by the roots of its colour, or a pane tinted by it; parts of it are told.
#[test]
fn what_transmits_is_glass() {
    let glass = principled("kd = [0.81, 0.64, 1], ior = 1.4, transmission = 1, roughness = 0.2");
    let d = glass.dielectric.expect("glass");
    assert!(is_near(d.transmission_tint, [0.9, 0.8, 1.0]) && d.ior == 1.4, "{d:?}");
    assert!((glass.facets.unwrap().alpha - 0.04).abs() < 1e-6);
    let pane = principled("kd = [0.81, 0.64, 1], transmission = 1, thin = true");
    assert!(pane.thin && is_near(pane.dielectric.unwrap().transmission_tint, [0.81, 0.64, 1.0]), "{pane:?}");
    let absorbing =
        principled("kd = 1, transmission = 1, attenuation_color = [0.5, 1, 1], attenuation_distance = 2");
    assert!((absorbing.interior.absorption[0] - 2f32.ln() / 2.0).abs() < 1e-5, "{absorbing:?}");
    for (keys, words) in [
        ("transmission = 1, clearcoat = 1", "of what transmits are ignored"),
        ("transmission = 0.7, opacity = 0.5", "opacity of what transmits is ignored"),
        ("transmission = 0.3, opacity = 0.5", "transmission of what has an opacity is ignored"),
        ("transmission = 0.5, clearcoat = 1", "are ignored, which lie over the rest of it alone"),
    ] {
        let scene = scene(&format!("type = \"principled\", kd = 0.5, {keys}")).unwrap();
        let is_cut_out = keys.contains("0.3");
        assert_eq!(scene.materials[0].dielectric.is_none(), is_cut_out, "{keys}");
        assert_eq!(scene.materials[0].opacity.is_some(), is_cut_out, "{keys}");
        assert!(scene.warnings.join("\n").contains(words), "{keys}: {:?}", scene.warnings);
    }
    for keys in
        ["transmission = 0", "transmission = 1", "transmission = 0.5", "transmission = 1, metallic = 1"]
    {
        let scene = scene(&format!("type = \"principled\", {keys}")).unwrap();
        assert!(scene.warnings.is_empty(), "{keys}: {:?}", scene.warnings);
        let is_opaque = keys.ends_with("= 0") || keys.contains("metallic");
        assert_eq!(scene.materials[0].dielectric.is_none(), is_opaque, "{keys}");
    }
}

/// Transmission between 0 and 1 mixes glass and the opaque rest, to which all metal belongs; the rest is the last of the materials.
#[test]
fn what_transmits_in_part_is_a_mixture() {
    let scene = scene(
        "type = \"principled\", kd = [0.81, 0.64, 1], ior = 1.4, metallic = 0.5, transmission = 0.4, \
         attenuation_color = 0.5, attenuation_distance = 1, clearcoat = 1",
    )
    .unwrap();
    let [glass, rest] = &scene.materials[..] else { panic!("{:?}", scene.materials) };
    let mixture = glass.mixture.as_ref().expect("a mixture");
    assert!(mixture.number == 1 && *mixture.rest == *rest, "{mixture:?}");
    assert_eq!((mixture.transmission, mixture.metallic), (0.4, 0.5));
    assert!(glass.interior.absorption[0] > 0.6 && rest.dielectric.is_none(), "{glass:?}");
    // of .8 that is no glass .5 is metal
    let metal = 0.5 / 0.8;
    assert!(is_near(rest.diffuse, [0.81, 0.64, 1.0].map(|x| x * (1.0 - metal))), "{rest:?}");
    let head_on = (0.4f32 / 2.4).powi(2);
    assert!(is_near(rest.glossy, [0.81, 0.64, 1.0].map(|x| head_on + metal * (x - head_on))), "{rest:?}");
    assert_eq!(rest.layers.expect("its coat").clear_coat, 1.0);
    assert!(glass.layers.is_none());
}

/// Transmission may be a picture, and so may the metallic part and the colour, which tints what goes through.
#[test]
fn mixtures_may_vary() {
    let board = "{ checkerboard = [[0.25, 0.5, 0.75], [0.5, 0.75, 1.0]] }";
    let glass = principled(&format!("kd = {board}, transmission = {board}, metallic = 0.5"));
    let mixture = glass.mixture.as_ref().expect("a mixture");
    assert_eq!(mixture.transmission_map.as_ref().expect("a map").range(), [0.25, 0.5]);
    // what is metal is settled at each place
    assert!(mixture.metallic == 0.5 && mixture.metallic_map.is_none());
    let metal = mixture.rest.metallic.as_ref().expect("it is mixed");
    assert!(metal.most == 0.5 && metal.map.is_none(), "{metal:?}");
    assert!(glass.diffuse_texture.is_some() && glass.diffuse_texture == mixture.rest.diffuse_texture);
    let opaque = principled(&format!("transmission = {board}, metallic = 1"));
    assert!(opaque.dielectric.is_none() && opaque.mixture.is_none());
    let pane = principled(&format!("kd = {board}, transmission = 1, thin = true"));
    assert!(pane.mixture.is_none() && pane.diffuse_texture.is_some(), "{pane:?}");
    let error =
        scene("type = \"principled\", transmission = { texture = \"no.png\" }").expect_err("no picture");
    assert!(error.to_string().contains("s.toml:3: texture no.png does not exist"), "{error}");
    let error = scene("type = \"principled\", transmission = { channel = \"r\" }").expect_err("no picture");
    assert!(error.to_string().contains("transmission"), "{error}");
}

/// Libraries: Pc, Pcr and Ps make a principled material, in Blender's as in others.
#[test]
fn libraries_state_layers() {
    let load = |header: &str, statements: &str| {
        with_mtl(format!("{header}\nnewmtl m\n{statements}\nKe 1 1 1\n")).unwrap().materials[0].clone()
    };
    for header in ["# by hand", "# Blender 4.2.0 MTL File: 'a.blend'"] {
        let of = |statements: &str| load(header, statements).layers;
        let coated = of("Kd .5 .5 .5\nPr .5\nPc .8\nPcr .5\nillum 2").expect(header);
        assert_eq!((coated.clear_coat, coated.clear_coat_alpha), (0.8, 0.25), "{header}");
        assert_eq!(of("Kd .5 .5 .5\nPr .5\nPs .6\nillum 2").expect(header).sheen, [0.6; 3], "{header}");
        assert_eq!(of("Kd .5 .5 .5\nPr .5\nPs .6 .4 .2\nillum 2").expect(header).sheen, [0.6, 0.4, 0.2]);
        assert_eq!(of("Kd .5 .5 .5\nPr .5\nPc 3\nillum 2").expect(header).clear_coat, 1.0, "cut");
        assert_eq!(of("Kd .5 .5 .5\nPr .5\nPc 0\nPcr .03\nPs 0\nillum 2"), None::<Layers>, "{header}");
    }
    let glossy = load("# by hand", "Kd .5 .5 .5\nKs .1 .1 .1\nNs 30\nPc 0\nillum 2");
    assert!(glossy.layers.is_none() && glossy.glossy == [0.1; 3] && glossy.glossy_exponent == 30.0);
    let coated = load("# by hand", "Kd .5 .5 .5\nKs .1 .1 .1\nNs 30\nPc 1\nillum 2");
    assert!(coated.layers.is_some() && coated.facets.is_some(), "{coated:?}");
}

/// Faults name their line and a remedy.
#[test]
fn faults_of_layers_are_told() {
    for (keys, culprit, remedy) in [
        ("type = \"principled\", clearcoat = 2", "clearcoat of 2", "0 to 1"),
        ("type = \"principled\", clearcoat_roughness = -1", "clearcoat_roughness of -1", "0 to 1"),
        ("type = \"principled\", sheen_color = [2, 0, 0]", "sheen_color of [2.0", "0 to 1"),
        ("type = \"principled\", sheen_color = [-1, 0, 0]", "sheen_color", "at least 0"),
        ("type = \"principled\", sheen_roughness = 1.5", "sheen_roughness of 1.5", "0 to 1"),
        ("type = \"principled\", specular = 3", "specular of 3", "0 to 1"),
        ("type = \"principled\", specular_color = \"red\"", "specular_color", "at least 0"),
        ("type = \"principled\", transmission = 2", "transmission of 2", "0 to 1"),
        ("type = \"plastic\", clearcoat = 1", "clearcoat in a material", "type = \"principled\""),
        ("kd = 0.5, sheen_color = 1", "sheen_color in a material", "type = \"principled\""),
        ("type = \"principled\", clear_coat = 1", "clear_coat", "clearcoat"),
        ("type = \"principled\", absorption = 1", "absorption of what is no glass", "glass"),
    ] {
        let error = scene(keys).expect_err(keys).to_string();
        assert!(
            error.contains("s.toml:3") && error.contains(culprit) && error.contains(remedy),
            "{keys}: {error}"
        );
    }
    let error = with_mtl("newmtl m\nKd 1 1 1\nPc -1\n").expect_err("negative").to_string();
    assert!(error.contains("m.mtl:3") && error.contains("Pc of -1"), "{error}");
    let warnings = with_mtl("newmtl m\nKd 1 1 1\nPs x\n").unwrap().warnings.join("\n");
    assert!(warnings.contains("m.mtl:3") && warnings.contains("Ps: not a number"), "{warnings}");
}
