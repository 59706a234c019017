//! Irradiance of a floor straight from its lights: shadow rays.

use crate::build::{Build, Look, black, glowing, matte, v, wide};
use crate::factors::lambert;
use crate::harness::{Renderer, Values, everyone, render};
use glam::DVec3;
use joton::film::Layer;
use joton::scene::Light;
use std::f64::consts::PI;

const ALBEDO: [f32; 3] = [0.8, 0.5, 0.2];
const STRENGTH: [f32; 3] = [1.0, 2.0, 3.0];

/// A small floor about the origin, of which a narrow view from the side sees a spot 0.01 wide: the irradiance of a point.
fn floor(half: f64) -> Build {
    let mut b = Build::new(v(0., -0.5, 0.5), v(0., 0., 0.), 0.007, 8);
    b.floor(v(0., 0., 0.), half, &matte(ALBEDO));
    b
}

/// Claim that the floor's direct light is that of `irradiance` for a strength of 1.
fn claim(what: &str, b: &Build, irradiance: f64, passes: u64, tolerance: impl Fn(Renderer) -> f64) {
    for who in everyone() {
        let shot = render(who, &b.0, "LDE", passes);
        let want: Values = std::array::from_fn(|i| wide(ALBEDO)[i] / PI * irradiance * wide(STRENGTH)[i]);
        shot.claim(what, shot.layer(Layer::Direct), want, tolerance(who));
    }
}

/// Rounding of f32 in the chain from camera to light, and the spot that stands for a point.
fn exact(_: Renderer) -> f64 {
    2e-4
}

/// [A3] Irradiance under a square light, aslant, and one that is half below the horizon.
#[test]
fn polygon_light_gives_lamberts_irradiance() {
    let cases = [
        ("overhead", 0.01, v(-0.3, 0.2, 1.0), v(0., 0.7, 0.), v(0.9, 0., 0.)),
        ("aslant", 0.01, v(0.8, -0.5, 0.6), v(0., 1.0, 0.), v(-0.4, 0., 0.6)),
        ("across the horizon", 0.02, v(0.8, -0.4, -0.5), v(0., 0.9, 0.), v(0., 0., 0.9)),
    ];
    for (name, tolerance, corner, u, w) in cases {
        let mut b = floor(0.1);
        // the front must look at the origin
        let (u, w) = if u.cross(w).dot(corner + (u + w) / 2.0) < 0.0 { (u, w) } else { (w, u) };
        b.quad(corner, u, w, &glowing(STRENGTH, [0.0; 3]));
        let irradiance = lambert(&[corner, corner + u, corner + u + w, corner + w], DVec3::Z);
        // noise of 16,384 shadow rays to two triangles
        claim(name, &b, irradiance, 256, |_| tolerance);
    }
}

/// [A4] Irradiance under a glowing ball: πL (R/d)² cosθ.
#[test]
fn sphere_light_gives_its_irradiance() {
    let (centre, radius) = (v(0.5, 0.3, 0.9), 0.3);
    let mut b = floor(0.1);
    b.sphere(centre, radius, 2, Look::Outward, &glowing(STRENGTH, [0.0; 3]));
    let d = centre.length();
    let irradiance = PI * (radius / d).powi(2) * centre.z / d;
    // half of the facets that are picked look away: the noise of 65,536 shadow rays is still 0.6 %
    claim("ball", &b, irradiance, 1024, |_| 0.02);
}

/// [A5] Irradiance under a point: I cosθ/d²; none where the point is below the floor.
#[test]
fn point_light_falls_with_cosine_and_distance() {
    for p in [v(0., 0., 1.), v(1.0, 0.5, 0.7), v(2.0, 0., 0.1)] {
        let mut b = floor(0.1);
        b.point(p, STRENGTH);
        claim("point", &b, p.z / p.length().powi(3), 8, |_| 2e-3);
        let mut b = floor(0.1);
        b.point(v(p.x, p.y, -p.z), STRENGTH);
        claim("point below the horizon", &b, 0.0, 8, |_| 0.0);
    }
}

/// [A5] A spot: full inside the inner cone, half where the cosine is in the middle of the ring, 5/32 at its quarter,
/// none outside.
#[test]
fn spot_light_falls_off_in_its_ring() {
    let (inner, outer) = (0.9, 0.7);
    let position = v(0.6, 0.4, 1.0);
    let to_floor = -position.normalize();
    let sideways = to_floor.cross(DVec3::Z).normalize();
    for (cosine, share) in [(1.0, 1.0), (0.92, 1.0), (0.8, 0.5), (0.75, 5.0 / 32.0), (0.68, 0.0)] {
        let angle = f64::acos(cosine);
        let mut b = floor(0.1);
        b.light(Light::Spot {
            position,
            direction: to_floor * angle.cos() + sideways * angle.sin(),
            intensity: STRENGTH,
            angle_inner: f64::acos(inner),
            angle_outer: f64::acos(outer),
        });
        let irradiance = share * position.z / position.length().powi(3);
        // the ring is steep: a spot 0.01 wide is not quite a point
        claim("spot", &b, irradiance, 8, |_| 2e-3);
    }
}

/// [A5] The sun: E cosθ, nothing from below, nothing behind a black roof.
#[test]
fn sun_falls_with_its_cosine() {
    for degrees in [0f64, 45.0, 80.0, 89.0] {
        let angle = degrees.to_radians();
        let mut b = floor(0.1);
        b.sun(v(angle.sin(), 0., -angle.cos()), STRENGTH);
        claim("sun", &b, angle.cos(), 8, exact);
    }
    let mut b = floor(0.1);
    b.sun(v(0.3, 0., 1.), STRENGTH);
    claim("sun below the horizon", &b, 0.0, 8, |_| 0.0);
    let mut b = floor(0.1);
    b.sun(v(0.3, 0., -1.), STRENGTH);
    b.floor(v(0., 0., 0.8), 1.0, &black());
    claim("sun behind a roof", &b, 0.0, 8, |_| 0.0);
}
