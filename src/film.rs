//! Film: the layers of an image, summed in f64 over passes.

use crate::bands::{BANDS, Bands};
use crate::error::{Error, Result};

/// Bytes of host memory for a pixel, from the first pass to the written file: the film (96) and what tells its error (120), a
/// batch (48 and its copy from the device), the picture (60), channels and screen values for the files (75), the backend's
/// own state.
const BYTES_PER_PIXEL: u64 = 568;

/// Bytes of host memory for an image.
pub fn host_bytes(size: [u32; 2]) -> u64 {
    (u64::from(size[0]) * u64::from(size[1])).saturating_mul(BYTES_PER_PIXEL)
}

/// Refuse an image that does not fit the memory that is left, before any of it is taken.
///
/// # Errors
/// [`Error::Capacity`] with need and limit.
pub fn check_memory(size: [u32; 2]) -> Result<()> {
    let need = host_bytes(size);
    // pixels and jotons are numbered in 32 bits, with a few to spare
    let limit = crate::memory::available().unwrap_or(u64::MAX).min(BYTES_PER_PIXEL << 28);
    if need > limit {
        let remedy = "render a smaller image (--size)".to_string();
        return Err(Error::Capacity { buffer: "the film", need, limit, remedy });
    }
    Ok(())
}

/// Added to a squared radiance that errors are divided by, (W/(m² sr))²: a black pixel must not weigh infinitely much.
pub const RELATIVE_OFFSET: f64 = 1e-2;

/// The layers of the image, by class of light path. Their sum is the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Layer {
    /// E S* L: emission seen directly or through specular surfaces.
    Emission,
    /// E S* D L: direct illumination.
    Direct,
    /// E S* D S+ L: caustics.
    Caustic,
    /// E S* D (S* D)+ … L: everything that was diffusely reflected before.
    Diffuse,
}

/// Number of layers.
pub const LAYERS: usize = 4;

impl Layer {
    /// All layers, in the order in which they are stored.
    pub const ALL: [Layer; LAYERS] = [Layer::Emission, Layer::Direct, Layer::Caustic, Layer::Diffuse];

    /// Name, lower case.
    pub fn name(self) -> &'static str {
        match self {
            Layer::Emission => "emission",
            Layer::Direct => "direct",
            Layer::Caustic => "caustic",
            Layer::Diffuse => "diffuse",
        }
    }
}

/// An image of linear radiance: W/(m² sr) per band, row 0 at the top.
#[derive(Debug, Clone, PartialEq)]
pub struct Image {
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// `width * height` pixels, row by row.
    pub pixels: Vec<Bands>,
}

impl Image {
    /// A black image.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![[0.0; BANDS]; width as usize * height as usize] }
    }
}

/// What a renderer hands out: the mean of its passes, whole and by layer.
#[derive(Debug, Clone)]
pub struct Picture {
    /// The sum of the layers.
    pub whole: Image,
    /// One image for each of [`Layer::ALL`].
    pub layers: [Image; LAYERS],
}

/// Sums over passes, per layer and pixel, in f64: 1e5 passes do not drift.
#[derive(Debug, Clone)]
pub struct Film {
    width: u32,
    height: u32,
    passes: u64,
    sums: [Vec<[f64; BANDS]>; LAYERS],
}

impl Film {
    /// An empty film.
    pub fn new(width: u32, height: u32) -> Self {
        let n = width as usize * height as usize;
        Self { width, height, passes: 0, sums: std::array::from_fn(|_| vec![[0.0; BANDS]; n]) }
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Passes summed so far.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Add the sums of `passes` passes, one slice of pixels for each layer.
    pub fn add(&mut self, passes: u64, layers: &[Vec<Bands>; LAYERS]) {
        self.passes += passes;
        for (sum, layer) in self.sums.iter_mut().zip(layers) {
            assert_eq!(sum.len(), layer.len(), "a batch has as many pixels as the film");
            for (s, l) in sum.iter_mut().zip(layer) {
                for b in 0..BANDS {
                    s[b] += f64::from(l[b]);
                }
            }
        }
    }

    /// Sum over the passes of one pixel, all layers together.
    pub fn sum_of_layers(&self, pixel: usize) -> [f64; BANDS] {
        std::array::from_fn(|b| self.sums.iter().map(|s| s[pixel][b]).sum::<f64>())
    }

    /// The mean of the passes, whole and by layer.
    pub fn picture(&self) -> Picture {
        let n = self.passes.max(1) as f64;
        let image = |f: &dyn Fn(usize, usize) -> f64| Image {
            width: self.width,
            height: self.height,
            pixels: (0..self.sums[0].len()).map(|p| std::array::from_fn(|b| (f(p, b) / n) as f32)).collect(),
        };
        Picture {
            whole: image(&|p, b| self.sums.iter().map(|s| s[p][b]).sum()),
            layers: std::array::from_fn(|l| image(&|p, b| self.sums[l][p][b])),
        }
    }
}
