//! Light that is scattered through a surface [E55].

use crate::build::{Build, Look, glowing, matte, v, wide};
use crate::harness::{EVERYTHING, everyone, everyone_both_ways, render, render_keeping};
use joton::film::Layer;
use joton::packed::PackedScene;
use joton::scene::Material;
use joton::scene::texture::{Bitmap, Space, Texels, Texture};
use joton::spectrum::Bands;
use std::f64::consts::PI;
use std::sync::Arc;

const KD: Bands = [0.3, 0.4, 0.1];
const TRANSMIT: Bands = [0.6, 0.2, 0.9];

fn sheet(kd: Bands, transmit: Bands) -> Material {
    Material { transmit, ..matte(kd) }
}

/// A sheet in the sun: kd E/π on the side that is lit, transmit E/π on the other, whichever of them is its front; a texture colours both,
/// also where one of them is black.
#[test]
fn a_sheet_in_the_sun_glows_on_both_sides() {
    let texel = [51u8, 102, 204, 255];
    let texture = Texture::of(Arc::new(Bitmap::new([1, 1], Texels::Bytes(vec![texel]))), Space::Linear);
    for (seen_from, to_front) in [(1.0, true), (-1.0, true), (1.0, false), (-1.0, false)] {
        for textured in [false, true] {
            let mut material = sheet(KD, TRANSMIT);
            let mut factor = [1.0; 3];
            if textured {
                (material.diffuse, material.diffuse_texture) = ([0.4, 0.8, 0.0], Some(texture.clone()));
                factor = [0, 1, 2].map(|b| f64::from(texel[b]) / 255.0);
            }
            let mut b = Build::new(v(0.3, 0.2, 2.0 * seen_from), v(0., 0., 0.), 0.2, 8);
            if to_front {
                b.floor(v(0., 0., 0.), 1.0, &material)
            } else {
                b.ceiling(v(0., 0., 0.), 1.0, &material)
            }
            b.0.mesh.uvs = vec![[0.5; 2]; b.0.mesh.positions.len()];
            b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
            let sun = v(0.4, -0.3, -1.0).normalize();
            b.sun(sun, [1.0, 2.0, 3.0]);
            let part = if seen_from > 0.0 { material.diffuse } else { material.transmit };
            let want = std::array::from_fn(|k| wide(part)[k] * factor[k] * -sun.z * [1.0, 2.0, 3.0][k] / PI);
            for who in everyone() {
                let shot = render(who, &b.0, "LDE", 8);
                // textures are kept in half floats
                let name = format!("sheet from {seen_from}, front up {to_front}, textured {textured}");
                shot.claim(&name, shot.layer(Layer::Direct), want, 1e-3);
            }
        }
    }
}

/// A lamp in a closed globe that light comes through, seen from outside: E = I/R²/(1 − kd) inside, L = transmit E/π; E of the lamp itself
/// without the denominator.
#[test]
fn a_globe_shines_as_its_closed_form_says() {
    let intensity = [1.0, 2.0, 3.0];
    let mut b = Build::new(v(0.3, 0.2, 4.0), v(0., 0., 0.), 0.1, 8);
    b.sphere(v(0., 0., 0.), 1.0, 4, Look::OutwardSmooth, &sheet(KD, TRANSMIT));
    b.point(v(0., 0., 0.), intensity);
    assert!(PackedScene::new(&b.0).out_of_reach.is_empty());
    for (who, keep) in everyone_both_ways(&b.0) {
        let shot = render_keeping(who, &b.0, EVERYTHING, 96, keep);
        let direct: [f64; 3] = std::array::from_fn(|i| wide(TRANSMIT)[i] * wide(intensity)[i] / PI);
        let rest = std::array::from_fn(|i| direct[i] * wide(KD)[i] / (1.0 - wide(KD)[i]));
        // facets, as in `furnace.rs`
        shot.claim("globe, direct", shot.layer(Layer::Direct), direct, 0.005);
        shot.claim("globe, diffuse", shot.layer(Layer::Diffuse), rest, 0.05);
    }
}

/// Light of outside comes into a closed room of paper: the walls are not left out for what lies behind them, and its ceiling glows.
#[test]
fn the_sun_shines_into_a_closed_room_of_paper() {
    for outward in [false, true] {
        let mut b = Build::new(v(0.1, 0.2, -0.7), v(0., 0., 1.), 0.2, 8);
        b.cuboid(v(-1., -1., -1.), v(1., 1., 1.), outward, &sheet(KD, TRANSMIT));
        let sun = v(0.5, 0.2, -1.0).normalize();
        b.sun(sun, [1.0; 3]);
        assert_eq!(PackedScene::new(&b.0).emitters.len(), 1, "the sun is out of reach");
        let want = std::array::from_fn(|k| wide(TRANSMIT)[k] * -sun.z / PI);
        for who in everyone() {
            let shot = render(who, &b.0, "LDE", 8);
            shot.claim("room of paper", shot.layer(Layer::Direct), want, 1e-3);
        }
    }
}

/// A sheet that absorbs nothing disappears in a furnace: one of two parts, in bands that differ, flat or with smooth normals.
#[test]
fn a_white_sheet_disappears_in_a_furnace() {
    // of a closed body light comes out after many events: in one colour they have no noise
    let [white, coloured] = [sheet([0.4; 3], [0.6; 3]), sheet([0.3, 0.5, 0.6], [0.7, 0.5, 0.4])];
    let mut b = Build::new(v(0., -1.2, 0.6), v(0., 0., -0.1), 0.4, 16);
    b.cuboid(v(-2., -2., -2.), v(2., 2., 2.), false, &glowing([0.5; 3], [0.5; 3]));
    b.floor(v(-0.5, 0., -0.1), 0.4, &coloured);
    b.sphere(v(0.5, 0.2, 0.0), 0.4, 3, Look::OutwardSmooth, &white);
    for (who, keep) in everyone_both_ways(&b.0) {
        let shot = render_keeping(who, &b.0, EVERYTHING, 64, keep);
        let seen = shot.mean(&Layer::ALL, |_, _| true);
        shot.claim("white sheet in a furnace", seen, [1.0; 3], 0.02);
        // discs of the map reach over the edges of what curves, in so small a picture
        let blocks = if keep.is_empty() { shot.blocks(4) } else { Vec::new() };
        for (i, block) in blocks.into_iter().enumerate() {
            shot.claim(&format!("white sheet, block {i}"), block, [1.0; 3], 0.06);
        }
    }
}

/// What a place behind a sheet gets from it: a lamp that a small part of the sheet alone sees, and the irradiance by the form factor of
/// a disc on its axis, B R²/(R² + h²).
#[test]
fn a_lit_disc_lights_what_is_behind_it() {
    let (radius, height) = (0.5, 1.0);
    let disc = sheet(KD, TRANSMIT);
    let grey = matte([0.5; 3]);
    let mut b = Build::new(v(0.0, -1.0, 0.5), v(0., 0., 0.), 0.005, 8);
    b.floor(v(0., 0., 0.), 0.02, &grey);
    let corner = |i: u32| {
        let phi = 2.0 * PI * f64::from(i) / 96.0;
        v(radius * phi.cos(), radius * phi.sin(), height)
    };
    (0..96).for_each(|i| b.triangle([v(0., 0., height), corner(i), corner(i + 1)], &disc));
    // no light comes to the floor but through the disc
    b.sun(v(0., 0., -1.), [1.0, 2.0, 3.0]);
    let share = radius * radius / (radius * radius + height * height);
    let want: [f64; 3] = std::array::from_fn(|k| 0.5 / PI * wide(TRANSMIT)[k] * [1.0, 2.0, 3.0][k] * share);
    for who in everyone() {
        let shot = render(who, &b.0, "LD.*DE", 96);
        // 96 corners: the disc's area is 0.07 % too small
        shot.claim("floor behind a disc", shot.layer(Layer::Diffuse), want, 0.03);
    }
}
