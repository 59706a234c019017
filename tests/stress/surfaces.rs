//! Surfaces that lie in one place, touch, or stand so close that only rounding tells them apart.

use crate::build::{Build, Look, black, clear, glowing, matte, v};
use crate::harness::{EVERYTHING, Renderer, Seen, everyone, mappers, render};
use crate::sheet::{Sheet, Stress, sized};
use crate::shoot::{alike, batch, few_jotons, images, open, seed, seed_by_map, shots};
use glam::DVec3;
use joton::film::{LAYERS, Layer};
use joton::packed::PackedScene;
use joton::plan::Plan;
use joton::scene::{Material, Scene};
use joton::spectrum::Bands;
use std::f64::consts::PI;

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "coplanar duplicates", run: duplicates },
    Stress { name: "walls of 1e-4 with light on one side", run: thin_walls },
    Stress { name: "corners and edges of a room", run: corners },
    Stress { name: "contact of sphere and floor", run: contact },
    Stress { name: "grazing light and views", run: grazing },
];

/// Pixels across and down.
const SIZE: u32 = 16;

/// Which way a square is cut, and what of it is there twice.
#[derive(Clone, Copy)]
enum Doubled {
    Nothing,
    Exactly,
    TurnedOver,
    OtherDiagonal,
    Partly,
    FourTimes,
}

/// A floor of side 2 under a lamp and beside a wall that it lights, a part of it doubled.
fn floor(doubled: Doubled) -> Scene {
    let mut b = Build::new(v(0.2, -2.4, 1.6), v(0., 0., 0.2), 0.5, SIZE);
    let white = matte([0.8, 0.6, 0.4]);
    let [x, y] = [v(2., 0., 0.), v(0., 2., 0.)];
    let corner = v(-1., -1., 0.);
    b.quad(corner, x, y, &white);
    match doubled {
        Doubled::Nothing => {}
        Doubled::Exactly => b.quad(corner, x, y, &white),
        Doubled::TurnedOver => b.quad(corner, y, x, &white),
        Doubled::OtherDiagonal => b.quad(corner + x, y, -x, &white),
        Doubled::Partly => b.quad(v(-0.7, -0.4, 0.), v(1.1, 0.3, 0.), v(-0.3, 1.1, 0.), &white),
        Doubled::FourTimes => {
            b.quad(corner + x, y, -x, &white);
            b.quad(corner, y, x, &white);
            b.quad(v(-0.9, -0.9, 0.), v(1.8, 0., 0.), v(0., 1.8, 0.), &white);
        }
    }
    b.quad(v(-1., 1., 0.), v(2., 0., 0.), v(0., 0., 1.5), &white);
    b.ceiling(v(0., 0., 1.6), 0.3, &glowing([8.0; 3], [0.5; 3]));
    b.0
}

/// A surface that is there more than once is there once: the same light, and none missing in the diffuse layer.
fn duplicates(sheet: &mut Sheet) {
    let passes = sized(4, 32);
    let scattered = [Layer::Direct, Layer::Diffuse];
    for who in mappers() {
        let once = shots(who, &floor(Doubled::Nothing), seed(0), passes);
        for (i, (name, doubled)) in (1..).zip([
            ("exact copies", Doubled::Exactly),
            ("copies turned over", Doubled::TurnedOver),
            ("the other diagonal", Doubled::OtherDiagonal),
            ("partial overlap", Doubled::Partly),
            ("four in one plane", Doubled::FourTimes),
        ]) {
            let twice = shots(who, &floor(doubled), seed(i), passes);
            let [a, b] = [&twice, &once].map(|p| images(p, &scattered, 1.0));
            alike(sheet, name, format!("{who:?}"), &a, &b, SIZE / 4);
        }
    }
}

/// Where the eye stands.
#[derive(Clone, Copy, PartialEq)]
enum Side {
    Lit,
    /// In the dark room, before the wall between the rooms.
    NearWall,
    /// In the dark room, before the wall at its other end.
    FarWall,
}

/// Two rooms with a wall between, `thickness` of the scene's size thick; light in one of them.
fn rooms(thickness: f64, side: Side, caustics: bool) -> Scene {
    let (eye, target) = match side {
        Side::Lit => (v(-0.9, -0.8, 0.7), v(-0.2, 0.5, -0.3)),
        Side::NearWall => (v(0.9, -0.8, 0.7), v(0.2, 0.5, -0.3)),
        Side::FarWall => (v(0.3, 0., 0.), v(1.0, 0., 0.)),
    };
    let mut b = Build::new(eye, target, if side == Side::FarWall { 1.4 } else { 0.9 }, SIZE);
    let white = matte([0.8; 3]);
    // the size of the scene is the diagonal of its bounds
    let half = thickness * 12f64.sqrt() / 2.0;
    b.cuboid(v(-1., -1., -1.), v(-half, 1., 1.), false, &white);
    b.cuboid(v(half, -1., -1.), v(1., 1., 1.), false, &white);
    b.ceiling(v(-0.5, 0., 0.98), 0.3, &glowing([8.0; 3], [0.5; 3]));
    b.point(v(-0.01 - half, 0.3, 0.2), [1.0; 3]);
    if caustics {
        b.sphere(v(-0.5, 0.2, 0.0), 0.3, 2, Look::OutwardSmooth, &clear(1.5));
    }
    b.0
}

/// What discs at later surfaces of paths let through a wall, of the light on its other side: 1.2e-4 were measured with eight passes.
const PATHS_LEAK: f64 = 5e-4;

/// Not a joton and not a ray gets through the wall, and no disc gathers on its other side, where floor and ceiling go on in
/// one plane.
fn thin_walls(sheet: &mut Sheet) {
    /// World units.
    const RADIUS: f64 = 0.1;
    let passes = sized(8, 256);
    let scale = PackedScene::whole(&rooms(1e-2, Side::Lit, false)).world_scale;
    // discs of the caustic map at later surfaces of a path are not ended at walls: by paths a little light passes
    for (thickness, caustics, by_map) in
        [(1e-2, false, false), (1e-4, false, false), (1e-4, true, true), (1e-4, true, false)]
    {
        let limit = if caustics && !by_map { PATHS_LEAK } else { 0.0 };
        for who in everyone() {
            // a radius that leaves something of the room beyond it
            let small = |plan: &mut Plan| {
                few_jotons(plan);
                for schedule in [&mut plan.diffuse, &mut plan.caustic] {
                    schedule.base = schedule.base.min(RADIUS / scale);
                }
            };
            let look = |side: Side| {
                let scene = rooms(thickness, side, caustics);
                let settings = if by_map { seed_by_map(1) } else { seed(1) };
                batch(&mut *open(who, &scene, settings, &small), 0, passes).layers
            };
            let kind = if caustics { ", caustics" } else { "" };
            let name = format!("{thickness:e} of the scene{kind}{}", if by_map { ", by map" } else { "" });
            let lit = |layers: &[Layer], from: &[Vec<Bands>; LAYERS]| {
                let values = layers.iter().flat_map(|&l| from[l as usize].iter().flatten());
                values.filter(|x| **x != 0.0).count() as u64
            };
            // it sees nothing but the wall at x = 1
            let far = look(Side::FarWall);
            if limit <= 0.0 {
                sheet.none(
                    format!("{name}: dark, beyond a radius"),
                    format!("{who:?}"),
                    "values lit",
                    lit(&Layer::ALL, &far),
                );
            }
            let near = look(Side::NearWall);
            let traced = [Layer::Emission, Layer::Direct];
            sheet.none(
                format!("{name}: dark, traced"),
                format!("{who:?}"),
                "values lit",
                lit(&traced, &near),
            );
            let bright = look(Side::Lit);
            assert!(lit(&Layer::ALL, &bright) > u64::from(SIZE * SIZE), "{who:?}: the lit side is dark");
            let sum = |from: &[Vec<Bands>; LAYERS]| {
                from[Layer::Diffuse as usize..]
                    .iter()
                    .chain(&from[Layer::Caustic as usize..Layer::Diffuse as usize])
                    .flatten()
                    .flatten()
                    .map(|x| f64::from(*x))
                    .sum::<f64>()
            };
            let leak = sum(&near) / sum(&bright);
            sheet.at_most(
                format!("{name}: dark, gathered within a radius"),
                format!("{who:?}"),
                "of the lit side",
                leak,
                limit,
            );
            let far_leak = sum(&far) / sum(&bright);
            sheet.at_most(
                format!("{name}: dark, beyond a radius"),
                format!("{who:?}"),
                "of the lit side",
                far_leak,
                limit,
            );
        }
    }
}

/// Relative deviation of a mean, and how much of it may be noise.
fn off(seen: Seen, want: f64) -> (f64, f64) {
    let b = 0;
    ((seen.mean[b] / want - 1.0).abs(), seen.error[b] / want)
}

/// In a furnace every stripe along an edge and every corner is as bright as the rest, and so is each layer.
fn corners(sheet: &mut Sheet) {
    // E and ρ of a half: 1 everywhere, a quarter of it interreflected
    let (emission, albedo) = (0.5f32, 0.5);
    let mut b = Build::new(v(-0.9, -0.9, -0.9), v(1., 1., 1.), 0.45, 32);
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &glowing([emission; 3], [albedo; 3]));
    for who in mappers() {
        let shot = render(who, &b.0, EVERYTHING, sized(64, 512));
        // three edges run from the corner in the middle of the image: up or down, and to both sides
        let middle = |x: f64, y: f64| (x - 0.5).hypot(y - 0.5);
        for (name, inside) in [
            ("within 0.15 of the corner", &(|x, y| middle(x, y) < 0.15) as &dyn Fn(f64, f64) -> bool),
            ("within 0.3 of the corner", &|x, y| middle(x, y) < 0.3),
            ("along the upright edge", &|x: f64, _| (x - 0.5).abs() < 0.05),
            ("all", &|_, _| true),
        ] {
            let (worst, noise) = off(shot.mean(&Layer::ALL, inside), f64::from(emission / (1.0 - albedo)));
            sheet.row(
                format!("furnace, {name}"),
                format!("{who:?}"),
                format!("{:.2} % ± {:.2} %", 100.0 * worst, 100.0 * noise),
                "1 %",
                worst <= 0.01 && 3.0 * noise <= 0.01,
            );
        }
    }
}

/// A matte and a clear ball that touch the floor in a corner of a facet: what path tracing sees.
fn contact(sheet: &mut Sheet) {
    for (name, level, look, ball) in
        [("matte", 3, Look::Outward, matte([0.7; 3])), ("clear", 3, Look::OutwardSmooth, clear(1.5))]
    {
        let mut b = Build::new(v(0.9, -2.2, 0.35), v(0., 0., 0.1), 0.25, SIZE);
        b.floor(v(0., 0., 0.), 2.0, &matte([0.6, 0.5, 0.4]));
        // blown up and turned by its faces, the ball is not as low as its radius: its lowest corner touches
        let mut alone = Build::new(v(0., 0., 0.), v(0., 1., 0.), 1.0, SIZE);
        alone.sphere(DVec3::ZERO, 0.4, level, look, &ball);
        let lowest = alone.0.mesh.positions.iter().map(|p| p.z).fold(f64::INFINITY, f64::min);
        b.sphere(v(0., 0., -lowest), 0.4, level, look, &ball);
        // large and near: a path tracer finds it by chance
        b.ceiling(v(0., 0., 2.5), 2.0, &glowing([1.0; 3], [0.0; 3]));
        let reference = shots(Renderer::PathTracer, &b.0, seed(9), sized(24, 256));
        for who in mappers() {
            let seen = shots(who, &b.0, seed(1), sized(6, 64));
            let [a, r] = [&seen, &reference].map(|p| images(p, &Layer::ALL, 1.0));
            alike(
                sheet,
                &format!("{name} ball, against the path tracer"),
                format!("{who:?}"),
                &a,
                &r,
                SIZE / 4,
            );
        }
    }
}

/// A sun that grazes, and an eye that nearly lies in the floor: the closed form holds, and nothing is shaded by itself.
fn grazing(sheet: &mut Sheet) {
    let albedo = 0.5;
    for height in [1e-2f64, 1e-4, 1e-6] {
        let mut b = Build::new(v(0., -0.5, 1.5), v(0., 0., 0.), 0.4, SIZE);
        b.floor(v(0., 0., 0.), 2.0, &matte([albedo as f32; 3]));
        b.sun(v(height.cos(), 0., -height.sin()), [1000.0; 3]);
        for who in everyone() {
            let shot = render(who, &b.0, EVERYTHING, 8);
            let (worst, _) = off(shot.layer(Layer::Direct), albedo / PI * 1000.0 * height.sin());
            // half a unit in the last place of a direction's coordinate near one, over its cosine
            let limit = 1e-4f64.max(2f64.powi(-24) / height);
            sheet.at_most(
                format!("sun {height:e} above the floor"),
                format!("{who:?}"),
                "relative",
                worst,
                limit,
            );
        }
    }
    for eye in [1e-2, 1e-4, 1e-6] {
        let mut b = Build::new(v(0., -3., eye), v(0., 0., 0.), 0.3, SIZE);
        b.floor(v(0., 0., 0.), 1.0, &matte([albedo as f32; 3]));
        b.floor(v(0., 0., -1.0), 2.0, &black());
        b.sun(v(0.3, 0.2, -0.9), [1.0; 3]);
        b.ceiling(v(0., 0., 2.0), 0.5, &Material { emission: [1.0; 3], ..black() });
        for who in mappers() {
            let mut backend = open(who, &b.0, seed(1), &few_jotons);
            let seen = batch(&mut *backend, 0, sized(4, 64));
            let direct = &seen.layers[Layer::Direct as usize];
            let wrong = direct.iter().flatten().filter(|x| !(0.0..1e3).contains(*x)).count() as u64;
            sheet.none(
                format!("eye {eye:e} above the floor"),
                format!("{who:?}"),
                "wild values of direct light",
                wrong,
            );
        }
    }
}
