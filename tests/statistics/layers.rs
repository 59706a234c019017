//! Clear coats, sheen and specular factors in one scene: host, device and path tracer see the same light.

use crate::images::{SIZE, all_sides_agree};
use crate::renders::file;
use joton::scene::{FacetKind, Facets, Layers, Light, Material, Scene};
use joton::spectrum::BLACK;

/// Renders by maps.
const MAPS: u32 = 4;

/// Spheres whose walls and bodies have layers: coats that are followed and that are gathered, over bases of either kind, and sheen under
/// one; a large lamp, and a point.
fn scene() -> Scene {
    let mut scene = file("spheres.toml", SIZE);
    scene.lights.push(Light::Point { position: scene.camera.position, intensity: [0.3; 3] });
    let lamp = scene.materials.iter().find(|m| m.emits()).expect("a light").emission;
    let plain = Layers::PLAIN;
    let sheen = Layers { sheen: [0.8, 0.6, 0.3], ..plain };
    for m in &mut scene.materials {
        let white = m.diffuse[0] > 0.0 && m.diffuse[0] == m.diffuse[1];
        m.emission = if white { lamp.map(|e| e * 0.01) } else { BLACK };
        let (diffuse, glossy, alpha, layers) = match m.name.as_str() {
            "green" => {
                (m.diffuse, [0.04; 3], 0.3, Layers { clear_coat: 0.8, clear_coat_alpha: 0.05, ..plain })
            }
            "red" => (m.diffuse, [0.04; 3], 0.5, Layers { clear_coat: 0.5, clear_coat_alpha: 0.2, ..sheen }),
            "mirror" => {
                (BLACK, [0.9, 0.5, 0.2], 0.06, Layers { clear_coat: 1.0, clear_coat_alpha: 0.03, ..sheen })
            }
            "glass" => {
                let red = Layers { head_on: [0.03, 0.01, 0.002], grazing: 0.5, ..plain };
                ([0.5, 0.4, 0.3], red.head_on, 0.15, Layers { clear_coat: 0.5, ..red })
            }
            _ => continue,
        };
        let root = layers.head_on[0].sqrt();
        let kind = FacetKind::Schlick { ior: (1.0 + root) / (1.0 - root) };
        *m = Material {
            diffuse,
            glossy,
            facets: Some(Facets { alpha, kind }),
            layers: Some(layers),
            emission: m.emission,
            ..Material::matte(m.name.clone(), BLACK)
        };
    }
    scene
}

/// Host and device against the path tracer, which cost little: by paths that go on, and by jotons that bounce on layers and are gathered
/// there.
#[test]
fn layers_are_alike_on_all_sides() {
    all_sides_agree("layers", &scene(), 128, MAPS, [8, 2]);
}
