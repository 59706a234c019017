//! Levels: a picture again and again with half as many texels across and down, by a box filter in linear light, down to one.

use super::{Bitmap, Space, Texels, f16};

/// A smaller level of a picture: texels in f32, in linear light.
pub(crate) struct Level {
    pub(crate) size: [u32; 2],
    texels: Vec<[f32; 4]>,
}

impl Level {
    /// The first after the picture itself; none of one texel.
    pub(crate) fn after(bitmap: &Bitmap, space: Space) -> Option<Self> {
        match &bitmap.texels {
            Texels::Bytes(texels) => {
                let linear = space.linear_bytes();
                smaller(bitmap.size, |i| {
                    let [r, g, b, a] = texels[i];
                    let [r, g, b] = [r, g, b].map(|x| linear[usize::from(x)]);
                    [r, g, b, f32::from(a) / 255.0]
                })
            }
            Texels::Halves(texels) => smaller(bitmap.size, |i| texels[i].map(f32::from)),
        }
    }

    /// The next one; none after that of one texel.
    pub(crate) fn next(&self) -> Option<Self> {
        smaller(self.size, |i| self.texels[i])
    }

    /// Its texels in the form of others.
    pub(crate) fn texels_like(&self, others: &Texels, space: Space) -> Texels {
        match others {
            Texels::Bytes(_) => {
                let byte = |x: f32| (x * 255.0).round() as u8;
                let bytes = |&[r, g, b, a]: &[f32; 4]| {
                    let [r, g, b] = [r, g, b].map(|x| byte(space.encoded(x)));
                    [r, g, b, byte(a)]
                };
                Texels::Bytes(self.texels.iter().map(bytes).collect())
            }
            Texels::Halves(_) => Texels::Halves(self.texels.iter().map(|t| t.map(f16::from_f32)).collect()),
        }
    }
}

/// Texels across and down of the level after one of this size.
pub(crate) fn half(size: [u32; 2]) -> [u32; 2] {
    size.map(|side| (side / 2).max(1))
}

/// The level after one of this size; none after the last, which has one texel.
fn smaller([width, height]: [u32; 2], texel: impl Fn(usize) -> [f32; 4]) -> Option<Level> {
    if width == 1 && height == 1 {
        return None;
    }
    let size = half([width, height]);
    let [columns, rows] = [0, 1].map(|k| parts([width, height][k], size[k]));
    let mut texels = Vec::with_capacity(size[0] as usize * size[1] as usize);
    for row in &rows {
        for column in &columns {
            let mut sum = [0.0; 4];
            for &(y, down) in row {
                for &(x, across) in column {
                    let found = texel(y as usize * width as usize + x as usize);
                    sum = std::array::from_fn(|k| sum[k] + found[k] * (down * across));
                }
            }
            texels.push(sum);
        }
    }
    Some(Level { size, texels })
}

/// For each of `to` equal parts of a row of `from` texels, the texels that it covers, and how much of the part each makes.
fn parts(from: u32, to: u32) -> Vec<Vec<(u32, f32)>> {
    let [from64, to64] = [from, to].map(u64::from);
    let part = |i: u64| {
        // in units of 1/to of a texel
        let [begin, end] = [i * from64, (i + 1) * from64];
        let covered = |x: u64| {
            let overlap = ((x + 1) * to64).min(end) - (x * to64).max(begin);
            (x as u32, overlap as f32 / from as f32)
        };
        (begin / to64..end.div_ceil(to64)).map(covered).collect()
    };
    (0..to64).map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each part of a row is covered exactly once, by neighbours.
    #[test]
    fn parts_cover_a_row_once() {
        for from in 1..40 {
            let to = (from / 2).max(1);
            let parts = parts(from, to);
            let mut covered = vec![0.0; from as usize];
            for part in &parts {
                assert!((part.iter().map(|(_, w)| w).sum::<f32>() - 1.0).abs() < 1e-6, "{from}: {part:?}");
                part.iter().for_each(|(x, w)| covered[*x as usize] += w);
            }
            let each = to as f32 / from as f32;
            assert!(covered.iter().all(|w| (w - each).abs() < 1e-6), "{from}: {covered:?}");
        }
    }
}
