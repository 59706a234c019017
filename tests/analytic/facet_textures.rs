//! Roughness, metal and the colour of metal from textures [E47].

use crate::build::{Build, glowing, matte, v};
use crate::harness::{EVERYTHING, Renderer, Values, everyone, render};
use joton::scene::texture::{Bitmap, Channel, Filter, NumberMap, Space, Texels, Texture};
use joton::scene::{FacetKind, Facets, Material, Metallic, Scene};
use std::f64::consts::PI;
use std::sync::Arc;

/// Two texels side by side: red is roughness, green the metallic part.
fn pair(left: [u8; 2], right: [u8; 2]) -> Texture {
    let texel = |[r, g]: [u8; 2]| [r, g, 0, 255];
    let bitmap = Bitmap::new([2, 1], Texels::Bytes(vec![texel(left), texel(right)]));
    Texture { filter: Filter::Nearest, ..Texture::of(Arc::new(bitmap), Space::Linear) }
}

fn principled(kd: [f32; 3], alpha: f32, glossy: [f32; 3]) -> Material {
    let kind = FacetKind::Schlick { ior: 1.5 };
    Material { glossy, facets: Some(Facets { alpha, kind }), ..matte(kd) }
}

/// A plate under a small lamp and a dim sky of lamps, seen from above, of one material for each half.
fn plate([left, right]: [&Material; 2], uv: impl Fn(f64) -> [f32; 2]) -> Scene {
    let mut b = Build::new(v(0., -1.2, 1.6), v(0., 0., 0.), 0.5, 16);
    for (x, material) in [(-1.0, left), (0.0, right)] {
        b.quad(v(x, -1., 0.), v(1., 0., 0.), v(0., 2., 0.), material);
    }
    b.ceiling(v(0., 0.5, 2.), 1.5, &glowing([1.0, 2.0, 0.5], [0.; 3]));
    b.sun(v(0.2, 0.5, -1.), [1.0, 0.5, 2.0]);
    b.0.mesh.uvs = b.0.mesh.positions.iter().map(|p| uv(p.x)).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    b.0
}

/// The two halves of a board of roughness and metal are what two plain materials are: one is followed, the other gathered.
#[test]
fn halves_of_a_board_are_plain_materials() {
    const HEAD_ON: f32 = 0.04;
    let kd = [0.8f32, 0.4, 0.1];
    // a roughness of 51/255 and of 178.5/255, of which 0 and 3/5 are metal
    let texels = [[51, 0], [179, 153]];
    let plain = texels.map(|[roughness, metal]| {
        let [roughness, metal] = [roughness, metal].map(|x| x as f32 / 255.0);
        let glossy = kd.map(|c| HEAD_ON + metal * (c - HEAD_ON));
        principled(kd.map(|c| c * (1.0 - metal)), roughness * roughness, glossy)
    });
    let map = |channel| Some(NumberMap { texture: pair(texels[0], texels[1]), channel, factor: 1.0 });
    let board = Material {
        roughness: map(Channel::Red),
        metallic: Some(Metallic { most: 0.6, map: map(Channel::Green) }),
        ..principled(kd, 0.5, [0.3; 3])
    };
    let uv = |x: f64| [if x < 0.0 { 0.25 } else { 0.75 }, 0.5];
    // corners at x = 0 belong to both halves: put the picture's edge there
    let along = |x: f64| [0.5 + 0.5 * x as f32, 0.5];
    for who in everyone() {
        let textured = render(who, &plate([&board, &board], along), EVERYTHING, 64);
        let wanted = render(who, &plate([&plain[0], &plain[1]], uv), EVERYTHING, 64);
        for (half, is_left) in [("followed", true), ("gathered", false)] {
            let part = |x: f64, _: f64| (x < 0.47) == is_left && !(0.47..0.53).contains(&x);
            let [a, b] = [&textured, &wanted].map(|shot| shot.mean(&joton::film::Layer::ALL, part));
            for k in 0..3 {
                let error = (a.error[k].powi(2) + b.error[k].powi(2)).sqrt();
                let off = (a.mean[k] - b.mean[k]).abs();
                assert!(
                    off < 4.0 * error + 2e-3 * b.mean[k] && b.mean[k] > 0.01,
                    "{who:?}, {half}, band {k}: {} and {} ± {error}",
                    a.mean[k],
                    b.mean[k]
                );
            }
        }
    }
}

/// Metal with a board of colours, in the sun: GGX's single scattering in f64 with the colour of each square, and what facets scatter again
/// is no more than a tenth of it.
#[test]
fn textured_metal_has_the_colour_of_each_square() {
    const ALPHA: f64 = 0.16;
    let colours = [[0.75, 0.5, 0.125], [0.25, 0.0625, 0.5]];
    let board =
        Texture { filter: Filter::Nearest, ..Texture::of(Arc::new(Bitmap::board(colours)), Space::Linear) };
    let facets = Some(Facets { alpha: ALPHA as f32, kind: FacetKind::Schlick { ior: 1.0 } });
    let metallic = Some(Metallic { most: 1.0, map: None });
    let metal =
        Material { diffuse_texture: Some(board), facets, metallic, glossy: [0.4; 3], ..matte([1.0; 3]) };
    let mut b = Build::new(v(0., 0., 200.), v(0., 0., 0.), 0.004, 8);
    b.floor(v(0., 0., 0.), 0.8, &metal);
    let sun = v(0.0, 0.5, -1.).normalize();
    b.sun(sun, [1.0, 2.0, 3.0]);
    b.0.mesh.uvs =
        b.0.mesh.positions.iter().map(|p| [0.5 + p.x as f32 / 1.6, 0.5 + p.y as f32 / 1.6]).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    let cos_i = -sun.z;
    let h = (v(0., 0., 1.) - sun).normalize();
    let (a2, cos_h) = (ALPHA * ALPHA, h.z);
    let density = a2 / (PI * (cos_h * cos_h * (a2 - 1.0) + 1.0).powi(2));
    let lambda = |c: f64| 0.5 * ((1.0 + a2 * (1.0 - c * c) / (c * c)).sqrt() - 1.0);
    let masking = 1.0 / (1.0 + lambda(cos_i) + lambda(1.0));
    for who in everyone() {
        let shot = render(who, &b.0, EVERYTHING, 8);
        for (i, seen) in shot.blocks(4).into_iter().enumerate() {
            // 2 × 2 squares over 4 × 4 blocks, of which the outer ones see past the plate in part
            let (x, up) = (i % 4, 3 - i / 4);
            if !(1..3).contains(&x) || !(1..3).contains(&up) {
                continue;
            }
            let colour = colours[(x / 2 + up / 2) % 2];
            let once: Values = std::array::from_fn(|k| {
                let fresnel = f64::from(colour[k]) + (1.0 - f64::from(colour[k])) * (1.0 - h.z).powi(5);
                // f_r cosθ E, over the cosine that is the density's
                fresnel * density * masking / 4.0 * [1.0, 2.0, 3.0][k]
            });
            for (k, once) in once.into_iter().enumerate() {
                let over = seen.mean[k] / once;
                assert!((0.995..1.1).contains(&over), "{who:?}, square {x} {up}, band {k}: {over}");
            }
        }
    }
}

/// A white board of roughness and metal in a furnace of one: never more than one, and no less than its plainest parts lose.
#[test]
fn a_white_board_of_facets_makes_no_light() {
    let map = |channel| Some(NumberMap { texture: pair([60, 255], [230, 0]), channel, factor: 1.0 });
    let white = Material {
        roughness: map(Channel::Red),
        metallic: Some(Metallic { most: 1.0, map: map(Channel::Green) }),
        ..principled([1.0; 3], 0.8, [0.5; 3])
    };
    let mut b = Build::new(v(0., -1.2, 0.5), v(0., 0., -0.5), 0.4, 16);
    b.cuboid(v(-2., -2., -2.), v(2., 2., 2.), false, &glowing([1.0; 3], [0.0; 3]));
    b.floor(v(0., 0., -0.5), 1.0, &white);
    b.0.mesh.uvs = b.0.mesh.positions.iter().map(|p| [0.5 + 0.5 * p.x as f32, 0.5]).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    for who in everyone() {
        let passes = if who == Renderer::PathTracer { 32 } else { 64 };
        let shot = render(who, &b.0, EVERYTHING, passes);
        for (half, is_left) in [("metal", true), ("plastic", false)] {
            let seen =
                shot.mean(&joton::film::Layer::ALL, |x, y| (x < 0.5) == is_left && (0.3..0.7).contains(&y));
            println!("{who:?}, {half}: {:.4} ± {:.4}", seen.mean[0], seen.error[0]);
            for k in 0..3 {
                assert!(
                    seen.mean[k] < 1.0 + 3.0 * seen.error[k] + 1e-3 && seen.mean[k] > 0.9,
                    "{who:?}, {half}, band {k}: {} ± {}",
                    seen.mean[k],
                    seen.error[k]
                );
            }
        }
    }
}
