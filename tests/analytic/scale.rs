//! Scale: the same picture whether the light or the camera is near or 10⁴ times as far away. A light at D with the intensity
//! D² and a camera at D with the field of view 1/D see what they saw before; each layer against a closed form in f64.

use crate::build::{Build, clear, glowing, matte, v};
use crate::harness::{EVERYTHING, Renderer, Shot, everyone, render};
use glam::DVec3;
use joton::film::Layer;
use joton::scene::Light;
use std::f64::consts::PI;

/// Pixels across and down.
const SIZE: u32 = 32;
/// Reflectances of floor and panel; the panel's is small: what it sends back to the floor is left out of the closed form.
const FLOOR: f64 = 0.5;
const PANEL: f64 = 0.2;
/// Radiance of the lamp, too faint to be seen in anything else.
const LAMP: f64 = 1e-3;
/// The slab of glass: low and high corner, and its index.
const SLAB: [DVec3; 2] = [DVec3::new(0.1, -0.8, 0.6), DVec3::new(0.9, 0.0, 0.62)];
const INDEX: f64 = 1.5;
/// Panel and lamp stand in the plane y = [`BACK`] and look along −y: x from, to; z from, to.
const BACK: f64 = 0.8;
const PANEL_AT: [f64; 4] = [-0.95, 0.0, 0.2, 1.1];
const LAMP_AT: [f64; 4] = [0.3, 0.9, 0.35, 0.77];
/// What the camera looks at, and how wide that is.
const TARGET: DVec3 = DVec3::new(0.0, 0.0, 0.3);
const WIDTH: f64 = 1.2;

/// What a ray of the camera meets first.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Met {
    Floor(f64, f64),
    Panel(f64, f64),
    Lamp,
    Glass,
    Nothing,
}

/// Where light and camera are.
#[derive(Clone, Copy, Debug)]
struct Far {
    light: f64,
    camera: f64,
    /// Half the width of the floor.
    floor: f64,
    /// A spot that is just wide enough, in place of the point.
    spot: bool,
}

impl Far {
    fn eye(self) -> DVec3 {
        TARGET + v(0., -0.866, 0.5).normalize() * self.camera
    }

    fn build(self) -> Build {
        let mut b = Build::new(self.eye(), TARGET, WIDTH / self.camera, SIZE);
        b.floor(v(0., 0., 0.), self.floor, &matte([FLOOR as f32; 3]));
        let mut upright = |[x0, x1, z0, z1]: [f64; 4], m: &_| {
            b.quad(v(x0, BACK, z0), v(x1 - x0, 0., 0.), v(0., 0., z1 - z0), m);
        };
        upright(PANEL_AT, &matte([PANEL as f32; 3]));
        upright(LAMP_AT, &glowing([LAMP as f32; 3], [0.0; 3]));
        b.cuboid(SLAB[0], SLAB[1], true, &clear(INDEX as f32));
        let (position, intensity) = (v(0., 0., self.light), [(self.light * self.light) as f32; 3]);
        b.light(if self.spot {
            let [angle_inner, angle_outer] = [2.0, 3.0].map(|w: f64| (w / self.light).atan());
            Light::Spot { position, direction: -DVec3::Z, intensity, angle_inner, angle_outer }
        } else {
            Light::Point { position, intensity }
        });
        b
    }

    /// What is seen in a place of the image, x right and y down in 0 to 1.
    fn met(self, x: f64, y: f64) -> Met {
        let eye = self.eye();
        let forward = (TARGET - eye).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let up = right.cross(forward);
        let d = forward + (right * (2. * x - 1.) + up * (1. - 2. * y)) * (WIDTH / self.camera);
        let at = |t: f64| eye + d * t;
        // both ends of the way through the slab's box
        let ends = [0, 1, 2].map(|k| {
            let [a, b] = SLAB.map(|c| (c[k] - eye[k]) / d[k]);
            [a.min(b), a.max(b)]
        });
        let enters = ends.iter().map(|e| e[0]).fold(f64::NEG_INFINITY, f64::max);
        if enters < ends.iter().map(|e| e[1]).fold(f64::INFINITY, f64::min) {
            return Met::Glass;
        }
        let p = at((BACK - eye.y) / d.y);
        let within = |[x0, x1, z0, z1]: [f64; 4]| p.x > x0 && p.x < x1 && p.z > z0 && p.z < z1;
        if within(PANEL_AT) {
            return Met::Panel(p.x, p.z);
        }
        if within(LAMP_AT) {
            return Met::Lamp;
        }
        let f = at(-eye.z / d.z);
        if f.x.abs().max(f.y.abs()) < self.floor && f.y < BACK || f.y >= BACK && p.z < 0.3 && f.y < self.floor
        {
            Met::Floor(f.x, f.y)
        } else {
            Met::Nothing
        }
    }

    /// True where a place of the floor lies under the slab, or (`grown` > 0) near it.
    fn under(x: f64, y: f64, grown: f64) -> bool {
        let [low, high] = SLAB;
        x > low.x - grown && x < high.x + grown && y > low.y - grown && y < high.y + grown
    }

    /// Irradiance on the floor straight from the light: I cosθ/d².
    fn straight(self, x: f64, y: f64) -> f64 {
        let d = v(x, y, self.light).length();
        (self.light / d).powi(3)
    }

    /// The same through the slab, with what it takes [A6] and the image that it lifts: almost head on everywhere.
    fn through_slab(self, x: f64, y: f64) -> f64 {
        let r = ((INDEX - 1.) / (INDEX + 1.)).powi(2);
        let thickness = SLAB[1].z - SLAB[0].z;
        let distance = self.light - thickness * (1. - 1. / INDEX);
        let cos = distance / v(x, y, distance).length();
        (1. - r) / (1. + r) * cos.powi(3) * (self.light / distance).powi(2)
    }

    /// Irradiance that a place of the panel gets from the floor, with the light that comes through the slab or without.
    fn by_floor(self, x: f64, z: f64, caustics: bool) -> f64 {
        const CELLS: u32 = 60;
        /// Cells are this wide in the middle, relative to those of a floor that is as large, and grow away from it.
        const MIDDLE: f64 = 0.5;
        let stretch = (self.floor / MIDDLE).asinh();
        // place and width
        let cell = |k: u32| {
            let s = stretch * ((f64::from(k) + 0.5) / f64::from(CELLS) * 2. - 1.);
            (MIDDLE * s.sinh(), MIDDLE * s.cosh() * stretch * 2. / f64::from(CELLS))
        };
        let given = |i: u32| {
            let ((fx, width), (fy, height)) = (cell(i % CELLS), cell(i / CELLS));
            let lit = match Self::under(fx, fy, 0.) {
                _ if fy > BACK => 0.0,
                true if !caustics => 0.0,
                true => self.through_slab(fx, fy),
                false => self.straight(fx, fy),
            };
            let d = v(fx - x, fy - BACK, -z);
            // cosines with −y and z over π d²
            FLOOR * lit * (-d.y) * z / (PI * d.length_squared().powi(2)) * width * height
        };
        (0..CELLS * CELLS).map(given).sum()
    }
}

/// Places across a pixel that are looked at; and where its worth is not the same all over.
const PLACES: [u32; 2] = [6, 60];

/// The mean over a pixel of what its places are worth; none where one of them is not known.
fn over_pixel(far: Far, i: u32, worth: impl Fn(Met) -> Option<f64>) -> Option<f64> {
    let all = |across: u32| -> Option<Vec<f64>> {
        let place = |pixel: u32, k: u32| {
            (f64::from(pixel) + (f64::from(k) + 0.5) / f64::from(across)) / f64::from(SIZE)
        };
        let at = |k: u32| far.met(place(i % SIZE, k % across), place(i / SIZE, k / across));
        (0..across * across).map(|k| worth(at(k))).collect()
    };
    let few = all(PLACES[0])?;
    let places = if few.contains(&0.0) && few.iter().any(|w| *w > 0.0) { all(PLACES[1])? } else { few };
    Some(places.iter().sum::<f64>() / places.len() as f64)
}

/// Claim that the mean of a layer over the pixels of which all is known is that of a closed form, radiance in each place.
fn claim(shot: &Shot, far: Far, layer: Layer, tolerance: f64, wanted: impl Fn(Met) -> Option<f64>) {
    claim_pixels(shot, far, layer, tolerance, wanted, |_| true);
}

/// The same for some of these pixels, by their mean.
fn claim_pixels(
    shot: &Shot,
    far: Far,
    layer: Layer,
    tolerance: f64,
    wanted: impl Fn(Met) -> Option<f64>,
    which: impl Fn(f64) -> bool,
) {
    let all: Vec<Option<f64>> =
        (0..SIZE * SIZE).map(|i| over_pixel(far, i, &wanted).filter(|w| which(*w))).collect();
    let index = |p: f64| (p * f64::from(SIZE)) as usize;
    let inside = |x: f64, y: f64| all[index(y) * SIZE as usize + index(x)].is_some();
    let known: Vec<f64> = all.iter().flatten().copied().collect();
    assert!(known.len() > 8, "{far:?}, {layer:?}: {} pixels", known.len());
    let want = known.iter().sum::<f64>() / known.len() as f64;
    shot.claim(&format!("{far:?}, {layer:?}"), shot.mean(&[layer], inside), [want; 3], tolerance);
}

fn check(who: Renderer, far: Far) {
    let shot = render(who, &far.build().0, EVERYTHING, 72);
    claim(&shot, far, Layer::Direct, 0.01, |met| match met {
        Met::Floor(x, y) if !Far::under(x, y, 0.05) && y < 0.7 => Some(FLOOR / PI * far.straight(x, y)),
        _ => None,
    });
    // a path tracer meets no point
    if who != Renderer::PathTracer {
        claim(&shot, far, Layer::Caustic, 0.02, |met| match met {
            Met::Floor(x, y) if Far::under(x, y, -0.1) => Some(FLOOR / PI * far.through_slab(x, y)),
            _ => None,
        });
    }
    // of the jotons on a wide floor hardly one comes back to the subject
    if far.floor <= 1.0 || who == Renderer::PathTracer {
        claim(&shot, far, Layer::Diffuse, 0.05, |met| match met {
            Met::Panel(x, z) if x > -0.9 && x < -0.05 && z > 0.25 && z < 1.05 => {
                Some(PANEL / PI * far.by_floor(x, z, who != Renderer::PathTracer))
            }
            _ => None,
        });
    }
    // pixels on an edge of the lamp alone: there a ray that is off by a part of a pixel shows; glass mirrors the lamp
    let lamp = |met| match met {
        Met::Glass => None,
        met => Some(if met == Met::Lamp { LAMP } else { 0.0 }),
    };
    claim_pixels(&shot, far, Layer::Emission, 0.04, lamp, |w| w > 0.0 && w < 0.999 * LAMP);
}

const NEAR: Far = Far { light: 10.0, camera: 3.0, floor: 1.0, spot: false };

#[test]
fn a_light_as_near_as_ten() {
    everyone().into_iter().for_each(|who| check(who, NEAR));
}

#[test]
fn a_light_far_away_with_the_square_of_its_intensity() {
    everyone().into_iter().for_each(|who| check(who, Far { light: 1e4, ..NEAR }));
}

#[test]
fn a_spot_far_away_that_just_lights_the_scene() {
    everyone().into_iter().for_each(|who| check(who, Far { light: 1e4, spot: true, ..NEAR }));
}

#[test]
fn a_camera_far_away_with_a_narrow_field_of_view() {
    everyone().into_iter().for_each(|who| check(who, Far { camera: 3e4, ..NEAR }));
}

#[test]
fn a_small_subject_on_a_wide_floor() {
    everyone().into_iter().for_each(|who| check(who, Far { light: 1e4, floor: 1e4, ..NEAR }));
}
