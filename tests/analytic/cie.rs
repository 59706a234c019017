//! The analytic test cases of CIE 171:2006, chapter 5, as far as they apply to this renderer; docs/EQUATIONS.md, "CIE
//! 171:2006", says which do. Not the report's tables but the closed forms they come from: some tables are known to be
//! wrong, and other sizes serve as well. A sky is a glowing plane behind the opening, so it is uniform.

use crate::build::{Build, black, clear, glowing, matte, reflectance, v, wide};
use crate::factors::{clip, lambert, mean_over_square};
use crate::harness::{EVERYTHING, Seen, Values, everyone, mappers, render};
use glam::DVec3;
use joton::film::Layer;
use std::f64::consts::PI;

const ALBEDO: [f32; 3] = [0.8, 0.5, 0.2];
const STRENGTH: [f32; 3] = [1.0, 2.0, 3.0];

/// Radiance of a surface of ALBEDO under an irradiance for a strength of 1.
fn radiance(irradiance: f64) -> Values {
    std::array::from_fn(|i| wide(ALBEDO)[i] / PI * irradiance * wide(STRENGTH)[i])
}

/// A roof at the height 1 with a square opening, all black.
fn roof(b: &mut Build, half: f64, opening: f64) {
    let side = half - opening;
    for (corner, across, along) in [
        (v(-half, -half, 1.), side, 2. * half),
        (v(opening, -half, 1.), side, 2. * half),
        (v(-opening, -half, 1.), 2. * opening, side),
        (v(-opening, opening, 1.), 2. * opening, side),
    ] {
        b.quad(corner, v(0., along, 0.), v(across, 0., 0.), &black());
    }
}

/// Corners of a horizontal square, as seen from a point.
fn opening_from(point: DVec3, half: f64) -> [DVec3; 4] {
    [v(-half, -half, 1.), v(half, -half, 1.), v(half, half, 1.), v(-half, half, 1.)].map(|p| p - point)
}

/// 5.4: what passes an opening arrives, and no more: the sun's beam lies half on the floor, half on the wall.
#[test]
fn luminous_flux_through_an_opening_is_conserved() {
    let (opening, tan) = (0.2, 0.5f64);
    let cosine = 1.0 / tan.hypot(1.0);
    let scene = |eye: DVec3, target: DVec3, tan_half: f64| {
        let mut b = Build::new(eye, target, tan_half, 48);
        b.floor(v(0., 0., 0.), 0.5, &matte(ALBEDO));
        b.quad(v(0.5, 0.5, 0.), v(0., -1., 0.), v(0., 0., 1.), &matte(ALBEDO));
        roof(&mut b, 1.5, opening);
        b.sun(v(tan, 0., -1.), STRENGTH);
        b.0
    };
    // both views are the whole of their surface, of area 1
    let floor = scene(v(0., 0., 0.9), v(0., 0., 0.), 0.5 / 0.9);
    let wall = scene(v(-0.4, 0., 0.5), v(0.5, 0., 0.5), 0.5 / 0.9);
    for who in everyone() {
        let [a, c] = [&floor, &wall].map(|scene| render(who, scene, "LDE", 32));
        let (on_floor, on_wall) = (a.layer(Layer::Direct), c.layer(Layer::Direct));
        let both = Seen {
            mean: std::array::from_fn(|b| on_floor.mean[b] + on_wall.mean[b]),
            error: std::array::from_fn(|b| on_floor.error[b].hypot(on_wall.error[b])),
        };
        // the beam's edges cross pixels: what their jitter adds
        a.claim("flux, half of it on the floor", on_floor, radiance(cosine * 2.0 * opening * opening), 0.01);
        a.claim("flux, on floor and wall", both, radiance(cosine * 4.0 * opening * opening), 0.005);
    }
}

/// Reflectance of the patch.
const PATCH: [f32; 3] = [0.9, 0.6, 0.3];
/// Half width and middle height of what is seen of the wall. Not its foot, where irradiance rises from nothing within a
/// gather radius: the diffuse map smooths it by 2 %.
const VIEW: (f64, f64) = (0.3, 0.65);

/// Light that falls straight down on a patch of floor, and a wall beside it that sees nothing but the patch, over an
/// obstruction or without: the camera sees the wall, a unit square at x = 0.
struct PatchAndWall {
    low: f64,
    high: f64,
    half: f64,
    /// Distance from the wall and height of a black panel.
    panel: Option<(f64, f64)>,
}

impl PatchAndWall {
    fn scene(&self) -> Build {
        let mut b = Build::new(v(0.95, 0., VIEW.1), v(0., 0., VIEW.1), VIEW.0 / 0.95, 16);
        b.quad(
            v(self.low, -self.half, 0.),
            v(self.high - self.low, 0., 0.),
            v(0., 2. * self.half, 0.),
            &matte(PATCH),
        );
        b.quad(v(0., -0.5, 0.), v(0., 1., 0.), v(0., 0., 1.), &matte(ALBEDO));
        if let Some((x, height)) = self.panel {
            b.quad(v(x, -1., 0.), v(0., 2., 0.), v(0., 0., height), &black());
        }
        b.sun(v(0., 0., -1.), STRENGTH);
        b
    }

    /// Irradiance of the wall at (y, z) under a patch of radiance 1.
    fn irradiance(&self, y: f64, z: f64) -> f64 {
        let eye = v(0., y, z);
        let corners = [(self.low, -1.), (self.high, -1.), (self.high, 1.), (self.low, 1.)];
        let patch = corners.map(|(x, side)| v(x, side * self.half, 0.) - eye);
        let Some((x, height)) = self.panel else { return lambert(&patch, DVec3::X) };
        // above the plane through the eye and the panel's upper edge
        let edge = v(x, 0., height - z);
        lambert(&clip(&patch, v(-edge.z, 0., edge.x)), DVec3::X)
    }

    fn claim(&self, what: &str, passes: u64, tolerance: f64) {
        let (half, middle) = VIEW;
        let mean = mean_over_square(|y, z| {
            self.irradiance(half * (2.0 * y - 1.0), middle + half * (2.0 * z - 1.0)) / PI
        });
        let want = std::array::from_fn(|i| radiance(1.0)[i] * wide(PATCH)[i] * mean);
        for who in everyone() {
            let shot = render(who, &self.scene().0, "LDDE", passes);
            // noise
            shot.claim(what, shot.layer(Layer::Diffuse), want, tolerance);
        }
    }
}

/// 5.6: a wall beside an evenly lit, diffuse patch gets what Lambert's formula says.
#[test]
fn diffuse_reflection_follows_its_configuration_factor() {
    PatchAndWall { low: 0.3, high: 1.1, half: 0.5, panel: None }.claim("patch", 1024, 0.012);
}

/// 5.7: behind a panel, what the part of the patch sends that it sees.
#[test]
fn internal_obstruction_hides_its_part_of_the_patch() {
    PatchAndWall { low: 0.3, high: 1.1, half: 0.5, panel: Some((0.2, 0.22)) }.claim(
        "patch behind a panel",
        1536,
        0.015,
    );
}

/// 5.8 [A14]: in a closed cube with a point of intensity I in its middle the mean irradiance of a wall is Φ/S direct and
/// ρ/(1−ρ) of it interreflected, S the whole area: all six walls are alike, and absorb what is emitted.
#[test]
fn interreflection_in_a_cube_keeps_its_mean() {
    let albedo = [0.2, 0.5, 0.8];
    // one wall is the image
    let mut b = Build::new(v(0., 0., 0.), v(1., 0., 0.), 1.0, 24);
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &matte(albedo));
    b.point(v(0., 0., 0.), STRENGTH);
    let direct = std::array::from_fn(|i| wide(albedo)[i] / PI * wide(STRENGTH)[i] * 4.0 * PI / 24.0);
    let rest = std::array::from_fn(|i| direct[i] * wide(albedo)[i] / (1.0 - wide(albedo)[i]));
    for who in everyone() {
        let shot = render(who, &b.0, EVERYTHING, 96);
        shot.claim("cube, direct", shot.layer(Layer::Direct), direct, 0.005);
        // noise, and a little of what walls lose at their edges
        shot.claim("cube, interreflected", shot.layer(Layer::Diffuse), rest, 0.01);
    }
}

/// A floor of which the camera sees a square of half width 0.3, under a roof with an opening and a glowing sky, with
/// glass between them or without.
fn under_the_sky(opening: f64, sky: f64, glass: bool) -> Build {
    let mut b = Build::new(v(0., 0., 0.9), v(0., 0., 0.), 0.3 / 0.9, 16);
    b.floor(v(0., 0., 0.), 0.5, &matte(ALBEDO));
    roof(&mut b, sky, opening);
    b.ceiling(v(0., 0., 1.08), sky, &glowing(STRENGTH, [0.0; 3]));
    if glass {
        b.cuboid(v(-sky, -sky, 1.01), v(sky, sky, 1.02), true, &clear(1.5));
    }
    b
}

/// The mean of `irradiance` over what the camera of [`under_the_sky`] sees.
fn mean_of_floor(irradiance: impl Fn(DVec3) -> f64) -> f64 {
    mean_over_square(|x, y| irradiance(v(0.6 * x - 0.3, 0.6 * y - 0.3, 0.)))
}

/// 5.9, uniform sky: under an opening the sky component is the opening's configuration factor.
#[test]
fn roof_opening_shows_its_part_of_the_sky() {
    let opening = 0.25;
    let b = under_the_sky(opening, 0.35, false);
    let want = radiance(mean_of_floor(|p| lambert(&opening_from(p, opening), DVec3::Z)));
    for who in everyone() {
        let shot = render(who, &b.0, "LDE", 192);
        // noise of 49,152 shadow rays, of which the opening lets half through
        shot.claim("roof opening", shot.layer(Layer::Direct), want, 0.01);
    }
}

/// 5.10, uniform sky: glass in the opening takes T(θ) of two faces [A6] from each direction.
#[test]
fn glazed_roof_opening_takes_the_glasss_part() {
    let opening = 0.25;
    let b = under_the_sky(opening, 0.35, true);
    // over the opening: cosθ cosθ' / d² = 1/d⁴ at the distance 1
    let through = |p: DVec3| {
        let area = 4.0 * opening * opening;
        area * mean_over_square(|x, y| {
            let to = v(2.0 * opening * (x - 0.5), 2.0 * opening * (y - 0.5), 1.) - p;
            let r = reflectance((1.0 / to.length()).acos(), 1.5);
            (1.0 - r) / (1.0 + r) / to.length().powi(4)
        })
    };
    // symmetric: a quarter of the floor, by fewer points than the mean of cheap ones
    let at = |i: u32| 0.3 * (f64::from(i) + 0.5) / 8.0;
    let mean = (0..64).map(|i| through(v(at(i % 8), at(i / 8), 0.))).sum::<f64>() / 64.0;
    for who in mappers() {
        let shot = render(who, &b.0, "LDE|LS+DE", 192);
        // noise
        shot.claim("glazed opening", shot.layer(Layer::Caustic), radiance(mean), 0.01);
        shot.claim("glazed opening, direct", shot.layer(Layer::Direct), [0.0; 3], 0.0);
    }
}

/// 5.11 and 5.13, uniform sky and ground: through an opening in a façade a point of the floor gets the sky's and the
/// ground's parts of the opening, less what a mask over it hides.
#[test]
fn facade_opening_shows_sky_and_ground_under_its_mask() {
    let window = [v(0., -0.4, 0.2), v(0., 0.4, 0.2), v(0., 0.4, 0.8), v(0., -0.4, 0.8)];
    // outside, at x = -0.5: the ground's radiance up to this height, the sky's above
    let (outside, split, ground) = (-0.5, 0.7, 0.25f32);
    // outer edge of the mask
    let mask = v(-0.2, 0., 0.85);
    for (x, masked) in [(0.3, false), (0.6, false), (0.4, true)] {
        let p = v(x, 0., 0.);
        let mut b = Build::new(v(x, -0.5, 0.5), p, 0.007, 16);
        b.floor(p, 0.1, &matte(ALBEDO));
        for (corner, across, up) in [
            (v(0., -1.5, -0.1), 3.0, 0.3),
            (v(0., -1.5, 0.8), 3.0, 1.2),
            (v(0., -1.5, 0.2), 1.1, 0.6),
            (v(0., 0.4, 0.2), 1.1, 0.6),
        ] {
            b.quad(corner, v(0., across, 0.), v(0., 0., up), &black());
        }
        for (low, high, strength) in [(-0.1, split, STRENGTH.map(|s| s * ground)), (split, 2.5, STRENGTH)] {
            let height = v(0., 0., high - low);
            b.quad(v(outside, -1.5, low), v(0., 3., 0.), height, &glowing(strength, [0.0; 3]));
        }
        if masked {
            b.quad(v(mask.x, -1.5, mask.z), v(-mask.x, 0., 0.), v(0., 3., 0.), &black());
        }
        // the window's part above or below the plane through the point and an edge along y
        let seen = window.map(|c| c - p);
        let above = |edge: DVec3| v(edge.z, 0., x - edge.x);
        let open = if masked { clip(&seen, -above(mask)) } else { seen.to_vec() };
        let line = above(v(outside, 0., split));
        let irradiance = lambert(&clip(&open, line), DVec3::Z)
            + f64::from(ground) * lambert(&clip(&open, -line), DVec3::Z);
        for who in everyone() {
            let shot = render(who, &b.0, "LDE", 384);
            // noise of 98,304 shadow rays
            shot.claim(
                &format!("façade {x} {masked}"),
                shot.layer(Layer::Direct),
                radiance(irradiance),
                0.02,
            );
        }
    }
}

/// The panel hides all of the patch from the wall's foot and a part of it from what the camera sees.
#[test]
fn the_panel_hides_a_part_of_the_patch() {
    let open = PatchAndWall { low: 0.3, high: 1.1, half: 0.5, panel: None };
    let hidden = PatchAndWall { panel: Some((0.2, 0.22)), ..open };
    assert_eq!(hidden.irradiance(0., 0.1), 0.0);
    let share = hidden.irradiance(0., 0.35) / open.irradiance(0., 0.35);
    assert!(share > 0.1 && share < 0.9, "{share}");
}
