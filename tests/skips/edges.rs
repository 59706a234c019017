//! Scenes at the edge of what a plan expects: they have a plan, with and without skips, and an image.

use crate::common::scenes::{Builder, emitter, glass, mirror};
use crate::common::twins::EVERYTHING;
use crate::renders::{Side, both, plan, run};
use glam::DVec3;
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::plan::{Part, Reason};
use joton::scene::{Material, Scene};
use std::sync::Arc;

const SIZE: u32 = 24;

/// A floor of a material, looked at from above, and a light.
fn floor(material: Material, light: impl FnOnce(&mut Builder)) -> Scene {
    let mut b = Builder::new([0., 2., 0.1], [0.; 3], [0., 1., 0.], 0.3, SIZE);
    let m = b.material(material);
    b.quad([-1., 0., -1.], [0., 0., 2.], [2., 0., 0.], m);
    light(&mut b);
    b.scene
}

fn point(b: &mut Builder) {
    b.point_light([0., 1., 0.], 1.0);
}

/// A lamp that is a point: it has no flux.
fn no_area(b: &mut Builder) {
    let lamp = b.material(emitter(1.0, 0.0));
    b.triangle([DVec3::Y; 3], lamp);
}

fn white() -> Material {
    Material::matte("white", [0.5; 3])
}

/// Nothing that emits: all of the layers that would need a light are skipped, whatever is kept, and the image is black.
#[test]
fn a_light_without_flux_lights_nothing() {
    let scene = Arc::new(PackedScene::new(&floor(white(), no_area)));
    assert!(scene.emitters.is_empty());
    for keep in [&[][..], &Part::ALL] {
        for side in both().into_iter().chain([Side::PathTracer]) {
            let plan = plan(&scene, EVERYTHING, 1, keep);
            let dark = plan.skipped.iter().filter(|s| s.why == Reason::NoLight).map(|s| s.what);
            assert_eq!(dark.collect::<Vec<_>>(), [Part::DirectLight, Part::CausticMap, Part::DiffuseMap]);
            let picture = run(side, &scene, plan, 1).picture;
            assert!(picture.whole.pixels.iter().flatten().all(|x| *x == 0.0), "{side:?}");
        }
    }
}

/// Nothing to see, nothing diffuse, nothing that reflects: what is kept finds nothing, and the image is what it is without.
#[test]
fn kept_parts_find_nothing_where_nothing_is() {
    let away = || {
        let mut scene = floor(white(), point);
        scene.camera.target = DVec3::new(0.0, 9.0, 0.2);
        scene
    };
    let scenes = [
        ("a camera that sees nothing", away()),
        ("a mirror and a point", floor(mirror(1.0), point)),
        ("glass and a point", floor(glass(1.5), point)),
        ("black and a point", floor(Material::matte("black", [0.0; 3]), point)),
    ];
    for (name, scene) in scenes {
        let scene = Arc::new(PackedScene::new(&scene));
        for side in both() {
            for keep in [&[][..], &Part::ALL] {
                let picture = run(side, &scene, plan(&scene, EVERYTHING, 1, keep), 1).picture;
                let lit = picture.whole.pixels.iter().flatten().filter(|x| **x != 0.0).count();
                assert_eq!(lit, 0, "{name}, {side:?}, {} parts kept", keep.len());
            }
        }
    }
}

/// No diffuse surface, no map: then there are no jotons to save for the background either.
#[test]
fn no_jotons_are_saved_where_none_are_traced() {
    let plan = plan(&PackedScene::new(&floor(mirror(1.0), point)), EVERYTHING, 1, &[]);
    assert!(!plan.traces(Layer::Caustic) && !plan.traces(Layer::Diffuse));
    assert!(plan.skipped.iter().all(|s| s.what != Part::Background), "{:?}", plan.skipped);
}
