//! Normals and heights from pictures [E48].

use crate::build::{Build, glowing, matte, v};
use crate::harness::{EVERYTHING, Renderer, Values, everyone, render};
use glam::{DMat2, DVec2, DVec3};
use joton::film::Layer;
use joton::scene::Material;
use joton::scene::texture::{Bitmap, Channel, Relief, ReliefKind, Space, Texels, Texture, Wrap};
use std::f64::consts::PI;
use std::sync::Arc;

fn picture(size: [u32; 2], texels: Vec<[u8; 4]>) -> Texture {
    Texture::of(Arc::new(Bitmap::new(size, Texels::Bytes(texels))), Space::Linear)
}

fn with(relief: Relief, kd: [f32; 3]) -> Material {
    Material { relief: Some(relief), ..matte(kd) }
}

/// A plate in the sun, seen from above; texture coordinates are a matrix times the place.
fn plate(material: &Material, coordinates: DMat2, sun: DVec3) -> Build {
    let mut b = Build::new(v(0., 0., 2.), v(0., 0., 0.), 0.2, 8);
    b.floor(v(0., 0., 0.), 1.0, material);
    let uv = |p: &DVec3| (coordinates * DVec2::new(p.x, p.y) + DVec2::splat(0.5)).as_vec2().to_array();
    b.0.mesh.uvs = b.0.mesh.positions.iter().map(uv).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    b.sun(sun, [1.0, 2.0, 3.0]);
    b
}

/// Radiance of a matte plate of this normal.
fn lit(kd: [f64; 3], n: DVec3, sun: DVec3) -> Values {
    let cosine = (-n.normalize().dot(sun.normalize())).max(0.0);
    std::array::from_fn(|k| kd[k] * [1.0, 2.0, 3.0][k] * cosine / PI)
}

/// A normal map of one colour tilts a plate in the sun, along the way in which its picture lies: as it is, turned, stretched, and mirrored.
#[test]
fn a_normal_map_tilts_a_plate() {
    let texel = [178u8, 77, 230, 255];
    let texture = picture([1, 1], vec![texel]);
    let strength = 0.5;
    let material = with(Relief { texture, kind: ReliefKind::Normals { strength } }, [0.75, 0.5, 0.25]);
    let [x, y, z] = [0, 1, 2].map(|k| f64::from(texel[k]) / 255.0 * 2.0 - 1.0);
    let sun = v(0.3, -0.4, -1.0);
    for (name, m) in [
        ("as it is", DMat2::from_cols_array(&[1., 0., 0., 1.])),
        ("turned", DMat2::from_cols_array(&[0., 1., -1., 0.])),
        ("stretched and turned", DMat2::from_cols_array(&[3., 3., -0.5, 0.5])),
        ("mirrored", DMat2::from_cols_array(&[-1., 0., 0., 1.])),
        ("upside down", DMat2::from_cols_array(&[1., 0., 0., -2.])),
    ] {
        // where the picture goes right, and at right angles to that, up rather than down
        let ways = m.inverse();
        let right = ways.x_axis.normalize();
        let across = right.perp();
        let up = across * across.dot(ways.y_axis).signum();
        let along = 0.5 * (x * right + y * up);
        let n = v(along.x, along.y, z);
        for who in everyone() {
            let shot = render(who, &plate(&material, m, sun).0, "LDE", 8);
            shot.claim(name, shot.layer(Layer::Direct), lit([0.75, 0.5, 0.25], n, sun), 1e-3);
        }
    }
}

/// A ramp of heights is a plate that is tilted; in lengths of the scene, and in widths of the picture.
#[test]
fn a_ramp_of_heights_tilts_a_plate() {
    // 16 texels from 0 to 255 by 17
    let texels = (0..16).map(|i| [i * 17; 4]).collect();
    let texture = Texture { wrap: Wrap::Clamp, ..picture([16, 1], texels) };
    let sun = v(0.4, 0.1, -1.0);
    // the picture is 4 wide and 2 high: its sides are √8 in the mean
    let coordinates = DMat2::from_diagonal(DVec2::new(0.25, 0.5));
    // one texel is a quarter, over which the height grows by a fifteenth
    let slope = |height: f64| height / 15.0 / 0.25;
    for (height, is_relative, n) in
        [(0.9, false, v(-slope(0.9), 0.0, 1.0)), (0.3, true, v(-slope(0.3 * 8f64.sqrt()), 0.0, 1.0))]
    {
        let kind = ReliefKind::Heights { channel: Channel::Green, height: height as f32, is_relative };
        let material = with(Relief { texture: texture.clone(), kind }, [0.5; 3]);
        for who in everyone() {
            let shot = render(who, &plate(&material, coordinates, sun).0, "LDE", 8);
            shot.claim(&format!("height {height}"), shot.layer(Layer::Direct), lit([0.5; 3], n, sun), 2e-3);
        }
    }
}

/// The steepest normals of a white plate: in a furnace of one it is never brighter than one, and what it loses, since its samples that leave below the
/// surface are lost, is stated in docs/MATERIALS.md. No light comes through it from behind.
#[test]
fn a_steep_relief_makes_no_light() {
    let texels = [[255, 128, 160, 255], [0, 128, 160, 255], [128, 255, 160, 255], [128, 0, 160, 255]];
    // wider than a pixel: what is smaller is seen as the mean of its normals, which is flatter
    let texture = Texture { scale: [2.0; 2], ..picture([2, 2], texels.to_vec()) };
    for (strength, least) in [(0.25, 0.93), (1.0, 0.6)] {
        let relief = Relief { texture: texture.clone(), kind: ReliefKind::Normals { strength } };
        let white = with(relief, [1.0; 3]);
        let plate = |b: &mut Build| {
            b.floor(v(0., 0., -0.5), 1.0, &white);
            b.0.mesh.uvs = b.0.mesh.positions.iter().map(|p| [p.x as f32, p.y as f32]).collect();
            b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
        };
        let mut furnace = Build::new(v(0., -1.2, 0.5), v(0., 0., -0.5), 0.4, 8);
        furnace.cuboid(v(-2., -2., -2.), v(2., 2., 2.), false, &glowing([1.0; 3], [0.0; 3]));
        plate(&mut furnace);
        let mut behind = Build::new(v(0., -1.2, 0.5), v(0., 0., -0.5), 0.4, 8);
        plate(&mut behind);
        behind.sun(v(0.8, 0.0, 0.3), [1.0; 3]);
        for who in everyone() {
            let passes = if who == Renderer::PathTracer { 16 } else { 64 };
            let shot = render(who, &furnace.0, EVERYTHING, passes);
            let seen = shot.mean(&Layer::ALL, |_, _| true);
            println!("{who:?}, strength {strength}: {:.4} ± {:.4}", seen.mean[0], seen.error[0]);
            assert!(seen.mean[0] < 1.0 + 3.0 * seen.error[0], "{who:?}, {strength}: {seen:?}");
            assert!(seen.mean[0] > least, "{who:?}, {strength}: {seen:?}");
            let shot = render(who, &behind.0, EVERYTHING, 8);
            assert_eq!(shot.mean(&Layer::ALL, |_, _| true).mean, [0.0; 3], "{who:?}: light from behind");
        }
    }
}
