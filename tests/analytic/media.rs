//! Light inside of bodies: what is left of it after a length [E44], whoever starts there, and which of several bodies counts [E45].

use crate::build::{Build, clear, glowing, matte, reflectance, v, wide};
use crate::harness::{EVERYTHING, Values, everyone, mappers, render};
use joton::film::Layer;
use joton::scene::{Interior, Material, MaterialSpectra};
use joton::spectrum::Spectrum;
use std::f64::consts::PI;
use std::sync::Arc;

const ALBEDO: [f32; 3] = [0.8, 0.5, 0.2];
const SUN: [f32; 3] = [1.0, 2.0, 3.0];
/// Per unit of length.
const ABSORPTION: [f32; 3] = [4.0, 0.0, 12.0];

/// A body that absorbs.
fn dark(ior: f32) -> Material {
    Material { interior: Interior { absorption: ABSORPTION, ..Interior::default() }, ..clear(ior) }
}

/// What is left of light after a length.
fn left(length: f64) -> Values {
    wide(ABSORPTION).map(|a| (-a * length).exp())
}

/// What a slab transmits at an angle, all ways between its faces together: (1−R)² a / (1 − R² a²), a = exp(−σ d / cos θ').
fn slab(angle: f64, ior: f64, thickness: f64) -> Values {
    let r = reflectance(angle, ior);
    let inner = (1.0 - (angle.sin() / ior).powi(2)).sqrt();
    left(thickness / inner).map(|a| (1.0 - r).powi(2) * a / (1.0 - (r * a).powi(2)))
}

/// [A15] A glowing floor seen through a slab, and a floor that the sun lights through one.
#[test]
fn slab_takes_what_its_length_takes() {
    for degrees in [0f64, 60.0] {
        let angle = degrees.to_radians();
        let (low, high) = (v(-1.5, -0.4, 0.2), v(0.8, 0.4, 0.25));
        // what is reflected sees nothing; the sight meets the middle of the slab
        let from = v(angle.sin(), 0., angle.cos()) * 0.8 + v(-0.2, 0., 0.2);
        let mut seen = Build::new(from, v(-0.2, 0., 0.2), 0.002, 8);
        seen.floor(v(0., 0., 0.), 5., &glowing(SUN, [0.0; 3]));
        seen.cuboid(low, high, true, &dark(1.5));
        let mut lit = Build::new(v(0., -0.1, 0.17), v(0., 0., 0.), 0.4, 16);
        lit.floor(v(0., 0., 0.), 0.5, &matte(ALBEDO));
        lit.cuboid(low, high, true, &dark(1.5));
        lit.sun(v(angle.sin(), 0., -angle.cos()), SUN);
        let through = slab(angle, 1.5, 0.05);
        let glow = std::array::from_fn(|i| wide(SUN)[i] * through[i]);
        for who in everyone() {
            let shot = render(who, &seen.0, "LS*E", 512);
            shot.claim(&format!("slab {degrees}°, seen"), shot.layer(Layer::Emission), glow, 0.02);
        }
        let sun = std::array::from_fn(|i| wide(ALBEDO)[i] / PI * wide(SUN)[i] * angle.cos() * through[i]);
        for who in mappers() {
            let shot = render(who, &lit.0, "LS+DE", 48);
            shot.claim(&format!("slab {degrees}°, lit"), shot.layer(Layer::Caustic), sun, 0.03);
        }
    }
}

/// [A16] Camera, floor and lamp in one absorbing water: I cosθ/d² exp(−σ d) arrives, exp(−σ l) of what leaves is seen.
#[test]
fn camera_floor_and_lamp_lie_in_the_same_water() {
    let mut b = Build::new(v(0., -0.1, 0.1), v(0., 0., 0.), 0.01, 8);
    b.floor(v(0., 0., 0.), 0.5, &matte(ALBEDO));
    // open: its inside is below it
    b.floor(v(0., 0., 0.3), 0.5, &dark(1.0));
    b.point(v(0.1, 0., 0.2), SUN);
    let distance = 0.05f64.sqrt();
    let (arrives, seen) = (left(distance), left(0.02f64.sqrt()));
    let want = std::array::from_fn(|i| {
        wide(ALBEDO)[i] / PI * wide(SUN)[i] * 0.2 / distance.powi(3) * arrives[i] * seen[i]
    });
    for who in everyone() {
        let shot = render(who, &b.0, "LDE", 8);
        // the floor that is seen is 3e-3 wide
        shot.claim("under water", shot.layer(Layer::Direct), want, 0.003);
    }
}

/// [A16] A lamp in a block that bends nothing: I cosθ/d² exp(−σ l), l of d in the block, on a floor below. A lamp with a face, seen by
/// a camera in the same block.
#[test]
fn jotons_start_inside() {
    let mut b = Build::new(v(0., -0.1, 0.1), v(0., 0., 0.), 0.1, 16);
    b.floor(v(0., 0., 0.), 0.5, &matte(ALBEDO));
    b.cuboid(v(-0.5, -0.5, 0.3), v(0.5, 0.5, 0.6), true, &dark(1.0));
    b.point(v(0., 0., 0.4), SUN);
    let l = left(0.1);
    let want = std::array::from_fn(|i| wide(ALBEDO)[i] / PI * wide(SUN)[i] / 0.16 * l[i]);
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 48);
        // to the rim of what is seen: 1/d² falls by 1 %
        shot.claim("a lamp in a block", shot.layer(Layer::Caustic), want, 0.03);
    }
    let mut b = Build::new(v(0., 0., 0.4), v(0., 0., 0.), 0.01, 8);
    b.floor(v(0., 0., 0.1), 0.1, &glowing(SUN, [0.0; 3]));
    b.cuboid(v(-0.5, -0.5, 0.), v(0.5, 0.5, 0.6), true, &dark(1.5));
    let want = std::array::from_fn(|i| wide(SUN)[i] * left(0.3)[i]);
    for who in everyone() {
        let shot = render(who, &b.0, EVERYTHING, 8);
        shot.claim("a face in the same block", shot.layer(Layer::Emission), want, 0.001);
    }
}

/// A body of this index and priority.
fn ranked(ior: f32, priority: i64, absorption: [f32; 3]) -> Material {
    Material { interior: Interior { absorption, priority: Some(priority) }, ..clear(ior) }
}

/// What a pile of layers transmits at an angle in the air above and below it: all ways
/// to and fro, added up layer by layer from the last.
fn pile(angle: f64, layers: &[Layered]) -> Values {
    let sine = angle.sin();
    let face = |a: f64, b: f64| reflectance((sine / a).asin(), b / a);
    std::array::from_fn(|k| {
        let mut below = 1.0;
        // of all that lies below: what it transmits, and what it reflects upward
        let (mut transmits, mut reflects) = (1.0, 0.0);
        for &(index, left) in layers.iter().rev().chain([&(1.0, [1.0; 3])]) {
            let r = face(index, below);
            let many = 1.0 / (1.0 - r * reflects);
            (transmits, reflects) = ((1.0 - r) * transmits * many, r + (1.0 - r).powi(2) * reflects * many);
            let slant = 1.0 / (1.0 - (sine / index).powi(2)).sqrt();
            let a = left[k].powf(slant);
            (transmits, reflects, below) = (transmits * a, reflects * a * a, index);
        }
        transmits
    })
}

/// From z to z, of a material.
type Slab = ([f64; 2], Material);
/// Index of a layer, and what is left of light across it.
type Layered = (f64, Values);

/// Boxes over a glowing floor.
fn boxes(from: glam::DVec3, target: glam::DVec3, all: &[Slab]) -> Build {
    let mut b = Build::new(from, target, 0.002, 8);
    b.floor(v(0., 0., -0.2), 8., &glowing([1.0; 3], [0.0; 3]));
    for (i, ([low, high], material)) in all.iter().enumerate() {
        // sides of no two in one place
        let half = 2.0 + 0.01 * i as f64;
        b.cuboid(
            v(-half, -half, *low),
            v(half, half, *high),
            true,
            &Material { name: format!("{i}"), ..material.clone() },
        );
    }
    b
}

/// [A17] Wine on glass, a void in glass, glass in wine: overlapping and flush, the lower number counts wherever two are in one place,
/// and light does not know how they were modelled.
#[test]
fn the_lower_number_counts() {
    const RED: [f32; 3] = [0.5, 3.0, 9.0];
    const NONE: [f32; 3] = [0.0; 3];
    let left = |a: [f32; 3], length: f64| wide(a).map(|a| (-a * length).exp());
    let glass = |priority| ranked(1.5, priority, NONE);
    let wine = |priority| ranked(1.33, priority, RED);
    let (on_glass, under_glass) = ((1.33, left(RED, 0.1)), (1.5, [1.0; 3]));
    let cases: [(&str, Vec<Slab>, Vec<Layered>); 6] = [
        ("overlapping", vec![([0., 0.1], glass(1)), ([0.08, 0.2], wine(2))], vec![on_glass, under_glass]),
        ("flush", vec![([0., 0.1], glass(-3)), ([0.1, 0.2], wine(7))], vec![on_glass, under_glass]),
        (
            "flush, wine first",
            vec![([0.1, 0.2], wine(1)), ([0., 0.1], glass(2))],
            vec![on_glass, under_glass],
        ),
        ("wine counts", vec![([0., 0.12], glass(2)), ([0.1, 0.2], wine(1))], vec![on_glass, under_glass]),
        (
            "a void",
            vec![([0., 0.2], wine(1)), ([0.05, 0.15], ranked(1.0, 0, NONE))],
            vec![(1.33, left(RED, 0.05)), (1.0, [1.0; 3]), (1.33, left(RED, 0.05))],
        ),
        (
            "inner ones of the same number count",
            vec![([0., 0.2], wine(1)), ([0.05, 0.15], glass(1))],
            vec![(1.33, left(RED, 0.05)), (1.5, [1.0; 3]), (1.33, left(RED, 0.05))],
        ),
    ];
    let angle = 50f64.to_radians();
    let from = v(angle.sin(), 0., angle.cos()) * 0.5 + v(0., 0., 0.2);
    for (name, bodies, layers) in cases {
        let b = boxes(from, v(0., 0., 0.2), &bodies);
        for who in everyone() {
            let shot = render(who, &b.0, "LS*E", 128);
            shot.claim(name, shot.layer(Layer::Emission), pile(angle, &layers), 0.03);
        }
    }
}

/// [A17] From wine into glass beyond the angle at which air between them would reflect all: (1−R) (n/n')² of a lamp in the glass. The
/// camera, and the lamp, are found to be where they are.
#[test]
fn no_air_is_between_bodies_that_touch() {
    const RED: [f32; 3] = [0.5, 3.0, 9.0];
    let angle = 60f64.to_radians();
    let inside = (1.33 / 1.5 * angle.sin()).asin();
    let target = v(0., 0., 0.1);
    let from = target + v(angle.sin(), 0., angle.cos()) * 0.1;
    // where the sight meets a lamp 5 cm below the glass's face
    let lamp = target - v(0.05 * inside.tan(), 0., 0.05);
    let through = 1.0 - reflectance(angle, 1.5 / 1.33);
    let want = wide(RED).map(|a| through * (1.33f64 / 1.5).powi(2) * (-a * 0.1).exp());
    for (name, low) in [("flush", 0.1), ("overlapping", 0.09)] {
        let bodies = [([0., 0.1], ranked(1.5, 1, [0.0; 3])), ([low, 0.2], ranked(1.33, 2, RED))];
        let mut b = boxes(from, target, &bodies);
        b.0.materials.iter_mut().filter(|m| m.name == "glowing").for_each(|m| m.emission = [0.0; 3]);
        b.floor(lamp, 0.02, &glowing([1.0; 3], [0.0; 3]));
        for who in everyone() {
            let shot = render(who, &b.0, "LS*E", 64);
            shot.claim(name, shot.layer(Layer::Emission), want, 0.01);
        }
    }
}

/// [E44] By wavelength white light has its stated spectrum, or where red, green and blue are stated the colour e^(−σ/σ_max) after 1/σ_max.
#[test]
fn absorption_is_by_wavelength() {
    const LENGTH: f64 = 1.0 / 12.0;
    let steep = |lambda: f64| 1.0 + 24.0 * ((lambda - 400.0) / 300.0).clamp(0.0, 1.0);
    let lambdas: Vec<f64> = (0..95).map(|i| 360.0 + 5.0 * f64::from(i)).collect();
    let left = lambdas.iter().map(|l| (-steep(*l) * LENGTH).exp()).collect();
    let of_table = Spectrum::reflectance_table(lambdas, left).expect("a table").reflectance_to_rgb();
    let shares = Spectrum::reflectance_table(vec![400.0, 700.0], vec![1.0 / 25.0, 1.0]).expect("a table");
    let spectra = MaterialSpectra { absorption: Some(shares.scaled(25.0)), ..MaterialSpectra::default() };
    let tabulated = Material { spectra: Some(Arc::new(spectra)), ..dark(1.0) };
    for (name, material, want) in [("colour", dark(1.0), self::left(LENGTH)), ("table", tabulated, of_table)]
    {
        let mut b = boxes(v(0., 0., 0.5), v(0., 0., 0.), &[([0., LENGTH], material)]);
        b.0.wavelengths.are_rendered = true;
        for who in everyone() {
            let shot = render(who, &b.0, "LS*E", 256);
            // in every pass the light is that of three wavelengths
            shot.claim(name, shot.layer(Layer::Emission), want, 0.02);
        }
    }
}
