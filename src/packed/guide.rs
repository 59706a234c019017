//! Guide: how emission, or the picking of lights for shadow rays, is steered by what was learned; tables that both backends
//! read.

use super::emitters::{PackedEmitter, cumulative_steps, set_picks};

/// Bins of a [`Warp`] along each side of the square.
pub const WARP_BINS: usize = 32;
/// Most warps: they share a uniform buffer.
pub const MAX_WARPS: usize = 16;
/// Steps of a warp's probabilities: two fit into a word.
const WARP_STEPS: u32 = 1 << 16;
/// Words of a warp: the rows, and the columns within each.
pub const WARP_WORDS: usize = (WARP_BINS + WARP_BINS * WARP_BINS) / 2;

/// Steers the emission of jotons of one map, or of shadow rays. The default steers nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct Guide {
    /// The scene's emitters with pick probabilities of their own, and their warps; empty where they are the scene's.
    emitters: Vec<PackedEmitter>,
    warps: Vec<Warp>,
    /// Jotons that would be as good without the warps as one is with them.
    pub gain: f64,
}

impl Default for Guide {
    fn default() -> Self {
        Self { emitters: Vec::new(), warps: Vec::new(), gain: 1.0 }
    }
}

impl Guide {
    /// Pick emitters in proportion to `weights`; `warp_of` tells which of `warps` an emitter has, if any, and `gain` what
    /// the warps are good for.
    pub fn new(
        scene: &[PackedEmitter],
        weights: &[f64],
        warps: Vec<Warp>,
        warp_of: impl Fn(usize) -> Option<usize>,
        gain: f64,
    ) -> Self {
        let mut emitters = scene.to_vec();
        set_picks(&mut emitters, |i| weights[i]);
        for (i, e) in emitters.iter_mut().enumerate() {
            e.warp = warp_of(i).map_or(0, |w| w as u32 + 1);
        }
        Self { emitters, warps, gain }
    }

    /// The same guide with what `change` makes of its emitters, one by one.
    pub fn with(&self, change: impl FnOnce(&[PackedEmitter]) -> Vec<PackedEmitter>) -> Self {
        Self { emitters: change(&self.emitters), ..self.clone() }
    }

    /// The emitters that are picked from; `scene` where nothing was learned.
    pub fn emitters<'a>(&'a self, scene: &'a [PackedEmitter]) -> &'a [PackedEmitter] {
        if self.is_empty() { scene } else { &self.emitters }
    }

    /// True where all is done as if nothing had been learned.
    pub fn is_empty(&self) -> bool {
        self.emitters.is_empty()
    }

    /// The warps.
    pub fn warps(&self) -> &[Warp] {
        &self.warps
    }

    /// Where a joton of `emitter` goes instead of `towards`, in the unit square, and the density of going there.
    pub fn steer(&self, emitter: &PackedEmitter, towards: [f32; 2]) -> ([f32; 2], f32) {
        match emitter.warp {
            0 => (towards, 1.0),
            number => self.warps[number as usize - 1].place(towards),
        }
    }
}

/// A density on the unit square, constant in each of 32 × 32 bins, drawn from by inversion: even points stay even \[E20\].
#[derive(Debug, Clone, PartialEq)]
pub struct Warp {
    /// Steps below each row, then below each bin of each row.
    below: Vec<u16>,
}

impl Warp {
    /// In proportion to `weights`, row by row, but for rounding and for a step that every row, and every bin of a row, has.
    pub fn new(weights: &[f64]) -> Self {
        assert_eq!(weights.len(), WARP_BINS * WARP_BINS, "one weight a bin");
        let rows = weights.chunks_exact(WARP_BINS);
        let mut below = Vec::with_capacity(2 * WARP_WORDS);
        let mut push = |weights: &[f64]| {
            let upto = cumulative_steps(weights.iter().copied(), WARP_STEPS);
            // the last is 2^16 for all, and left out
            below.push(0);
            below.extend(upto[..WARP_BINS - 1].iter().map(|&s| s as u16));
        };
        push(&rows.clone().map(|row| row.iter().sum()).collect::<Vec<f64>>());
        rows.for_each(push);
        Self { below }
    }

    /// A place drawn by the density, `u` uniform, and the density there.
    pub fn place(&self, u: [f32; 2]) -> ([f32; 2], f32) {
        let (row, x, density_x) = self.draw(0, u[0]);
        let (_, y, density_y) = self.draw(1 + row, u[1]);
        ([x, y], density_x * density_y)
    }

    /// Bin, place and density along one side by list `list` of steps.
    fn draw(&self, list: usize, u: f32) -> (usize, f32, f32) {
        let below = &self.below[list * WARP_BINS..][..WARP_BINS];
        let x = u * WARP_STEPS as f32;
        let bin = below.partition_point(|&b| f32::from(b) <= x) - 1;
        let upto = below.get(bin + 1).map_or(WARP_STEPS as f32, |&b| f32::from(b));
        let width = upto - f32::from(below[bin]);
        let rest = (x - f32::from(below[bin])) / width;
        let place = ((bin as f32 + rest) / WARP_BINS as f32).min(1.0 - f32::EPSILON / 2.0);
        (bin, place, width * (WARP_BINS as f32 / WARP_STEPS as f32))
    }

    /// As the kernels read it: two numbers of steps in a word, the first in its low half.
    pub fn words(&self) -> Vec<u32> {
        self.below.chunks_exact(2).map(|b| u32::from(b[0]) | u32::from(b[1]) << 16).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Bin by bin: the part of an even grid that lands there is the bin's probability, and the density tells it.
    #[test]
    fn warp_draws_by_its_density() {
        let weights: Vec<f64> = (0..WARP_BINS * WARP_BINS)
            .map(|i| if i / WARP_BINS < 2 { 0.0 } else { (i % 7) as f64 + 0.1 * (i / WARP_BINS) as f64 })
            .collect();
        let warp = Warp::new(&weights);
        assert_eq!(warp.words().len(), WARP_WORDS);
        let n = 2048;
        let mut counts = vec![0.0f64; WARP_BINS * WARP_BINS];
        let mut inverse = 0.0f64;
        let mut densities = vec![0.0f64; WARP_BINS * WARP_BINS];
        for i in 0..n * n {
            let u = [i % n, i / n].map(|k| (k as f32 + 0.5) / n as f32);
            let (place, density) = warp.place(u);
            assert!(place.iter().all(|x| (0.0..1.0).contains(x)), "{place:?}");
            let [x, y] = place.map(|x| (x * WARP_BINS as f32) as usize);
            counts[x * WARP_BINS + y] += 1.0;
            densities[x * WARP_BINS + y] = f64::from(density);
            inverse += 1.0 / f64::from(density);
        }
        let total = f64::from(n * n);
        // the mean of one over the density is the area: of all rows but the two, which this grid is too wide to meet
        assert!((inverse / total - 30.0 / 32.0).abs() < 1e-3, "{}", inverse / total);
        let sum: f64 = weights.iter().sum();
        let bins = (WARP_BINS * WARP_BINS) as f64;
        for (i, w) in weights.iter().enumerate() {
            if *w == 0.0 {
                continue;
            }
            let (count, density) = (counts[i] / total * bins, densities[i]);
            // rows and bins begin between two points of the grid: 64 points a row, as many a bin
            assert!((count / density - 1.0).abs() < 0.1, "bin {i}: {count} against {density}");
            assert!((density / (w / sum * bins) - 1.0).abs() < 0.02, "bin {i}: {density}");
        }
    }

    /// The largest number below one stays below one, whatever the last bin's width.
    #[test]
    fn warp_stays_in_the_square() {
        let weights: Vec<f64> = (0..WARP_BINS * WARP_BINS).map(|i| f64::from(u8::from(i == 0))).collect();
        let (place, density) = Warp::new(&weights).place([16_777_215.0 / 16_777_216.0; 2]);
        assert!(place.iter().all(|x| *x < 1.0) && density > 0.0, "{place:?} {density}");
    }
}
