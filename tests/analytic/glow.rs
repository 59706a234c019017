//! Light from pictures [E49].

use crate::build::{Build, matte, v};
use crate::harness::{Values, everyone, render};
use joton::film::Layer;
use joton::scene::Material;
use joton::scene::texture::{Bitmap, Filter, Space, Texels, Texture, f16};
use std::f64::consts::PI;
use std::sync::Arc;

/// Four texels, left to right and top to bottom: black, coloured, and brighter than one.
const TEXELS: [[f64; 3]; 4] = [[0.0, 0.0, 0.0], [6.0, 0.5, 0.25], [0.25, 2.0, 0.0], [1.0, 1.0, 8.0]];
const POWER: [f64; 3] = [1.0, 2.0, 0.5];

/// A square of side 2 at z = 1 that shines down by a picture: its right is +x, its up +y.
fn shining(b: &mut Build, size: [u32; 2], texels: &[[f64; 3]]) {
    let texel = |t: &[f64; 3]| [t[0], t[1], t[2], 1.0].map(|x| f16::from_f32(x as f32));
    let bitmap = Bitmap::new(size, Texels::Halves(texels.iter().map(texel).collect()));
    let glow = Texture { filter: Filter::Nearest, ..Texture::of(Arc::new(bitmap), Space::Linear) };
    let emission = POWER.map(|x| x as f32);
    let material = Material { emission, emission_texture: Some(glow), ..matte([0.0; 3]) };
    b.ceiling(v(0., 0., 1.), 1.0, &material);
    b.0.mesh.uvs =
        b.0.mesh.positions.iter().map(|p| [0.5 + 0.5 * p.x as f32, 0.5 + 0.5 * p.y as f32]).collect();
    b.0.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
}

fn lamp(b: &mut Build) {
    shining(b, [2; 2], &TEXELS);
}

/// Radiance at a place of the square.
fn radiance(x: f64, y: f64) -> [f64; 3] {
    let texel = TEXELS[usize::from(x > 0.0) + if y > 0.0 { 0 } else { 2 }];
    std::array::from_fn(|k| texel[k] * POWER[k])
}

/// The irradiance of a floor below is the sum over the picture of L cos²θ/d² dA, by shadow rays and by hits, wherever the floor is.
#[test]
fn a_picture_lights_a_floor() {
    let albedo = [0.75, 0.5, 0.25];
    for (x, y) in [(0.0, 0.0), (0.8, -0.4), (-1.5, 0.6)] {
        let mut b = Build::new(v(x, y - 0.2, 0.4), v(x, y, 0.0), 0.02, 8);
        b.floor(v(0., 0., 0.), 3.0, &matte(albedo.map(|a| a as f32)));
        lamp(&mut b);
        const CELLS: i32 = 400;
        let mut want: Values = [0.0; 3];
        for i in 0..CELLS * CELLS {
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(CELLS) * 2.0 - 1.0;
            let (u, w) = (at(i % CELLS), at(i / CELLS));
            let d2 = (u - x).powi(2) + (w - y).powi(2) + 1.0;
            let area = (2.0 / f64::from(CELLS)).powi(2);
            // both cosines are 1/d
            let l = radiance(u, w);
            want = std::array::from_fn(|k| want[k] + albedo[k] / PI * l[k] * area / (d2 * d2));
        }
        for who in everyone() {
            let shot = render(who, &b.0, "LDE", 1024);
            shot.claim(&format!("floor at {x} {y}"), shot.layer(Layer::Direct), want, 0.02);
        }
    }
}

/// Seen by itself each square of the picture has its own radiance, and nothing shines from its back.
#[test]
fn a_picture_is_seen_as_it_shines() {
    for (up, lit) in [(false, true), (true, false)] {
        let (eye, mid) = if up { (v(0., 0., 3.), 1.0) } else { (v(0., 0., -1.), 1.0) };
        let mut b = Build::new(eye, v(0., 0., mid), 0.4, 16);
        lamp(&mut b);
        for who in everyone() {
            let shot = render(who, &b.0, "LE", 8);
            for half in [[false, false], [true, false], [false, true], [true, true]] {
                let [right, low] = half;
                // the middle of a quarter of the image
                let part = |a: f64, b: f64| {
                    let inside = |t: f64, far: bool| {
                        if far { (0.6..0.9).contains(&t) } else { (0.1..0.4).contains(&t) }
                    };
                    inside(a, right) && inside(b, low)
                };
                let seen = shot.mean(&[Layer::Emission], part);
                let sum: f64 = seen.mean.iter().sum();
                let candidates: Vec<[f64; 3]> =
                    [(-1., -1.), (1., -1.), (-1., 1.), (1., 1.)].map(|(x, y)| radiance(x, y)).to_vec();
                let is_one = candidates.iter().any(|c| (0..3).all(|k| (c[k] - seen.mean[k]).abs() < 1e-3));
                assert!(if lit { is_one } else { sum == 0.0 }, "{who:?}, {half:?}: {:?}", seen.mean);
            }
        }
    }
}

/// A lamp that lies where its picture is black is dark, whatever else shines: it is no emitter, and its material shines elsewhere.
#[test]
fn a_lamp_in_the_dark_of_its_picture_is_dark() {
    let mut b = Build::new(v(0., 0., -1.), v(0., 0., 1.), 0.4, 8);
    let half = |x| if x < 4 { [0.0; 3] } else { [1.0; 3] };
    shining(&mut b, [8, 1], &std::array::from_fn::<_, 8, _>(half));
    b.0.mesh.uvs = vec![[0.3, 0.5]; b.0.mesh.positions.len()];
    b.ceiling(v(8., 0., 1.), 0.5, &Material { emission: [1.0; 3], ..matte([0.0; 3]) });
    for who in everyone() {
        let seen = render(who, &b.0, "L.*E", 4).layer(Layer::Emission);
        assert_eq!(seen.mean, [0.0; 3], "{who:?}");
    }
}
