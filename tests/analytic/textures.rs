//! Textures and surfaces of which some is not there.

use crate::build::{Build, glowing, matte, v, wide};
use crate::harness::{EVERYTHING, Values, everyone, everyone_both_ways, render, render_keeping};
use joton::film::Layer;
use joton::scene::Material;
use joton::scene::texture::{Bitmap, Filter, Opacity, Space, Texture};
use std::f64::consts::PI;
use std::sync::Arc;

/// [E37] A board in the sun, seen from above: ρE/π, with the ρ of each square, in the right place.
#[test]
fn a_board_shows_its_squares() {
    // half floats have these
    let colours = [[0.75, 0.5, 0.125], [0.25, 0.0625, 0.5]];
    let bitmap = Arc::new(Bitmap::board(colours));
    let board = Texture { filter: Filter::Nearest, scale: [2.0; 2], ..Texture::of(bitmap, Space::Linear) };
    let kd = [1.0, 0.5, 1.0];
    let mut b = Build::new(v(0., 0., 2.), v(0., 0., 0.), 0.5, 16);
    b.floor(v(0., 0., 0.), 1.0, &Material { diffuse_texture: Some(board), ..matte(kd) });
    b.0.mesh.uvs =
        b.0.mesh.positions.iter().map(|p| [0.5 + 0.5 * p.x as f32, 0.5 + 0.5 * p.y as f32]).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    b.sun(v(0., 0., -1.), [1.0, 2.0, 3.0]);
    for who in everyone() {
        let shot = render(who, &b.0, EVERYTHING, 8);
        for (i, seen) in shot.blocks(4).into_iter().enumerate() {
            // rows run down, coordinates up; the first colour is at the lower left
            let (x, up) = (i % 4, 3 - i / 4);
            let colour = colours[(x + up) % 2];
            let want: Values =
                std::array::from_fn(|k| wide(colour)[k] * wide(kd)[k] * wide([1.0, 2.0, 3.0])[k] / PI);
            shot.claim(&format!("square {x} {up}"), seen, want, 2e-4);
        }
    }
}

/// A material of which so much is there.
fn in_part(opacity: f32, material: Material) -> Material {
    Material { opacity: Some(Opacity { factor: opacity, texture: None }), ..material }
}

/// [E38] A sheet of opacity α over a floor, in the sun: the floor has 1 − α of its light, and where it is seen through the sheet, that
/// much of it beside α of the sheet's own.
#[test]
fn a_sheet_in_part_lets_the_rest_through() {
    const OPACITY: f64 = 0.25;
    let albedo = [0.8, 0.5, 0.2];
    let irradiance = [1.0, 2.0, 3.0];
    let scene = |eye| {
        let mut b = Build::new(eye, v(0., 0., 0.), 0.05, 16);
        b.floor(v(0., 0., 0.), 10.0, &matte(albedo));
        b.floor(v(0., 0., 1.), 10.0, &in_part(OPACITY as f32, matte([0.5; 3])));
        b.sun(v(0.1, 0.2, -1.), irradiance);
        b
    };
    let down = v(0.1, 0.2, -1.).normalize().z.abs();
    let of = |i: usize, albedo: f64| albedo * wide(irradiance)[i] * down / PI;
    for who in everyone() {
        let below: Values = std::array::from_fn(|i| (1.0 - OPACITY) * of(i, wide(albedo)[i]));
        let shot = render(who, &scene(v(0., -0.4, 0.5)).0, "LDE", 1024);
        // chance decides about each shadow ray: 3 standard errors of 262,144 are half of that
        shot.claim("under the sheet", shot.layer(Layer::Direct), below, 0.015);
        let above: Values = std::array::from_fn(|i| {
            OPACITY * of(i, 0.5) + (1.0 - OPACITY) * (1.0 - OPACITY) * of(i, wide(albedo)[i])
        });
        let shot = render(who, &scene(v(0., -0.4, 1.5)).0, "LDE", 1024);
        shot.claim("through the sheet", shot.layer(Layer::Direct), above, 0.02);
    }
}

/// [E38] A white partition of a furnace of which half is there cannot be seen: it reflects and lets through what is the same.
#[test]
fn a_white_partition_in_part_disappears_in_a_furnace() {
    let mut b = Build::new(v(0.2, 0.1, -0.5), v(0.3, 0.5, 0.2), 1.0, 16);
    b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &glowing([0.5, 0.7, 0.8], [0.5, 0.3, 0.2]));
    b.floor(v(0., 0., 0.2), 1.0, &in_part(0.5, matte([1.0; 3])));
    for (who, keep) in everyone_both_ways(&b.0) {
        let shot = render_keeping(who, &b.0, EVERYTHING, 96, keep);
        let seen = shot.mean(&Layer::ALL, |_, _| true);
        shot.claim(&format!("furnace with a partition, {keep:?}"), seen, [1.0; 3], 0.02);
    }
}
