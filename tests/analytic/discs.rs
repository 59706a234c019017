//! Small things lit through glass: a disc of the caustic map holds what there is of a surface, and nothing from behind walls.

use crate::build::{Build, clear, matte, v};
use crate::harness::{EVERYTHING, mappers, render};
use joton::film::Layer;
use std::f64::consts::PI;

const ALBEDO: f32 = 0.7;
/// Height of posts.
const TOP: f64 = 0.2;

/// Strips of 2, 5, 10 and 30 cm under a sun through a slab that is all but air: across each there is the light that falls on it,
/// ρ/π E w, though the narrow ones are narrower than a disc.
#[test]
fn strips_have_the_light_that_falls_on_them() {
    const LENGTH: f64 = 0.9;
    let (distance, tan) = (1.5, 0.364);
    let mut b = Build::new(v(0., 0., distance), v(0., 0., 0.), tan, 96);
    // middle, width, and what may be off after 24 passes
    let strips = [(-0.42, 0.02, 0.05), (-0.25, 0.05, 0.03), (-0.05, 0.1, 0.02), (0.3, 0.3, 0.01)];
    for (middle, width, _) in strips {
        let corner = v(middle - width / 2.0, -LENGTH / 2.0, 0.);
        b.quad(corner, v(width, 0., 0.), v(0., LENGTH, 0.), &matte([ALBEDO; 3]));
    }
    b.cuboid(v(-1., -1., 2.), v(1., 1., 2.05), true, &clear(1.0001));
    b.sun(v(0., 0., -1.), [1.0; 3]);
    let half = distance * tan;
    let pixel = (2.0 * half / 96.0).powi(2);
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 24);
        for (middle, width, tolerance) in strips {
            let near = |x: f64| (half * (2.0 * x - 1.0) - middle).abs() < width / 2.0 + 0.05;
            let weight = |x: f64, _| if near(x) { pixel / (width * LENGTH) } else { 0.0 };
            let seen = shot.weighed(&[Layer::Caustic], weight);
            shot.claim(&format!("strip of {width}"), seen, [f64::from(ALBEDO) / PI; 3], tolerance);
        }
    }
}

/// [A6] Posts of 10 and 3 cm under a glass roof: the light on their tops is that of a wide floor there, ρ/π (1−R)/(1+R), and does not
/// reach beyond their edges.
#[test]
fn small_tops_are_as_bright_as_wide_ones() {
    let (height, tan) = (0.95, 0.2134);
    let mut b = Build::new(v(0., 0., height), v(0., 0., 0.), tan, 64);
    b.floor(v(0., 0., 0.), 0.5, &matte([ALBEDO; 3]));
    // middle, width, and what may be off after 20 passes
    let posts = [(0.08, 0.1, 0.02), (-0.08, 0.03, 0.05)];
    for (x, width, _) in posts {
        let half = width / 2.0;
        b.cuboid(v(x - half, -half, 0.001), v(x + half, half, TOP), true, &matte([ALBEDO; 3]));
    }
    b.cuboid(v(-0.25, -0.25, 1.0), v(0.25, 0.25, 1.02), true, &clear(1.5));
    b.sun(v(0., 0., -1.), [1.0; 3]);
    let half = (height - TOP) * tan;
    let pixel = 2.0 * half / 64.0;
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 20);
        for (middle, width, tolerance) in posts {
            // pixels that see nothing but the top
            let reach = (width - pixel) / 2.0;
            let inside = |x: f64, y: f64| {
                (half * (2.0 * x - 1.0) - middle).abs() < reach && (half * (2.0 * y - 1.0)).abs() < reach
            };
            let seen = shot.mean(&[Layer::Caustic], inside);
            let want = f64::from(ALBEDO) / PI * 0.96 / 1.04;
            shot.claim(&format!("top of {width}"), seen, [want; 3], tolerance);
        }
    }
}

/// The top of a post of 3 cm fills the image, under a glass roof of 6 m through which one joton in forty thousand would come there: it
/// is learned where they must start [E20].
#[test]
fn jotons_find_a_close_up_under_a_wide_roof() {
    let (half, tan) = (0.015, 0.02);
    let x = 0.7;
    let mut b = Build::new(v(x, 0., TOP + 0.7), v(x, 0., TOP), tan, 32);
    b.floor(v(0., 0., 0.), 3.0, &matte([ALBEDO; 3]));
    b.cuboid(v(x - half, -half, 0.001), v(x + half, half, TOP), true, &matte([ALBEDO; 3]));
    b.cuboid(v(-3., -3., 1.), v(3., 3., 1.02), true, &clear(1.5));
    b.sun(v(0., 0., -1.), [1.0; 3]);
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE", 16);
        let want = f64::from(ALBEDO) / PI * 0.96 / 1.04;
        shot.claim("close-up", shot.mean(&[Layer::Caustic], |_, _| true), [want; 3], 0.02);
    }
}

/// A closed box of thin walls stands on a floor that is lit through glass. Inside it is dark, at whichever surface of a path the
/// caustic map is asked: exactly, since no disc reaches below the walls.
#[test]
fn no_caustic_light_passes_below_walls() {
    let mut b = Build::new(v(0., -0.15, 0.2), v(0., 0.2, 0.1), 1.2, 16);
    b.floor(v(0., 0., 0.), 1.0, &matte([ALBEDO; 3]));
    let (low, high) = (v(-0.2, -0.2, 0.), v(0.2, 0.2, 0.3));
    let [x, y, z] = [v(0.4, 0., 0.), v(0., 0.4, 0.), v(0., 0., 0.3)];
    for (corner, along) in [(low, x), (low, y), (high - z, -x), (high - z, -y)] {
        b.quad(corner, along, z, &matte([0.9; 3]));
    }
    b.ceiling(v(0., 0., 0.3), 0.2, &matte([0.9; 3]));
    b.cuboid(v(-0.5, -0.5, 0.5), v(0.5, 0.5, 0.55), true, &clear(1.5));
    b.sun(v(0., 0., -1.), [1.0; 3]);
    for who in mappers() {
        let shot = render(who, &b.0, EVERYTHING, 16);
        shot.claim("in a dark box", shot.mean(&Layer::ALL, |_, _| true), [0.0; 3], 0.0);
    }
}

/// Part of what a point of a plane sees that lies in a corner of a parallel rectangle, from the point's foot to (x, y), in units of the
/// distance; odd in both.
fn corner_factor(x: f64, y: f64) -> f64 {
    let part = |a: f64, b: f64| a / (1.0 + a * a).sqrt() * (b / (1.0 + a * a).sqrt()).atan();
    (part(x, y) + part(y, x)) / (2.0 * PI)
}

/// Strips that are lit through a slab light a plate above them by ρ² E F/π, F the part of what the plate sees that they fill: paths
/// that go on from the plate find the caustic light on strips, which are as narrow as their discs.
#[test]
fn later_surfaces_of_a_path_have_their_light() {
    const SIZE: u32 = 16;
    let (half_width, half_length, height, tan) = (0.01, 0.5, 0.3, 0.2);
    // the shadow of the plate falls beside them
    let middles = [-0.4, -0.32, -0.24, -0.16, -0.08, 0.0];
    let (eye, target) = (v(0.15, 0., 0.1), v(0., 0., height));
    let mut b = Build::new(eye, target, tan, SIZE);
    let (width, length) = (v(2.0 * half_width, 0., 0.), v(0., 2.0 * half_length, 0.));
    for middle in middles {
        b.quad(v(middle - half_width, -half_length, 0.), width, length, &matte([ALBEDO; 3]));
    }
    b.ceiling(target, 0.12, &matte([ALBEDO; 3]));
    b.cuboid(v(-1.2, -0.7, 1.), v(-0.3, 0.7, 1.05), true, &clear(1.0001));
    let sun = v(0.6, 0., -0.8);
    b.sun(sun, [1.0; 3]);

    let along = (target - eye).normalize();
    let right = along.cross(v(0., 0., 1.)).normalize();
    let up = right.cross(along);
    // fine enough: the factor hardly changes across a pixel
    let factors = (0..SIZE * SIZE).map(|i| {
        let [x, y] = [i % SIZE, i / SIZE].map(|k| (2.0 * (f64::from(k) + 0.5) / f64::from(SIZE) - 1.0) * tan);
        let way = along + right * x - up * y;
        let at = eye + way * ((height - eye.z) / way.z);
        let corner = |x: f64, y: f64| corner_factor((x - at.x) / height, (y - at.y) / height);
        let strip = |middle: f64| {
            let [left, right] = [middle - half_width, middle + half_width];
            corner(right, half_length) - corner(left, half_length) - corner(right, -half_length)
                + corner(left, -half_length)
        };
        middles.iter().map(|middle| strip(*middle)).sum::<f64>()
    });
    let mean = factors.sum::<f64>() / f64::from(SIZE * SIZE);
    let want = f64::from(ALBEDO).powi(2) / PI * -sun.z * mean;
    for who in mappers() {
        let shot = render(who, &b.0, "LS+DE|LS+DDE", 96);
        // noise of paths that seldom meet a strip
        shot.claim("plate over strips", shot.mean(&Layer::ALL, |_, _| true), [want; 3], 0.05);
    }
}
