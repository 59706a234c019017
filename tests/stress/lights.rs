//! Lights at the limits of their numbers: of all powers, without area, by the thousand.

use crate::build::{Build, black, glowing, matte, v};
use crate::harness::{EVERYTHING, everyone, mappers, render};
use crate::sheet::{Sheet, Stress, sized};
use crate::shoot::{alike, images, seed, shots};
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::scene::Scene;
use std::f64::consts::PI;

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "lights of 1e-12 W and 1e12 W together", run: all_powers },
    Stress { name: "lights without area", run: no_area },
    Stress { name: "every light is picked as often as it says", run: picks },
    Stress { name: "a lamp in a thousand pieces", run: pieces },
    Stress { name: "ten thousand point lights", run: many_points },
];

/// Pixels across and down.
const SIZE: u32 = 16;

/// A room with a view, without light.
fn room() -> Build {
    let mut b = Build::new(v(0., -0.9, 0.2), v(0., 0.3, -0.3), 0.8, SIZE);
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &matte([0.7, 0.5, 0.3]));
    b
}

/// Flux of a point or of a lamp of area one, W per band, as intensity or radiance.
const FEW_WATTS: f32 = 1e-12 / 12.6;
const MANY_WATTS: f32 = 1e12 / 12.6;

/// The strong lights are what is seen, and the weak ones spoil nothing.
fn all_powers(sheet: &mut Sheet) {
    let scene = |weak: bool| {
        let mut b = room();
        if weak {
            b.point(v(0.3, 0.1, 0.5), [FEW_WATTS; 3]);
            b.ceiling(v(-0.5, 0.4, 0.9), 0.1, &glowing([FEW_WATTS; 3], [0.5; 3]));
        }
        b.point(v(0.5, 0.2, 0.6), [MANY_WATTS; 3]);
        if weak {
            b.ceiling(v(-0.5, -0.4, 0.9), 0.1, &glowing([FEW_WATTS; 3], [0.5; 3]));
            b.point(v(-0.3, 0.1, 0.5), [FEW_WATTS; 3]);
        }
        b.0
    };
    // matte squares that emit next to nothing are in the other scene, too
    let strong = || {
        let mut b = Build(scene(false));
        for y in [0.4, -0.4] {
            b.ceiling(v(-0.5, y, 0.9), 0.1, &matte([0.5; 3]));
        }
        b.0
    };
    for who in everyone() {
        let [all, strong] = [(scene(true), 1), (strong(), 2)]
            .map(|(s, n)| images(&shots(who, &s, seed(n), sized(4, 32)), &Layer::ALL, 1.0));
        alike(sheet, "with and without the weak ones", format!("{who:?}"), &all, &strong, SIZE / 4);
    }
}

/// Emitters that are points or lines: nothing comes of them, not even a division by zero.
fn no_area(sheet: &mut Sheet) {
    let scene = |flat: bool| {
        let mut b = room();
        b.ceiling(v(0., 0.2, 0.98), 0.3, &glowing([4.0; 3], [0.5; 3]));
        if flat {
            let lamp = glowing([1e6; 3], [0.5; 3]);
            let (p, x) = (v(0.1, 0.2, 0.3), v(0.3, 0.1, 0.2));
            b.triangle([p, p, p], &lamp);
            b.triangle([p, p + x, p + x * 2.0], &lamp);
            b.triangle([p, p + x, p + x + v(0., 1e-25, 0.)], &lamp);
        }
        b.0
    };
    for who in everyone() {
        let [with, without] = [(true, 1), (false, 2)]
            .map(|(f, n)| images(&shots(who, &scene(f), seed(n), sized(4, 32)), &Layer::ALL, 1.0));
        alike(sheet, "a point, a line and a hair that emit", format!("{who:?}"), &with, &without, SIZE / 4);
    }
}

/// Steps of a random number: 24 bits.
const STEPS: f64 = 16_777_216.0;

/// Flux that a scene's jotons carry in the mean over that of its lights: Σ P Φ/pick over Σ Φ, P the share of the 2^24
/// random numbers that fall on a light.
fn carried(scene: &Scene, only: impl Fn(f64) -> bool) -> f64 {
    let packed = PackedScene::whole(scene);
    let (mut before, mut carried, mut all) = (0.0, 0.0, 0.0);
    for e in &packed.emitters {
        let upto = (f64::from(e.cumulative) * STEPS).ceil();
        let flux = f64::from(e.flux[0]);
        if only(flux) {
            all += flux;
            if upto > before {
                carried += (upto - before) / STEPS * flux / f64::from(e.pick);
            }
        }
        before = upto;
    }
    carried / all
}

/// A sun and small lamps by the hundred thousand: each lamp is far below the resolution of a random number, but not all
/// together, and a room that the sun does not reach has no other light.
fn picks(sheet: &mut Sheet) {
    for (count, share) in [(1_000u32, 1e-5f32), (100_000, 1e-3), (sized(100_000, 1_000_000), 0.5)] {
        let mut b = room();
        let each = MANY_WATTS * share / count as f32;
        for i in 0..count {
            let [x, y, z, _] = crate::common::random(3, i as usize);
            b.point(v(f64::from(x), f64::from(y), f64::from(z)) * 0.9, [each; 3]);
        }
        b.point(v(0., 0., 0.5), [MANY_WATTS * (1.0 - share); 3]);
        let largest = PackedScene::whole(&b.0).emitters.iter().map(|e| e.flux[0]).fold(0.0, f32::max);
        let weak = carried(&b.0, |flux| flux < f64::from(largest) * 0.1);
        let name = format!("{count} lamps that have {share:e} of all flux");
        sheet.at_most(format!("{name}: theirs"), "host", "relative", (weak - 1.0).abs(), 1e-5);
        sheet.at_most(
            format!("{name}: all"),
            "host",
            "relative",
            (carried(&b.0, |_| true) - 1.0).abs(),
            1e-5,
        );
    }
}

/// A lamp cut into small triangles shines as the whole one.
fn pieces(sheet: &mut Sheet) {
    let scene = |cuts: u32| {
        let mut b = room();
        let lamp = glowing([4.0, 3.0, 2.0], [0.5; 3]);
        let each = 0.6 / f64::from(cuts);
        for i in 0..cuts * cuts {
            let at = v(-0.3, -0.1, 0.98) + v(f64::from(i % cuts), f64::from(i / cuts), 0.) * each;
            b.quad(at, v(0., each, 0.), v(each, 0., 0.), &lamp);
        }
        b.0
    };
    let cuts = sized(32, 708);
    for who in mappers() {
        let [cut, whole] = [(cuts, 1), (1, 2)]
            .map(|(n, s)| images(&shots(who, &scene(n), seed(s), sized(4, 32)), &Layer::ALL, 1.0));
        let name = format!("{} emissive triangles", 2 * cuts * cuts);
        alike(sheet, &name, format!("{who:?}"), &cut, &whole, SIZE / 4);
    }
}

/// Points in a raster above a floor: the direct light is the sum of them all.
fn many_points(sheet: &mut Sheet) {
    let across = sized(100u32, 1000);
    let mut b = Build::new(v(0., 0., 0.9), v(0., 0., 0.), 0.5, SIZE);
    b.floor(v(0., 0., 0.), 1.0, &matte([0.5; 3]));
    b.floor(v(0., 0., -1.), 2.0, &black());
    let place = |i: u32| (f64::from(i) + 0.5) / f64::from(across) * 2.0 - 1.0;
    let intensity = 1.0 / (across * across) as f32;
    for i in 0..across * across {
        b.point(v(place(i % across), place(i / across), 1.0), [intensity; 3]);
    }
    // E of the floor's middle, over what the eye sees: |x|, |y| < 0.45; a raster of places is enough, the field is smooth
    let irradiance = |x: f64, y: f64| {
        let one = |i: u32| {
            let d = v(place(i % across) - x, place(i / across) - y, 1.0);
            f64::from(intensity) * d.z / d.length().powi(3)
        };
        (0..across * across).map(one).sum::<f64>()
    };
    const PLACES: u32 = 6;
    let at = |k: u32| (f64::from(k) + 0.5) / f64::from(PLACES) * 0.9 - 0.45;
    let mean = (0..PLACES * PLACES).map(|k| irradiance(at(k % PLACES), at(k / PLACES))).sum::<f64>()
        / f64::from(PLACES * PLACES);
    for who in everyone() {
        let shot = render(who, &b.0, EVERYTHING, sized(128, 512));
        let seen = shot.layer(Layer::Direct);
        let want = 0.5 / PI * mean;
        let (worst, noise) = (seen.mean[0] / want - 1.0, seen.error[0] / want);
        sheet.row(
            format!("{} points over a floor", across * across),
            format!("{who:?}"),
            format!("{:+.2} % ± {:.2} %", 100.0 * worst, 100.0 * noise),
            "1 %",
            worst.abs() <= 0.01 && 3.0 * noise <= 0.01,
        );
    }
}
