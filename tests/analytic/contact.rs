//! Faces that touch, or all but touch: panes, coats, lamps and floors whose gaps are a millionth of the scene.

use crate::build::{Build, Look, black, clear, glowing, matte, reflectance, v};
use crate::harness::{Renderer, Shot, everyone, mappers, render};
use glam::DVec3;
use joton::film::Layer;
use joton::scene::Scene;
use std::f64::consts::PI;

const IOR: f32 = 1.5;
const SUN: f32 = PI as f32;

/// Reflectance of the glass in normal light.
fn face() -> f64 {
    reflectance(0.0, f64::from(IOR))
}

/// [A6] Transmittance of so many clear surfaces in normal light: each adds its R/(1 − R) to that of the whole.
fn through(surfaces: f64) -> f64 {
    let r = face();
    (1.0 - r) / (1.0 + (surfaces - 1.0) * r)
}

/// Mean over the image.
fn whole(shot: &Shot, layers: &[Layer]) -> crate::harness::Seen {
    shot.mean(layers, |_, _| true)
}

/// Two panes in the sun, one on the other, with air between them: light passes four surfaces and all ways between them,
/// however thin the air is. With nothing between them, too: it is the limit.
#[test]
fn air_between_panes_has_two_surfaces() {
    let want = 0.5 / PI * through(4.0);
    for (floor, gaps) in [(3.0, [1e-3, 1e-6, 0.0]), (30.0, [1e-4, 1e-5, 1e-6])] {
        for gap in gaps {
            let mut b = Build::new(v(0., 0.02, 0.4), v(0., 0., 0.), 0.3, 8);
            b.floor(v(0., 0., 0.), floor, &matte([0.5; 3]));
            b.cuboid(v(-1., -1., 0.5), v(1., 1., 0.6), true, &clear(IOR));
            b.cuboid(v(-1., -1., 0.6 + gap), v(1., 1., 0.7), true, &clear(IOR));
            b.sun(v(0., 0., -1.), [1.0; 3]);
            // light that goes to and fro in a wide gap leaves the glass elsewhere
            let passes = if gap >= 1e-4 { 32 } else { 12 };
            for who in mappers() {
                let shot = render(who, &b.0, "LS+DE", passes);
                shot.claim(
                    &format!("gap {gap:e}, floor {floor}"),
                    shot.layer(Layer::Caustic),
                    [want; 3],
                    0.012,
                );
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
    for who in mappers() {
        let wide = whole(&render(who, &scene(1e-3), "L.*E", 64), &Layer::ALL);
        let narrow = render(who, &scene(1e-6), "L.*E", 64);
        // noise of the caustics in the coat
        narrow.claim("coat of 1e-6", whole(&narrow, &Layer::ALL), wide.mean, 0.03);
    }
}

/// A block of glass on a matte floor in the sun, seen from above through it. With air below the glass the floor has the
/// light of a slab, and is seen through one; where the glass touches it, or reaches into it, there is no such air:
/// (1 − R)²/η² [A7], whichever way the two are made to touch.
#[test]
fn glass_that_touches_a_floor_has_no_air_below() {
    let scene = |gap: f64, turned: bool| {
        // a turned scene has faces that f32 rounds one by one
        let turn = |p: DVec3| if turned { glam::DQuat::from_rotation_x(0.61) * p } else { p };
        let mut b = Build::new(turn(v(0., 0., 2.)), turn(v(0., 0., 0.)), 0.05, 8);
        b.floor(v(0., 0., 0.), 1.0, &matte([0.8; 3]));
        b.cuboid(v(-0.5, -0.5, gap), v(0.5, 0.5, 0.3), true, &clear(IOR));
        b.sun(turn(v(0., 0., -1.)), [SUN; 3]);
        if turned {
            b.0.mesh.positions.iter_mut().for_each(|p| *p = turn(*p));
        }
        b.0
    };
    let apart = 0.8 * through(2.0) * through(2.0);
    let touching = 0.8 * (1.0 - face()).powi(2) / f64::from(IOR * IOR);
    for (gap, turned, want) in [
        (1e-6, false, apart),
        (1e-5, true, apart),
        (0.0, false, touching),
        (0.0, true, touching),
        (-1e-4, true, touching),
    ] {
        for who in mappers() {
            let shot = render(who, &scene(gap, turned), "LS+DS*E", 48);
            shot.claim(
                &format!("gap {gap:e}, turned: {turned}"),
                shot.layer(Layer::Caustic),
                [want; 3],
                0.02,
            );
        }
    }
}

/// The same block under a large lamp, which the path tracer can find: one value for all.
#[test]
fn everyone_agrees_on_glass_that_touches() {
    let mut b = Build::new(v(0., 0., 2.), v(0., 0., 0.), 0.1, 8);
    b.floor(v(0., 0., 0.), 1.0, &matte([0.6; 3]));
    b.cuboid(v(-0.5, -0.5, 0.0), v(0.5, 0.5, 0.3), true, &clear(IOR));
    b.ceiling(v(0., 0., 2.5), 2.0, &glowing([1.0; 3], [0.0; 3]));
    let truth = whole(&render(Renderer::PathTracer, &b.0, "L.*E", 64), &Layer::ALL);
    for who in mappers() {
        let shot = render(who, &b.0, "L.*E", 32);
        // noise of the path tracer
        shot.claim("touching block", whole(&shot, &Layer::ALL), truth.mean, 0.03);
    }
}

/// A thin pane, 700 m from the middle of a plane of 2 km: the floor has the light of a slab.
#[test]
fn a_thin_pane_far_from_the_middle_is_a_pane() {
    let at = v(700., 0., 0.);
    let mut b = Build::new(at + v(0., -0.6, 0.3), at, 0.1, 8);
    b.floor(v(0., 0., 0.), 1000.0, &matte([0.5; 3]));
    b.cuboid(at + v(-0.5, -0.5, 0.5), at + v(0.5, 0.5, 0.504), true, &clear(IOR));
    b.sun(v(0., 0., -1.), [1.0; 3]);
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 8);
        shot.claim("4 mm pane", shot.layer(Layer::Caustic), [0.5 / PI * through(2.0); 3], 0.02);
    }
}

/// A pane in the plane of a wall, over a hole with an overlap: only the hole lets light through, since glass that touches
/// an opaque face is in contact with it.
#[test]
fn a_pane_flush_with_a_wall_lights_by_its_hole_alone() {
    let (hole, overlap) = (0.3, 0.05);
    let (low, high) = (v(-1., -1., 1.), v(1., 1., 1.));
    let mut b = Build::new(v(0., 0., 0.9), v(0., 0., 0.), 0.5, 16);
    b.floor(v(0., 0., 0.), 1.0, &matte([0.5; 3]));
    let wall = black();
    for (corner, x, y) in [
        (low, 2.0, 1.0 - hole),
        (v(-1., hole, 1.), 2.0, 1.0 - hole),
        (v(-1., -hole, 1.), 1.0 - hole, 2.0 * hole),
        (v(hole, -hole, 1.), 1.0 - hole, 2.0 * hole),
    ] {
        b.quad(corner, v(0., y, 0.), v(x, 0., 0.), &wall);
    }
    let pane = v(hole + overlap, hole + overlap, 0.02);
    for below in [0.0, 0.02] {
        // above the wall, or below
        let mut b = Build(b.0.clone());
        let base = v(0., 0., high.z - below);
        b.cuboid(base - v(pane.x, pane.y, 0.), base + pane, true, &clear(IOR));
        b.sun(v(0., 0., -1.), [1.0; 3]);
        // of 0.9² of the floor that is seen
        let want = 0.5 / PI * through(2.0) * (2.0 * hole / 0.9f64).powi(2);
        for who in mappers() {
            let shot = render(who, &b.0, "LS+DE", 32);
            shot.claim(&format!("pane {below} below"), shot.layer(Layer::Caustic), [want; 3], 0.02);
        }
    }
}

/// A black sheet close under a lamp shades everything below, and one above nothing.
#[test]
fn a_sheet_close_to_a_lamp_shades_it() {
    for gap in [4e-4, 1e-5, -1e-5] {
        let mut b = Build::new(v(0., -1., 1.), v(0., 0., 0.), 0.3, 8);
        b.floor(v(0., 0., 0.), 5.0, &matte([0.5; 3]));
        b.ceiling(v(0., 0., 5.), 0.5, &glowing([10.0; 3], [0.0; 3]));
        b.floor(v(0., 0., 5. - gap), 1.0, &black());
        for who in everyone() {
            let shot = render(who, &b.0, "LDE", 8);
            let lit = shot.layer(Layer::Direct).mean[0];
            assert_eq!(lit > 0.0, gap < 0.0, "{who:?}, sheet {gap:e} below the lamp: {lit}");
        }
    }
}

/// A lamp of two faces in one place shines to both sides, like one whose faces are apart.
#[test]
fn a_doubled_lamp_shines_both_ways() {
    let lamp = glowing([5.0; 3], [0.0; 3]);
    let scene = |side: f64, apart: f64| {
        let mut b = Build::new(v(0., 0.6, 0.8 * side), v(0., 0., 0.), 0.8, 16);
        b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &matte([0.5; 3]));
        b.ceiling(v(0., 0., -apart), 0.3, &lamp);
        b.floor(v(0., 0., apart), 0.3, &lamp);
        b.0
    };
    for side in [-1.0, 1.0] {
        let seen = |shot: &Shot| whole(shot, &[Layer::Emission, Layer::Direct]);
        let truth = seen(&render(Renderer::PathTracer, &scene(side, 1e-3), "LE|LDE", 64));
        for who in everyone() {
            let shot = render(who, &scene(side, 0.0), "LE|LDE", 32);
            shot.claim(&format!("side {side}"), seen(&shot), truth.mean, 0.02);
        }
    }
}

/// Two faces in one place, red one way and blue the other.
#[test]
fn the_back_of_a_doubled_face_shows_its_own_material() {
    let scene = |side: f64| -> Scene {
        let mut b = Build::new(v(0., 0., 2. * side), v(0., 0., 0.), 0.2, 4);
        b.floor(v(0., 0., 0.), 1.0, &matte([0.8, 0., 0.]));
        b.ceiling(v(0., 0., 0.), 1.0, &matte([0., 0., 0.8]));
        b.sun(v(0., 0., -side), [SUN; 3]);
        b.0
    };
    for (side, want) in [(1.0, [0.8, 0., 0.]), (-1.0, [0., 0., 0.8])] {
        for who in everyone() {
            let shot = render(who, &scene(side), "LDE", 8);
            shot.claim(&format!("side {side}"), shot.layer(Layer::Direct), want, 1e-5);
        }
    }
}
