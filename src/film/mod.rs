//! Film: the layers of an image, summed in f64 over passes.

pub(crate) mod neighbours;
pub mod paths;
pub mod stats;
mod sums;
pub mod tile_schedule;

use crate::error::{Error, Result};
use crate::film::tile_schedule::{Run, TILE, TileSchedule};
use crate::spectrum::{BANDS, Bands};
use rayon::prelude::*;
use std::ops::Range;
use sums::Sums;

/// Bytes of a pixel of a layer: its sum, the last sample where it rests, and a batch of it, whose place the picture takes.
const LAYER_BYTES: u64 = 24 + 12 + 12;
/// Bytes of a pixel of the whole picture.
const PIXEL_BYTES: u64 = 12;
/// Bytes of a pixel of who has trees (level, what they saw, a list), and of what more surfaces it shows through glass and in
/// mirrors.
const TREE_BYTES: u64 = 17 + 31;
/// Bytes of a pixel that is looked at to tell the error.
const SAMPLE_BYTES: u64 = 120;
/// Bytes of a pixel that is resolved: what its errors weigh, what it shows, blocks of all sizes, what neighbours tell, and what threads
/// have not given back.
const RESOLVE_BYTES: u64 = 16 + 60 + 60 + 62 + 16;
/// Bytes of a layer of it: its first half, both means, what blocks found, what came of it, and what it was.
const RESOLVE_LAYER_BYTES: u64 = 24 + 24 + 43 + 20 + 12;
/// Bytes more of each sum that is exact.
const EXACT_BYTES: u64 = 24;
/// Pixels that tell the error of an image, at most: of larger images every second, third … across and down.
pub const SAMPLES_MAX: u64 = 1 << 19;
/// Most pixels of an image: they are numbered in 28 bits.
const PIXELS_MAX: u64 = 1 << 28;

/// What decides how much memory an image takes on the host.
#[derive(Debug, Clone, Copy)]
pub struct FilmNeeds {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Layers that hold light: where one is black none is taken.
    pub layers: usize,
    /// Those of them that are resolved.
    pub resolved: usize,
    /// Camera trees look through mirrors and glass.
    pub has_trees: bool,
    /// It is a part of a render: its sums are exact.
    pub is_part: bool,
}

impl FilmNeeds {
    /// Bytes from the first pass to the written file, at most.
    pub fn bytes(&self) -> u64 {
        let [layers, resolved] = [self.layers, self.resolved].map(|n| n as u64);
        let pixels = u64::from(self.size[0]) * u64::from(self.size[1]);
        let trees = if self.has_trees { TREE_BYTES } else { 0 };
        let to_resolve = if resolved > 0 { RESOLVE_BYTES + RESOLVE_LAYER_BYTES * resolved } else { 0 };
        let exact = if self.is_part { EXACT_BYTES * (layers + resolved) } else { 0 };
        let each = PIXEL_BYTES + trees + LAYER_BYTES * layers + to_resolve + exact;
        pixels.saturating_mul(each) + pixels.min(SAMPLES_MAX) * SAMPLE_BYTES
    }
}

/// Refuse an image that does not fit the memory that is left, before any of it is taken.
///
/// # Errors
/// [`Error::Capacity`] with need and limit.
pub fn check_memory(size: [u32; 2], is_part: bool) -> Result<()> {
    let need = FilmNeeds { size, layers: LAYERS, resolved: 0, has_trees: false, is_part }.bytes();
    let most = PIXELS_MAX * (PIXEL_BYTES + TREE_BYTES + (LAYER_BYTES + EXACT_BYTES) * LAYERS as u64);
    let limit = crate::host::memory::available().unwrap_or(u64::MAX).min(most);
    if need > limit {
        let remedy = "render a smaller image (--size)".to_string();
        return Err(Error::Capacity { buffer: "the film", need, limit, remedy });
    }
    Ok(())
}

/// Added to a squared radiance that errors are divided by, (W/(m² sr))²: a black pixel must not weigh infinitely much.
pub const RELATIVE_OFFSET: f64 = 1e-2;

/// The layers of the image, by class of light path. Their sum is the image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
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

    /// Those that light on surfaces makes: neighbours on the same surface can share it.
    pub const ON_SURFACES: [Layer; 3] = [Layer::Direct, Layer::Caustic, Layer::Diffuse];

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
    /// The layers that were resolved, as the passes found them.
    pub unresolved: Vec<(Layer, Image)>,
}

/// Sums over passes, per layer and pixel, in f64: 1e5 passes do not drift. A sample of a tile that rests counts for the
/// passes of its block \[E21\].
#[derive(Debug, Clone, serde::Serialize, serde::Deserialize)]
pub struct Film {
    width: u32,
    height: u32,
    /// The pass that it begins with: 0 but for a part of a render.
    first: u64,
    passes: u64,
    sums: [Sums; LAYERS],
    schedule: TileSchedule,
    /// The last sample of the pixels whose block is longer than a batch; empty before there are any. `sums` has it as often
    /// as its block has passes, those to come among them.
    last: [Vec<Bands>; LAYERS],
    /// Of the layers that are resolved, the passes of the first half [`half`]: who resolves them sees both apart. None where none are resolved.
    first_half: Option<FirstHalf>,
}

/// The passes of one half.
#[derive(Debug, Clone, Default, serde::Serialize, serde::Deserialize)]
struct FirstHalf {
    passes: u64,
    sums: Vec<(Layer, Sums)>,
}

/// A layer's mean in each half of the passes, and the part of the passes that each half has.
#[derive(Debug, Clone)]
pub struct Halves {
    /// Radiance, W/(m² sr).
    pub means: [Vec<Bands>; 2],
    /// They add up to one; the second is 0 after one pass.
    pub parts: [f32; 2],
}

/// The half that a pass belongs to, from its first bit after the leading one: 0 | 1 | 2 | 3 | 4 5 | 6 7 | 8 9 10 11 | 12 …
/// Both have passes of all radii, and runs of them, which are spread evenly over the Sobol sequences.
pub(crate) fn half(pass: u64) -> usize {
    match pass {
        0 | 1 => pass as usize,
        _ => (pass >> (pass.ilog2() - 1) & 1) as usize,
    }
}

impl Film {
    /// An empty film.
    pub fn new(width: u32, height: u32) -> Self {
        Self::with_sums(width, height, 0, false)
    }

    /// An empty film of the passes from `first` on. Sums are exact: parts of a render can be merged.
    pub(crate) fn of_part(width: u32, height: u32, first: u64) -> Self {
        Self::with_sums(width, height, first, true)
    }

    fn with_sums(width: u32, height: u32, first: u64, is_exact: bool) -> Self {
        let n = width as usize * height as usize;
        Self {
            width,
            height,
            first,
            passes: 0,
            sums: std::array::from_fn(|_| Sums::new(n, is_exact)),
            schedule: TileSchedule::none([width, height]),
            last: Default::default(),
            first_half: None,
        }
    }

    /// Whether it is one of an image so large, where it was stored: a part of a render or none.
    pub(crate) fn is_sound(&self, size: [u32; 2], is_part: bool) -> bool {
        // as many as there are numbers, and so no more than the file could hold
        let pixels = u64::from(size[0]) * u64::from(size[1]);
        let Ok(pixels) = usize::try_from(pixels) else { return false };
        let halves = self.first_half.iter().flat_map(|half| half.sums.iter().map(|(_, sums)| sums));
        let lengths = self.last.each_ref().map(Vec::len);
        self.size() == size
            && pixels > 0
            && self.sums.iter().chain(halves).all(|sums| sums.is_sound(pixels, is_part))
            && self.schedule.is_sound(size)
            && (lengths == [pixels; LAYERS] || lengths == [0; LAYERS] && self.schedule.is_none())
            && self.first.checked_add(self.passes).is_some()
            && self.first_half.as_ref().is_none_or(|half| half.passes <= self.passes)
    }

    /// From the first pass on, keep the halves of these layers apart.
    pub fn keep_halves(&mut self, layers: &[Layer]) {
        let is_exact = matches!(self.sums[0], Sums::Exact(_));
        let sums = layers.iter().map(|layer| (*layer, Sums::new(self.pixels(), is_exact))).collect();
        self.first_half = Some(FirstHalf { passes: 0, sums });
    }

    /// The halves of a layer; none where they are not kept.
    pub fn halves(&self, layer: Layer) -> Option<Halves> {
        let FirstHalf { passes, sums } = self.first_half.as_ref()?;
        let (_, sums) = sums.iter().find(|(of, _)| *of == layer)?;
        let layer = layer as usize;
        let (first, second) = (*passes as f64, (self.passes - passes) as f64);
        let means = (0..self.pixels()).into_par_iter().map(|pixel| {
            let all = self.sum(layer, pixel);
            let mean = all.map(|x| x / self.passes.max(1) as f64);
            // what rests has no noise, and blocks that are not over
            if second == 0.0 || self.schedule.is_resting(pixel) {
                return [mean.map(|x| x as f32); 2];
            }
            let early = sums.at(pixel);
            let rest = std::array::from_fn(|b| ((all[b] - early[b]) / second) as f32);
            [early.map(|x| (x / first) as f32), rest]
        });
        let (a, b) = means.map(|[a, b]| (a, b)).unzip();
        let part = first / self.passes.max(1) as f64;
        Some(Halves { means: [a, b], parts: [part as f32, (1.0 - part) as f32] })
    }

    /// Pixels across and down.
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    fn pixels(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The passes that are summed: the first of them, and the one after the last.
    pub(crate) fn range(&self) -> Range<u64> {
        self.first..self.first + self.passes
    }

    /// Add the passes of another part of the render, which follow this one's.
    pub(crate) fn merge(&mut self, next: &Self) {
        assert_eq!((self.size(), self.range().end), (next.size(), next.first), "parts follow each other");
        for (sums, more) in self.sums.iter_mut().zip(&next.sums) {
            sums.merge(more);
        }
        if let (Some(half), Some(more)) = (&mut self.first_half, &next.first_half) {
            half.passes += more.passes;
            for ((_, sums), (_, more)) in half.sums.iter_mut().zip(&more.sums) {
                sums.merge(more);
            }
        }
        self.passes += next.passes;
    }

    /// Passes summed so far.
    pub fn passes(&self) -> u64 {
        self.passes
    }

    /// Who rests.
    pub fn tile_schedule(&self) -> &TileSchedule {
        &self.schedule
    }

    /// From here on these tiles rest. No block of those that do now is open.
    pub fn set_tile_schedule(&mut self, schedule: TileSchedule) {
        if !schedule.is_none() && self.last[0].is_empty() {
            self.last = std::array::from_fn(|_| vec![[0.0; BANDS]; self.pixels()]);
        }
        self.schedule = schedule;
    }

    /// Add the sums of `passes` passes, one slice of pixels for each layer; none for a layer that is not traced. They are a
    /// power of two and begin at a multiple of it, where anything rests.
    pub fn add(&mut self, passes: u64, layers: &[Vec<Bands>; LAYERS]) {
        let width = self.width as usize;
        let first = self.range().end;
        let fits = |layer: &Vec<Bands>| layer.is_empty() || layer.len() == self.pixels();
        assert!(layers.iter().all(fits), "a batch has as many pixels as the film");
        let runs = self.schedule.runs(first, passes);
        let each = width * TILE as usize;
        let add = |sums: &mut Sums, layer: &[Bands]| {
            let chunks = sums.chunks_mut(each);
            in_runs(chunks.into_par_iter(), layer, &runs, width, |sums, pixels, samples, weight| {
                sums.add(pixels.start, samples, weight);
            });
        };
        if let Some(first_half) = self.first_half.as_mut().filter(|_| half(first) == 0) {
            first_half.passes += passes;
            for (layer, sums) in &mut first_half.sums {
                add(sums, &layers[*layer as usize]);
            }
        }
        self.passes += passes;
        for ((sums, last), layer) in self.sums.iter_mut().zip(&mut self.last).zip(layers) {
            add(sums, layer);
            in_runs(last.par_chunks_mut(each), layer, &runs, width, |last, pixels, samples, weight| {
                if weight > passes {
                    let pairs = last[pixels].iter_mut().zip(samples);
                    pairs.filter(|(last, l)| *last != *l).for_each(|(last, l)| *last = *l);
                }
            });
        }
    }

    /// Sum over the passes of a layer of a pixel.
    pub(crate) fn sum(&self, layer: usize, pixel: usize) -> [f64; BANDS] {
        let sum = self.sums[layer].at(pixel);
        match self.schedule.pending_at(pixel, self.range().end) {
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
        let image = |f: &(dyn Fn(usize) -> [f64; BANDS] + Sync)| {
            let mut image = Image::new(self.width, self.height);
            image.pixels.par_iter_mut().enumerate().for_each(|(p, pixel)| {
                let sum = f(p);
                if sum != [0.0; BANDS] {
                    *pixel = sum.map(|x| (x / n) as f32);
                }
            });
            image
        };
        Picture {
            whole: image(&|p| self.sum_of_layers(p)),
            layers: std::array::from_fn(|l| image(&|p| self.sum(l, p))),
            unresolved: Vec::new(),
        }
    }
}

/// Do something with the pixels of the runs of each row of tiles: with the row's part of what is kept of the pixels, where they are in it, a
/// batch's samples of them, and the passes that a sample stands for. A layer without pixels is left alone.
fn in_runs<T: Send>(
    rows: impl IndexedParallelIterator<Item = T>,
    layer: &[Bands],
    runs: &[Vec<Run>],
    width: usize,
    work: impl Fn(&mut T, Range<usize>, &[Bands], u64) + Sync,
) {
    if layer.is_empty() {
        return;
    }
    let each = width * TILE as usize;
    rows.zip(layer.par_chunks(each)).zip(runs).enumerate().for_each(|(strip, ((mut row, layer), runs))| {
        for run in runs {
            for pixels in run.pixels(width) {
                let local: Range<usize> = pixels.start - strip * each..pixels.end - strip * each;
                work(&mut row, local.clone(), &layer[local], run.weight);
            }
        }
    });
}
