//! Bodies that are glass in part, of which one overlaps another one by priority, and rough panes: host, device and path tracer see the
//! same light [E57, E58].

use crate::common::scenes::{Builder, emitter, glass};
use crate::images::{SIZE, all_sides_agree};
use joton::scene::{FacetKind, Facets, Interior, Material, Mixture, Scene, number_rests};

/// Renders by maps.
const MAPS: u32 = 3;

fn mixed(glass: Material, transmission: f32, rest: Material) -> Material {
    let (transmission_map, metallic, metallic_map) = (None, 0.0, None);
    let mixture =
        Mixture { transmission, transmission_map, metallic, metallic_map, rest: Box::new(rest), number: 0 };
    Material { mixture: Some(mixture), ..glass }
}

/// In a room: a rough ball, half of it glass that absorbs, which reaches into a ball of smooth glass that counts over it; a smooth one
/// that is glass in part; and a rough pane.
fn scene() -> Scene {
    let mut b = Builder::new([0., -0.1, 0.95], [0., -0.6, 0.], [0., 1., 0.], 0.6, SIZE);
    let white = b.matte(0.6);
    let lamp = b.material(emitter(4.0, 0.0));
    b.room([-1.; 3], [1.; 3], white);
    b.quad([-0.6, 0.95, -0.6], [1.2, 0., 0.], [0., 0., 1.2], lamp);
    let coat = |alpha| Some(Facets { alpha, kind: FacetKind::Schlick { ior: 1.5 } });
    let plastic = |diffuse, alpha| Material {
        glossy: [0.04; 3],
        facets: coat(alpha),
        ..Material::matte("rest", diffuse)
    };
    let body = |ior, absorption: [f32; 3], priority| Material {
        interior: Interior { absorption, priority: Some(priority) },
        ..glass(ior)
    };
    let rough = Material {
        facets: Some(Facets { alpha: 0.09, kind: FacetKind::Interface }),
        ..body(1.5, [0.5, 2.0, 3.0], 2)
    };
    let rough = b.material(mixed(rough, 0.5, plastic([0.8, 0.3, 0.2], 0.09)));
    let inner = b.material(body(1.33, [0.0; 3], 1));
    let smooth = b.material(mixed(body(1.5, [0.0; 3], 3), 0.7, plastic([0.2, 0.4, 0.8], 0.0)));
    b.icosphere([-0.45, -0.6, 0.], 0.35, 2, true, rough);
    b.icosphere([-0.2, -0.75, 0.2], 0.2, 2, true, inner);
    b.icosphere([0.5, -0.6, 0.1], 0.3, 2, true, smooth);
    let pane = b.material(Material {
        facets: Some(Facets { alpha: 0.2, kind: FacetKind::Interface }),
        thin: true,
        ..glass(1.5)
    });
    b.quad([0.1, -0.9, -0.6], [0.8, 0., 0.1], [0., 0.9, 0.], pane);
    number_rests(&mut b.scene.materials);
    b.scene
}

/// Host and device against the path tracer, by paths that go on and by jotons.
#[test]
fn mixtures_are_alike_on_all_sides() {
    all_sides_agree("mixtures", &scene(), 24, MAPS, [4, 1]);
}
