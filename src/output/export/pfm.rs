//! PFM: a picture as linear texels in f32, so that no one needs to know how they were encoded (Debevec 2001, "PFM Portable
//! FloatMap Image Format").

use crate::scene::texture::{Texels, Texture};
use crate::spectrum::{BANDS, Bands};

/// Which number of a texel is its opacity.
const OPACITY: usize = 3;

/// A picture's file.
#[derive(Debug, Clone)]
pub(super) struct PictureFile {
    /// In the folder of the scene file.
    pub(super) name: String,
    /// What it shows.
    pub(super) texture: Texture,
    /// What of it is written.
    pub(super) factor: Factor,
}

/// What of a picture is written, and the factor on it.
#[derive(Debug, Clone, Copy)]
pub(super) enum Factor {
    /// Red, green and blue.
    Colour(Bands),
    /// Opacity.
    Opacity(f32),
}

impl PictureFile {
    /// Its bytes: rows from the bottom to the top.
    pub(super) fn bytes(&self) -> Vec<u8> {
        let [across, down] = self.texture.bitmap.size;
        let kind = if matches!(self.factor, Factor::Colour(_)) { "PF" } else { "Pf" };
        // a scale below zero says that the numbers are little-endian
        let linear = self.texture.space.linear_bytes();
        let mut bytes = format!("{kind}\n{across} {down}\n-1.0\n").into_bytes();
        for row in (0..down as usize).rev() {
            for column in 0..across as usize {
                let texel = self.texel(row * across as usize + column, &linear);
                match self.factor {
                    Factor::Colour(factor) => {
                        (0..BANDS).for_each(|b| bytes.extend((factor[b] * texel[b]).to_le_bytes()));
                    }
                    Factor::Opacity(factor) => bytes.extend((factor * texel[OPACITY]).to_le_bytes()),
                }
            }
        }
        bytes
    }

    /// Linear red, green, blue and opacity of a texel, of bytes by what each stands for.
    fn texel(&self, index: usize, linear: &[f32]) -> [f32; 4] {
        match &self.texture.bitmap.texels {
            Texels::Bytes(texels) => {
                let [r, g, b, a] = texels[index];
                let [r, g, b] = [r, g, b].map(|x| linear[usize::from(x)]);
                [r, g, b, f32::from(a) / f32::from(u8::MAX)]
            }
            Texels::Halves(texels) => texels[index].map(f32::from),
        }
    }
}
