//! Walls: no light where none can be.

use crate::common::scenes::{Builder, mirror};
use crate::renders::{EVERYTHING, Side, plan, run};
use glam::{DVec3, Vec3};
use joton::packed::PackedScene;
use joton::scene::Light;
use std::sync::Arc;

/// Where the light of a sun outside would come from; no coordinate is zero.
const TOWARD_SUN: DVec3 = DVec3::new(-0.717, -0.512, 0.473);

/// A closed, light grey room in the full sun.
fn room() -> PackedScene {
    let mut b = Builder::new([-0.9, -0.9, -0.9], [0.6, 0.3, 0.5], [0., 1., 0.], 1.0, 64);
    let walls = b.matte(0.7);
    b.room([-1.; 3], [1.; 3], walls);
    b.scene.lights.push(Light::Sun { direction: -TOWARD_SUN.normalize(), irradiance: [100.0; 3] });
    // a plan would leave the sun out
    PackedScene::whole(&b.scene)
}

/// A shadow ray, however long, sees what stands a thousandth of a unit from where it starts: from points along the
/// room's edges none reaches the sun.
#[test]
fn long_shadow_rays_see_what_is_near() {
    const BEYOND: f32 = 4096.0;
    let scene = room();
    let corner = scene.bounds[1];
    let to_sun = TOWARD_SUN.normalize().as_vec3();
    for i in 0..2000u32 {
        let [along, off, ..] = joton::sampling::rng::random4(0, 0, i, 0);
        // a unit is 1/1024 of the room
        let off = 10f32.powf(3.0 * off - 3.0);
        let from = Vec3::new(-corner.x + off, -corner.y + 2e-3, corner.z * (2.0 * along - 1.0));
        let hidden = scene.bvh.occluded(&scene.triangles, from, to_sun * BEYOND, 1.0);
        assert!(hidden, "the sun is seen from {from}, {off} from the wall");
    }
}

/// A closed room is dark, whatever shines outside.
#[test]
fn closed_rooms_are_dark() {
    let scene = Arc::new(room());
    for side in [Side::Host, Side::PathTracer, Side::Device] {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        let rendered = run(side, &scene, plan(&scene, EVERYTHING, 1), 16);
        let pixels = &rendered.picture.whole.pixels;
        let mean = pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>() / (3 * pixels.len()) as f64;
        // one camera ray of 65,536 that found a hole would show as 3e-4: the sun makes a wall shine with 22
        assert!(mean < 1e-4, "{side:?}: {mean}");
    }
}

/// A low mirror board on a floor, lit from the front: behind it is no caustic. The camera looks over it, and in the pixels
/// of its rim the pilot often sees the sky in a mirror instead of the floor, and so no wall. Jotons are so few that discs
/// about the floor behind the rim reach over the board: with many they shrink and do not.
#[test]
fn boards_seen_in_a_part_of_a_pixel_are_walls() {
    const SIZE: u32 = 32;
    const EYE: [f64; 3] = [0.0, 0.6, 1.2];
    const TARGET: [f64; 3] = [0.0, 0.0, -0.05];
    const TAN_HALF_FOV: f64 = 0.25;
    const FRONT: f64 = 0.002;
    const JOTONS: u32 = 1 << 14;
    let mut b = Builder::new(EYE, TARGET, [0., 1., 0.], TAN_HALF_FOV, SIZE);
    let floor = b.matte(0.8);
    b.quad([-2., 0., -2.], [0., 0., 6.], [4., 0., 0.], floor);
    let board = b.material(mirror(0.9));
    let (width, height) = ([4., 0., 0.], [0., 0.02, 0.]);
    b.quad([-2., 0., FRONT], width, height, board);
    b.quad([-2., 0., -FRONT], height, width, board);
    b.quad([-2., 0.02, -FRONT], [0., 0., 2. * FRONT], width, board);
    b.point_light([0.03, 0.2, 1.5], 1.0);
    let scene = Arc::new(PackedScene::new(&b.scene));
    // where the lower edge of a row of pixels meets the floor
    let meets_floor = |row: u32| {
        let forward = (DVec3::from(TARGET) - DVec3::from(EYE)).normalize();
        let up = DVec3::X.cross(forward).normalize();
        let up = if up.y > 0.0 { up } else { -up };
        let down = 2.0 * f64::from(row + 1) / f64::from(SIZE) - 1.0;
        let d = forward - up * (TAN_HALF_FOV * down);
        EYE[2] - EYE[1] / d.y * d.z
    };
    let behind = (0..SIZE).take_while(|&row| meets_floor(row) < FRONT).count();
    assert!(behind > 8 && behind < 24, "{behind} rows behind the board");
    for side in [Side::Host, Side::Device] {
        if side == Side::Device && crate::common::device().is_none() {
            continue;
        }
        for seed in 0..4 {
            let mut plan = plan(&scene, "LS+DE", seed);
            plan.caustic_jotons = JOTONS;
            let rendered = run(side, &scene, plan, 8);
            let image = &rendered.picture.whole;
            let (dark, lit) = image.pixels.split_at(behind * SIZE as usize);
            let sum = |pixels: &[[f32; 3]]| pixels.iter().flatten().map(|x| f64::from(*x)).sum::<f64>();
            assert!(sum(lit) > 0.0, "{side:?}: the board reflects nothing");
            assert_eq!(sum(dark), 0.0, "{side:?}, seed {seed}: light behind the board, of {}", sum(lit));
        }
    }
}
