//! shading/texture.wgsl and its counterpart on the host against the formula in f64 [E37].

use crate::common::scenes::Builder;
use crate::common::{Row, Snippet, floats, random, row};
use crate::device_or_return;
use joton::backend::cpu::harness::texture_lookup;
use joton::backend::gpu::harness::Harness;
use joton::packed::PackedScene;
use joton::scene::Material;
use joton::scene::texture::{Bitmap, Filter, Opacity, Space, Texels, Texture, Wrap, f16};
use std::sync::Arc;

/// A picture of random texels.
fn picture(size: [u32; 2], halves: bool) -> Arc<Bitmap> {
    let texels = (0..size[0] * size[1]).map(|i| random(71 + size[0], i as usize));
    let texels = if halves {
        Texels::Halves(texels.map(|t| t.map(f16::from_f32)).collect())
    } else {
        Texels::Bytes(texels.map(|t| t.map(|x| (x * 256.0) as u8)).collect())
    };
    Arc::new(Bitmap::new(size, texels))
}

/// Every way to lie on a surface, with pictures of sizes that halve badly.
fn textures() -> Vec<Texture> {
    let sizes = [[1, 1], [2, 2], [5, 3], [16, 9], [1, 7], [33, 32]];
    let mut all = Vec::new();
    for (i, size) in sizes.into_iter().enumerate() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for (halves, space) in [(true, Space::Linear), (false, Space::Linear), (false, Space::Srgb)] {
                let filter = if (i + all.len()) % 4 == 3 { Filter::Nearest } else { Filter::Linear };
                let [a, b, c, d] = random(72, all.len());
                let scale = [4.0 * a - 2.0, 0.3 + b];
                let lies = Texture {
                    wrap,
                    filter,
                    scale,
                    offset: [c, -d],
                    ..Texture::of(picture(size, halves), space)
                };
                all.push(lies);
            }
        }
    }
    all
}

/// Texels of a level, f64 and linear.
struct Level {
    size: [usize; 2],
    texels: Vec<[f64; 4]>,
}

/// The levels of a picture, each the mean of the one before by area.
fn levels(t: &Texture) -> Vec<Level> {
    let linear = |x: f64| match t.space {
        Space::Linear => x,
        Space::Srgb if x <= 0.04045 => x / 12.92,
        Space::Srgb => ((x + 0.055) / 1.055).powf(2.4),
    };
    let texels = match &t.bitmap.texels {
        Texels::Halves(texels) => texels.iter().map(|t| t.map(f64::from)).collect(),
        Texels::Bytes(texels) => {
            let of = |t: &[u8; 4]| {
                let [r, g, b, a] = t.map(|x| f64::from(x) / 255.0);
                [linear(r), linear(g), linear(b), a]
            };
            texels.iter().map(of).collect()
        }
    };
    let mut all = vec![Level { size: t.bitmap.size.map(|s| s as usize), texels }];
    while all[all.len() - 1].size != [1, 1] {
        let last = &all[all.len() - 1];
        let size = last.size.map(|s| (s / 2).max(1));
        let mut texels = Vec::new();
        for i in 0..size[0] * size[1] {
            let at = [i % size[0], i / size[0]];
            let ends = [0, 1].map(|k| [at[k], at[k] + 1].map(|x| (x * last.size[k]) as f64 / size[k] as f64));
            let mut sum = [0.0; 4];
            for (j, texel) in last.texels.iter().enumerate() {
                let from = [j % last.size[0], j / last.size[0]];
                let covered =
                    [0, 1].map(|k| ((from[k] + 1) as f64).min(ends[k][1]) - (from[k] as f64).max(ends[k][0]));
                let share = covered.iter().map(|c| c.max(0.0)).product::<f64>()
                    / ends.iter().map(|[a, b]| b - a).product::<f64>();
                sum = std::array::from_fn(|c| sum[c] + share * texel[c]);
            }
            texels.push(sum);
        }
        all.push(Level { size, texels });
    }
    all
}

/// What a level shows: the sum over all texels of a tent, or a box, about each, wherever the picture comes again.
fn shown(t: &Texture, level: &Level, uv: [f64; 2]) -> [f64; 4] {
    let axis = |x: f64, count: usize| -> Vec<(usize, f64)> {
        let n = count as f64;
        // texel i of the endless row lies about (i + 1/2)/n
        let x = if t.wrap == Wrap::Clamp { x.clamp(0.0, 1.0) } else { x } * n;
        let first = x.floor() as i64 - 2;
        let of = |i: i64| {
            let away = (x - (i as f64 + 0.5)).abs();
            let weight = match t.filter {
                Filter::Linear => (1.0 - away).max(0.0),
                Filter::Nearest => f64::from(u8::from(x.floor() as i64 == i)),
            };
            let c = count as i64;
            let number = match t.wrap {
                Wrap::Repeat => i.rem_euclid(c),
                Wrap::Clamp => i.clamp(0, c - 1),
                Wrap::Mirror if i.rem_euclid(2 * c) < c => i.rem_euclid(2 * c),
                Wrap::Mirror => 2 * c - 1 - i.rem_euclid(2 * c),
            };
            (number as usize, weight)
        };
        (first..first + 5).map(of).collect()
    };
    let mut sum = [0.0; 4];
    for (column, across) in axis(uv[0], level.size[0]) {
        for (row, up) in axis(uv[1], level.size[1]) {
            let texel = level.texels[(level.size[1] - 1 - row) * level.size[0] + column];
            sum = std::array::from_fn(|c| sum[c] + across * up * texel[c]);
        }
    }
    sum
}

/// What is seen at a width.
fn reference(t: &Texture, levels: &[Level], uv: [f64; 2], width: f64) -> [f64; 4] {
    let at = [0, 1].map(|k| uv[k] * f64::from(t.scale[k]) + f64::from(t.offset[k]));
    let area = t.bitmap.size.iter().map(|s| f64::from(*s)).product::<f64>()
        * f64::from(t.scale[0] * t.scale[1]).abs();
    let level = (width * area.sqrt()).max(1.0).log2().min(levels.len() as f64 - 1.0);
    let finer = level.floor();
    let [a, b] =
        [finer, (finer + 1.0).min(levels.len() as f64 - 1.0)].map(|l| shown(t, &levels[l as usize], at));
    std::array::from_fn(|c| a[c] + (level - finer) * (b[c] - a[c]))
}

/// A scene of one triangle for each texture.
fn scene(textures: &[Texture]) -> PackedScene {
    let mut b = Builder::new([0., 0., 5.], [0., 0., 0.], [0., 1., 0.], 0.7, 8);
    b.point_light([0., 0., 4.], 1.0);
    for (i, texture) in textures.iter().enumerate() {
        let m = b.material(Material {
            diffuse_texture: Some(texture.clone()),
            opacity: Some(Opacity { factor: 0.5, texture: Some(texture.clone()) }),
            ..Material::matte("m", [1.0; 3])
        });
        b.quad([i as f64, 0., 0.], [1., 0., 0.], [0., 1., 0.], m);
    }
    PackedScene::whole(&b.scene)
}

#[test]
fn lookups_are_those_of_the_formula() {
    let context = device_or_return!();
    let textures = textures();
    let packed = scene(&textures);
    let mut harness = Harness::new(context);
    harness.scene("textures", &packed.textures.records);
    harness.scene("texels", &packed.textures.texels);
    let mut inputs: Vec<[Row; 1]> = Vec::new();
    for number in 0..packed.textures.records.len() {
        for i in 0..60 {
            let [u, v, w, x] = random(73 + number as u32, i);
            let width = if x < 0.4 { 0.0 } else { w * w };
            let [_, _, number, _] = [0, 0, number as u32, 0];
            inputs.push([[(6.0 * u - 3.0).to_bits(), (6.0 * v - 3.0).to_bits(), width.to_bits(), number]]);
        }
    }
    let code = "let i = in_f(0u); let n = in_u(0u).w;
        out_f(0u, vec4(texture_lookup(n, i.xy, i.z).rgb, texture_number(n, i.xy, i.z)));";
    let imports = &["shading/texture.wgsl"];
    let out: Vec<[Row; 1]> = Snippet::new(imports, code).run_in(context, &mut harness, &[], &inputs);
    let all: Vec<Vec<Level>> = textures.iter().map(levels).collect();
    let mut compared = 0;
    for ([input], [o]) in inputs.iter().zip(out) {
        let [u, v, width] = [0, 1, 2].map(|k| f32::from_bits(input[k]));
        let number = input[3] as usize;
        // of each texture there is one record for its colour, and one for the opacity, which has a factor
        let (t, levels) = (&textures[number / 2], &all[number / 2]);
        let record = &packed.textures.records[number];
        assert_eq!(record.factor, if number.is_multiple_of(2) { 1.0 } else { 0.5 });
        if t.filter == Filter::Nearest {
            // on an edge between texels rounding decides
            let near_edge = |uv: f32, k: usize| {
                let x = f64::from(uv) * f64::from(t.scale[k]) + f64::from(t.offset[k]);
                let x = x * f64::from(t.bitmap.size[k]);
                (x - x.round()).abs() < 1e-3
            };
            if near_edge(u, 0) || near_edge(v, 1) {
                continue;
            }
        }
        let mut wanted = reference(t, levels, [f64::from(u), f64::from(v)], f64::from(width));
        wanted[3] *= f64::from(record.factor);
        // smaller levels are rounded to half floats, or to bytes, which the curve of sRGB makes 2.3 times as coarse
        let is_first = f64::from(width) == 0.0;
        let tolerance = match (&t.bitmap.texels, is_first) {
            (_, true) => 3e-5,
            (Texels::Halves(_), false) => 1e-3,
            (Texels::Bytes(_), false) => 0.5 / 255.0 * 2.3 + 1e-4,
        };
        let host = texture_lookup(&packed, number as u32 + 1, [u, v], width);
        for (who, got) in [("device", floats(o)), ("host", host)] {
            for c in 0..4 {
                let away = (f64::from(got[c]) - wanted[c]).abs();
                assert!(away < tolerance, "{who}, texture {number}, {u} {v} {width}: {got:?}, {wanted:?}");
            }
        }
        compared += 1;
    }
    assert!(compared > 3000, "{compared}");
}

/// Where a texture lies on a triangle: at its corners and between, and how large it is there; whichever corner comes first.
#[test]
fn coordinates_lie_between_those_of_the_corners() {
    let context = device_or_return!();
    let mut b = Builder::new([0., 0., 5.], [0., 0., 0.], [0., 1., 0.], 0.7, 8);
    b.point_light([0., 0., 4.], 1.0);
    let texture = Texture::of(Arc::new(Bitmap::board([[0.5; 3], [0.1; 3]])), Space::Linear);
    let m = b.material(Material { diffuse_texture: Some(texture), ..Material::matte("m", [1.0; 3]) });
    b.quad([0., 0., 0.], [2., 0., 0.], [0., 3., 0.], m);
    // slivers begin at another corner
    b.quad([0., 0., 1.], [20., 0., 0.], [0., 0.001, 0.], m);
    // u runs along x, v along y, twice as fast
    b.scene.mesh.uvs = b.scene.mesh.positions.iter().map(|p| [p.x as f32, 2.0 * p.y as f32]).collect();
    b.scene.mesh.triangles.iter_mut().for_each(|t| t.uv = Some(t.vertex));
    let packed = PackedScene::whole(&b.scene);
    let mut harness = Harness::new(context);
    harness.scene("triangles", &packed.triangles);
    harness.scene("uvs", &packed.textures.uvs);
    let inputs: Vec<[Row; 1]> = (0..packed.triangles.len() * 50)
        .map(|i| {
            let [a, b, ..] = random(90, i);
            let [a, b] = if a + b > 1.0 { [1.0 - a, 1.0 - b] } else { [a, b] };
            [row([a, b, f32::from_bits((i % packed.triangles.len()) as u32), 0.0])]
        })
        .collect();
    let code = "let i = in_f(0u); let t = in_u(0u).z;
        let p = texture_place(t, triangle_at(t), i.xy); out_f(0u, vec4(p.uv, p.per_unit, 0.0));";
    let imports = &["shading/texture.wgsl"];
    let out: Vec<[Row; 1]> = Snippet::new(imports, code).run_in(context, &mut harness, &[], &inputs);
    for ([input], [o]) in inputs.iter().zip(out) {
        let ([a, b, ..], [u, v, per_unit, _]) = (floats(*input), floats(o));
        let t = &packed.triangles[input[2] as usize];
        let place = (t.v0 + t.e1 * a + t.e2 * b).as_dvec3() * packed.world_scale + packed.world_center;
        assert!((place.x - f64::from(u)).abs() < 1e-4, "{place} {u}");
        assert!((2.0 * place.y - f64::from(v)).abs() < 1e-4, "{place} {v}");
        // the area of a square of one unit of length is two, in units of the coordinates
        let wanted = 2f64.sqrt() * packed.world_scale;
        assert!((f64::from(per_unit) / wanted - 1.0).abs() < 2e-3, "{per_unit} {wanted}");
    }
}
