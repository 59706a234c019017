//! A ball of water in the sun: the primary bow, red at 42.4° and violet at 40.7° from where the sun's light comes.

use crate::build::{Build, Look, reflectance, v};
use crate::harness::{mappers, render_packed};
use crate::spectral::by_wavelength;
use glam::DVec3;
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::scene::{Dielectric, Material, MaterialSpectra, Scene};
use joton::spectrum::Spectrum;
use joton::spectrum::glass::Index;
use joton::spectrum::lamp::Emission;
use std::sync::Arc;

/// Lines of mercury, sodium and hydrogen, nm, and the index of water there at 20 °C [CRC Handbook].
const WATER: [(f64, f64); 3] = [(404.7, 1.34274), (589.3, 1.33299), (656.3, 1.33115)];
/// From the ball, of radius 1, to the middle of the screen, and from the axis of the sun, degrees.
const SCREEN: (f64, f64) = (60.0, 40.5);
/// Half of the screen's side.
const HALF: f64 = 4.2;
/// From the eye to the screen.
const EYE: f64 = 24.0;
/// Pixels of a side.
const SIZE: u32 = 48;
/// Bins of the closed form, a degree.
const BINS: usize = 25;

/// Middle of the screen.
fn middle() -> DVec3 {
    let (sin, cos) = SCREEN.1.to_radians().sin_cos();
    v(sin, 0., cos) * SCREEN.0
}

/// How far off the axis a place is, degrees.
fn off_axis(p: DVec3) -> f64 {
    p.x.hypot(p.y).atan2(p.z).to_degrees()
}

/// The smallest deviation that one reflection inside leaves, from the way back, degrees: 4 r − 2 i where cos² i = (n² − 1)/3
/// [Descartes 1637].
fn bow(n: f64) -> f64 {
    let i = ((n * n - 1.0) / 3.0).sqrt().acos();
    (4.0 * (i.sin() / n).asin() - 2.0 * i).to_degrees()
}

/// Irradiance of the screen in bins of the angle off the axis, of any unit: rays of the sun in a plane through the axis, once reflected inside,
/// and outside.
fn irradiance(n: f64) -> Vec<f64> {
    const RAYS: usize = 100_000;
    let mut bins = vec![0.0; 90 * BINS];
    let normal = middle().normalize();
    for ray in 0..RAYS {
        let b = (ray as f64 + 0.5) / RAYS as f64;
        let i = b.asin();
        let r = (b / n).asin();
        // the same from both sides
        let reflected = reflectance(i, n);
        let passes = 1.0 - reflected;
        // where it leaves, and where to, as turns from +z; it comes down at x = b on one side or the other
        let inside = [-1.0, 1.0].map(|side: f64| {
            let (leaves, turned) = (i + 2.0 * (std::f64::consts::PI - 2.0 * r), 2.0 * i - 4.0 * r);
            (side * leaves, side * turned, passes * passes * reflected)
        });
        let outside = [-1.0, 1.0].map(|side: f64| (side * i, side * 2.0 * i, reflected));
        for (leaves, turned, part) in inside.into_iter().chain(outside) {
            let at = |turn: f64| v(turn.sin(), 0., turn.cos());
            let (from, along) = (at(leaves), at(turned));
            let far = (middle() - from).dot(normal) / along.dot(normal);
            let hit = from + along * far;
            if far > 0.0 && hit.x > 0.0 && hit.z > 0.0 {
                // on a ring about the axis
                bins[(off_axis(hit) * BINS as f64) as usize] += b * part / hit.x;
            }
        }
    }
    bins
}

/// The ball and a piece of a screen that faces it.
fn scene() -> Scene {
    let (c, along) = (middle(), middle().normalize());
    let mut b = Build::new(c - along * EYE, c, HALF / EYE, SIZE);
    let water = Material {
        dielectric: Some(Dielectric { ior: 1.333, reflection_tint: [1.0; 3], transmission_tint: [1.0; 3] }),
        spectra: Some(Arc::new(MaterialSpectra { index: Index::named("water"), ..Default::default() })),
        ..Material::matte("water", [0.0; 3])
    };
    b.sphere(v(0., 0., 0.), 1.0, 5, Look::OutwardSmooth, &water);
    let (across, up) = (v(0., -1., 0.), v(-along.z, 0., along.x));
    b.quad(
        c - (across + up) * 2.0 * HALF,
        up * 4.0 * HALF,
        across * 4.0 * HALF,
        &Material::matte("screen", [0.8; 3]),
    );
    let light = Emission::continuous(Spectrum::Constant(100.0));
    b.sun(v(0., 0., -1.), light.to_rgb().map(|c| c as f32));
    by_wavelength(b, light)
}

/// Each colour has its own bow: the light of the screen lies where that of the closed form does, within 0.15°.
#[test]
fn bows_of_water_lie_where_descartes_says() {
    assert!((bow(WATER[0].1) - 40.65).abs() < 0.1 && (bow(WATER[2].1) - 42.35).abs() < 0.1);
    let along = middle().normalize();
    let up = v(-along.z, 0., along.x);
    let place = |x: f64, y: f64| middle() + (v(0., -1., 0.) * (2.0 * x - 1.0) + up * (1.0 - 2.0 * y)) * HALF;
    let packed = PackedScene::whole(&scene()).at_wavelengths(WATER.map(|(lambda, _)| lambda));
    let closed = WATER.map(|(_, n)| irradiance(n));
    for who in mappers() {
        let shot = render_packed(who, packed.clone(), "LS+DE", 24, &[]);
        let all = shot.weighed(&[Layer::Caustic], |_, _| 1.0).mean;
        let turned = shot.weighed(&[Layer::Caustic], |x, y| off_axis(place(x, y)));
        for (band, (lambda, n)) in WATER.into_iter().enumerate() {
            let bins = &closed[band];
            let [mut sum, mut moment] = [0.0; 2];
            for pixel in 0..SIZE * SIZE {
                let [x, y] = [pixel % SIZE, pixel / SIZE].map(|i| (f64::from(i) + 0.5) / f64::from(SIZE));
                let angle = off_axis(place(x, y));
                // a bin's part of the screen is as long as the ray is, and tilted
                let tilt = (angle - SCREEN.1).to_radians().cos();
                let light = bins[(angle * BINS as f64) as usize] * tilt * tilt;
                (sum, moment) = (sum + light, moment + light * angle);
            }
            let (found, want) = (turned.mean[band] / all[band], moment / sum);
            println!(
                "{lambda} nm, {who:?}: mean {found:.3}°, not {want:.3}°; bow at {:.2}°, not {:.2}°",
                bow(n) + found - want,
                bow(n)
            );
            assert!((found - want).abs() < 0.15, "{lambda} nm, {who:?}: {found}°, not {want}°");
        }
    }
}
