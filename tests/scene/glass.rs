//! What surfaces of glass are taken for: bodies, thin panes, the levels of liquids.

use crate::folder::{Folder, warned};
use joton::Error;
use joton::scene::Scene;

const SUN: &str = "[[light]]\nkind = \"sun\"\ndirection = [0, -1, 0.1]\nirradiance = 1\n";
const FLOOR: &str = "usemtl floor\nv -9 -3 9\nv 9 -3 9\nv 9 -3 -9\nv -9 -3 -9\nf -4 -3 -2 -1\n";
const QUAD: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf -4 -3 -2 -1\n";

/// A scene with `obj` beside a floor; materials `glass` of index 1.5 and `water` of 1.33, and more of the scene file.
fn load(obj: &str, toml: &str) -> Result<Scene, Error> {
    let obj = format!("mtllib m.mtl\n{FLOOR}usemtl glass\n{obj}");
    let mtl = "newmtl glass\nillum 7\nNi 1.5\nnewmtl water\nillum 7\nNi 1.33\nnewmtl floor\nKd .5 .5 .5\n\
               newmtl lit\nillum 7\nNi 1.5\nKe 1 1 1\n";
    let toml = format!("[[mesh]]\nfile = \"a.obj\"\n{SUN}{toml}");
    Folder::new(&[("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_bytes()), ("s.toml", toml.as_bytes())])
        .load("s.toml")
}

fn scene(obj: &str) -> Scene {
    load(obj, "").unwrap()
}

/// A box of six quads, or fewer; `inward` turns all of them.
fn cuboid(low: [f64; 3], high: [f64; 3], sides: &[usize], inward: bool) -> String {
    let mut text = String::new();
    for i in 0..8usize {
        let pick = |axis: usize| if i >> axis & 1 == 0 { low[axis] } else { high[axis] };
        text += &format!("v {} {} {}\n", pick(0), pick(1), pick(2));
    }
    // -z, +z, -x, +x, -y, +y, fronts outward
    let faces = [[1, 3, 4, 2], [5, 6, 8, 7], [1, 5, 7, 3], [2, 4, 8, 6], [1, 2, 6, 5], [3, 7, 8, 4]];
    for &side in sides {
        let mut face = faces[side];
        if inward {
            face.reverse();
        }
        text += &format!("f {}\n", face.map(|i: i32| (i - 9).to_string()).join(" "));
    }
    text
}

const ALL: [usize; 6] = [0, 1, 2, 3, 4, 5];

/// For each material of glass that triangles have: its name, whether it is thin, and how many.
fn glass(scene: &Scene) -> Vec<(String, bool, usize)> {
    let count = |i: usize| scene.mesh.triangles.iter().filter(|t| t.material as usize == i).count();
    let used = scene.materials.iter().enumerate().filter(|(_, m)| m.dielectric.is_some());
    used.map(|(i, m)| (m.name.clone(), m.thin, count(i))).filter(|(_, _, n)| *n > 0).collect()
}

/// Signed volume that the triangles of glass enclose.
fn volume(scene: &Scene) -> f64 {
    let glass =
        scene.mesh.triangles.iter().filter(|t| scene.materials[t.material as usize].dielectric.is_some());
    let part = |t: &joton::scene::Triangle| {
        let [a, b, c] = t.vertex.map(|v| scene.mesh.positions[v as usize]);
        a.dot(b.cross(c)) / 6.0
    };
    glass.map(part).sum()
}

#[track_caller]
fn told(scene: &Scene, words: &str) {
    assert!(
        scene.warnings.iter().any(|w| w.contains("/a.obj:") && w.contains(words)),
        "{:#?}",
        scene.warnings
    );
}

fn silent(scene: &Scene) {
    assert!(scene.warnings.is_empty(), "{:#?}", scene.warnings);
}

/// A quad is a thin pane, and so are a showcase of five panes and a tumbler; a closed box is a body, and so is a ball with a hole.
#[test]
fn sheets_are_panes() {
    let pane = scene(QUAD);
    assert_eq!(glass(&pane), [("glass".into(), true, 2)]);
    warned(&pane, "a.obj:13", "\"glass\": open glass without thickness is taken for a thin pane");
    let five = scene(&cuboid([0.; 3], [1.; 3], &[0, 1, 2, 3, 5], false));
    assert_eq!(glass(&five), [("glass".into(), true, 10)]);
    let body = scene(&cuboid([0.; 3], [1.; 3], &ALL, false));
    assert_eq!(glass(&body), [("glass".into(), false, 12)]);
    silent(&body);
    let holed = scene(&ball(0.0, |_, k| k != 3));
    assert!(glass(&holed).iter().all(|g| !g.1), "{:?}", glass(&holed));
    told(&holed, "\"glass\": the glass body has holes");
}

/// A ball of 12 × 16 quads whose corners are stated again for each of them, moved by `rounding`.
fn ball(rounding: f64, keep: impl Fn(usize, usize) -> bool) -> String {
    let (rings, sectors) = (12, 16);
    let mut text = String::new();
    let mut calls = 0.0;
    for (i, k) in (0..rings).flat_map(|i| (0..sectors).map(move |k| (i, k))) {
        if i == 5 && !keep(i, k) {
            continue;
        }
        for (di, dk) in [(0, 0), (0, 1), (1, 1), (1, 0)] {
            let theta = std::f64::consts::PI * (i + di) as f64 / rings as f64;
            let phi = std::f64::consts::TAU * (k + dk) as f64 / sectors as f64;
            calls += 1.0;
            let off = rounding * f64::sin(calls * 7.0);
            text += &format!(
                "v {} {} {}\n",
                theta.sin() * phi.cos() + off,
                theta.cos() + off,
                -theta.sin() * phi.sin() - off
            );
        }
        text += "f -1 -2 -3 -4\n";
    }
    text
}

/// Corners that are stated for each face anew, and rounded otherwise, still are one surface.
#[test]
fn seams_are_welded() {
    for rounding in [0.0, 2e-8] {
        let round = scene(&ball(rounding, |_, _| true));
        assert!(glass(&round).iter().all(|g| !g.1));
        assert!(round.warnings.iter().all(|w| w.contains("without area")), "{:#?}", round.warnings);
    }
}

/// A pane drawn from both sides is one pane, whichever way its quads are cut.
#[test]
fn doubled_panes_are_one() {
    for back in ["f -1 -2 -3 -4\n", "f -4 -1 -2 -3\n"] {
        let double = scene(&format!("{QUAD}{back}"));
        assert_eq!(glass(&double), [("glass".into(), true, 2)], "{back}");
    }
}

/// The sides of a slab without its rim, facing away from each other, still close a body; facing alike they are two panes.
#[test]
fn two_sides_close_a_body() {
    let slab = scene(&cuboid([0.; 3], [1., 1., 0.01], &[0, 1], false));
    assert_eq!(glass(&slab), [("glass".into(), false, 4)]);
    let panes = scene(&format!("{QUAD}{}", QUAD.replace(" 0\n", " 0.01\n")));
    assert_eq!(glass(&panes), [("glass".into(), true, 4)]);
}

/// Water is drawn by its level: an open surface of it stays the boundary of what is below, silently where it faces up.
#[test]
fn levels_of_liquids_stay() {
    let level = scene("usemtl water\nv 0 0 0\nv 0 0 1\nv 1 0 1\nv 1 0 0\nf -4 -3 -2 -1\n");
    assert_eq!(glass(&level), [("water".into(), false, 2)]);
    silent(&level);
    let wall = scene(&format!("usemtl water\n{QUAD}"));
    assert_eq!(glass(&wall), [("water".into(), false, 2)]);
    told(&wall, "\"water\": an open surface of so low an index is taken for a liquid's");
}

/// The scene file decides otherwise, and then nothing is said; of what is no glass it is a slip.
#[test]
fn thin_can_be_said() {
    let said = |name: &str, thin: bool| format!("[[material]]\nname = \"{name}\"\nthin = {thin}\n");
    let thick = load(QUAD, &said("glass", false)).unwrap();
    assert_eq!(glass(&thick), [("glass".into(), false, 2)]);
    let water = load(&format!("usemtl water\n{QUAD}"), &said("water", true)).unwrap();
    assert_eq!(glass(&water), [("water".into(), true, 2)]);
    silent(&water);
    warned(
        &load(QUAD, &said("floor", true)).unwrap(),
        "s.toml:9",
        "\"floor\": thin says nothing of what is no glass",
    );
}

/// A body and a pane of one material part: the pane gets a material of its own.
#[test]
fn panes_and_bodies_share_a_material() {
    let both = scene(&format!("{QUAD}{}", cuboid([2.; 3], [3.; 3], &ALL, false)));
    assert_eq!(glass(&both), [("glass".into(), false, 12), ("glass".into(), true, 2)]);
}

/// A body that is inside out is turned, all of it or the faces that are; a bubble in another body is not.
#[test]
fn bodies_inside_out_are_turned() {
    let mirrored = scene(&cuboid([0.; 3], [1.; 3], &ALL, true));
    assert!((volume(&mirrored) - 1.0).abs() < 1e-12, "{}", volume(&mirrored));
    warned(&mirrored, "a.obj:17", "\"glass\": fronts of this glass body look inward");
    let mixed = [
        cuboid([0.; 3], [1.; 3], &[0, 1, 4, 5], true),
        "f -8 -4 -2 -6\n".to_owned(),
        "f -7 -5 -1 -3\n".to_owned(),
    ]
    .concat();
    let mixed = scene(&mixed);
    assert!((volume(&mixed) - 1.0).abs() < 1e-12, "{}", volume(&mixed));
    let bubble = scene(&format!(
        "{}{}",
        cuboid([0.; 3], [1.; 3], &ALL, false),
        cuboid([0.25; 3], [0.75; 3], &ALL, true)
    ));
    assert!((volume(&bubble) - 0.875).abs() < 1e-12, "{}", volume(&bubble));
    silent(&bubble);
    // in a liquid it may be a bubble, too
    let level = "usemtl water\nv -5 2 5\nv 5 2 5\nv 5 2 -5\nv -5 2 -5\nf -4 -3 -2 -1\nusemtl glass\n";
    let sunk = scene(&format!("{level}{}", cuboid([0.; 3], [1.; 3], &ALL, true)));
    told(&sunk, "\"glass\": the fronts of this glass body look inward, which makes it a bubble");
    let shines = scene(&format!("usemtl lit\n{}", cuboid([0.; 3], [1.; 3], &ALL, true)));
    told(&shines, "\"lit\": the fronts of this glass body look inward");
}

/// Shading normals are turned with their triangles.
#[test]
fn turned_bodies_keep_their_shading() {
    let mut text =
        String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn -1 -1 -1\nvn 1 .1 .1\nvn .1 1 .1\nvn .1 .1 1\n");
    for [a, b, c] in [[1, 3, 2], [1, 2, 4], [1, 4, 3], [2, 3, 4]] {
        text += &format!("f {0}//{0} {1}//{1} {2}//{2}\n", c - 5, b - 5, a - 5);
    }
    let scene = scene(&text);
    assert!((volume(&scene) - 1.0 / 6.0).abs() < 1e-12);
    for t in &scene.mesh.triangles {
        let Some(normals) = t.normal else { continue };
        let [a, b, c] = t.vertex.map(|v| scene.mesh.positions[v as usize]);
        let front = (b - a).cross(c - a);
        for (n, v) in normals.iter().zip(t.vertex) {
            let n = scene.mesh.normals[*n as usize].as_dvec3();
            assert!(n.dot(front) > 0.0, "{n} on the front {front}");
            // each corner's normal points away from the opposite side, as it was given
            let away = scene.mesh.positions[v as usize] - glam::DVec3::splat(0.2);
            assert!(n.dot(away) > 0.0, "{n} at {away}");
        }
    }
}
