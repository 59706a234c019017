//! Lights without area in lobes of every width, up to n = 10⁶: ρ (n + 2)/2π E in the mirror direction, E the irradiance of the surface, and
//! where lobes are followed ρ (n + 1)/2π times that across the beam, as of a mirror. And spots as narrow as a hundredth of a degree.

use crate::build::{Build, clear, matte, v};
use crate::harness::{Renderer, everyone, render};
use glam::DVec3;
use joton::film::Layer;
use joton::scene::{Light, Material};
use std::f64::consts::PI;

/// Phong exponents of the strips of the floor.
const EXPONENTS: [f64; 7] = [299.0, 300.0, 301.0, 1e3, 1e4, 1e5, 1e6];
/// Width of a strip, and reflectance.
const WIDTH: f64 = 0.2;
const GLOSSY: f64 = 0.5;
/// Light and eye are so far away that the whole floor mirrors the light into the eye: to 1e-5 rad, where the narrowest lobe
/// is 1e-3 wide.
const DISTANCE: f64 = 1e5;
/// Irradiance across the beam.
const BEAM: f64 = 5.0;

/// Strips under a light at 45 degrees, and an eye where a mirror would show it.
fn strips(light: Light) -> Build {
    let across = WIDTH * EXPONENTS.len() as f64 / 2.0;
    let mut b = Build::new(v(0., -1., 1.).normalize() * DISTANCE, v(0., 0., 0.), across / DISTANCE, 14);
    for (k, exponent) in EXPONENTS.into_iter().enumerate() {
        let strip = Material {
            glossy: [GLOSSY as f32; 3],
            glossy_exponent: exponent as f32,
            ..Material::matte(format!("{exponent}"), [0.0; 3])
        };
        b.quad(v(WIDTH * k as f64 - across, -1.5, 0.), v(WIDTH, 0., 0.), v(0., 3., 0.), &strip);
    }
    b.light(light);
    b
}

/// 84.97 in a lobe of exponent 300, 120.2 at 301, and so on.
#[test]
fn lights_without_area_are_seen_in_every_lobe() {
    let to_light = v(0., 1., 1.).normalize();
    let (position, direction) = (to_light * DISTANCE, -to_light);
    let intensity = [(BEAM * DISTANCE * DISTANCE) as f32; 3];
    let (angle_inner, angle_outer) = (0.01, 0.02);
    for (name, light) in [
        ("sun", Light::Sun { direction, irradiance: [BEAM as f32; 3] }),
        ("point", Light::Point { position, intensity }),
        ("spot", Light::Spot { position, direction, intensity, angle_inner, angle_outer }),
    ] {
        for who in everyone() {
            let passes = if who == Renderer::PathTracer { 8 } else { 256 };
            let shot = render(who, &strips(light).0, "L.E", passes);
            for (k, exponent) in EXPONENTS.into_iter().enumerate() {
                let middle = (k as f64 + 0.5) / EXPONENTS.len() as f64;
                let inside = |x: f64, _: f64| (x - middle).abs() < 0.5 / EXPONENTS.len() as f64;
                let is_followed = exponent > 300.0;
                let scattered = (exponent + 2.0) * to_light.z;
                let want = GLOSSY * BEAM / (2.0 * PI) * if is_followed { exponent + 1.0 } else { scattered };
                let what = format!("exponent {exponent}, {name}");
                // eye, light and places are rounded at 1e-4 of the width of the narrowest lobe
                shot.claim(
                    &what,
                    shot.mean(&[if is_followed { Layer::Emission } else { Layer::Direct }], inside),
                    [want; 3],
                    0.01,
                );
            }
        }
    }
}

/// A spot of half-angle a sends I Ω, Ω = π (2 − cos a_i − cos a_o), however narrow it is: to a floor, and through a slab
/// to a floor [A6].
#[test]
fn narrow_spots_send_all_of_their_flux() {
    const HEIGHT: f64 = 2.0;
    const RHO: f64 = 0.5;
    for degrees in [0.05f64, 0.001] {
        let outer = degrees.to_radians();
        let spread = HEIGHT * outer;
        let camera = v(0., 0., 0.5);
        let half = 2.0 * spread;
        let scene = |slab: bool| {
            let mut b = Build::new(camera, v(0., 0., 0.), half / camera.z, 16);
            b.floor(v(0., 0., 0.), 1.0, &matte([RHO as f32; 3]));
            if slab {
                b.cuboid(v(-0.4, -0.4, 1.0), v(0.4, 0.4, 1.1), true, &clear(1.5));
            }
            b.light(Light::Spot {
                position: v(0., 0., HEIGHT),
                direction: -DVec3::Z,
                intensity: [1.0; 3],
                angle_inner: 0.5 * outer,
                angle_outer: outer,
            });
            b
        };
        let below = |a: f64| 2.0 * (0.5 * a).sin().powi(2);
        let flux = PI * (below(outer) + below(0.5 * outer));
        let want = RHO / PI * flux / (4.0 * half * half);
        for who in everyone() {
            let shot = render(who, &scene(false).0, "LDE", 32);
            shot.claim(&format!("spot of {degrees}°"), shot.layer(Layer::Direct), [want; 3], 0.01);
            if who == Renderer::PathTracer {
                continue;
            }
            let shot = render(who, &scene(true).0, "LS+DE", 64);
            let r = 0.04;
            let through = want * (1.0 - r) / (1.0 + r);
            let name = format!("spot of {degrees}° through a slab");
            shot.claim(&name, shot.layer(Layer::Caustic), [through; 3], 0.03);
        }
    }
}
