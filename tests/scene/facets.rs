//! Metal, plastic, principled surfaces and rough glass: what scene files say of them, and what is wrong.

use crate::folder::Folder;
use joton::Error;
use joton::scene::{FacetKind, Inner, Material};

/// The material of a cube under the sun.
fn material(keys: &str) -> Result<Material, Error> {
    let toml = format!(
        "[[shape]]\nkind = \"cube\"\nmaterial = {{ {keys} }}\n\
         [[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n"
    );
    Folder::new(&[("s.toml", toml.as_bytes())]).load("s.toml").map(|scene| scene.materials[0].clone())
}

fn is_near(a: [f32; 3], b: [f32; 3]) -> bool {
    a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-5)
}

/// Metal by its name, by its index and by its colour.
#[test]
fn metal_is_known_by_name_index_or_colour() {
    let gold = material("type = \"metal\", metal = \"Gold\", roughness = 0.5").unwrap();
    let facets = gold.facets.expect("microfacets");
    assert_eq!((gold.diffuse, gold.glossy, facets.alpha), ([0.0; 3], [1.0; 3], 0.25));
    assert!(matches!(facets.kind, FacetKind::Conductor { eta, .. } if eta[0] < eta[1] && eta[1] < eta[2]));
    assert!(gold.metal.is_some(), "its index by wavelength is known, too");

    let stated = material("type = \"metal\", eta = [0.2, 0.4, 1.4], k = [3.3, 2.4, 1.9], ks = 0.5").unwrap();
    let kind = FacetKind::Conductor { eta: [0.2, 0.4, 1.4], k: [3.3, 2.4, 1.9] };
    assert_eq!((stated.glossy, stated.facets.unwrap().kind), ([0.5; 3], kind));
    assert!(stated.metal.is_none());

    let red = material("type = \"metal\", ks = [0.9, 0.2, 0.1], alpha = 0.3").unwrap();
    assert_eq!((red.glossy, red.facets.unwrap().alpha), ([0.9, 0.2, 0.1], 0.3));
    assert_eq!(red.facets.unwrap().kind, FacetKind::Schlick { ior: 1.0 });
}

/// What of a principled material is metal reflects its colour, and the rest lies under a coat.
#[test]
fn plastic_and_principled_have_a_coat() {
    let plastic = material("type = \"plastic\", kd = [0.1, 0.2, 0.3]").unwrap();
    assert_eq!((plastic.diffuse, plastic.glossy), ([0.1, 0.2, 0.3], [1.0; 3]));
    assert_eq!(plastic.facets.unwrap().kind, FacetKind::Coat { ior: 1.5, inner: Inner::Even });
    let deep = material("type = \"plastic\", kd = 0.5, ior = 1.7, saturated = true").unwrap();
    assert_eq!(deep.facets.unwrap().kind, FacetKind::Coat { ior: 1.7, inner: Inner::Coloured });

    let half = material("type = \"principled\", kd = [0.8, 0.4, 0.2], metallic = 0.5").unwrap();
    assert!(is_near(half.diffuse, [0.4, 0.2, 0.1]) && is_near(half.glossy, [0.42, 0.22, 0.12]), "{half:?}");
    assert_eq!(half.facets.unwrap().alpha, 0.25, "roughness .5 where none is stated");

    // none reflects more than it gets
    for keys in
        ["type = \"glossy\", ks = 0.04, roughness = 0.5", "type = \"plastic\"", "type = \"principled\""]
    {
        let bright = material(&format!("{keys}, kd = [2, 1, 0.5]")).unwrap();
        assert!(is_near(bright.diffuse, [1.0, 0.5, 0.25]), "{bright:?}");
    }
}

/// Rough glass is a body; a pane without thickness is smooth.
#[test]
fn glass_may_be_rough() {
    let frosted = material("type = \"glass\", roughness = 0.5").unwrap();
    assert_eq!(frosted.facets.unwrap().kind, FacetKind::Interface);
    assert!(material("type = \"glass\"").unwrap().facets.is_none());
    assert!(
        material("type = \"glass\", roughness = 0.5, thin = true").unwrap().facets.is_some(),
        "a rough pane"
    );
}

/// Faults name their line and a remedy.
#[test]
fn faults_of_facets_are_told() {
    for (keys, culprit, remedy) in [
        ("type = \"metal\", metal = \"golt\"", "golt", "gold"),
        ("type = \"metal\", eta = 1", "one of its parts", "eta and k"),
        ("type = \"metal\", eta = 0, k = 3", "eta of a metal's index", "0.001 to 100"),
        ("type = \"metal\", eta = 1, k = 1e10", "k of a metal's index", "0.001 to 100"),
        ("type = \"plastic\", metal = \"gold\"", "metal in a material", "type = \"metal\""),
        ("kd = 0.5, metallic = 1", "metallic in a material", "type = \"principled\""),
        ("type = \"principled\", metallic = 5", "metallic of 5", "0 to 1"),
        ("type = \"metal\", roughness = 35", "roughness of 35", "0 to 1"),
        ("type = \"glass\", alpha = -0.5", "alpha of -0.5", "0 to 1"),
        ("type = \"plastic\", ior = 0.9", "index of refraction 0.9", "of a coat from 1"),
    ] {
        let error = material(keys).expect_err(keys).to_string();
        assert!(
            error.contains("s.toml:3") && error.contains(culprit) && error.contains(remedy),
            "{keys}: {error}"
        );
    }
}

/// What is transmitted takes part in rule 7, has a default beside it, and is of what is matte alone.
#[test]
fn matte_surfaces_may_transmit() {
    let leaf = material("type = \"matte\", kd = [0.2, 0.4, 0.1], transmit = [0.1, 0.3, 0.05]").unwrap();
    assert_eq!((leaf.diffuse, leaf.transmit), ([0.2, 0.4, 0.1], [0.1, 0.3, 0.05]));
    let paper = material("type = \"matte\", transmit = [0.8, 0.6, 0.2]").unwrap();
    assert!(is_near(paper.diffuse, [0.2, 0.4, 0.5]) && is_near(paper.transmit, [0.8, 0.6, 0.2]), "{paper:?}");
    let bright = material("type = \"matte\", kd = 0.8, transmit = [0.8, 0.4, 0.0]").unwrap();
    assert!(is_near(bright.diffuse, [0.5; 3]) && is_near(bright.transmit, [0.5, 0.25, 0.0]), "{bright:?}");
    // without a type: what of a mesh turns out to be matte
    assert_eq!(material("kd = 0.5, transmit = 0.25").unwrap().transmit, [0.25; 3]);
    assert!(material("type = \"glossy\", ks = 0.1, exponent = 20, transmit = 0.2").is_ok());
    for keys in [
        "type = \"glass\", transmit = 0.5",
        "type = \"principled\", transmit = 0.5",
        "type = \"glossy\", ks = 0.1, roughness = 0.4, transmit = 0.5",
        "type = \"mirror\", transmit = 0.5",
        "type = \"matte\", transmit = -0.5",
    ] {
        let refused = material(keys).expect_err(keys).to_string();
        assert!(refused.contains("s.toml:3") && refused.contains("transmit"), "{refused}");
    }
}

/// Brushed surfaces by scene files, in degrees, and by libraries, in turns; what is smooth is not brushed, with a warning.
#[test]
fn microfacets_may_be_brushed() {
    let steel =
        material("type = \"metal\", roughness = 0.4, anisotropy = 0.5, anisotropy_rotation = 90").unwrap();
    let brush = steel.anisotropy.expect("it is brushed");
    assert!((brush.strength, brush.is_around) == (0.5, false), "{brush:?}");
    assert!((brush.rotation - std::f32::consts::FRAC_PI_2).abs() < 1e-6, "{brush:?}");
    for keys in [
        "type = \"plastic\", alpha = 0.1, anisotropy = 1",
        "type = \"principled\", anisotropy = 0.1",
        "type = \"glass\", roughness = 0.3, anisotropy = 0.1",
        "type = \"glossy\", ks = 0.1, roughness = 0.4, anisotropy = 0.5",
    ] {
        assert!(material(keys).unwrap().anisotropy.is_some(), "{keys}");
    }
    let smooth = "type = \"metal\", anisotropy = 0.5";
    assert_eq!(material(smooth).unwrap().anisotropy, None);
    let refused =
        material("type = \"metal\", roughness = 0.4, anisotropy = 1.5").expect_err("above 1").to_string();
    assert!(refused.contains("s.toml:3") && refused.contains("anisotropy of 1.5"), "{refused}");
    let of_library =
        crate::folder::with_mtl("newmtl m\nPr 0.5\nPm 1\naniso 0.25\nanisor 0.5").expect("it is read");
    let brush = of_library.materials[0].anisotropy.expect("it is brushed");
    assert!((brush.strength - 0.25).abs() < 1e-6 && (brush.rotation - std::f32::consts::PI).abs() < 1e-6);
}

/// Round shapes are brushed around their axis, by coordinates across it; what has sides, along these.
#[test]
fn round_shapes_are_brushed_around_their_axis() {
    for (kind, is_round) in
        [("disc", true), ("cylinder", true), ("sphere", true), ("cube", false), ("rectangle", false)]
    {
        let toml = format!(
            "[[shape]]\nkind = \"{kind}\"\nmaterial = {{ type = \"metal\", roughness = 0.4, anisotropy = 0.5 }}\n\
             [[light]]\nkind = \"sun\"\ndirection = [0, -1, 0]\nirradiance = 1\n"
        );
        let scene = Folder::new(&[("s.toml", toml.as_bytes())]).load("s.toml").expect("it is read");
        let t = scene.mesh.triangles[0];
        let brush = scene.materials[t.material as usize].anisotropy.expect("it is brushed");
        assert_eq!(brush.is_around, is_round, "{kind}");
        let uv = t.uv.expect("coordinates").map(|uv| scene.mesh.uvs[uv as usize]);
        if is_round {
            // across y: as far from the middle as the place
            for (uv, vertex) in uv.iter().zip(t.vertex) {
                let p = scene.mesh.positions[vertex as usize];
                let [u, v] = uv.map(f64::from);
                assert!((u.hypot(v) - p.x.hypot(p.z)).abs() < 1e-6, "{kind}: {uv:?} at {p}");
            }
        }
    }
}
