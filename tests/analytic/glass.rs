//! Plane boundaries: Fresnel, total reflection, and the change of radiance and irradiance behind them.

use crate::build::{Build, clear, glowing, matte, pane, reflectance, v, wide};
use crate::harness::{Renderer, everyone, mappers, render};
use joton::film::Layer;
use joton::scene::Light;
use std::f64::consts::PI;

const ALBEDO: [f32; 3] = [0.8, 0.5, 0.2];
const SUN: [f32; 3] = [1.0, 2.0, 3.0];
const WATER: f64 = 1.33;

/// [A6] The sun at an angle on a floor behind glass that `put` puts there: the floor has its irradiance times (1−R)/(1+R), in the
/// caustic layer alone.
fn glass_transmits_by_two_faces(glass: &str, degrees: f64, put: impl Fn(&mut Build)) {
    let angle = degrees.to_radians();
    let mut b = Build::new(v(0., -0.1, 0.17), v(0., 0., 0.), 0.4, 16);
    b.floor(v(0., 0., 0.), 0.5, &matte(ALBEDO));
    put(&mut b);
    b.sun(v(angle.sin(), 0., -angle.cos()), SUN);
    let r = reflectance(angle, 1.5);
    let irradiance = angle.cos() * (1.0 - r) / (1.0 + r);
    let want = std::array::from_fn(|i| wide(ALBEDO)[i] / PI * wide(SUN)[i] * irradiance);
    for who in mappers() {
        let shot = render(who, &b.0, "LDE|LS+DE", 48);
        // noise of some 30,000 jotons, 10,000 at 70°
        shot.claim(&format!("{glass} {degrees}°"), shot.layer(Layer::Caustic), want, 0.03);
        shot.claim(&format!("{glass} {degrees}°, direct"), shot.layer(Layer::Direct), [0.0; 3], 0.0);
    }
}

/// A parallel slab.
#[test]
fn slab_transmits_by_two_interfaces() {
    for degrees in [0f64, 45.0, 70.0] {
        // wide enough that no light from its sides reaches what is seen
        let (low, high) = (v(-1.1, -0.4, 0.2), v(0.4, 0.4, 0.25));
        glass_transmits_by_two_faces("slab", degrees, |b| b.cuboid(low, high, true, &clear(1.5)));
    }
}

/// A single quad of thin glass lets through what the closed slab does, whichever way it looks.
#[test]
fn pane_transmits_as_the_slab_does() {
    for (degrees, looks_up) in [(0f64, true), (45.0, false), (70.0, true)] {
        let (corner, x, y) = (v(-1.1, -0.4, 0.2), v(1.5, 0., 0.), v(0., 0.8, 0.));
        let [u, w] = if looks_up { [x, y] } else { [y, x] };
        glass_transmits_by_two_faces("pane", degrees, |b| b.quad(corner, u, w, &pane(1.5)));
    }
}

/// [A6] What a thin pane shows: 2R/(1+R) of the sky before it and the rest of the floor behind it, from either side, not
/// bent and not scaled by an index.
#[test]
fn pane_mixes_what_lies_on_both_sides() {
    for (degrees, looks_up) in [(0f64, false), (45.0, true), (70.0, false)] {
        let angle = degrees.to_radians();
        let from = v(angle.sin(), 0., angle.cos());
        let mut b = Build::new(from, v(0., 0., 0.), 0.005, 8);
        b.cuboid(v(-5., -5., -5.), v(5., 5., 5.), false, &glowing([1.0, 0.0, 0.5], [0.0; 3]));
        // where the line of sight ends if nothing bends it: bent, it would miss this plate
        let seen = -from / from.z * 0.5;
        b.floor(seen, 0.05, &glowing([0.0, 1.0, 0.5], [0.0; 3]));
        match looks_up {
            true => b.floor(v(0., 0., 0.), 4.0, &pane(1.5)),
            false => b.ceiling(v(0., 0., 0.), 4.0, &pane(1.5)),
        }
        let face = reflectance(angle, 1.5);
        let r = 2.0 * face / (1.0 + face);
        for who in everyone() {
            // an eye path goes both ways, a path of the path tracer one
            let passes = if who == Renderer::PathTracer { 512 } else { 32 };
            let shot = render(who, &b.0, "LS*E", passes);
            let seen = shot.layer(Layer::Emission);
            let what = format!("at {degrees}°, front up {looks_up}");
            // a pixel shows either side: of 32,768 samples 8 % reflect straight down, a noise of 2 %
            shot.claim_band(&format!("sky {what}"), seen, 0, r, if r < 0.15 { 0.08 } else { 0.03 });
            shot.claim_band(&format!("floor {what}"), seen, 1, 1.0 - r, 0.02);
            shot.claim_band(&format!("both {what}"), seen, 2, 0.5, 0.01);
        }
    }
}

/// [A7] The floor of a pool in the sun, seen from above: ρ/π E cosθ T(θ) T(φ)/η².
#[test]
fn pool_floor_is_seen_through_its_surface() {
    for (sun, view) in [(0f64, 0f64), (45.0, 0.0), (0.0, 45.0), (45.0, 45.0), (70.0, 45.0)] {
        let (sun, view) = (sun.to_radians(), view.to_radians());
        let mut b = Build::new(v(view.sin(), 0., view.cos()), v(0., 0., 0.), 0.12, 16);
        b.floor(v(0., 0., -0.3), 0.9, &matte(ALBEDO));
        b.floor(v(0., 0., 0.), 0.9, &clear(WATER as f32));
        b.sun(v(sun.sin(), 0., -sun.cos()), SUN);
        let transmitted = |angle: f64| 1.0 - reflectance(angle, WATER);
        let factor = sun.cos() * transmitted(sun) * transmitted(view) / (WATER * WATER);
        let want = std::array::from_fn(|i| wide(ALBEDO)[i] / PI * wide(SUN)[i] * factor);
        for who in mappers() {
            let shot = render(who, &b.0, "LS+DS*E", 32);
            let what = format!("pool, sun {:.0}°, view {:.0}°", sun.to_degrees(), view.to_degrees());
            // noise of the jotons, fewer where the sun is low, and of pixels that reflect
            shot.claim(&what, shot.layer(Layer::Caustic), want, 0.03);
        }
    }
}

/// [A8] Sky and glowing floor in a water surface: R and (1−R)/η² of them from above; η²(1−R) and R from below; the floor
/// alone beyond the critical angle.
#[test]
fn surface_mixes_what_lies_on_both_sides() {
    let scene = |from: glam::DVec3| {
        let mut b = Build::new(from, v(0., 0., 0.), 0.005, 16);
        b.cuboid(v(-5., -5., -5.), v(5., 5., 5.), false, &glowing([1.0, 0.0, 0.5], [0.0; 3]));
        b.floor(v(0., 0., -0.5), 4.0, &glowing([0.0, 1.0, 0.5], [0.0; 3]));
        b.floor(v(0., 0., 0.), 4.0, &clear(WATER as f32));
        b
    };
    for degrees in [0f64, 45.0, 80.0, 88.0] {
        let angle = degrees.to_radians();
        let b = scene(v(angle.sin(), 0., angle.cos()));
        let (r, t) = (reflectance(angle, WATER), (1.0 - reflectance(angle, WATER)) / (WATER * WATER));
        for who in everyone() {
            let shot = render(who, &b.0, "LS*E", 512);
            let seen = shot.layer(Layer::Emission);
            // a pixel shows either side: of 131,072 samples 2 % reflect straight down, a noise of 2 %
            shot.claim_band(&format!("sky at {degrees}°"), seen, 0, r, if r < 0.1 { 0.08 } else { 0.015 });
            shot.claim_band(&format!("floor at {degrees}°"), seen, 1, t, 0.02);
            shot.claim_band(&format!("both at {degrees}°"), seen, 2, (r + t) / 2.0, 0.01);
        }
    }
    // from below, at this angle inside
    let inside = 30f64.to_radians();
    let b = scene(v(-0.4 * inside.tan(), 0., -0.4));
    let r = reflectance((WATER * inside.sin()).asin(), WATER);
    let total = scene(v(-0.4 * 60f64.to_radians().tan(), 0., -0.4));
    for who in everyone() {
        let shot = render(who, &b.0, "LS*E", 512);
        let seen = shot.layer(Layer::Emission);
        shot.claim_band("sky from below", seen, 0, (1.0 - r) * WATER * WATER, 0.005);
        shot.claim_band("floor from below", seen, 1, r, 0.08);
        // nothing is left to chance: rounding only
        let shot = render(who, &total.0, "LS*E", 64);
        shot.claim("beyond the critical angle", shot.layer(Layer::Emission), [0.0, 1.0, 0.5], 1e-6);
    }
}

/// [A8] A narrow beam that meets the surface from below, beyond the critical angle: nothing above, and on the floor
/// I cosθ/d² with d unfolded.
#[test]
fn total_reflection_keeps_the_beam_under_water() {
    let angle = 60f64.to_radians();
    let beam = |camera: Build| {
        let mut b = camera;
        b.floor(v(0., 0., -0.3), 1.0, &matte(ALBEDO));
        b.floor(v(0., 0., 0.), 1.0, &clear(WATER as f32));
        b.ceiling(v(0., 0., 0.5), 2.0, &matte(ALBEDO));
        b.light(Light::Spot {
            position: v(-0.5, 0., -0.2),
            direction: v(angle.sin(), 0., angle.cos()),
            intensity: SUN,
            angle_inner: 2.8f64.to_radians(),
            angle_outer: 3f64.to_radians(),
        });
        b
    };
    // up 0.2 and down 0.3: the unfolded distance is 0.5/cos 60° = 1
    let spot = v(-0.5 + 0.5 * angle.tan(), 0., -0.3);
    let below = beam(Build::new(spot + v(0., -0.15, 0.2), spot, 0.05, 16));
    let above = beam(Build::new(v(0., 0., 0.02), v(0., 0., 0.5), 1.5, 16));
    let want = std::array::from_fn(|i| wide(ALBEDO)[i] / PI * wide(SUN)[i] * angle.cos());
    for who in mappers() {
        let shot = render(who, &below.0, "LS+DE", 24);
        shot.claim("beam on the floor", shot.layer(Layer::Caustic), want, 0.03);
        let shot = render(who, &above.0, "LS+DE", 8);
        shot.claim("beam above the surface", shot.layer(Layer::Caustic), [0.0; 3], 0.0);
    }
}
