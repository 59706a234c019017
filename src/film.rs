//! Film: the layers of an image, summed in f64 over passes.

use crate::bands::{BANDS, Bands};
use crate::error::{Error, Result};
use crate::rest::Rest;

/// Bytes of host memory for a pixel, from the first pass to the written file: the film (96, and 48 where pixels rest) and
/// what tells its error (120), glints (16), a batch (48 and its copy from the device), the picture (60), channels and screen values for
/// the files (75), the backend's own state.
const BYTES_PER_PIXEL: u64 = 632;

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

/// Sums over passes, per layer and pixel, in f64: 1e5 passes do not drift. A sample of a tile that rests counts for the
/// passes of its block [E21].
#[derive(Debug, Clone)]
pub struct Film {
    width: u32,
    height: u32,
    passes: u64,
    sums: [Vec<[f64; BANDS]>; LAYERS],
    rest: Rest,
    /// The last sample of the pixels whose block is longer than a batch; empty before there are any. `sums` has it as often
    /// as its block has passes, those to come among them.
    last: [Vec<Bands>; LAYERS],
}

impl Film {
    /// An empty film.
    pub fn new(width: u32, height: u32) -> Self {
        let n = width as usize * height as usize;
        Self {
            width,
            height,
            passes: 0,
            sums: std::array::from_fn(|_| vec![[0.0; BANDS]; n]),
            rest: Rest::none([width, height]),
            last: Default::default(),
        }
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Passes summed so far.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Who rests.
    pub fn rest(&self) -> &Rest {
        &self.rest
    }

    /// From here on these tiles rest. No block of those that do now is open.
    pub fn set_rest(&mut self, rest: Rest) {
        if !rest.is_none() && self.last[0].is_empty() {
            self.last = std::array::from_fn(|_| vec![[0.0; BANDS]; self.sums[0].len()]);
        }
        self.rest = rest;
    }

    /// Add the sums of `passes` passes, one slice of pixels for each layer; none for a layer that is not traced. They are a
    /// power of two and begin at a multiple of it, where anything rests.
    pub fn add(&mut self, passes: u64, layers: &[Vec<Bands>; LAYERS]) {
        let width = self.width as usize;
        let runs = self.rest.runs(self.passes, passes);
        self.passes += passes;
        for ((sum, last), layer) in self.sums.iter_mut().zip(&mut self.last).zip(layers) {
            if layer.is_empty() {
                continue;
            }
            assert_eq!(sum.len(), layer.len(), "a batch has as many pixels as the film");
            for run in &runs {
                let weight = run.weight as f64;
                for pixels in run.pixels(width) {
                    if run.weight > passes {
                        last[pixels.clone()].copy_from_slice(&layer[pixels.clone()]);
                    }
                    for (s, l) in sum[pixels.clone()].iter_mut().zip(&layer[pixels]) {
                        for b in 0..BANDS {
                            s[b] += weight * f64::from(l[b]);
                        }
                    }
                }
            }
        }
    }

    /// Sum over the passes of a layer of a pixel.
    pub(crate) fn sum(&self, layer: usize, pixel: usize) -> [f64; BANDS] {
        let sum = self.sums[layer][pixel];
        match self.rest.pending_at(pixel, self.passes) {
            0 => sum,
            pending => {
                let last = self.last[layer][pixel];
                std::array::from_fn(|b| sum[b] - pending as f64 * f64::from(last[b]))
            }
        }
    }

    /// Sum over the passes of one pixel, all layers together.
    pub fn sum_of_layers(&self, pixel: usize) -> [f64; BANDS] {
        (0..LAYERS).fold([0.0; BANDS], |sum, layer| {
            let more = self.sum(layer, pixel);
            std::array::from_fn(|b| sum[b] + more[b])
        })
    }

    /// The mean of the passes, whole and by layer.
    pub fn picture(&self) -> Picture {
        let n = self.passes.max(1) as f64;
        let image = |f: &dyn Fn(usize) -> [f64; BANDS]| Image {
            width: self.width,
            height: self.height,
            pixels: (0..self.sums[0].len()).map(|p| f(p).map(|x| (x / n) as f32)).collect(),
        };
        Picture {
            whole: image(&|p| self.sum_of_layers(p)),
            layers: std::array::from_fn(|l| image(&|p| self.sum(l, p))),
        }
    }
}
