//! Smooth reflectances that have a given colour under daylight.
//!
//! R(λ) = ½ + x / (2 √(1+x²)),  x = c₀ t² + c₁ t + c₂,  t = (λ-360)/470  \[E33\]  Jakob & Hanika 2019. The coefficients are
//! found by damped Gauss-Newton steps in CIE L*a*b*, as in the paper, but with exact derivatives and without a table.

use super::cie::{Illuminant, Matrix, STEPS, cmf, rgb_to_xyz, y_integral};
use super::{LAMBDA_MAX, LAMBDA_MIN};
use std::sync::LazyLock;

/// Distance in L*a*b* that counts as none.
const CONVERGED: f64 = 1e-8;

/// Where |x| is as large or larger, R is 0 or 1: an f64 does not know them apart.
const LARGEST: f64 = 1e9;

/// Largest coefficient that is tried: what is steeper is a step at one wavelength.
const STEEPEST: f64 = 1e5;

/// The grey that the search starts from is no nearer to black or white, where a sigmoid has no slope left.
const DARKEST_START: f64 = 1e-3;

/// Steps of Gauss and Newton toward one colour. Most need five to fifteen.
const MOST_STEPS: usize = 60;

/// Parts in which the way from grey to a colour is gone, one after the other, where it fails in one.
const PARTS: [usize; 3] = [1, 8, 64];

/// A smooth reflectance, a sigmoid of a parabola in the wavelength; within [0, 1].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigmoid {
    /// c₀, c₁, c₂ of x = c₀ t² + c₁ t + c₂ with t = (λ - [`LAMBDA_MIN`]) / ([`LAMBDA_MAX`] - [`LAMBDA_MIN`]), no unit.
    pub coefficients: [f64; 3],
}

/// A node of the quadrature over wavelength.
struct Node {
    t: f64,
    /// XYZ that a reflectance of one at this node adds under D65.
    weight: [f64; 3],
}

/// Nodes at every nm. Simpson's rule in each nm on either side of a node, with reflectances linear between nodes: the sums
/// are as exact as [`super::cie::xyz`], but for the curvature of the reflectance within a nm.
static NODES: LazyLock<Vec<Node>> = LazyLock::new(|| {
    let lit = |lambda: f64| cmf(lambda).map(|c| c * Illuminant::D65.at(lambda) / (6.0 * y_integral()));
    let node = |i: usize| {
        let lambda = LAMBDA_MIN + i as f64;
        let sides = [(i > 0, lambda - 0.5), (i < STEPS, lambda + 0.5)];
        let mut weight = [0.0; 3];
        for (_, middle) in sides.into_iter().filter(|(is_inside, _)| *is_inside) {
            let (here, between) = (lit(lambda), lit(middle));
            weight = std::array::from_fn(|k| weight[k] + here[k] + 2.0 * between[k]);
        }
        Node { t: i as f64 / STEPS as f64, weight }
    };
    (0..=STEPS).map(node).collect()
});

/// XYZ of the white, which L*a*b* is relative to.
static WHITE: LazyLock<[f64; 3]> =
    LazyLock::new(|| std::array::from_fn(|k| NODES.iter().map(|node| node.weight[k]).sum()));

impl Sigmoid {
    /// The same reflectance at all wavelengths; `value` in [0, 1].
    pub fn constant(value: f64) -> Self {
        let x = (value - 0.5) / (value * (1.0 - value)).sqrt();
        Self { coefficients: [0.0, 0.0, x.clamp(-LARGEST, LARGEST)] }
    }

    /// A reflectance that has this linear sRGB under D65, or as near to it in L*a*b* as a sigmoid comes; clamped to [0, 1]
    /// before.
    pub fn of_rgb(rgb: [f64; 3]) -> Self {
        let rgb = rgb.map(reflected_part);
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return Self::constant(rgb[0]);
        }
        let target = rgb_to_xyz(rgb);
        let grey = Self::constant(target[1].clamp(DARKEST_START, 1.0 - DARKEST_START));
        let white = *WHITE;
        let mut best = (f64::INFINITY, grey);
        for parts in PARTS {
            let mut at = grey.coefficients;
            let mut distance = f64::INFINITY;
            for part in 1..=parts {
                let share = part as f64 / parts as f64;
                let on_the_way = std::array::from_fn(|k| {
                    white[k] * target[1] + share * (target[k] - white[k] * target[1])
                });
                (distance, at) = approach(at, lab(on_the_way));
            }
            if distance < best.0 {
                best = (distance, Self { coefficients: at });
            }
            if distance < CONVERGED {
                break;
            }
        }
        best.1
    }

    /// Reflectance at `lambda`, nm.
    pub fn at(&self, lambda: f64) -> f64 {
        sigmoid(self.x((lambda - LAMBDA_MIN) / (LAMBDA_MAX - LAMBDA_MIN)))
    }

    fn x(&self, t: f64) -> f64 {
        let [a, b, c] = self.coefficients;
        (a * t + b) * t + c
    }
}

/// The part of a value that a surface can reflect: within [0, 1], and 0 where it is no number.
pub(super) fn reflected_part(value: f64) -> f64 {
    if value.is_nan() { 0.0 } else { value.clamp(0.0, 1.0) }
}

/// ½ + x / (2 √(1+x²)), without the loss of digits where it is near 0.
fn sigmoid(x: f64) -> f64 {
    if x.abs() >= LARGEST {
        return if x > 0.0 { 1.0 } else { 0.0 };
    }
    let root = (1.0 + x * x).sqrt();
    if x < 0.0 { 0.5 / (root * (root - x)) } else { 0.5 + 0.5 * x / root }
}

/// L*a*b* of XYZ relative to [`WHITE`].
fn lab(xyz: [f64; 3]) -> [f64; 3] {
    let [x, y, z] = std::array::from_fn(|k| lab_curve(xyz[k] / WHITE[k]).0);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The curve of L*a*b*, cube root above and linear below, and its derivative.
fn lab_curve(ratio: f64) -> (f64, f64) {
    const DELTA: f64 = 6.0 / 29.0;
    if ratio > DELTA * DELTA * DELTA {
        let root = ratio.cbrt();
        (root, 1.0 / (3.0 * root * root))
    } else {
        let slope = 1.0 / (3.0 * DELTA * DELTA);
        (slope * ratio + 4.0 / 29.0, slope)
    }
}

/// L*a*b* of a sigmoid under D65, and its derivatives: rows L, a, b, columns c₀, c₁, c₂.
fn lab_of(coefficients: [f64; 3]) -> ([f64; 3], Matrix) {
    let curve = Sigmoid { coefficients };
    let (mut xyz, mut slopes) = ([0.0; 3], [[0.0; 3]; 3]);
    for node in NODES.iter() {
        let x = curve.x(node.t);
        let root_squared = 1.0 + x * x;
        let slope = 0.5 / (root_squared * root_squared.sqrt());
        let value = sigmoid(x);
        for k in 0..3 {
            let w = node.weight[k] * slope;
            xyz[k] += node.weight[k] * value;
            slopes[k][0] += w * node.t * node.t;
            slopes[k][1] += w * node.t;
            slopes[k][2] += w;
        }
    }
    for k in 0..3 {
        let rate = lab_curve(xyz[k] / WHITE[k]).1 / WHITE[k];
        slopes[k] = slopes[k].map(|s| s * rate);
    }
    let [x, y, z] = slopes;
    let rows = std::array::from_fn(|j| [116.0 * y[j], 500.0 * (x[j] - y[j]), 200.0 * (y[j] - z[j])]);
    (lab(xyz), transpose(&rows))
}

/// The coefficients near `start` whose colour is nearest to `target`, and how near, in L*a*b*: Gauss-Newton steps, damped as
/// by Levenberg and Marquardt.
fn approach(start: [f64; 3], target: [f64; 3]) -> (f64, [f64; 3]) {
    let residual = |lab: [f64; 3]| -> [f64; 3] { std::array::from_fn(|k| lab[k] - target[k]) };
    let mut at = start;
    let (lab, mut slopes) = lab_of(at);
    let mut left = residual(lab);
    let mut damping = 1e-3;
    for _ in 0..MOST_STEPS {
        if length(left) < CONVERGED {
            break;
        }
        let next =
            step(&slopes, left, damping).map(|step| -> [f64; 3] { std::array::from_fn(|k| at[k] + step[k]) });
        let next = next.filter(|next| next.iter().all(|c| c.abs() <= STEEPEST));
        let tried = next.map(|next| (next, lab_of(next)));
        match tried {
            Some((next, (lab, next_slopes))) if length(residual(lab)) < length(left) => {
                (at, left, slopes) = (next, residual(lab), next_slopes);
                damping *= 0.1;
            }
            _ => damping *= 10.0,
        }
    }
    (length(left), at)
}

/// The step that a linear model asks for, (JᵀJ + μ diag JᵀJ) s = -Jᵀ r; none where that has no solution.
fn step(slopes: &Matrix, left: [f64; 3], damping: f64) -> Option<[f64; 3]> {
    let columns = transpose(slopes);
    let mut normal: Matrix = std::array::from_fn(|i| std::array::from_fn(|j| dot(columns[i], columns[j])));
    for (k, row) in normal.iter_mut().enumerate() {
        row[k] *= 1.0 + damping;
    }
    let right = columns.map(|c| -dot(c, left));
    solve(normal, right).filter(|s| s.iter().all(|x| x.is_finite()))
}

/// Solution of a symmetric positive system by Cholesky's decomposition.
fn solve(m: Matrix, right: [f64; 3]) -> Option<[f64; 3]> {
    let mut l = [[0.0; 3]; 3];
    for i in 0..3 {
        for j in 0..=i {
            let known: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            let rest = m[i][j] - known;
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
        }
        if l[i][i].is_nan() || l[i][i] <= 0.0 {
            return None;
        }
    }
    let mut y = right;
    for i in 0..3 {
        let known: f64 = (0..i).map(|k| l[i][k] * y[k]).sum();
        y[i] = (y[i] - known) / l[i][i];
    }
    for i in (0..3).rev() {
        let known: f64 = (i + 1..3).map(|k| l[k][i] * y[k]).sum();
        y[i] = (y[i] - known) / l[i][i];
    }
    Some(y)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn transpose(m: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| m[j][i]))
}

#[cfg(test)]
mod tests {
    use super::super::cie::{xyz, xyz_to_rgb};
    use super::*;

    /// Largest error of linear sRGB: the nodes are 1 nm apart and see no curvature of the reflectance, unlike the check.
    const TOLERANCE: f64 = 5e-5;

    /// The same for reflectances that are nearly flat.
    const FLAT_TOLERANCE: f64 = 1e-6;

    fn rgb_of(curve: &Sigmoid) -> [f64; 3] {
        xyz_to_rgb(xyz(|lambda| curve.at(lambda) * Illuminant::D65.at(lambda)))
    }

    /// A cube of 11×11×11 colours through `scale`, which maps [0, 1] to where it looks.
    fn cube(scale: impl Fn(f64) -> f64) -> impl Iterator<Item = [f64; 3]> {
        (0..1331_u32).map(move |i| [i / 121, i / 11 % 11, i % 11].map(|x| scale(f64::from(x) / 10.0)))
    }

    /// Every colour of sRGB has a sigmoid: bright, dark and nearly white ones.
    #[test]
    fn colours_come_back() {
        let worst = |colours: &mut dyn Iterator<Item = [f64; 3]>| {
            let errors = colours.map(|rgb| {
                let curve = Sigmoid::of_rgb(rgb);
                assert!((360..=830).all(|nm| (0.0..=1.0).contains(&curve.at(f64::from(nm)))), "{rgb:?}");
                let back = rgb_of(&curve);
                ((0..3).map(|k| (back[k] - rgb[k]).abs()).fold(0.0, f64::max), rgb)
            });
            errors.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap()
        };
        let all = worst(&mut cube(|x| x));
        let dark = worst(&mut cube(|x| 0.05 * x.powi(4)));
        let bright = worst(&mut cube(|x| 1.0 - 0.05 * x.powi(4)));
        let black = worst(&mut cube(|x| 1e-6 * x));
        let white = worst(&mut cube(|x| 1.0 - 1e-6 * x));
        println!("all {all:?}, dark {dark:?}, bright {bright:?}, nearly black {black:?} or white {white:?}");
        let limits = [TOLERANCE, TOLERANCE, TOLERANCE, FLAT_TOLERANCE, FLAT_TOLERANCE];
        for ((error, rgb), limit) in [all, dark, bright, black, white].into_iter().zip(limits) {
            assert!(error < limit, "{rgb:?} comes back with an error of {error}");
        }
    }

    /// Greys are flat; black and white are exact, as is what lies beyond them.
    #[test]
    fn greys_are_constant() {
        for grey in [0.0, 1e-6, 0.18, 0.5, 0.73, 1.0] {
            let curve = Sigmoid::of_rgb([grey; 3]);
            for lambda in [360.0, 555.5, 830.0] {
                assert!(
                    (curve.at(lambda) - grey).abs() < 1e-15,
                    "{grey} at {lambda} nm: {}",
                    curve.at(lambda)
                );
            }
        }
        assert_eq!(Sigmoid::of_rgb([-1.0; 3]).at(500.0), 0.0);
        assert_eq!(Sigmoid::of_rgb([7.0, 2.0, f64::INFINITY]).at(500.0), 1.0);
        assert_eq!(Sigmoid::of_rgb([-1.0, 0.0, f64::NAN]).at(500.0), 0.0);
    }

    /// A grey with a trace of colour is all but flat.
    #[test]
    fn spectra_near_grey_are_nearly_constant() {
        let curve = Sigmoid::of_rgb([0.5, 0.5, 0.5 + 1e-6]);
        assert!((360..=830).all(|nm| (curve.at(f64::from(nm)) - 0.5).abs() < 1e-4));
    }

    /// The derivatives are those of the colour, by differences.
    #[test]
    fn derivatives_are_right() {
        let at = [3.0, -2.0, 0.4];
        let (_, slopes) = lab_of(at);
        for column in 0..3 {
            let moved = |by: f64| {
                let mut moved = at;
                moved[column] += by;
                lab_of(moved).0
            };
            let (above, below) = (moved(1e-5), moved(-1e-5));
            for row in 0..3 {
                let slope = (above[row] - below[row]) / 2e-5;
                assert!((slope - slopes[row][column]).abs() < 1e-6 * (1.0 + slope.abs()), "{row}, {column}");
            }
        }
    }
}
