//! Faces that touch, or all but touch: panes, coats, lamps and floors whose gaps are a millionth of the scene.

use crate::build::{Build, Look, black, clear, glowing, matte, reflectance, v};
use crate::harness::{Renderer, everyone, mappers, render};
use joton::film::Layer;
use joton::paths::LightPaths;
use joton::plan::Plan;
use std::f64::consts::PI;

const IOR: f32 = 1.5;

/// [A6] Transmittance of a clear slab in normal light.
fn slab() -> f64 {
    let r = reflectance(0.0, f64::from(IOR));
    (1.0 - r) / (1.0 + r)
}

/// Two panes in the sun, one on the other, with air between them: light passes four surfaces and all ways between them,
/// however thin the air is. With nothing between them, too: it is the limit.
#[test]
fn air_between_panes_has_two_surfaces() {
    // n surfaces of reflectance R pass (1 − R)/(1 + (n − 1) R): each adds its R/(1 − R) to that of the whole [A6]
    let r = reflectance(0.0, f64::from(IOR));
    let want = 0.5 / PI * (1.0 - r) / (1.0 + 3.0 * r);
    for floor in [3.0, 30.0] {
        for gap in [1e-2, 1e-4, 1e-5, 1e-6, 0.0] {
            let mut b = Build::new(v(0., 0.02, 0.4), v(0., 0., 0.), 0.3, 8);
            b.floor(v(0., 0., 0.), floor, &matte([0.5; 3]));
            b.cuboid(v(-1., -1., 0.5), v(1., 1., 0.6), true, &clear(IOR));
            b.cuboid(v(-1., -1., 0.6 + gap), v(1., 1., 0.7), true, &clear(IOR));
            b.sun(v(0., 0., -1.), [1.0; 3]);
            for who in mappers() {
                let shot = render(who, &b.0, "LS+DE", 32);
                shot.claim(&format!("gap {gap:e}, floor {floor}"), shot.layer(Layer::Caustic), [want; 3], 0.012);
            }
        }
    }
}

/// A matte ball in a coat of glass: what is seen of it does not depend on how thin the air between them is.
#[test]
fn a_thin_coat_is_a_coat() {
    let scene = |gap: f64| {
        // radii such that internal lengths are hard to tell apart: a radius of one unit, 512 of the scene's
        let mut b = Build::new(v(0., 0., 4.), v(0., 0., 0.), 0.03, 4);
        b.sphere(v(0., 0., 0.), 1.0, 4, Look::Outward, &matte([0.8, 0.1, 0.1]));
        b.sphere(v(0., 0., 0.), 1.0 + gap, 4, Look::Outward, &clear(IOR));
        b.sun(v(0., 0., -1.), [PI as f32; 3]);
        b.0
    };
    let centre = |shot: &crate::harness::Shot| shot.mean(&Layer::ALL, |_, _| true);
    for who in mappers() {
        let wide = centre(&render(who, &scene(1e-3), "L.*E", 64));
        let narrow = render(who, &scene(1e-6), "L.*E", 64);
        narrow.claim("coat of 1e-6", centre(&narrow), wide.mean, 0.03);
    }
}
