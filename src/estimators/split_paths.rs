//! Split paths: the pixels whose emission (E S* L) camera trees look for besides the eye path, and how many of them a pass
//! follows \[E25\]. A pilot marks them; what the passes see makes trees more where a pixel's emission is noisy.

use crate::film::neighbours::around;
use crate::film::{Film, Layer, RELATIVE_OFFSET};
use crate::packed::constants::{GLINT_PIXEL_BITS, GLINT_TREES, GLINT_TURNS};
use crate::sampling::rng::purpose::STREAM_TURN;
use crate::sampling::rng::sequence_seed;
use crate::spectrum::{BANDS, Bands};
use rayon::prelude::*;
use std::ops::Range;

/// Trees a pass for all pixels that see dielectric bodies and no light, over the pixels of the image: they take their turns.
const SPARSE_SHARE: f64 = 1.0 / 32.0;
/// Trees of a pixel in a pass, at most.
pub const TREES_MAX: u32 = GLINT_TREES << DOUBLINGS_MAX;
/// The fewest trees a pass of a pixel that sees light in part, [`GLINT_TREES`], are doubled so often at most …
const DOUBLINGS_MAX: u8 = 5;
/// … and so often by the pilot, whose few trees cannot tell how little noise is left where many are spread evenly.
const PILOT_DOUBLINGS_MAX: u8 = 1;
/// Trees squared per relative variance of one: where another tree takes as much off the image's error as its time spent
/// on whole passes would. A pass costs about three trees a pixel, and leaves about 6e-3 of relMSE.
const WORTH: f32 = 512.0;
/// What varies in a pixel may vary in one of its eight neighbours, too: lamps in glass are long and thin.
const NEIGHBOURS: f32 = 9.0;

/// What a pilot's trees saw of light in a pixel.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Light {
    /// None of them any.
    Nowhere,
    /// Some of them, or through specular surfaces.
    InPart,
    /// Every one, and directly.
    Everywhere,
}

/// A pilot's trees through a pixel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Look {
    /// Where there was light.
    pub light: Light,
    /// Some of them took both ways at an interface.
    pub branched: bool,
    /// Mean of the squared radiance of the emitters on a tree, summed over the bands.
    pub square: f32,
    /// Square of its mean, likewise.
    pub squared_mean: f32,
}

/// How many trees each pixel has in a pass.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct SplitPaths {
    size: [u32; 2],
    /// 0: none, [`GLINT_TURNS`]: one in `turns` passes, from [`FEWEST`] on [`GLINT_TREES`], doubled with each level.
    levels: Vec<u8>,
    /// Passes of which one has a tree, in pixels that see dielectric bodies and no light; a power of two.
    turns: u32,
}

/// Levels.
const NONE: u8 = 0;
const NOW_AND_THEN: u8 = GLINT_TURNS as u8;
const FEWEST: u8 = NOW_AND_THEN + 1;

impl SplitPaths {
    /// What a pilot's looks mark: pixels that see light in some of their trees, or see something else than a neighbour
    /// does. Pixels inside a lamp, and far from any, are not; where there may be light behind glass, trees look in some passes only.
    /// In and about `lamp_images`, pixels where the plan has found images of lamps from the lamps' side, there are as many
    /// trees as ever: camera rays meet what is small too seldom to tell.
    pub fn mark(size: [u32; 2], looks: &[Look], lamp_images: &[u32]) -> Self {
        let level = |pixel: usize, most: u8| {
            let look = &looks[pixel];
            if is_mixed(looks, pixel, size) {
                let variance = relative_variance(look.square, look.squared_mean, look.squared_mean);
                worth(variance).clamp(FEWEST, FEWEST + most)
            } else if look.branched {
                NOW_AND_THEN
            } else {
                NONE
            }
        };
        let mut wanted: Vec<u8> = (0..looks.len()).map(|pixel| level(pixel, PILOT_DOUBLINGS_MAX)).collect();
        for pixel in lamp_images.iter().flat_map(|pixel| around(*pixel, size)) {
            let is_lit = looks[pixel].square > 0.0;
            wanted[pixel] = if is_lit { level(pixel, DOUBLINGS_MAX) } else { FEWEST + DOUBLINGS_MAX };
        }
        let levels = Self { size, levels: vec![NONE; wanted.len()], turns: 1 }.limited(&wanted);
        let sparse = levels.iter().filter(|l| **l == NOW_AND_THEN).count() as f64;
        let turns = (sparse / (SPARSE_SHARE * looks.len() as f64)).ceil().max(1.0) as u32;
        Self { size, levels, turns: turns.next_power_of_two() }
    }

    /// Whether it is of an image so large, where it was stored.
    pub(crate) fn is_sound(&self, size: [u32; 2]) -> bool {
        let pixels = size.map(|n| n as usize).into_iter().product::<usize>();
        self.size == size
            && self.levels.len() == pixels
            && self.levels.iter().all(|level| *level <= FEWEST + DOUBLINGS_MAX)
            && self.turns.is_power_of_two()
    }

    /// Whether any pixel of these columns and rows has trees.
    pub(crate) fn any(&self, [columns, rows]: &[Range<usize>; 2]) -> bool {
        let width = self.size[0] as usize;
        let mut rows = rows.clone().map(|y| y * width);
        rows.any(|row| self.levels[row + columns.start..row + columns.end].iter().any(|l| *l != NONE))
    }

    /// Trees of a pixel in a pass, on average.
    pub fn trees_a_pass(&self, pixel: usize) -> f32 {
        match self.levels[pixel] {
            NONE => 0.0,
            NOW_AND_THEN => 1.0 / self.turns as f32,
            level => trees_of(level) as f32,
        }
    }

    /// The numbers of a pixel's trees of a pass. They only become more, at powers of two of passes: none comes twice.
    pub fn numbers(&self, pixel: u32, pass: u32, seed: u32) -> Range<u64> {
        match self.levels[pixel as usize] {
            NONE => 0..0,
            NOW_AND_THEN if pass % self.turns != self.turn(pixel, seed) => 0..0,
            NOW_AND_THEN => {
                let number = u64::from(pass / self.turns);
                number..number + 1
            }
            level => {
                let trees = u64::from(trees_of(level));
                u64::from(pass) * trees..(u64::from(pass) + 1) * trees
            }
        }
    }

    /// Passes of which one has a tree, in pixels that have one in some passes only.
    pub fn turns(&self) -> u32 {
        self.turns
    }

    /// The trees of these pixels, as the device grows them.
    pub fn list(&self, pixels: Range<u32>, seed: u32) -> List {
        let at = |level: u8| {
            let pixels = pixels.clone().filter(move |p| self.levels[*p as usize] == level);
            pixels.map(move |p| p | u32::from(level) << GLINT_PIXEL_BITS)
        };
        let mut trees: Vec<u32> = Vec::new();
        for level in (FEWEST..=FEWEST + DOUBLINGS_MAX).rev() {
            trees.extend(at(level).flat_map(|entry| std::iter::repeat_n(entry, trees_of(level) as usize)));
        }
        let always = trees.len() as u32;
        let turn = |entry: &u32| self.turn(entry & ((1 << GLINT_PIXEL_BITS) - 1), seed);
        let mut sparse: Vec<u32> = at(NOW_AND_THEN).collect();
        sparse.sort_by_key(turn);
        let end = |t| always + sparse.partition_point(|entry| turn(entry) < t) as u32;
        let turns = (0..=self.turns).map(end).collect();
        trees.extend(sparse);
        List { trees, always, turns }
    }

    /// As many trees as these levels say, but no more than [`SplitPaths::most`] together: the highest levels give way. Where even the
    /// fewest for each are too many, pixels of the highest levels come first.
    fn limited(&self, wanted: &[u8]) -> Vec<u8> {
        let with = |highest: u8| -> Vec<u8> {
            self.levels.iter().zip(wanted).map(|(now, wanted)| *now.max(&(*wanted).min(highest))).collect()
        };
        let total = |levels: &[u8]| levels.iter().map(|l| u64::from(trees_of(*l))).sum::<u64>();
        let fits = |levels: &Vec<u8>| total(levels) <= Self::most(self.levels.len() as u64);
        let highest = (FEWEST..=FEWEST + DOUBLINGS_MAX).rev();
        if let Some(levels) = highest.clone().map(with).find(fits) {
            return levels;
        }
        let mut levels = self.levels.clone();
        let mut room = Self::most(levels.len() as u64).saturating_sub(total(&levels));
        for wanted_level in highest {
            let here = levels.iter_mut().zip(wanted).filter(|(_, wanted)| **wanted == wanted_level);
            for (level, _) in here.filter(|(level, _)| **level < FEWEST) {
                let more = u64::from(GLINT_TREES - trees_of(*level));
                if more <= room {
                    (*level, room) = (FEWEST, room - more);
                }
            }
        }
        levels
    }

    /// Where another device has found more so far, as many as it has: a render goes on with trees that did not grow before.
    pub(crate) fn joined(&self, other: &SplitPaths) -> SplitPaths {
        Self { size: self.size, turns: self.turns, levels: self.limited(&other.levels) }
    }

    /// Trees in the [`List`] of an image with so many pixels, at most.
    pub fn most(pixels: u64) -> u64 {
        pixels * u64::from(GLINT_TREES)
    }

    /// The pass of [`SplitPaths::turns`] in which a pixel has its tree.
    fn turn(&self, pixel: u32, seed: u32) -> u32 {
        sequence_seed(seed, pixel, STREAM_TURN) % self.turns
    }
}

/// The trees of a pass, in the order in which a device grows them.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct List {
    /// Pixel and level of each. Those that grow in every pass come first, from the most in a pixel to the fewest: the trees of
    /// one pixel begin at a multiple of their number.
    pub trees: Vec<u32>,
    /// How many these are.
    always: u32,
    /// Where the trees of each turn begin, and the last one's end.
    turns: Vec<u32>,
}

impl List {
    /// The trees that grow in a pass, in parts of at most so many, which is at least [`TREES_MAX`].
    pub fn growths(&self, pass: u64, most: u32) -> impl Iterator<Item = Range<u32>> + '_ {
        let turn = (pass % (self.turns.len() as u64 - 1)) as usize;
        let most = most / TREES_MAX * TREES_MAX;
        [0..self.always, self.turns[turn]..self.turns[turn + 1]].into_iter().flat_map(move |all| {
            let end = all.end;
            all.step_by(most as usize).map(move |first| first..(first + most).min(end))
        })
    }
}

/// Trees of a pass at a level; those that grow in some passes only count for one.
fn trees_of(level: u8) -> u32 {
    if level < FEWEST { u32::from(level) } else { GLINT_TREES << (level - FEWEST) }
}

/// Where light is seen in part, or a neighbour sees it otherwise.
pub(crate) fn is_mixed(looks: &[Look], pixel: usize, size: [u32; 2]) -> bool {
    let here = looks[pixel].light;
    around(pixel as u32, size).any(|i| looks[i].light == Light::InPart || looks[i].light != here)
}

/// Variance as relMSE counts it: of a mean square and a squared mean, against a squared radiance; sums over the bands.
fn relative_variance(square: f32, squared_mean: f32, squared_radiance: f32) -> f32 {
    (square - squared_mean).max(0.0) / (squared_radiance + BANDS as f32 * RELATIVE_OFFSET as f32)
}

/// The level whose trees are next to those that a variance is worth; none where it is not worth half of the fewest.
fn worth(variance: f32) -> u8 {
    let doublings = ((WORTH * variance).sqrt() / GLINT_TREES as f32).log2().round();
    if doublings < 0.0 { NONE } else { FEWEST + (doublings as u8).min(DOUBLINGS_MAX) }
}

/// Watches how emission varies from pass to pass.
#[derive(Debug, serde::Serialize, serde::Deserialize)]
pub(crate) struct Watch {
    batches: u64,
    /// Sums over the batches of trees times squared radiance, the latter summed over bands.
    squares: Vec<f32>,
    /// Passes so far.
    passes: f32,
    /// Trees beyond one a pass, which is the eye path's.
    more: Vec<f32>,
}

impl Watch {
    /// Nothing was seen yet.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let pixels = size[0] as usize * size[1] as usize;
        Self { batches: 0, squares: vec![0.0; pixels], passes: 0.0, more: vec![0.0; pixels] }
    }

    /// Whether it is of an image so large, where it was stored.
    pub(crate) fn is_sound(&self, size: [u32; 2]) -> bool {
        let pixels = size.map(|n| n as usize).into_iter().product::<usize>();
        [self.squares.len(), self.more.len()] == [pixels; 2]
    }

    /// Look at the emission of `passes` passes, summed.
    pub(crate) fn watch(&mut self, passes: u64, emission: &[Bands], glints: &SplitPaths) {
        self.batches += 1;
        let passes = passes as f32;
        self.passes += passes;
        let sums = self.squares.par_iter_mut().zip(&mut self.more).zip(emission).enumerate();
        sums.for_each(|(pixel, ((square, more), radiance))| {
            let each = glints.trees_a_pass(pixel).max(1.0);
            let squared = radiance.iter().map(|x| x * x).sum::<f32>();
            // pages of zeros that are never written take no memory
            if squared > 0.0 {
                *square += each / passes * squared;
            }
            if each > 1.0 {
                *more += (each - 1.0) * passes;
            }
        });
    }

    /// More trees where emission varies, by what all passes saw.
    pub(crate) fn grown(&self, glints: &SplitPaths, film: &Film) -> SplitPaths {
        let passes = film.passes() as f32;
        // of one tree: a batch's mean varies the less the more trees it has
        let seen = (self.batches - 1).max(1) as f32;
        let varies = |pixel: usize| {
            if self.squares[pixel] <= 0.0 {
                return 0.0;
            }
            let squared = |sum: [f64; BANDS]| sum.iter().map(|x| (*x as f32 / passes).powi(2)).sum::<f32>();
            let mean =
                squared(film.sum(Layer::Emission as usize, pixel)) * (self.passes + self.more[pixel]) / seen;
            relative_variance(self.squares[pixel] / seen, mean, squared(film.sum_of_layers(pixel)))
        };
        let found: Vec<f32> = (0..glints.levels.len()).into_par_iter().map(varies).collect();
        let wanted = |pixel: usize| {
            let near = around(pixel as u32, glints.size).map(|i| found[i]).fold(0.0, f32::max);
            worth(found[pixel].max(near / NEIGHBOURS))
        };
        let wanted: Vec<u8> = (0..found.len()).into_par_iter().map(wanted).collect();
        SplitPaths { size: glints.size, turns: glints.turns, levels: glints.limited(&wanted) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::LAYERS;
    use std::collections::BTreeSet;

    const SIZE: [u32; 2] = [12, 10];
    const PIXELS: usize = 120;
    const MIDDLE: usize = 65;

    fn look(light: Light, branched: bool) -> Look {
        Look { light, branched, square: 1.0, squared_mean: 0.5 }
    }

    /// Nothing but D surfaces, but for one pixel that sees a light in part and a column that sees glass.
    fn marked() -> SplitPaths {
        let mut looks = vec![look(Light::Nowhere, false); PIXELS];
        looks[MIDDLE] = look(Light::InPart, true);
        (0..10).for_each(|y| looks[y * 12] = look(Light::Nowhere, true));
        SplitPaths::mark(SIZE, &looks, &[])
    }

    /// The emission that `at` says for each pass and pixel, watched for `passes` passes of one each, and what it makes of
    /// the glints.
    fn after(passes: u64, glints: &SplitPaths, at: impl Fn(u64, usize) -> f32) -> SplitPaths {
        let (mut watch, mut film) = (Watch::new(SIZE), Film::new(SIZE[0], SIZE[1]));
        for pass in 0..passes {
            let mut layers: [Vec<Bands>; LAYERS] = Default::default();
            layers[Layer::Emission as usize] = (0..PIXELS).map(|p| [at(pass, p); BANDS]).collect();
            watch.watch(1, &layers[Layer::Emission as usize], glints);
            film.add(1, &layers);
        }
        watch.grown(glints, &film)
    }

    /// The pilot marks a pixel that sees light in part and those around it; glass gets a tree in turn; nothing else any.
    #[test]
    fn the_pilot_marks_light_in_part_and_glass() {
        let glints = marked();
        for pixel in 0..PIXELS {
            let near = around(MIDDLE as u32, SIZE).any(|i| i == pixel);
            let trees = glints.trees_a_pass(pixel);
            if near {
                assert!(trees >= GLINT_TREES as f32, "{pixel}: {trees}");
            } else {
                let wanted = if pixel % 12 == 0 { 1.0 / glints.turns() as f32 } else { 0.0 };
                assert_eq!(trees, wanted, "{pixel}");
            }
        }
        // ten pixels of 120, one tree for each 32 pixels: four turns
        assert_eq!(glints.turns(), 4);
    }

    /// No tree comes twice, whenever a pixel gets more; on average they are as many as they should be.
    #[test]
    fn no_tree_comes_twice() {
        let few = marked();
        let more = few.limited(&[FEWEST + 3; PIXELS]);
        let more = SplitPaths { levels: more, ..few.clone() };
        for pixel in [0, MIDDLE as u32, 12, 24, 36] {
            for grows_at in [2, 4, 16] {
                let (mut seen, mut count) = (BTreeSet::new(), 0);
                for pass in 0..32 {
                    let glints = if pass < grows_at { &few } else { &more };
                    for number in glints.numbers(pixel, pass, 7) {
                        assert!(seen.insert(number), "pixel {pixel}, pass {pass}: tree {number} again");
                        count += 1;
                    }
                }
                let before = few.trees_a_pass(pixel as usize) * grows_at as f32;
                let after = more.trees_a_pass(pixel as usize) * (32 - grows_at) as f32;
                assert!((count as f32 - before - after).abs() < 1.0, "{count}, {before} + {after}");
            }
        }
    }

    /// What the list grows in a pass, in parts of whatever size, is what each pixel's numbers say; the trees of one pixel
    /// lie side by side in one part, the first at a multiple of their number.
    #[test]
    fn the_list_grows_the_same_trees() {
        let mut glints = marked();
        (glints.levels[3], glints.levels[7], glints.levels[90]) =
            (FEWEST + 5, FEWEST + 2, FEWEST + DOUBLINGS_MAX);
        for pixels in [0..120, 48..72] {
            let list = glints.list(pixels.clone(), 5);
            for (pass, most) in (0..9).zip([64, 100, 128, 1000].into_iter().cycle()) {
                let mut grown = vec![0; PIXELS];
                for part in list.growths(pass, most) {
                    assert!(part.len() <= most as usize);
                    for (i, entry) in list.trees[part.start as usize..part.end as usize].iter().enumerate() {
                        let (pixel, level) = (entry & 0x0fff_ffff, entry >> GLINT_PIXEL_BITS);
                        assert_eq!(level, u32::from(glints.levels[pixel as usize]));
                        let own = grown[pixel as usize];
                        assert_eq!(i as u32 % trees_of(level as u8), own, "pixel {pixel}");
                        grown[pixel as usize] += 1;
                    }
                }
                for (pixel, grown) in (0u32..).zip(grown) {
                    let wanted = if pixels.contains(&pixel) {
                        glints.numbers(pixel, pass as u32, 5).count() as u32
                    } else {
                        0
                    };
                    assert_eq!(grown, wanted, "pixel {pixel}, pass {pass}");
                }
            }
        }
    }

    /// A dot makes its pixel's trees many and those of its neighbours some; steady light, however bright, makes none.
    #[test]
    fn trees_grow_where_emission_is_noisy() {
        let none = SplitPaths::mark(SIZE, &[look(Light::Nowhere, false); PIXELS], &[]);
        let grown = after(4, &none, |pass, pixel| match pixel {
            MIDDLE if pass == 2 => 8.0,
            5 => 1e4,
            _ => 0.0,
        });
        let trees = |pixel| grown.trees_a_pass(pixel);
        assert!(trees(MIDDLE) >= 32.0, "{}", trees(MIDDLE));
        assert!(trees(MIDDLE + 1) >= GLINT_TREES as f32 && trees(MIDDLE + 1) < trees(MIDDLE));
        assert_eq!((trees(5), trees(6), trees(MIDDLE + 2)), (0.0, 0.0, 0.0));
    }

    /// A device that goes on has no fewer trees in any pixel than the one before it and than its own pilot found.
    #[test]
    fn a_device_that_goes_on_has_no_fewer_trees() {
        let own = marked();
        let before = after(4, &own, |pass, pixel| if pixel == 3 && pass == 2 { 8.0 } else { 0.0 });
        let joined = own.joined(&before);
        assert_ne!(joined, own);
        for pixel in 0..PIXELS {
            let most = own.trees_a_pass(pixel).max(before.trees_a_pass(pixel));
            assert_eq!(joined.trees_a_pass(pixel), most, "{pixel}");
        }
    }

    /// Trees are limited by the pixels, and what has some loses none.
    #[test]
    fn trees_are_limited_and_none_is_lost() {
        let few = marked();
        let noisy = after(4, &few, |pass, _| if pass == 1 { 50.0 } else { 0.0 });
        let total: u64 = noisy.levels.iter().map(|l| u64::from(trees_of(*l))).sum();
        assert!(total <= SplitPaths::most(PIXELS as u64), "{total}");
        assert!(noisy.levels.iter().zip(&few.levels).all(|(now, before)| now >= before));
        assert_ne!(noisy, few);
    }
}
