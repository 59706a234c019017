//! Textures: pictures on surfaces, and how they lie there \[E37\].

mod decode;
pub(crate) mod entry;
pub mod fit;
mod integral;
pub(crate) mod levels;
pub(crate) mod stated;
pub(crate) mod store;

pub use half::f16;
use std::path::PathBuf;
use std::sync::Arc;

/// Texels of a picture, row by row from the top: red, green, blue and opacity.
#[derive(Debug, Clone, PartialEq)]
pub enum Texels {
    /// In 8 bits each.
    Bytes(Vec<[u8; 4]>),
    /// In half floats, linear; from 0 to 1, of what shines beyond.
    Halves(Vec<[f16; 4]>),
}

/// A picture as it was read, or smaller.
#[derive(Debug, Clone, PartialEq)]
pub struct Bitmap {
    /// Texels across and down; at least one each.
    pub size: [u32; 2],
    /// All of them.
    pub texels: Texels,
    /// Where it was read; none where it was not.
    pub(crate) file: Option<Arc<PictureFile>>,
}

/// A file of a picture.
#[derive(Debug, PartialEq)]
pub(crate) struct PictureFile {
    pub(crate) path: PathBuf,
    /// Texels across and down, as they are there.
    pub(crate) size: [u32; 2],
}

/// How the red, green and blue of a texel in 8 or 16 bits are meant.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Space {
    /// Encoded by the curve of sRGB.
    Srgb,
    /// In proportion to light.
    Linear,
}

/// What lies outside of the unit square.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Wrap {
    /// The picture again.
    Repeat,
    /// Its mirror image, then the picture again.
    Mirror,
    /// Its edge.
    Clamp,
}

/// What lies between the middles of texels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Filter {
    /// Their mean by distance.
    Linear,
    /// The nearest.
    Nearest,
}

/// Which of a texel's numbers counts where one is asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Channel {
    /// Red: of a grey picture any.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Opacity.
    Alpha,
}

/// A number that varies over a surface, from 0 to 1: a factor times one of a texel's numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberMap {
    /// What it shows.
    pub texture: Texture,
    /// Which of its numbers.
    pub channel: Channel,
    /// Factor on it.
    pub factor: f32,
}

/// A picture of which way a surface faces, or how high it is, where it has no triangles for that.
#[derive(Debug, Clone, PartialEq)]
pub struct Relief {
    /// The picture.
    pub texture: Texture,
    /// What its texels are.
    pub kind: ReliefKind,
}

/// What the texels of a [`Relief`] are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReliefKind {
    /// Normals, from -1 to 1 along the picture's right, its up, and the surface's own normal.
    Normals {
        /// Factor on what leads away from that.
        strength: f32,
    },
    /// Heights.
    Heights {
        /// Which number of a texel is the height.
        channel: Channel,
        /// How much higher white is than black, scene units, or widths of the picture as it lies there.
        height: f32,
        /// In widths of the picture.
        is_relative: bool,
    },
}

impl ReliefKind {
    /// Which number of a texel is asked for where one is.
    pub(crate) fn channel(self) -> Channel {
        match self {
            Self::Normals { .. } => Channel::Red,
            Self::Heights { channel, .. } => channel,
        }
    }
}

/// A picture, and how it lies on a surface.
#[derive(Debug, Clone, PartialEq)]
pub struct Texture {
    /// What it shows.
    pub bitmap: Arc<Bitmap>,
    /// How its colours are meant; halves are linear.
    pub space: Space,
    /// What lies outside of it.
    pub wrap: Wrap,
    /// What lies between its texels.
    pub filter: Filter,
    /// Factor on texture coordinates …
    pub scale: [f32; 2],
    /// … and what is added after it.
    pub offset: [f32; 2],
}

/// How much of a surface is there: the rest lets light straight through \[E38\].
#[derive(Debug, Clone, PartialEq)]
pub struct Opacity {
    /// Of all of it, from 0 to 1 …
    pub factor: f32,
    /// … times the opacity of a texture's texels.
    pub texture: Option<Texture>,
}

impl Bitmap {
    /// So many texels across and down.
    pub fn new(size: [u32; 2], texels: Texels) -> Self {
        Self { size, texels, file: None }
    }

    /// Bytes of its texels.
    pub(crate) fn bytes(&self) -> u64 {
        let bytes = match &self.texels {
            Texels::Bytes(texels) => size_of_val(&texels[..]),
            Texels::Halves(texels) => size_of_val(&texels[..]),
        };
        bytes as u64
    }

    /// A board of two by two squares: the first colour at the lower left and the upper right.
    pub fn board([a, b]: [[f32; 3]; 2]) -> Self {
        let [a, b] = [a, b].map(|[r, g, b]| [r, g, b, 1.0].map(f16::from_f32));
        Self::new([2; 2], Texels::Halves(vec![b, a, a, b]))
    }

    /// True where its texels look like normals and not like heights: coloured, and about the blue of what faces straight up.
    pub(crate) fn is_of_normals(&self) -> bool {
        let texture = Texture::of(Arc::new(self.clone()), Space::Linear);
        let [r, g, b] = texture.mean();
        b > 0.6 && (r - 0.5).abs() < 0.2 && (g - 0.5).abs() < 0.2
    }

    /// One white texel.
    pub fn white() -> Self {
        Self::new([1; 2], Texels::Bytes(vec![[255; 4]]))
    }
}

impl Texture {
    /// A picture over the unit square of texture coordinates, again and again.
    pub fn of(bitmap: Arc<Bitmap>, space: Space) -> Self {
        let (wrap, filter) = (Wrap::Repeat, Filter::Linear);
        Self { bitmap, space, wrap, filter, scale: [1.0; 2], offset: [0.0; 2] }
    }

    /// The largest red, green and blue of any texel, linear.
    pub fn most(&self) -> [f32; 3] {
        match &self.bitmap.texels {
            Texels::Bytes(texels) => {
                let most = texels.iter().fold([0; 3], |m, t| std::array::from_fn(|k| m[k].max(t[k])));
                most.map(|x| self.space.to_linear(f32::from(x) / 255.0))
            }
            Texels::Halves(texels) => {
                texels.iter().fold([0.0; 3], |m, t| std::array::from_fn(|k| f32::max(m[k], f32::from(t[k]))))
            }
        }
    }
}

impl NumberMap {
    /// The least and the most of all texels.
    pub fn range(&self) -> [f32; 2] {
        let k = self.channel as usize;
        let within = |[least, most]: [f32; 2], x: f32| [least.min(x), most.max(x)];
        let none = [f32::INFINITY, f32::NEG_INFINITY];
        let [least, most] = match &self.texture.bitmap.texels {
            Texels::Bytes(texels) => {
                let bytes = texels.iter().fold([u8::MAX, 0], |[a, b], t| [a.min(t[k]), b.max(t[k])]);
                bytes.map(|x| f32::from(x) / 255.0)
            }
            Texels::Halves(texels) => texels.iter().fold(none, |range, t| within(range, f32::from(t[k]))),
        };
        [least, most].map(|x| (x * self.factor).clamp(0.0, 1.0))
    }
}

impl Texture {
    /// The mean of all texels, linear.
    pub fn mean(&self) -> [f32; 3] {
        let count = u64::from(self.bitmap.size[0]) * u64::from(self.bitmap.size[1]);
        let add = |sum: [f64; 3], t: [f32; 3]| std::array::from_fn(|k| sum[k] + f64::from(t[k]));
        let sum = match &self.bitmap.texels {
            Texels::Bytes(texels) => {
                let linear = self.space.linear_bytes();
                let of = |t: &[u8; 4]| [t[0], t[1], t[2]].map(|x| linear[usize::from(x)]);
                texels.iter().fold([0.0; 3], |sum, t| add(sum, of(t)))
            }
            Texels::Halves(texels) => {
                texels.iter().fold([0.0; 3], |sum, t| add(sum, [t[0], t[1], t[2]].map(f32::from)))
            }
        };
        sum.map(|x| (x / count as f64) as f32)
    }
}

impl Space {
    /// A number in proportion to light, of an encoded one from 0 to 1.
    pub fn to_linear(self, encoded: f32) -> f32 {
        match self {
            Self::Linear => encoded,
            Self::Srgb if encoded <= 0.040_45 => encoded / 12.92,
            Self::Srgb => ((encoded + 0.055) / 1.055).powf(2.4),
        }
    }

    /// Likewise of each byte, 255 for one.
    pub(crate) fn linear_bytes(self) -> Vec<f32> {
        (0..=u8::MAX).map(|x| self.to_linear(f32::from(x) / 255.0)).collect()
    }

    /// The opposite way.
    pub fn encoded(self, linear: f32) -> f32 {
        match self {
            Self::Linear => linear,
            Self::Srgb if linear <= 0.003_130_8 => linear * 12.92,
            Self::Srgb => 1.055 * linear.powf(1.0 / 2.4) - 0.055,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The curve of sRGB goes through the values of its standard, and back.
    #[test]
    fn the_curve_is_that_of_srgb() {
        for (encoded, linear) in [(0.0, 0.0), (0.04, 0.003_095_975), (0.5, 0.214_041_1), (1.0, 1.0)] {
            assert!((Space::Srgb.to_linear(encoded) - linear).abs() < 1e-6, "{encoded}");
            assert!((Space::Srgb.encoded(linear) - encoded).abs() < 1e-6, "{linear}");
        }
    }

    /// What is largest is found in each channel by itself.
    #[test]
    fn the_most_of_a_texture_is_that_of_its_channels() {
        let board = Bitmap::board([[0.25, 0.5, 0.0], [0.75, 0.125, 0.0]]);
        assert_eq!(Texture::of(Arc::new(board), Space::Linear).most(), [0.75, 0.5, 0.0]);
    }
}
