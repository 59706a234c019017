//! Courses: how the three wavelengths of a pass go together, so that white is white in every pass.
//!
//! Each of three parts of the spectrum is gone through once while u goes from 0 to 1, with speeds at which the colours of the
//! three wavelengths add up to white all the way  \[E39\]. What is drawn stays unbiased whatever the speeds are: where a part is
//! gone through fast, its wavelengths are rare and count for more.

use super::BANDS;
use super::cie::{apply, inverse};
use super::curve::Spectrum;
use std::sync::LazyLock;

/// Cells of the cumulative probability in which colours are held.
const CELLS: usize = 1024;
/// Steps of u.
const STEPS: usize = 256;
/// Steps while the ends of the parts are searched.
const COARSE_STEPS: usize = 64;
/// Slowest and fastest, in units of probability; a third is even.
const SPEEDS: [f64; 2] = [0.02, 1.0];
/// How much it costs to leave the even speed, beside the squared error of white: where colours are all alike, as in the light of
/// one line, speeds are even.
const STIFFNESS: f64 = 0.1;
/// Of the brightest band of white: what a dimmer band's error is related to at least.
const DIMMEST: f64 = 0.1;
/// Added to the squared colour of a reference, white being 1, as errors of pictures have it.
const OFFSET: f64 = 1e-2;
/// Between ends of parts that are tried, first and at last.
const TRIED: [f64; 2] = [0.04, 0.02];

/// Linear sRGB of smooth reflectances beside white that should be right, too, as far as the ends of the parts allow it.
const COLOURS: [[f64; 3]; 5] =
    [[0.63, 0.06, 0.05], [0.14, 0.45, 0.09], [0.1, 0.2, 0.6], [0.7, 0.5, 0.3], [0.7, 0.6, 0.05]];
const REFERENCES: usize = 1 + COLOURS.len();

static REFLECTANCES: LazyLock<[Spectrum; COLOURS.len()]> =
    LazyLock::new(|| COLOURS.map(Spectrum::reflectance_of_rgb));

/// A colour for each band of the picture.
type Colour = [f64; 3];

/// Where a course is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Cumulative probability, from 0 to 1.
    pub at: f64,
    /// How fast it grows with u.
    pub speed: f64,
}

/// Three courses, each through a part of the cumulative probability.
#[derive(Clone, Debug)]
pub struct Courses {
    /// Where each is after every step.
    knots: Vec<[f64; BANDS]>,
}

impl Courses {
    /// Courses for lights; `seen` tells of a cumulative probability its wavelength, nm, and the linear sRGB that the lights together
    /// have there, per probability.
    pub fn new(seen: impl Fn(f64) -> (f64, Colour)) -> Self {
        match Light::new(seen) {
            Some(light) => Self { knots: light.course(light.best_ends(), STEPS) },
            None => Self::even(),
        }
    }

    /// Thirds, gone through evenly.
    pub fn even() -> Self {
        let knot = |after: usize| std::array::from_fn(|band| (after + band) as f64 / BANDS as f64);
        Self { knots: [0, 1].map(knot).to_vec() }
    }

    /// Where the courses are at `u` in [0, 1).
    pub fn at(&self, u: f64) -> [Place; BANDS] {
        let steps = self.knots.len() - 1;
        let along = u * steps as f64;
        let step = (along as usize).min(steps - 1);
        let (from, to) = (self.knots[step], self.knots[step + 1]);
        std::array::from_fn(|band| {
            let length = to[band] - from[band];
            Place { at: from[band] + (along - step as f64) * length, speed: length * steps as f64 }
        })
    }
}

/// What the lights show of the references.
struct Light {
    /// Colours per probability, in the middle of each cell; white is the first.
    cells: Vec<[Colour; REFERENCES]>,
    /// Sums of white's over the cells before each, times the length of a cell; one more than there are cells.
    sums: Vec<Colour>,
    /// Colours of all the light.
    whole: [Colour; REFERENCES],
}

impl Light {
    /// None where there is no light.
    fn new(seen: impl Fn(f64) -> (f64, Colour)) -> Option<Self> {
        let cell = |i: usize| {
            let (lambda, white) = seen((i as f64 + 0.5) / CELLS as f64);
            let on = |reflectance: &Spectrum| white.map(|c| c * reflectance.at(lambda));
            let mut colours = [white; REFERENCES];
            colours[1..].iter_mut().zip(&*REFLECTANCES).for_each(|(colour, r)| *colour = on(r));
            colours
        };
        let mut cells: Vec<[Colour; REFERENCES]> = (0..CELLS).map(cell).collect();
        // each band relative to white
        let white = mean(&cells)[0].map(f64::abs);
        let brightest = white.into_iter().fold(0.0, f64::max);
        if brightest <= 0.0 {
            return None;
        }
        let scale = white.map(|c| 1.0 / c.max(DIMMEST * brightest));
        for colour in cells.as_flattened_mut() {
            *colour = std::array::from_fn(|k| colour[k] * scale[k]);
        }
        let mut sums = vec![[0.0; 3]];
        let mut sum = [0.0; 3];
        for [white, ..] in &cells {
            sum = std::array::from_fn(|k| sum[k] + white[k] / CELLS as f64);
            sums.push(sum);
        }
        let whole = mean(&cells);
        Some(Self { cells, sums, whole })
    }

    /// Colours per probability.
    fn seen(&self, at: f64) -> &[Colour; REFERENCES] {
        &self.cells[((at * CELLS as f64) as usize).min(CELLS - 1)]
    }

    /// White of the light up to `at`.
    fn white_up_to(&self, at: f64) -> Colour {
        let along = at * CELLS as f64;
        let cell = (along as usize).min(CELLS - 1);
        let t = along - cell as f64;
        std::array::from_fn(|k| (1.0 - t) * self.sums[cell][k] + t * self.sums[cell + 1][k])
    }

    /// Where the courses are after each of so many steps, through parts with these ends. At each step the three speeds are those at
    /// which white is right, as the rest of the way has it, which takes up what went wrong before.
    fn course(&self, [first, second]: [f64; 2], steps: usize) -> Vec<[f64; BANDS]> {
        let ends = [first, second, 1.0];
        let white_of_ends = ends.map(|end| self.white_up_to(end));
        let mut at = [0.0, first, second];
        let mut knots = vec![at];
        for step in 0..steps {
            let left = (steps - step) as f64;
            let even: [f64; BANDS] =
                std::array::from_fn(|band| (ends[band] - at[band]) * steps as f64 / left);
            let bounds = even.map(|even| {
                let bound = |others: f64| even * left - others * (left - 1.0);
                [SPEEDS[0].max(bound(SPEEDS[1])), SPEEDS[1].min(bound(SPEEDS[0]))]
            });
            let mut target = [0.0; 3];
            for (end, at) in white_of_ends.iter().zip(at) {
                let white = self.white_up_to(at);
                target = std::array::from_fn(|k| target[k] + (end[k] - white[k]) * steps as f64 / left);
            }
            let mut speeds = even;
            // the second time with the colours of the middle of the step
            for _ in 0..if left > 1.0 { 2 } else { 0 } {
                let middles = std::array::from_fn(|band| at[band] + speeds[band] / (2 * steps) as f64);
                speeds = self.speeds(middles, even, target);
                speeds = std::array::from_fn(|band| speeds[band].max(bounds[band][0]).min(bounds[band][1]));
            }
            at = std::array::from_fn(|band| at[band] + speeds[band] / steps as f64);
            knots.push(at);
        }
        // without the rounding of all steps
        knots[steps] = ends;
        knots
    }

    /// Speeds with which white is `target`, by least squares, `even` where that leaves them open.
    fn speeds(&self, at: [f64; BANDS], even: [f64; BANDS], target: Colour) -> [f64; BANDS] {
        let columns = at.map(|at| self.seen(at)[0]);
        let dot = |a: Colour, b: Colour| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let missing: Colour = std::array::from_fn(|k| {
            target[k] - columns.iter().zip(even).map(|(column, speed)| column[k] * speed).sum::<f64>()
        });
        let normal = std::array::from_fn(|i| {
            std::array::from_fn(|j| dot(columns[i], columns[j]) + if i == j { STIFFNESS } else { 0.0 })
        });
        let change = apply(&inverse(&normal), columns.map(|column| dot(column, missing)));
        std::array::from_fn(|band| even[band] + change[band])
    }

    /// Mean relative squared error of the references along a course.
    fn error(&self, knots: &[[f64; BANDS]]) -> f64 {
        let steps = knots.len() - 1;
        let mut sum = 0.0;
        for ends in knots.windows(2) {
            let speeds: [f64; BANDS] =
                std::array::from_fn(|band| (ends[1][band] - ends[0][band]) * steps as f64);
            let seen: [_; BANDS] =
                std::array::from_fn(|band| self.seen((ends[0][band] + ends[1][band]) / 2.0));
            for (reference, whole) in self.whole.iter().enumerate() {
                for k in 0..3 {
                    let found: f64 = (0..BANDS).map(|band| seen[band][reference][k] * speeds[band]).sum();
                    sum += (found - whole[k]).powi(2) / (whole[k].powi(2) + OFFSET);
                }
            }
        }
        sum / (steps * REFERENCES * 3) as f64
    }

    /// The ends of the first and the second part with the least error.
    fn best_ends(&self) -> [f64; 2] {
        let [far, near] = TRIED;
        let all = || (2..).map(move |i| f64::from(i) * far).take_while(move |end| *end < 1.0 - 2.0 * far);
        let pairs = all().flat_map(|a| all().map(move |b| [a, b]));
        let best = self.best(pairs);
        let around = [-near, 0.0, near];
        self.best(around.iter().flat_map(|a| around.iter().map(move |b| [best[0] + a, best[1] + b])))
    }

    fn best(&self, ends: impl Iterator<Item = [f64; 2]>) -> [f64; 2] {
        let mut best = (f64::INFINITY, [1.0 / 3.0, 2.0 / 3.0]);
        for ends in ends.filter(|[a, b]| b - a >= TRIED[0]) {
            let error = self.error(&self.course(ends, COARSE_STEPS));
            if error < best.0 {
                best = (error, ends);
            }
        }
        best.1
    }
}

fn mean(cells: &[[Colour; REFERENCES]]) -> [Colour; REFERENCES] {
    let sum = |reference: usize, k: usize| cells.iter().map(|colours| colours[reference][k]).sum::<f64>();
    std::array::from_fn(|reference| std::array::from_fn(|k| sum(reference, k) / cells.len() as f64))
}
