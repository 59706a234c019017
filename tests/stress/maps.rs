//! Joton maps that are empty, hold one joton, or hold all of them in one cell. What single kernels do at these limits
//! (corners of cells, far cells in one bucket, 65,535 workgroups, empty and huge sorts) is claimed in tests/gpu_kernels.

use crate::build::{Build, Look, black, clear, glowing, matte, v};
use crate::harness::{Renderer, mappers};
use crate::sheet::{Sheet, Stress, sized};
use crate::shoot::{alike, batch, images, open, seed, seed_by_map, shots_of};
use joton::film::{Image, Layer};
use joton::plan::Plan;
use joton::scene::{Material, Scene};

/// The stresses of this file.
pub const STRESSES: &[Stress] = &[
    Stress { name: "empty maps", run: empty },
    Stress { name: "one joton", run: one },
    Stress { name: "every joton in one cell, and cells at their smallest", run: cells },
];

/// Pixels across and down.
const SIZE: u32 = 16;

/// A room with a clear ball.
fn room(walls: &Material) -> Scene {
    let mut b = Build::new(v(0., -0.9, 0.2), v(0., 0.3, -0.3), 0.8, SIZE);
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, walls);
    b.sphere(v(0., 0.2, -0.4), 0.3, 2, Look::OutwardSmooth, &clear(1.5));
    b.ceiling(v(0., 0.2, 0.98), 0.4, &glowing([4.0, 3.0, 2.0], [0.0; 3]));
    b.0
}

/// Walls that take all light, and a matte tile that no light reaches: there are maps, and nothing in them.
fn empty(sheet: &mut Sheet) {
    let mut b = Build(room(&black()));
    b.quad(v(-0.5, 0.999, -0.5), v(1., 0., 0.), v(0., 0., 1.), &matte([0.5; 3]));
    // and a lid before it
    b.quad(v(-0.6, 0.99, -0.6), v(1.2, 0., 0.), v(0., 0., 1.2), &black());
    for who in mappers() {
        for (name, settings) in [("black walls, map", seed_by_map(1)), ("black walls, paths", seed(1))] {
            let seen = batch(&mut *open(who, &b.0, settings, &|_| ()), 0, 4);
            let lit = |layer: Layer| {
                seen.layers[layer as usize].iter().flatten().filter(|x| **x != 0.0).count() as u64
            };
            let gathered = lit(Layer::Caustic) + lit(Layer::Diffuse);
            sheet.none(name, format!("{who:?}"), "values of gathered light", gathered);
            sheet.none(name, format!("{who:?}"), "jotons stored", seen.tally.jotons_stored);
        }
    }
}

/// What both maps hold, in groups of passes of a changed plan.
fn groups(who: Renderer, scene: &Scene, passes: u32, adjust: &dyn Fn(&mut Plan)) -> Vec<Image> {
    images(&shots_of(who, scene, seed_by_map(1), passes, adjust), &[Layer::Caustic, Layer::Diffuse], 1.0)
}

/// One joton a pass in each map: noisy, and right in the mean.
fn one(sheet: &mut Sheet) {
    let scene = room(&matte([0.7, 0.5, 0.3]));
    for who in mappers() {
        let lonely = groups(
            who,
            &scene,
            if who == Renderer::Cpu { sized(128, 4096) } else { sized(16, 512) },
            &|plan| {
                (plan.diffuse_jotons, plan.caustic_jotons) = (1, 1);
                // discs that are met now and then
                plan.diffuse.base *= 4.0;
            },
        );
        let many = groups(who, &scene, 4, &|plan| plan.diffuse.base *= 4.0);
        alike(sheet, "one joton a pass against thousands", format!("{who:?}"), &lonely, &many, SIZE);
    }
}

/// Cells so wide that eight hold the scene, and cells whose width is bounded by the table: both backends agree, the one
/// without a grid and the one with it. (All jotons in one cell: tests/gpu_kernels/gather.rs.)
fn cells(sheet: &mut Sheet) {
    let scene = room(&matte([0.7, 0.5, 0.3]));
    if !mappers().contains(&Renderer::Device) {
        return;
    }
    // internal units: the scene's radius lies between 512 and 1024, its cells are no narrower than a 30,000th of it
    for (name, radius) in [("a radius of 400 units", 400.0), ("a radius of 0.05 units", 0.05)] {
        let adjust = |plan: &mut Plan| {
            plan.diffuse.base = radius;
            (plan.diffuse_jotons, plan.caustic_jotons) = (1 << 11, 1 << 11);
        };
        let [device, host] =
            [Renderer::Device, Renderer::Cpu].map(|w| groups(w, &scene, sized(2, 16), &adjust));
        alike(sheet, name, "Device, Cpu", &device, &host, SIZE);
    }
}
