//! Caustics of mirrors: where light arrives, and how much.

use crate::build::{Build, icosphere, matte, mirror, v, wide};
use crate::harness::{Seen, Shot, Values, mappers, render};
use joton::film::Layer;
use std::f64::consts::{PI, TAU};

const ALBEDO: f32 = 0.5;
const MIRROR: [f32; 3] = [1.0, 0.5, 0.25];

/// Flux on a plate that the camera faces at `distance`, within `radius` of the middle of the image.
fn flux(shot: &Shot, distance: f64, tan_half_fov: f64, radius: f64) -> Seen {
    let half = distance * tan_half_fov;
    let pixel = (2.0 * half / f64::from(shot.size[0])).powi(2);
    shot.weighed(&[Layer::Caustic], |x, y| {
        let from_middle = half * (2.0 * x - 1.0).hypot(2.0 * y - 1.0);
        if from_middle < radius { PI / f64::from(ALBEDO) * pixel } else { 0.0 }
    })
}

/// The mirror's reflectance times `x`.
fn mirrored(x: f64) -> Values {
    wide(MIRROR).map(|m| m * x)
}

/// [A9] A point over a mirror lights a wall like its image below the mirror: I cosθ/d².
#[test]
fn mirror_image_of_a_point_lights_a_wall() {
    let (distance, tan) = (0.9, 0.3);
    let mut b = Build::new(v(-0.3, 0., 0.5), v(0.6, 0., 0.5), tan, 16);
    b.floor(v(0., 0., 0.), 0.5, &mirror(MIRROR));
    b.quad(v(0.6, 1., 0.), v(0., -2., 0.), v(0., 0., 1.2), &matte([ALBEDO; 3]));
    b.point(v(-0.4, 0., 0.5), [1.0; 3]);
    let image = v(-0.4, 0., -0.5);
    let half = distance * tan;
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 32);
        // quarters of the image
        for i in 0..4u32 {
            let at = |k: u32, n: u32| (f64::from(k) + 0.5) / f64::from(n);
            let inside = |x: f64, y: f64| (u32::from(x > 0.5), u32::from(y > 0.5)) == (i % 2, i / 2);
            let points: Vec<f64> = (0..64 * 64)
                .map(|k| (at(k % 64, 64), at(k / 64, 64)))
                .filter(|&(x, y)| inside(x, y))
                .map(|(x, y)| {
                    let d = v(0.6, -half * (2.0 * x - 1.0), 0.5 + half * (1.0 - 2.0 * y)) - image;
                    d.x / d.length().powi(3)
                })
                .collect();
            let mean = points.iter().sum::<f64>() / points.len() as f64;
            let want = mirrored(f64::from(ALBEDO) / PI * mean);
            // noise of some 10,000 jotons in a quarter
            shot.claim(&format!("wall, quarter {i}"), shot.mean(&[Layer::Caustic], inside), want, 0.03);
        }
    }
}

/// A dish z = r²/4f that opens upward, of rings and segments with smooth normals; its area across the axis.
fn dish(b: &mut Build, focus: f64, radius: f64) -> f64 {
    let (rings, segments) = (20, 96);
    let at = |ring: u32, segment: u32| {
        let r = radius * f64::from(ring) / f64::from(rings);
        let (sin, cos) = (TAU * f64::from(segment) / f64::from(segments)).sin_cos();
        let slope = r / (2.0 * focus);
        (v(r * cos, r * sin, r * r / (4.0 * focus)), v(-slope * cos, -slope * sin, 1.0))
    };
    for ring in 0..rings {
        for s in 0..segments {
            let corners = [at(ring, s), at(ring + 1, s), at(ring + 1, s + 1), at(ring, s + 1)];
            for [i, j, k] in [[0, 1, 2], [0, 2, 3]] {
                let c = [corners[i], corners[j], corners[k]];
                if c[0].0 != c[2].0 {
                    b.smooth(c.map(|c| c.0), Some(c.map(|c| c.1)), &mirror(MIRROR));
                }
            }
        }
    }
    f64::from(segments) / 2.0 * radius * radius * (TAU / f64::from(segments)).sin()
}

/// [A10] A parabolic dish in the sun: below the focus, what fell within r lies within s(r). In focus itself the spot is
/// smaller than a pixel, and what the image holds of it is up to the jitter.
#[test]
fn parabolic_dish_has_its_focus() {
    let (focus, radius, half) = (0.5, 0.5, 0.15);
    let (irradiance, tan) = (2.0, 0.4);
    for height in [0.97 * focus, 0.9 * focus] {
        let distance = height - 0.2;
        let mut b = Build::new(v(0., 0., 0.2), v(0., 0., height), tan, 48);
        let area = dish(&mut b, focus, radius);
        b.ceiling(v(0., 0., height), half, &matte([ALBEDO; 3]));
        b.sun(v(0., 0., -1.), [irradiance as f32; 3]);
        // the plate's own shadow is missing
        let shadow = 4.0 * half * half;
        for who in mappers() {
            let shot = render(who, &b.0, "LS+DE", 64);
            let all = flux(&shot, distance, tan, f64::INFINITY);
            // noise, and what the fit of facets with smooth normals loses
            shot.claim("dish, all light", all, mirrored(irradiance * (area - shadow)), 0.02);
            // all of it inside the rim's circle, half a pixel more
            let s = |r: f64| r * (focus - height) / (focus - r * r / (4.0 * focus));
            let pixel = 2.0 * distance * tan / 48.0;
            let rim = flux(&shot, distance, tan, s(radius) + 2.0 * pixel);
            shot.claim("dish, within the rim's circle", rim, mirrored(irradiance * (area - shadow)), 0.03);
            if s(radius) > 10.0 * pixel {
                // pixels and the gather radius blur the circle
                let r = 0.35;
                let want = mirrored(irradiance * (PI * r * r - shadow));
                shot.claim("dish, within s(r)", flux(&shot, distance, tan, s(r)), want, 0.04);
            }
        }
    }
}

/// [A11] From focus to focus of an ellipsoid: the front of a plate in the second one gets 2πI (1 + 2c/(a + ec)).
#[test]
fn ellipsoid_mirror_carries_light_from_focus_to_focus() {
    let (a, e): (f64, f64) = (1.0, 0.5);
    let (c, stretch) = (a * e, v(a, a * (1.0 - e * e).sqrt(), a * (1.0 - e * e).sqrt()));
    let (distance, tan) = (0.4, 0.8);
    let mut b = Build::new(v(c - distance, 0., 0.), v(c, 0., 0.), tan, 48);
    for t in icosphere(4) {
        // flat facets: the image of the point is as wide as two of them, and many pixels see it
        b.triangle(t.map(|p| p * stretch), &mirror(MIRROR));
    }
    b.quad(v(c, 0.3, -0.3), v(0., -0.6, 0.), v(0., 0., 0.6), &matte([ALBEDO; 3]));
    b.point(v(-c, 0., 0.), [1.0; 3]);
    let want = mirrored(TAU * (1.0 + 2.0 * c / (a + e * c)));
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 16);
        shot.claim("ellipsoid, plate", flux(&shot, distance, tan, f64::INFINITY), want, 0.03);
        shot.claim("ellipsoid, focus", flux(&shot, distance, tan, 0.15), want, 0.05);
    }
}

/// The column, of `size` about `middle`, in which most of a sun's rays meet the two rows of pixels beside the axis of a
/// cylinder mirror: R = 1, 0.6 high, 40° to each side.
fn brightest_on_the_axis(low: f64, middle: f64, pixel: f64, size: u32) -> u32 {
    const RAYS: u32 = 2000;
    let step = |i: u32| (f64::from(i) + 0.5) / f64::from(RAYS);
    let mut columns = vec![0.0; size as usize];
    for i in 0..RAYS {
        let alpha = 40f64.to_radians() * (2.0 * step(i) - 1.0);
        for run in (0..RAYS).map(|j| 0.6 * step(j) / low.tan()) {
            let x = alpha.cos() - run * (2.0 * alpha).cos();
            let y = alpha.sin() - run * (2.0 * alpha).sin();
            let column = (x - middle) / pixel + 0.5 * f64::from(size);
            if y.abs() < pixel && (0.0..f64::from(size)).contains(&column) {
                columns[column as usize] += alpha.cos();
            }
        }
    }
    (0..size).max_by(|&i, &j| columns[i as usize].total_cmp(&columns[j as usize])).expect("columns")
}

/// [A12] A cylinder mirror in a low sun draws its nephroid on the floor: on the axis ρE sinφ/|1 − 2s/R| at the distance s
/// from the wall, and the cusp at R/2, where branches run away from the axis so steeply that the brightest pixels lie behind it.
#[test]
fn cylinder_mirror_draws_its_nephroid() {
    let (low, irradiance) = (30f64.to_radians(), 2.0);
    let scene = |x: f64, tan: f64, size: u32| {
        let mut b = Build::new(v(x, 0., 1.), v(x, 0., 0.), tan, size);
        // no wider than 40°: on the axis in front of 0.65 R and behind R/2 only one ray arrives
        let (segments, half) = (160u32, 40f64.to_radians());
        let at = |i: u32| {
            let alpha = half * (2.0 * f64::from(i) / f64::from(segments) - 1.0);
            v(alpha.cos(), alpha.sin(), 0.)
        };
        let up = v(0., 0., 0.6);
        for i in 0..segments {
            let (p, q) = (at(i), at(i + 1));
            b.smooth([q, p, p + up], Some([-q, -p, -p]), &mirror(MIRROR));
            b.smooth([q, p + up, q + up], Some([-q, -p, -q]), &mirror(MIRROR));
        }
        b.floor(v(0.45, 0., 0.), 0.54, &matte([ALBEDO; 3]));
        b.sun(v(low.cos(), 0., -low.sin()), [irradiance as f32; 3]);
        b.0
    };
    for who in mappers() {
        for x in [0.75, 0.3] {
            let shot = render(who, &scene(x, 0.05, 16), "LS+DE", 64);
            let factor = low.sin() / (1.0 - 2.0 * (1.0 - x)).abs();
            let want = mirrored(f64::from(ALBEDO) / PI * irradiance * factor);
            // noise of some 5,000 jotons; the field is 0.1 wide, over which the factor bends by 1 %
            shot.claim(&format!("nephroid at {x}"), shot.layer(Layer::Caustic), want, 0.06);
        }
        // all that the mirror takes; less what falls beside the floor through the rims of discs
        let shot = render(who, &scene(0.45, 0.54, 48), "LS+DE", 16);
        let taken = low.cos() * 0.6 * 2.0 * 40f64.to_radians().sin() * irradiance;
        shot.claim("nephroid, all light", flux(&shot, 1.0, 0.54, f64::INFINITY), mirrored(taken), 0.02);
        let size = 48;
        let shot = render(who, &scene(0.5, 0.4, size), "LS+DE", 16);
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(size);
        let column = |i: u32| {
            let axis = |x: f64, y: f64| (x - at(i)).abs() < 1e-6 && (y - 0.5).abs() < 1.5 / f64::from(size);
            shot.mean(&[Layer::Caustic], axis).mean[0]
        };
        let brightest = (0..size).max_by(|&i, &j| column(i).total_cmp(&column(j))).expect("columns");
        let expected = brightest_on_the_axis(low, 0.5, 0.8 / f64::from(size), size);
        println!("brightest column {brightest}, expected {expected}");
        // a pixel: the gather radius
        assert!(brightest.abs_diff(expected) <= 1, "{who:?}: column {brightest}, not {expected}");
    }
}
