//! Closed rooms where every ray brings the same light.

use crate::build::{Build, Look, clear, glowing, matte, mirror, v, wide};
use crate::harness::{EVERYTHING, everyone_both_ways, mappers, render_keeping};
use joton::film::Layer;
use joton::plan::Part;
use std::f64::consts::PI;

/// [A1] A closed box of radiance E/(1−ρ): E seen, ρE direct, the rest interreflected, in bands that differ.
#[test]
fn closed_box_has_the_radiance_of_a_furnace() {
    // the noise of so many passes, each of which traces 100 events for a joton where the albedo is 0.99
    for (albedo, emission, passes, tolerance) in [
        ([0.0, 0.5, 0.9], [0.2, 0.5, 1.0], 64, 0.01),
        ([0.8; 3], [0.1, 0.2, 0.3], 64, 0.015),
        ([0.99, 0.9, 0.3], [0.02, 0.03, 0.04], 16, 0.025),
    ] {
        let mut b = Build::new(v(0.2, 0.1, -0.3), v(1., 0.3, 0.1), 1.0, 16);
        b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &glowing(emission, albedo));
        for (who, keep) in everyone_both_ways(&b.0) {
            let shot = render_keeping(who, &b.0, EVERYTHING, passes, keep);
            let want =
                |f: &dyn Fn(f64, f64) -> f64| std::array::from_fn(|i| f(wide(emission)[i], wide(albedo)[i]));
            shot.claim("furnace, emission", shot.layer(Layer::Emission), want(&|e, _| e), 1e-6);
            shot.claim("furnace, direct", shot.layer(Layer::Direct), want(&|e, a| e * a), tolerance);
            let rest = want(&|e, a| e * a * a / (1.0 - a));
            shot.claim("furnace, diffuse", shot.layer(Layer::Diffuse), rest, tolerance);
        }
    }
}

/// [A1] A glass ball and a mirror ball in a furnace cannot be seen: every block of the image has the radiance E/(1−ρ).
#[test]
fn glass_and_mirror_disappear_in_a_furnace() {
    // flat facets of glass reflect light inside for hundreds of events
    let [paths, map]: [&[Part]; 2] = [&[], &[Part::DiffuseMap]];
    for (name, look, ball, keep) in [
        ("glass", Look::Outward, clear(1.5), paths),
        ("glass", Look::OutwardSmooth, clear(1.5), map),
        ("mirror", Look::Outward, mirror([1.0; 3]), map),
        ("mirror", Look::OutwardSmooth, mirror([1.0; 3]), paths),
    ] {
        let scene = |size| {
            let mut b = Build::new(v(0., 0.9, 0.), v(0., 0., 0.), 0.9, size);
            b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &glowing([0.5, 0.7, 0.8], [0.5, 0.3, 0.2]));
            b.sphere(v(0., 0., 0.), 0.45, 3, look, &ball);
            b
        };
        for who in mappers() {
            // eye paths meet caustics by discs of four pixels, which reach over edges: 2 % at 16 pixels, a fourth of it at 32
            let (size, passes) = if keep.is_empty() { (32, 16) } else { (16, 64) };
            let shot = render_keeping(who, &scene(size).0, EVERYTHING, passes, keep);
            let name = format!("{name} {look:?} in a furnace");
            for (what, layers, want) in [
                ("emission", &[Layer::Emission][..], [0.5, 0.7, 0.8]),
                ("first bounce", &[Layer::Direct, Layer::Caustic], [0.25, 0.21, 0.16]),
                ("diffuse", &[Layer::Diffuse], [0.25, 0.09, 0.04]),
            ] {
                let seen = shot.mean(layers, |_, _| true);
                shot.claim(&format!("{name}, {what}"), seen, want, 0.02);
            }
            // the noise of a block of 4 × 4 pixels
            for (i, block) in shot.blocks(4).into_iter().enumerate() {
                shot.claim(&format!("{name}, block {i}"), block, [1.0; 3], 0.05);
            }
        }
    }
}

/// [A2] A matte sphere with a point light in its centre: direct light ρI/(πr²), and ρ/(1−ρ) times as much interreflected.
#[test]
fn lit_sphere_has_the_radiance_of_its_closed_form() {
    let (albedo, intensity) = ([0.2, 0.5, 0.8], [1.0, 2.0, 3.0]);
    // off the centre: all of the sphere is alike
    let mut b = Build::new(v(0.1, 0.2, 0.3), v(1., 0.4, 0.2), 1.0, 16);
    b.sphere(v(0., 0., 0.), 1.0, 4, Look::Inward, &matte(albedo));
    b.point(v(0., 0., 0.), intensity);
    for (who, keep) in everyone_both_ways(&b.0) {
        let shot = render_keeping(who, &b.0, EVERYTHING, 64, keep);
        let direct: [f64; 3] = std::array::from_fn(|i| wide(albedo)[i] * wide(intensity)[i] / PI);
        let rest = std::array::from_fn(|i| direct[i] * wide(albedo)[i] / (1.0 - wide(albedo)[i]));
        // facets: cosine and distance of a point differ from the sphere's by up to 0.3 %
        shot.claim("sphere, direct", shot.layer(Layer::Direct), direct, 0.003);
        shot.claim("sphere, diffuse", shot.layer(Layer::Diffuse), rest, 0.015);
    }
}
