//! What surfaces look like in an export: metals, coats, pictures, spectra.

use crate::{POINT, TRIANGLE, child, export_small, export_small_as, named, numbers, values};
use joton::output::export::Fidelity;
use roxmltree::Node;
use std::fs;

/// Metal by its index, and what is matte under a coat, with factors; rough ones where what is near is asked for.
#[test]
fn metals_and_coats_keep_their_index() {
    let metal = "type = \"metal\"\neta = [0.2, 0.4, 1.4]\nk = [3.9, 2.4, 1.6]\nks = [0.9, 0.8, 0.7]\n";
    let coat = "type = \"plastic\"\nkd = [0.1, 0.3, 0.7]\nior = 1.7\nks = 0.5\nsaturated = true\n";
    for (keys, kind, fidelity) in [
        (metal.to_owned(), "conductor", Fidelity::Exact),
        (format!("{metal}alpha = 0.3\n"), "roughconductor", Fidelity::Near),
        (coat.to_owned(), "plastic", Fidelity::Exact),
        (format!("{coat}alpha = 0.3\n"), "roughplastic", Fidelity::Near),
    ] {
        let toml = format!("{POINT}[[material]]\nname = \"a\"\n{keys}");
        let written = export_small_as(&toml, TRIANGLE, "newmtl a\n", fidelity);
        let xml = written.xml();
        let two_sided = child(xml.root_element(), "bsdf");
        assert_eq!(two_sided.attribute("type"), Some("twosided"));
        let bsdf = child(two_sided, "bsdf");
        assert_eq!(bsdf.attribute("type"), Some(kind));
        if kind.ends_with("conductor") {
            assert_eq!(values(bsdf, "eta"), [0.2, 0.4, 1.4]);
            assert_eq!(values(bsdf, "k"), [3.9, 2.4, 1.6]);
            assert_eq!(values(bsdf, "specular_reflectance"), [0.9, 0.8, 0.7]);
        } else {
            assert_eq!(values(bsdf, "diffuse_reflectance"), [0.1, 0.3, 0.7]);
            assert_eq!(values(bsdf, "specular_reflectance"), [0.5; 3]);
            assert_eq!((values(bsdf, "int_ior"), values(bsdf, "ext_ior")), (vec![1.7], vec![1.0]));
            assert_eq!(named(bsdf, "nonlinear").attribute("value"), Some("true"));
        }
        if fidelity == Fidelity::Near {
            assert_eq!(values(bsdf, "alpha"), [0.3]);
            assert_eq!(named(bsdf, "distribution").attribute("value"), Some("ggx"));
        }
    }
}

/// A picture is written as the linear texels that are seen, from the lowest row on, with its place, filter and edges; an
/// opacity as one number a texel, with its factor.
#[test]
fn pictures_are_written_as_they_are_seen() {
    let board = "{ checkerboard = [[0.25, 0.5, 0.75], [1, 0, 0]], scale = [2, 3], offset = [0.5, 0.25], wrap = \"mirror\" }";
    let cut = "{ checkerboard = [[1, 1, 1], [0, 0, 0]], filter = \"linear\", wrap = \"clamp\" }";
    let toml = format!("{POINT}[[material]]\nname = \"a\"\nkd = {board}\nopacity = {cut}\n");
    let obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 0.75 0\nvt 0 0.5\nusemtl a\nf 1/1 2/2 3/3\n";
    let written = export_small(&toml, obj, "newmtl a\n");
    let xml = written.xml();
    let mask = child(xml.root_element(), "bsdf");
    assert_eq!(mask.attribute("type"), Some("mask"));
    let read =
        |name: &str| fs::read(written.folder.path().join(name)).expect("a picture beside the scene file");
    let check =
        |texture: Node<'_, '_>, words: [&str; 2], place: [[f64; 3]; 2], head: &str, texels: &[f32]| {
            let said = |key: &str| named(texture, key).attribute("value").expect("a value").to_owned();
            assert_eq!([said("filter_type"), said("wrap_mode")], words);
            assert_eq!(said("raw"), "true");
            let to_uv = named(texture, "to_uv");
            let of = |tag: &str| numbers(child(to_uv, tag).attribute("value").expect("a value"));
            assert_eq!([of("scale"), of("translate")], place);
            let bytes = read(&said("filename"));
            let body = bytes.strip_prefix(head.as_bytes()).expect("the head of a picture");
            let got: Vec<f32> = body.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect();
            assert_eq!(got, texels);
        };
    let ([a, b], [on, off]) = ([[0.25, 0.5, 0.75], [1.0, 0.0, 0.0]], [1.0, 0.0]);
    // Mitsuba's rows run down: what is at v up is at 1 - v there
    let place = [[2.0, -3.0, 1.0], [0.5, 0.75, 0.0]];
    let colour = named(child(child(mask, "bsdf"), "bsdf"), "reflectance");
    check(colour, ["nearest", "mirror"], place, "PF\n2 2\n-1.0\n", &[a, b, b, a].concat());
    let place = [[1.0, -1.0, 1.0], [0.0, 1.0, 0.0]];
    let opacity = named(mask, "opacity");
    check(opacity, ["bilinear", "clamp"], place, "Pf\n2 2\n-1.0\n", &[on, off, off, on]);
    let shape = child(xml.root_element(), "shape");
    let file = read(named(shape, "filename").attribute("value").expect("a file"));
    assert!(String::from_utf8_lossy(&file).contains("property float u\nproperty float v\n"));
    let second: Vec<u8> = [1.0f32, 0.0, 0.0, 0.75, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    assert!(
        file.windows(second.len()).any(|w| w == second),
        "the second corner, with its place in the picture"
    );
}

/// By wavelength: reflectances whose ends hold, light with none outside of what is stated, metal by its index at each
/// wavelength; what is stated in red, green and blue stays so.
#[test]
fn spectra_are_written_by_wavelength() {
    let toml = "[[light]]\nkind = \"point\"\nposition = [0, 0, 2]\nintensity = { spectrum = [[400, 1], [700, 2]], \
                power = 3 }\n[[light]]\nkind = \"sun\"\ndirection = [0, 0, -1]\nirradiance = [3, 2, 1]\n\
                [[material]]\nname = \"a\"\nkd = { spectrum = [[400, 0.1], [600, 0.5]] }\n\
                ke = { blackbody = 3000 }\n[[shape]]\nkind = \"cube\"\nmaterial = { type = \"metal\", metal = \"gold\" }\n";
    let written = export_small(toml, TRIANGLE, "newmtl a\n");
    let xml = written.xml();
    let pairs = |node: Node<'_, '_>, name: &str| -> Vec<[f64; 2]> {
        let node = named(node, name);
        assert!(node.has_tag_name("spectrum"));
        let text = node.attribute("value").expect("values");
        let pair = |pair: &str| {
            let (lambda, value) = pair.split_once(':').expect("a pair");
            [lambda, value].map(|x| x.trim().parse().expect("a number"))
        };
        text.split(',').map(pair).collect()
    };
    let all = |tag: &'static str, kind: &'static str| {
        xml.descendants().filter(move |n| n.has_tag_name(tag) && n.attribute("type") == Some(kind))
    };
    let first = |tag, kind| all(tag, kind).next().expect("one");
    let paint = pairs(first("bsdf", "diffuse"), "reflectance");
    assert_eq!(paint, [[360.0, 0.1], [400.0, 0.1], [600.0, 0.5], [830.0, 0.5]]);
    assert_eq!(pairs(first("emitter", "point"), "intensity"), [[400.0, 3.0], [700.0, 6.0]]);
    assert_eq!(values(first("emitter", "directional"), "irradiance"), [3.0, 2.0, 1.0]);
    let glow = pairs(first("emitter", "area"), "radiance");
    assert_eq!([glow[0][0], glow[glow.len() - 1][0]], [360.0, 830.0]);
    assert!(
        glow.windows(2).all(|w| w[1][0] - w[0][0] == 1.0 && w[1][1] > w[0][1]),
        "3000 K, brightest beyond red"
    );
    let gold = first("bsdf", "conductor");
    for (name, wanted) in [("eta", 0.21), ("k", 3.272)] {
        let table = pairs(gold, name);
        let [low, high] =
            [616.0, 617.0].map(|lambda| table.iter().find(|p| p[0] == lambda).expect("a step")[1]);
        // its table has 616.8 nm
        assert!((0.2 * low + 0.8 * high - wanted).abs() < 1e-3, "{name}: {low} {high}");
    }
}
