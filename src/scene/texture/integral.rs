//! Integral: the mean of a texture over a triangle, by which lights with textures are picked.

use super::{Bitmap, Texels, Texture, Wrap};

/// Texels that are looked at for a triangle, at most: beyond, it shows the picture so often that the mean of all of it serves.
const MOST: f64 = 4e6;
/// Rows of the places of a triangle that are looked at beside the middles of texels.
const ROWS: u32 = 4;
/// A triangle of which some may shine is taken to shine with this part of the brightest texel about it, at least.
const LEAST: f32 = 1e-3;

impl Texture {
    /// Mean over a triangle of texture coordinates, linear red, green and blue: of the texels whose middles are in it, and of some places. It is
    /// black where all that a lookup could show is.
    pub(crate) fn mean_over(&self, corners: [[f32; 2]; 3]) -> [f32; 3] {
        let [width, height] = self.bitmap.size.map(f64::from);
        let texels = corners.map(|uv| {
            let at = |k: usize, size: f64| {
                (f64::from(uv[k]) * f64::from(self.scale[k]) + f64::from(self.offset[k])) * size
            };
            [at(0, width), at(1, height)]
        });
        let range = |k: usize| {
            let [least, most] = texels
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], t| [a.min(t[k]), b.max(t[k])]);
            // what lies between texels shows those beside it
            [(least - 1.0).floor(), (most + 1.0).ceil()]
        };
        let [across, up] = [range(0), range(1)];
        if (across[1] - across[0]) * (up[1] - up[0]) > MOST {
            return self.mean();
        }
        let reader = Reader::new(self);
        let (mut sum, mut count, mut most) = ([0.0f64; 3], 0.0f64, [0.0f32; 3]);
        let mut add = |texel: [f32; 3]| {
            sum = std::array::from_fn(|k| sum[k] + f64::from(texel[k]));
            count += 1.0;
        };
        for y in up[0] as i64..up[1] as i64 {
            for x in across[0] as i64..across[1] as i64 {
                let texel = reader.at([x, y]);
                most = std::array::from_fn(|k| most[k].max(texel[k]));
                if holds(&texels, [x as f64 + 0.5, y as f64 + 0.5]) {
                    add(texel);
                }
            }
        }
        // middles of as many equal triangles, whatever lies between the texels' own
        let corner =
            |i: u32, j: u32, third: f64| [i, j].map(|x| (f64::from(x) + third / 3.0) / f64::from(ROWS));
        let upright = (0..ROWS).flat_map(|i| (0..ROWS - i).map(move |j| corner(i, j, 1.0)));
        let turned = (1..ROWS).flat_map(|i| (1..=ROWS - i).map(move |j| corner(i - 1, j - 1, 2.0)));
        for [b, c] in upright.chain(turned) {
            let at = |k: usize| (1.0 - b - c) * texels[0][k] + b * texels[1][k] + c * texels[2][k];
            add(reader.at([at(0).floor() as i64, at(1).floor() as i64]));
        }
        std::array::from_fn(|k| ((sum[k] / count) as f32).max(most[k] * LEAST))
    }
}

/// Whether a triangle, in whichever turn, holds a place.
fn holds(corners: &[[f64; 2]; 3], place: [f64; 2]) -> bool {
    let side = |i: usize| {
        let [a, b] = [corners[i], corners[(i + 1) % 3]];
        (b[0] - a[0]) * (place[1] - a[1]) - (b[1] - a[1]) * (place[0] - a[0])
    };
    let sides = [side(0), side(1), side(2)];
    sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0)
}

/// Texels by their column and their row from below, wherever the picture comes again.
struct Reader<'a> {
    bitmap: &'a Bitmap,
    wrap: Wrap,
    linear: Vec<f32>,
}

impl<'a> Reader<'a> {
    fn new(texture: &'a Texture) -> Self {
        Self { bitmap: &texture.bitmap, wrap: texture.wrap, linear: texture.space.linear_bytes() }
    }

    fn at(&self, place: [i64; 2]) -> [f32; 3] {
        let [column, row] = [0, 1].map(|k| {
            let (i, count) = (place[k], i64::from(self.bitmap.size[k]));
            match self.wrap {
                Wrap::Repeat => i.rem_euclid(count),
                Wrap::Clamp => i.clamp(0, count - 1),
                Wrap::Mirror => {
                    let twice = i.rem_euclid(2 * count);
                    twice.min(2 * count - 1 - twice)
                }
            }
        });
        let [width, height] = self.bitmap.size.map(i64::from);
        let number = ((height - 1 - row) * width + column) as usize;
        match &self.bitmap.texels {
            Texels::Bytes(texels) => [0, 1, 2].map(|k| self.linear[usize::from(texels[number][k])]),
            Texels::Halves(texels) => [0, 1, 2].map(|k| f32::from(texels[number][k])),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::texture::{Space, Texture};
    use std::sync::Arc;

    /// The mean over a triangle is that of what it covers, in whichever turn and tile; what shows nothing bright is black.
    #[test]
    fn triangles_shine_by_what_they_cover() {
        const SIDE: u32 = 64;
        // brightness rises to the right, and the upper half is black
        let texel = |i: u32| {
            let (x, row) = (i % SIDE, i / SIDE);
            [if row < SIDE / 2 { 0 } else { (4 * x) as u8 }, 0, 0, 255]
        };
        let texels = Texels::Bytes((0..SIDE * SIDE).map(texel).collect());
        let texture = Texture::of(Arc::new(Bitmap::new([SIDE; 2], texels)), Space::Linear);
        let whole = 4.0 * 63.0 / 255.0;
        for tile in [0.0, 3.0, -2.0] {
            let at = |u: f32, v: f32| [u + tile, v + tile];
            let [a, b, c] = [at(0.0, 0.02), at(0.75, 0.02), at(0.0, 0.45)];
            for corners in [[a, b, c], [b, a, c]] {
                let [red, green, _] = texture.mean_over(corners);
                // a quarter of the way, in the mean
                assert!((red - 0.25 * whole).abs() < 0.01 && green == 0.0, "{red} {whole}");
            }
            let black = [at(0.1, 0.6), at(0.9, 0.6), at(0.5, 0.9)];
            assert_eq!(texture.mean_over(black), [0.0; 3]);
        }
        // smaller than a texel
        let tiny = texture.mean_over([[0.5, 0.25], [0.501, 0.25], [0.5, 0.251]]);
        assert!((tiny[0] - 128.0 / 255.0).abs() < 0.02, "{tiny:?}");
    }
}
