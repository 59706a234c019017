//! Film: the layers of an image, summed in f64 over passes.

mod monochrome;
pub(crate) mod neighbours;
pub mod paths;
pub mod stats;
mod sums;
pub mod tile_schedule;

use crate::error::{Error, Result};
use crate::film::tile_schedule::{Run, TILE, TileSchedule};
use crate::spectrum::{BANDS, Bands};
pub use monochrome::Monochrome;
use rayon::prelude::*;
use std::ops::Range;
use sums::Sums;

/// Bytes of a pixel of a layer: its sum.
const LAYER_BYTES: u64 = 24;
/// Bytes of it while passes are rendered: a batch. What sharing holds takes its place, and then the picture.
const BATCH_BYTES: u64 = 12;
/// Bytes of a pixel of the last samples: what rests is black but in one layer.
const REST_BYTES: u64 = 12;
/// Bytes of a pixel of who has trees (level, what they saw, a list).
const TREE_BYTES: u64 = 17;
/// Bytes of a pixel that is looked at to tell the error: sums of passes, and what sharing says.
const SAMPLE_BYTES: u64 = 24 + 20;
/// Bytes more of it where maps blur: two lines.
const LINE_BYTES: u64 = 2 * 48;
/// Bytes of a pixel of a layer that is resolved: its first half, and what came of it.
const RESOLVED_BYTES: u64 = 24 + 12;
/// Rows that a sweep over the image holds.
const SWEPT_ROWS: u64 = 464;
/// Bytes of a pixel of these: what it shows, blocks of all sizes, and what neighbours tell.
const SWEPT_BYTES: u64 = 66 + 30 + 12;
/// Bytes of a layer of it, as pixels and blocks have it.
const SWEPT_LAYER_BYTES: u64 = 32 + 14;
/// Bytes of a pixel of the rows that are at their end, and of a layer of it.
const ENDED_BYTES: [u64; 2] = [88, 52];
/// Rows of these.
const ENDED_ROWS: u64 = 40;
/// Surfaces that pixels show, where there is glass and where there is none.
const SURFACES: [f64; 2] = [1.6, 1.05];
/// Bytes more of each sum that is exact.
const EXACT_BYTES: u64 = 24;
/// Bytes of a pixel of a band for who measures.
const MEASURED_BYTES: u64 = size_of::<f32>() as u64;
/// Bytes of a pixel that one render after the other leaves with the allocator, as measured.
const LEFT_BYTES: u64 = 72;
/// Pixels that tell the error of an image, at most: of larger images every second, third … across and down.
pub const SAMPLES_MAX: u64 = 1 << 19;
/// Most pixels of an image: they are numbered in 28 bits.
const PIXELS_MAX: u64 = 1 << 28;

/// What decides how much memory an image takes on the host.
#[derive(Debug, Clone, Copy)]
pub struct FilmNeeds {
    /// Width and height, pixels.
    pub size: [u32; 2],
    /// Layers of light on surfaces: where one is black none is taken.
    pub layers: usize,
    /// Pixels that can show emission.
    pub emission: u64,
    /// Pixels that can rest.
    pub resting: u64,
    /// Layers that are resolved.
    pub resolved: usize,
    /// Camera trees look through mirrors and glass.
    pub has_trees: bool,
    /// Light is stored in maps, whose radii blur it.
    pub has_maps: bool,
    /// It is a part of a render: its sums are exact.
    pub is_part: bool,
    /// Bands for who measures, beside red, green and blue.
    pub measured: usize,
}

impl FilmNeeds {
    /// Bytes from the first pass to the written file, at most.
    pub fn bytes(&self) -> u64 {
        let [layers, resolved] = [self.layers, self.resolved].map(|n| n as u64);
        let [width, height] = self.size.map(u64::from);
        let pixels = width * height;
        let trees = if self.has_trees { TREE_BYTES } else { 0 };
        let exact = if self.is_part { EXACT_BYTES * (layers + resolved) } else { 0 };
        let each = trees + LAYER_BYTES * layers + RESOLVED_BYTES * resolved + exact;
        let exact = if self.is_part { EXACT_BYTES } else { 0 };
        let dark = self.emission * (LAYER_BYTES + exact) + self.resting * REST_BYTES;
        let samples = sample_count(self.size) * (SAMPLE_BYTES + if self.has_maps { LINE_BYTES } else { 0 });
        let swept = if resolved > 0 { self.swept([width, height]) } else { 0 };
        // the picture has a layer more
        let batch = BATCH_BYTES * (pixels * (layers + 1) + self.emission);
        // red, green and blue are finished before the others begin, and are held
        let pictures = (1 + LAYERS as u64 + resolved) * size_of::<Bands>() as u64;
        let bands = pictures + LEFT_BYTES + MEASURED_BYTES * self.measured as u64;
        let finished = if self.measured > 0 { bands } else { 0 };
        pixels.saturating_mul(each + finished) + dark + samples + swept.max(batch)
    }

    /// Bytes of the rows that are held while light is shared.
    fn swept(&self, [width, height]: [u64; 2]) -> u64 {
        let resolved = self.resolved as u64;
        let surfaces = SURFACES[usize::from(!self.has_trees)];
        let held = (SWEPT_BYTES + SWEPT_LAYER_BYTES * resolved) as f64 * surfaces;
        let ended = ENDED_BYTES[0] + ENDED_BYTES[1] * resolved;
        width * (height.min(SWEPT_ROWS) as f64 * held) as u64 + width * height.min(ENDED_ROWS) * ended
    }
}

/// Pixels that tell the error of an image: every one, or every second, third … across and down.
fn sample_count(size: [u32; 2]) -> u64 {
    let of = |step: u32| size.map(|n| u64::from(n.div_ceil(step))).iter().product::<u64>();
    (1..).map(of).find(|n| *n <= SAMPLES_MAX).unwrap_or(0)
}

/// Refuse an image that does not fit the memory that is left, before any of it is taken.
///
/// # Errors
/// [`Error::Capacity`] with need and limit.
pub fn check_memory(size: [u32; 2], is_part: bool, measured: usize) -> Result<()> {
    let pixels = size.map(u64::from).iter().product();
    let bytes = |measured| {
        let needs = FilmNeeds {
            size,
            layers: Layer::ON_SURFACES.len(),
            emission: pixels,
            resting: pixels,
            resolved: 0,
            has_trees: false,
            has_maps: true,
            is_part,
            measured,
        };
        needs.bytes()
    };
    let most =
        PIXELS_MAX * (REST_BYTES + TREE_BYTES + (LAYER_BYTES + BATCH_BYTES + EXACT_BYTES) * LAYERS as u64);
    let available = crate::host::memory::available().unwrap_or(u64::MAX);
    let without = (bytes(0), available.min(most));
    let (need, limit) = if without.0 > without.1 { without } else { (bytes(measured), available) };
    if need > limit {
        let fewer = if measured > 0 { " or fewer bands (--bands)" } else { "" };
        let remedy = format!("render a smaller image (--size){fewer}");
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
pub struct Halves<'a> {
    film: &'a Film,
    layer: usize,
    first: &'a FirstHalf,
    sums: &'a Sums,
    /// They add up to one; the second is 0 after one pass.
    pub parts: [f32; 2],
}

impl Halves<'_> {
    /// Radiance of a pixel, W/(m² sr).
    pub fn means(&self, pixel: usize) -> [Bands; 2] {
        let (film, passes) = (self.film, self.film.passes);
        let (first, second) = (self.first.passes as f64, (passes - self.first.passes) as f64);
        let all = film.sum(self.layer, pixel);
        // what rests has no noise, and blocks that are not over
        if second == 0.0 || film.schedule.is_resting(pixel) {
            return [all.map(|x| (x / passes.max(1) as f64) as f32); 2];
        }
        let early = self.sums.at(pixel);
        let rest = std::array::from_fn(|b| ((all[b] - early[b]) / second) as f32);
        [early.map(|x| (x / first) as f32), rest]
    }

    /// Whether any pixel is not black.
    pub fn has_light(&self) -> bool {
        let is_lit = |pixel| self.means(pixel).as_flattened().iter().any(|x| *x > 0.0);
        (0..self.film.pixels()).into_par_iter().any(is_lit)
    }
}

/// The half that a pass belongs to, from its first bit after the leading one: 0 | 1 | 2 | 3 | 4 5 | 6 7 | 8 9 10 11 | 12 …
/// Both have passes of all radii, and runs of them, which are spread evenly over the Sobol sequences.
pub(crate) fn half(pass: u64) -> usize {
    match pass {
        0 | 1 => pass as usize,
        _ => (pass >> (pass.ilog2() - 1) & 1) as usize,
    }
}

/// Which pass of its half it is, from 0 on.
pub(crate) fn place_in_half(pass: u64) -> u64 {
    match pass {
        0 | 1 => 0,
        _ => {
            let length = 1 << (pass.ilog2() - 1);
            length + pass % length
        }
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

    /// Keep no halves any more.
    pub(crate) fn forget_halves(&mut self) {
        self.first_half = None;
    }

    /// The halves of a layer; none where they are not kept.
    pub fn halves(&self, layer: Layer) -> Option<Halves<'_>> {
        let first = self.first_half.as_ref()?;
        let (_, sums) = first.sums.iter().find(|(of, _)| *of == layer)?;
        let part = first.passes as f64 / self.passes.max(1) as f64;
        Some(Halves {
            film: self,
            layer: layer as usize,
            first,
            sums,
            parts: [part as f32, (1.0 - part) as f32],
        })
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
        Picture {
            whole: self.image(&|p| self.sum_of_layers(p)),
            layers: Layer::ALL.map(|layer| self.layer(layer)),
            unresolved: Vec::new(),
        }
    }

    /// The mean of the passes of a layer.
    pub(crate) fn layer(&self, layer: Layer) -> Image {
        self.image(&|p| self.sum(layer as usize, p))
    }

    /// The mean of some sums over the passes.
    fn image(&self, sum: &(dyn Fn(usize) -> [f64; BANDS] + Sync)) -> Image {
        let n = self.passes.max(1) as f64;
        let mut image = Image::new(self.width, self.height);
        image.pixels.par_iter_mut().enumerate().for_each(|(p, pixel)| {
            let sum = sum(p);
            if sum != [0.0; BANDS] {
                *pixel = sum.map(|x| (x / n) as f32);
            }
        });
        image
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
