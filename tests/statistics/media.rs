//! Media: a ball of glass full of wine and a bubble, in dark water that the camera is in, too. Host, device and path tracer show the
//! same, whether bodies overlap and have priorities [E45] or each boundary is drawn once with an index over what is around it.

use crate::chi_square::Claims;
use crate::common::scenes::{Builder, emitter, glass};
use crate::images::{BLOCKS, SIZE, claim, narrow};
use crate::renders::{EVERYTHING, Planner, Side, pictures, pictures_of, plan, plan_by_map};
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::scene::{FacetKind, Facets, Interior, Material, MaterialSpectra, Scene};
use joton::spectrum::glass::Index;
use std::sync::Arc;

const WATER: f32 = 1.33;
const WINE: f32 = 1.36;
const GLASS: f32 = 1.5;
const OF_WATER: [f32; 3] = [0.8, 0.2, 0.1];
const OF_WINE: [f32; 3] = [0.3, 3.0, 4.0];
/// Radii of the ball, of what is in it and of the bubble.
const RADII: [f64; 3] = [0.45, 0.35, 0.2];
/// How far the wine reaches into the glass, where bodies overlap.
const OVERLAP: f64 = 0.02;

fn body(name: &str, ior: f32, absorption: [f32; 3], priority: Option<i64>) -> Material {
    Material { name: name.into(), interior: Interior { absorption, priority }, ..glass(ior) }
}

/// A room full of water up to a level, under a wide lamp and with another one in it.
fn aquarium() -> Builder {
    let mut b = Builder::new([0., 0., 0.95], [0., -0.25, 0.], [0., 1., 0.], 0.8, SIZE);
    let white = b.matte(0.6);
    let lamp = b.material(emitter(4.0, 0.0));
    b.room([-1.; 3], [1.; 3], white);
    b.quad([-0.9, 0.95, -0.9], [1.8, 0., 0.], [0., 0., 1.8], lamp);
    b.quad([-0.98, -0.6, -0.5], [0., 0.6, 0.], [0., 0., 1.], lamp);
    b
}

fn level(b: &mut Builder, priority: Option<i64>) {
    let water = b.material(body("water", WATER, OF_WATER, priority));
    b.quad([-1., 0.6, -1.], [0., 0., 2.], [2., 0., 0.], water);
}

const BALL: [f64; 3] = [0.2, -0.5, -0.1];
const BUBBLE: [f64; 3] = [-0.5, -0.2, 0.0];

/// Every body as it is.
fn honest() -> Scene {
    let mut b = aquarium();
    level(&mut b, Some(3));
    let shell = b.material(body("glass", GLASS, [0.0; 3], Some(1)));
    b.icosphere(BALL, RADII[0], 2, false, shell);
    let first = b.scene.mesh.triangles.len();
    b.icosphere(BALL, RADII[1], 2, false, shell);
    // the inner side of the glass looks inward
    b.scene.mesh.triangles[first..].iter_mut().for_each(|t| t.vertex.swap(1, 2));
    let wine = b.material(body("wine", WINE, OF_WINE, Some(2)));
    b.icosphere(BALL, RADII[1] + OVERLAP, 2, false, wine);
    let bubble = b.material(body("bubble", 1.0, [0.0; 3], Some(0)));
    b.icosphere(BUBBLE, RADII[2], 2, false, bubble);
    b.scene
}

/// Every boundary once.
fn hand_made() -> Scene {
    let mut b = aquarium();
    level(&mut b, None);
    let outer = b.material(body("outer", GLASS / WATER, [0.0; 3], None));
    b.icosphere(BALL, RADII[0], 2, false, outer);
    let inner = b.material(body("inner", WINE / GLASS, OF_WINE, None));
    b.icosphere(BALL, RADII[1], 2, false, inner);
    let bubble = b.material(body("bubble", 1.0 / WATER, [0.0; 3], None));
    b.icosphere(BUBBLE, RADII[2], 2, false, bubble);
    b.scene
}

/// Independent renders of each: compiling for a device is most of what one takes.
const SEEDS: u32 = 4;

/// Host and device show either way of modelling as the path tracer shows one of them.
#[test]
fn bodies_that_overlap_are_what_their_boundaries_are() {
    const PASSES: u64 = 12;
    const PATHS: u64 = 192;
    let mut claims = Claims::default();
    let [honest, hand_made] = [honest(), hand_made()].map(|scene| Arc::new(PackedScene::new(&scene)));
    let paths = pictures(Side::PathTracer, &honest, EVERYTHING, 0..SEEDS, PATHS, |_| ());
    let cases: [(&str, Side, &Arc<PackedScene>, Planner); 3] = [
        ("overlapping, map", Side::Host, &honest, plan_by_map),
        ("hand-made, paths", Side::Host, &hand_made, plan),
        ("overlapping, paths", Side::Device, &honest, plan),
    ];
    for (name, side, scene, planner) in cases {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        let maps = pictures_of(planner, side, scene, EVERYTHING, 0..SEEDS, PASSES, narrow);
        claim(&mut claims, &format!("{name}, {side:?}"), &maps, &paths, &Layer::ALL, &BLOCKS);
    }
    claims.hold();
}

/// With rough glass of heavy flint, by wavelength, host and device agree.
#[test]
fn rough_bodies_that_part_colours_are_alike() {
    const PASSES: u64 = 12;
    crate::device_or_return!();
    let mut scene = honest();
    for m in &mut scene.materials {
        let index = Index::named(match m.name.as_str() {
            "glass" => "sf11",
            "wine" => "bk7",
            "water" => "water",
            _ => continue,
        });
        m.spectra = Some(Arc::new(MaterialSpectra { index, ..MaterialSpectra::default() }));
        if m.name == "glass" || m.name == "wine" {
            m.facets = Some(Facets { alpha: 0.1, kind: FacetKind::Interface });
        }
    }
    scene.wavelengths.are_rendered = true;
    let scene = Arc::new(PackedScene::new(&scene));
    let [a, b] = [Side::Device, Side::Host]
        .map(|side| pictures_of(plan, side, &scene, EVERYTHING, 0..SEEDS, PASSES, |_| ()));
    let mut claims = Claims::default();
    claim(&mut claims, "rough flint", &a, &b, &Layer::ALL, &BLOCKS);
    claims.hold();
}
