//! One scene scaled, moved and turned, with its camera: the image stays the same. Radiance does not know units of length;
//! intensities scale with their square.

use crate::build::{Build, Look, clear, glowing, matte, mirror, v};
use crate::harness::{Renderer, everyone, mappers};
use crate::sheet::{Sheet, Stress, is_long, sized};
use crate::shoot::{SIGNIFICANCE, alike, batch, few_jotons, images, open, seed, shots};
use glam::{DQuat, DVec3};
use joton::film::stats::{Estimate, test_equal};
use joton::film::{Layer, Picture};
use joton::scene::{Light, Material, Scene};

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "scaled 1e-6 to 1e6", run: scaled },
    Stress { name: "moved by 1e6 scene sizes, and turned", run: moved_and_turned },
    Stress { name: "scaled by powers of two", run: powers_of_two },
    Stress { name: "control: what differs is told apart", run: control },
];

/// Pixels across and down.
const SIZE: u32 = 16;
/// Pixels of a block that is compared.
const BLOCK: u32 = 4;

/// Every kind of surface and of light, in a room of size 2 about the origin.
pub fn room() -> Scene {
    let mut b = Build::new(v(0.1, -0.92, 0.15), v(0., 0.3, -0.3), 0.8, SIZE);
    let glossy = Material { glossy: [0.3, 0.4, 0.2], glossy_exponent: 20.0, ..matte([0.3, 0.2, 0.4]) };
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &matte([0.7, 0.5, 0.3]));
    b.floor(v(0., 0., -0.97), 0.9, &glossy);
    b.ceiling(v(0.2, 0.1, 0.97), 0.4, &glowing([4.0, 3.0, 2.0], [0.3; 3]));
    b.sphere(v(-0.45, 0.2, -0.5), 0.35, 2, Look::OutwardSmooth, &clear(1.5));
    b.sphere(v(0.5, 0.4, -0.6), 0.3, 2, Look::Outward, &mirror([0.9, 0.8, 0.7]));
    b.point(v(-0.7, -0.3, 0.6), [0.3, 0.2, 0.4]);
    b.light(Light::Spot {
        position: v(0.8, -0.5, 0.7),
        direction: v(-1.0, 0.6, -1.2).normalize(),
        intensity: [15.0, 10.0, 5.0],
        angle_inner: f64::acos(0.95),
        angle_outer: f64::acos(0.85),
    });
    b.0
}

/// A similarity.
#[derive(Clone, Copy)]
struct Frame {
    scale: f64,
    turn: DQuat,
    shift: DVec3,
}

const STILL: Frame = Frame { scale: 1.0, turn: DQuat::IDENTITY, shift: DVec3::ZERO };

impl Frame {
    fn point(&self, p: DVec3) -> DVec3 {
        self.turn * p * self.scale + self.shift
    }

    fn apply(&self, mut scene: Scene) -> Scene {
        scene.mesh.positions.iter_mut().for_each(|p| *p = self.point(*p));
        scene.mesh.normals.iter_mut().for_each(|n| *n = (self.turn * n.as_dvec3()).as_vec3());
        let c = &mut scene.camera;
        (c.position, c.target, c.up) = (self.point(c.position), self.point(c.target), self.turn * c.up);
        // W/sr: the same radiance on surfaces that are larger by the square
        let stronger = |i: [f32; 3]| i.map(|x| (f64::from(x) * self.scale * self.scale) as f32);
        for light in &mut scene.lights {
            match light {
                Light::Point { position, intensity } => {
                    (*position, *intensity) = (self.point(*position), stronger(*intensity));
                }
                Light::Spot { position, direction, intensity, .. } => {
                    (*position, *direction) = (self.point(*position), self.turn * *direction);
                    *intensity = stronger(*intensity);
                }
                Light::Sun { direction, .. } => *direction = self.turn * *direction,
            }
        }
        scene
    }
}

/// Passes of a group.
fn passes() -> u32 {
    sized(2, 16)
}
/// Renders of a frame. Eight groups of one tell their noise so badly that only what is off by a dozen times as much counts;
/// sixteen of two find what is off by eight times as much.
const RENDERS: u32 = 2;

/// Pictures of a frame, with seeds that no other has.
fn shots_of_frame(who: Renderer, frame: &Frame, number: u32) -> Vec<Picture> {
    let scene = frame.apply(room());
    let seeds = number * RENDERS..(number + 1) * RENDERS;
    seeds.flat_map(|s| shots(who, &scene, seed(s), passes())).collect()
}

/// Hold frames against the scene as it is built, layer by layer: in their sum direct light hides what is wrong with the rest.
/// Other seeds, so that equal noise does not hide anything.
fn compare(sheet: &mut Sheet, renderers: &[Renderer], frames: &[(String, Frame)]) {
    for &who in renderers {
        let still = shots_of_frame(who, &STILL, 0);
        for (i, (name, frame)) in (1..).zip(frames) {
            let seen = shots_of_frame(who, frame, i);
            for layer in Layer::ALL {
                let [a, b] = [&seen, &still].map(|p| images(p, &[layer], 1.0));
                alike(sheet, &format!("{name}, {}", layer.name()), format!("{who:?}"), &a, &b, BLOCK);
            }
        }
    }
}

fn scaled(sheet: &mut Sheet) {
    let frames = sized(&[1e-6, 1e6][..], &[1e-6, 1e-4, 1e-2, 1e2, 1e4, 1e6]).iter();
    let frames: Vec<_> =
        frames.map(|&scale| (format!("times {scale:e}"), Frame { scale, ..STILL })).collect();
    compare(sheet, &everyone(), &frames);
}

fn moved_and_turned(sheet: &mut Sheet) {
    let by = |sizes: f64| {
        // the room has size 2
        let shift = v(0.6, -0.48, 0.64) * sizes * 2.0;
        (format!("by {sizes:e} scene sizes"), Frame { shift, ..STILL })
    };
    let about = |axis: DVec3, angle: f64| {
        let turn = DQuat::from_axis_angle(axis.normalize(), angle.to_radians());
        (format!("by {angle}°"), Frame { turn, ..STILL })
    };
    let all = |scale: f64| {
        let (_, Frame { turn, .. }) = about(v(1., -0.4, 0.8), 115.0);
        let shift = v(-0.48, 0.6, 0.64) * 2e6 * scale;
        (format!("by 1e6 scene sizes, by 115°, times {scale:e}"), Frame { scale, turn, shift })
    };
    // upside down: what looks along an axis of the world and not of the scene then looks the other way
    let mut frames = vec![by(1e6), about(v(1., 0., 0.), 180.0), all(1e-6)];
    if is_long() {
        frames.extend([
            by(1e2),
            by(1e4),
            about(v(0., 0., 1.), 45.0),
            about(v(0.2, 1., -0.7), 271.3),
            all(1e6),
        ]);
    }
    compare(sheet, &mappers(), &frames);
}

/// Packing divides by a power of two: the same bits come out.
fn powers_of_two(sheet: &mut Sheet) {
    for who in everyone() {
        let bits = |frame: &Frame| {
            let mut backend = open(who, &frame.apply(room()), seed(3), &few_jotons);
            let values = batch(&mut *backend, 0, 2).layers.into_iter().flatten().flatten();
            values.map(f32::to_bits).collect::<Vec<u32>>()
        };
        let still = bits(&STILL);
        for exponent in [-40, 40] {
            let other = bits(&Frame { scale: 2f64.powi(exponent), ..STILL });
            let differ = still.iter().zip(&other).filter(|(a, b)| a != b).count() as u64;
            sheet.none(format!("times 2^{exponent}"), format!("{who:?}"), "values differ", differ);
        }
    }
}

/// The test behind these rows finds six per cent.
fn control(sheet: &mut Sheet) {
    let scattered = [Layer::Direct, Layer::Caustic, Layer::Diffuse];
    let shoot = |s: u32, factor: f32| {
        let pictures = shots_of_frame(Renderer::Cpu, &STILL, s);
        Estimate::from_renders(&images(&pictures, &scattered, factor), SIZE).unwrap_or_else(|e| panic!("{e}"))
    };
    let p = test_equal(&shoot(0, 1.06), &shoot(1, 1.0)).unwrap_or_else(|e| panic!("{e}")).p_value;
    sheet.row("6 % more light", "Cpu", format!("p = {p:.1e}"), "p < 1e-5", p < SIGNIFICANCE);
}
