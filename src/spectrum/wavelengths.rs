//! Which wavelengths the bands of a pass have.
//!
//! Wavelengths are drawn from a density over 360 to 830 nm, mixed with atoms, the lines of lamps. A pass has three of them, one
//! of each of three parts of the probability, in which 2^m passes are evenly spread  \[E34, E39\].

use super::LAMBDA_MIN;
use super::cie::{STEPS, line_xyz, sensitivity, xyz_to_rgb};
use super::courses::Courses;
use super::lamp::Emission;
use super::pick::{PICKS, Pick};

/// Part of the continuous density that follows the eye alone, so that a wavelength where lights are weak is not starved.
const EYE_PART: f64 = 0.1;

/// Digits that are flipped in the second half of the passes. Of each number of passes that is a power of two, its gaps are then
/// those of the first half shifted by about a half or a quarter of themselves: the halves differ by as much as both are wrong,
/// and both together have gaps of half the width.
const OTHER_HALF: u64 = 0xaaaa_aaaa_aaaa_aaaa;

/// A stretch of the distribution, in the order of wavelength.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// Where it begins and ends, nm; the same for an atom.
    ends: [f64; 2],
    /// Density at both ends, 1/nm, linear between; the probability, twice, for an atom.
    pdf: [f64; 2],
    atom: Option<usize>,
}

impl Piece {
    fn chance(&self) -> f64 {
        let mean = (self.pdf[0] + self.pdf[1]) / 2.0;
        if self.atom.is_some() { mean } else { mean * (self.ends[1] - self.ends[0]) }
    }
}

/// Density and atoms that the wavelengths of passes are drawn from.
#[derive(Clone, Debug)]
pub struct Distribution {
    /// Wavelengths of all lines, nm, ascending, each once.
    atoms: Vec<f64>,
    pieces: Vec<Piece>,
    /// Probability of all pieces up to each, itself included; the last is 1.
    sums: Vec<f64>,
    /// How the three of a pass go together.
    courses: Courses,
}

impl Distribution {
    /// A distribution for these lights, each with its share in the picture, zero or more, of any scale. Density and atoms are
    /// proportional to what they add to the picture: [`sensitivity`] times emission. Without any light the density follows
    /// the eye.
    pub fn new<'a>(lights: impl IntoIterator<Item = (f64, &'a Emission)>) -> Self {
        let lights: Vec<(f64, &Emission)> = lights.into_iter().collect();
        let mut seen = [0.0; STEPS + 1];
        let mut lines: Vec<(f64, f64)> = Vec::new();
        for (share, light) in &lights {
            if let Some(spectrum) = &light.continuous {
                for (i, seen) in seen.iter_mut().enumerate() {
                    let lambda = LAMBDA_MIN + i as f64;
                    *seen += share * spectrum.at(lambda) * sensitivity(lambda);
                }
            }
            let weighed = light.lines.iter().map(|l| (l.lambda, share * l.power * sensitivity(l.lambda)));
            lines.extend(weighed.filter(|(_, weight)| *weight > 0.0));
        }
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        lines.dedup_by(|later, first| {
            let is_same = later.0 == first.0;
            first.1 += if is_same { later.1 } else { 0.0 };
            is_same
        });
        with_eye_part(&mut seen, lines.is_empty());
        let pieces = pieces(&seen, &lines);
        let total: f64 = pieces.iter().map(Piece::chance).sum();
        let pieces: Vec<Piece> =
            pieces.into_iter().map(|p| Piece { pdf: p.pdf.map(|x| x / total), ..p }).collect();
        let mut sums: Vec<f64> = Vec::with_capacity(pieces.len());
        for piece in &pieces {
            sums.push(sums.last().unwrap_or(&0.0) + piece.chance());
        }
        let atoms = lines.iter().map(|(lambda, _)| *lambda).collect();
        let mut found = Self { atoms, pieces, sums, courses: Courses::even() };
        found.courses = Courses::new(|place| {
            let pick = found.pick(place);
            let emitted: f64 = lights.iter().map(|(share, light)| share * light.value(&pick)).sum();
            (pick.lambda, xyz_to_rgb(line_xyz(pick.lambda)).map(|c| c * emitted / pick.pdf))
        });
        found
    }

    /// Wavelengths of all lines that can be picked, nm, ascending.
    pub fn atoms(&self) -> &[f64] {
        &self.atoms
    }

    /// Probability that a wavelength is an atom.
    pub fn chance_of_atoms(&self) -> f64 {
        self.pieces.iter().filter(|p| p.atom.is_some()).map(Piece::chance).sum()
    }

    /// The wavelength at `u` in [0, 1); ascends with it.
    pub fn pick(&self, u: f64) -> Pick {
        let last = self.pieces.len() - 1;
        let i = self.sums.partition_point(|sum| *sum <= u).min(last);
        let piece = &self.pieces[i];
        let [lambda, end] = piece.ends;
        if piece.atom.is_some() {
            return Pick { lambda, atom: piece.atom, pdf: piece.pdf[0] };
        }
        let before = if i == 0 { 0.0 } else { self.sums[i - 1] };
        let ([pdf, next], width) = (piece.pdf, end - lambda);
        let slope = (next - pdf) / width;
        // the root of pdf x + slope x²/2 = u - before that is 0 where u is, without a difference of equals
        let mass = (u - before).clamp(0.0, piece.chance());
        let root = (pdf * pdf + 2.0 * slope * mass).max(0.0).sqrt();
        let x = (2.0 * mass / (pdf + root)).clamp(0.0, width);
        Pick { lambda: lambda + x, atom: None, pdf: pdf + slope * x }
    }

    /// The wavelengths of the bands in a pass, the `place`th of its half of the passes, one of each part of the probability. Which band
    /// has which part changes from pass to pass. The first 4 · 2^m passes of a half are evenly spread, and in other places than
    /// those of the other half.
    pub fn of_pass(&self, seed: u64, half: usize, place: u64) -> [Pick; PICKS] {
        let turn = (2 * place + half as u64 + mixed(seed) % PICKS as u64) % PICKS as u64;
        let places = self.courses.at(offset(seed, half, place));
        std::array::from_fn(|band| {
            let place = places[(band + turn as usize) % PICKS];
            let pick = self.pick(place.at);
            Pick { pdf: pick.pdf / (PICKS as f64 * place.speed), ..pick }
        })
    }
}

/// How far in [0, 1) a pass is along the courses.
fn offset(seed: u64, half: usize, place: u64) -> f64 {
    // two passes, and then two that mirror them, in one half earlier than in the other: what grows evenly from end to end cancels
    let (index, is_mirrored) = (place >> 2 << 1 | place & 1, (place >> 1 & 1) as usize != half);
    // van der Corput's sequence with its digits flipped by the seed's: each doubling halves the gaps
    let digits = index.reverse_bits() ^ mixed(seed) ^ [0, OTHER_HALF][half];
    let digits = if is_mirrored { !digits } else { digits };
    (digits >> 11) as f64 / (1_u64 << 53) as f64
}

/// Adds to what is seen of lights at each nm the eye's part; all of it where nothing else is there, unless there are lines.
fn with_eye_part(seen: &mut [f64; STEPS + 1], is_without_lines: bool) {
    let total: f64 = seen.iter().sum();
    if total == 0.0 && !is_without_lines {
        return;
    }
    let eye: Vec<f64> = (0..=STEPS).map(|i| sensitivity(LAMBDA_MIN + i as f64)).collect();
    let scale =
        if total == 0.0 { 1.0 } else { EYE_PART / (1.0 - EYE_PART) * total / eye.iter().sum::<f64>() };
    for (seen, eye) in seen.iter_mut().zip(eye) {
        *seen += scale * eye;
    }
}

/// The density between the whole nm, and the atoms, of wavelength and weight, where they belong; not yet of sum one.
fn pieces(density: &[f64; STEPS + 1], atoms: &[(f64, f64)]) -> Vec<Piece> {
    let at = |lambda: f64| {
        let below = ((lambda - LAMBDA_MIN) as usize).min(STEPS - 1);
        let t = lambda - LAMBDA_MIN - below as f64;
        (1.0 - t) * density[below] + t * density[below + 1]
    };
    let mut knots: Vec<(f64, Option<usize>)> = (0..=STEPS).map(|i| (LAMBDA_MIN + i as f64, None)).collect();
    knots.extend(atoms.iter().enumerate().map(|(i, (lambda, _))| (*lambda, Some(i))));
    knots.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut found = Vec::with_capacity(2 * knots.len());
    let mut before = LAMBDA_MIN;
    for (lambda, atom) in knots {
        if lambda > before {
            let piece = Piece { ends: [before, lambda], pdf: [at(before), at(lambda)], atom: None };
            found.push(piece);
        }
        if let Some(i) = atom {
            found.push(Piece { ends: [lambda; 2], pdf: [atoms[i].1; 2], atom });
        }
        before = lambda;
    }
    found.retain(|piece| piece.chance() > 0.0);
    found
}

/// Digits of a number that look random: the finaliser of SplitMix64, Steele et al. 2014.
fn mixed(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::super::cie::{apply, cmf, integral};
    use super::super::curve::Spectrum;
    use super::super::lamp::{Lamp, Line};
    use super::super::pick::rgb_matrix;
    use super::*;

    fn lamp(name: &str) -> Emission {
        Lamp::named(name).unwrap().emission()
    }

    fn red() -> Spectrum {
        Spectrum::reflectance_of_rgb([0.8, 0.1, 0.05])
    }

    fn tan() -> Spectrum {
        Spectrum::reflectance_of_rgb([0.7, 0.5, 0.3])
    }

    /// Colour of a light on a reflectance by passes of these wavelengths.
    fn mean_colour(light: &Emission, on: &Spectrum, passes: &[[Pick; PICKS]]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for picks in passes {
            let bands = picks.map(|pick| light.value(&pick) * on.at(pick.lambda));
            let rgb = apply(&rgb_matrix(picks), bands);
            sum = std::array::from_fn(|k| sum[k] + rgb[k] / passes.len() as f64);
        }
        sum
    }

    /// The same by so many passes from the first on.
    fn rendered(of: &Distribution, light: &Emission, on: &Spectrum, seed: u64, passes: u64) -> [f64; 3] {
        mean_colour(light, on, &of_passes(of, seed, passes))
    }

    fn distance(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
    }

    /// What a spectrum's colour is, with its lines: by integration and not by picks.
    fn colour(light: &Emission, on: &Spectrum) -> [f64; 3] {
        let y = integral(|lambda| cmf(lambda)[1]);
        let mut xyz = [0, 1, 2].map(|k| {
            let continuous = |lambda| light.continuous.as_ref().map_or(0.0, |s| s.at(lambda));
            integral(|lambda| continuous(lambda) * on.at(lambda) * cmf(lambda)[k]) / y
        });
        for Line { lambda, power } in &light.lines {
            xyz = std::array::from_fn(|k| xyz[k] + power * on.at(*lambda) * cmf(*lambda)[k] / y);
        }
        super::super::cie::xyz_to_rgb(xyz)
    }

    /// 1/pdf averages to the length of what is picked from, u ascends with wavelength, and an atom's stretch of u is as long
    /// as its probability.
    #[test]
    fn picks_have_the_density_that_they_tell() {
        let lights = [lamp("A"), lamp("sodium"), lamp("mercury")];
        let of = Distribution::new(lights.iter().map(|light| (1.0, light)));
        let count = 400_000;
        let (mut length, mut moment, mut before) = (0.0, 0.0, 0.0);
        let mut stretches = vec![(0.0, 0.0); of.atoms().len()];
        for i in 0..count {
            let pick = of.pick((f64::from(i) + 0.5) / f64::from(count));
            assert!(pick.lambda >= before && pick.lambda <= 830.0 && pick.pdf > 0.0, "{pick:?}");
            before = pick.lambda;
            match pick.atom {
                Some(atom) => {
                    assert_eq!(of.atoms()[atom], pick.lambda);
                    stretches[atom] = (stretches[atom].0 + 1.0 / f64::from(count), pick.pdf);
                }
                None => {
                    // the far ends have too few picks
                    let is_middle = (400.0..700.0).contains(&pick.lambda);
                    length += f64::from(is_middle) / (pick.pdf * f64::from(count));
                    moment += cmf(pick.lambda)[2] / (pick.pdf * f64::from(count));
                }
            }
        }
        assert!((length / 300.0 - 1.0).abs() < 1e-3, "{length} nm");
        let exact = integral(|lambda| cmf(lambda)[2]);
        // on each side of an atom one pick may fall on the wrong side of the edge
        assert!((moment / exact - 1.0).abs() < 3e-4, "{moment}, not {exact}");
        assert_eq!(stretches.len(), 7);
        assert!(stretches.iter().all(|(stretch, pdf)| (stretch - pdf).abs() < 1e-5), "{stretches:?}");
        let atoms: f64 = stretches.iter().map(|(stretch, _)| stretch).sum();
        assert!((of.chance_of_atoms() - atoms).abs() < 1e-4);
    }

    /// Within a nm, too, where the density rises from next to nothing.
    #[test]
    fn picks_have_the_density_where_it_is_steep() {
        let peak = Spectrum::emission_table(vec![549.0, 550.0, 551.0], vec![0.0, 1.0, 0.0]).unwrap();
        let of = Distribution::new([(1.0, &Emission::continuous(peak))]);
        let count = 1_000_000;
        let picks = (0..count).map(|i| of.pick((f64::from(i) + 0.5) / f64::from(count)));
        let inside = picks.filter(|pick| (549.0..551.0).contains(&pick.lambda));
        let length: f64 = inside.map(|pick| 1.0 / (pick.pdf * f64::from(count))).sum();
        assert!((length / 2.0 - 1.0).abs() < 1e-3, "{length} nm");
    }

    /// Chances follow the length of what is added to linear sRGB: of a line, and of a constant spectrum.
    #[test]
    fn atoms_are_picked_as_often_as_they_are_seen() {
        let light = |lines: Vec<Line>, continuous| Emission { continuous, lines };
        let seen = |lambda: f64| {
            let [x, y, z] = cmf(lambda);
            // the matrix of IEC 61966-2-1
            let r = 3.2406 * x - 1.5372 * y - 0.4986 * z;
            let g = -0.9689 * x + 1.8758 * y + 0.0415 * z;
            let b = 0.0557 * x - 0.2040 * y + 1.0570 * z;
            (r * r + g * g + b * b).sqrt()
        };
        // two lines at one place are one atom of their sum
        let line = Line { lambda: 550.3, power: 1.0 };
        let both = light(vec![line, line], Some(Spectrum::Constant(0.01)));
        let of = Distribution::new([(5.0, &both)]);
        // what follows the eye alone is added to the continuous part
        let continuous = 0.01 * integral(seen) / (1.0 - EYE_PART);
        let expected = 2.0 * seen(550.3) / (2.0 * seen(550.3) + continuous);
        assert!((of.chance_of_atoms() - expected).abs() < 1e-4, "{}, not {expected}", of.chance_of_atoms());
        // a share of none, and lines that nobody sees, are no atoms
        let unseen =
            light(vec![Line { lambda: 1064.0, power: 1.0 }, Line { lambda: 550.0, power: 0.0 }], None);
        let of = Distribution::new([(0.0, &both), (1.0, &unseen)]);
        assert!(of.atoms().is_empty());
        assert!(of.pick(0.5).atom.is_none() && of.pick(0.0).pdf > 0.0);
    }

    /// Wavelengths of the first passes, of both halves in turns.
    fn of_passes(of: &Distribution, seed: u64, passes: u64) -> Vec<[Pick; PICKS]> {
        (0..passes).map(|pass| of.of_pass(seed, (pass % 2) as usize, pass / 2)).collect()
    }

    /// In each half, every second two of the first 4 · 2^m passes are at equal distances along the courses, for every seed; those between
    /// mirror them. No place is in both halves, and each band has all parts.
    #[test]
    fn halves_are_lattices() {
        let light = lamp("D65");
        let of = Distribution::new([(1.0, &light)]);
        let is_near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        for (seed, passes) in [(0, 4), (1, 8), (7, 64), (u64::MAX, 1024)] {
            let of_half = |half: usize| {
                let sorted = |is_late: bool| {
                    let some = (0..passes).filter(|place| (place / 2 % 2 == 1) == is_late);
                    let mut some: Vec<f64> = some.map(|place| offset(seed, half, place)).collect();
                    some.sort_by(f64::total_cmp);
                    some
                };
                let (sorted, mirrored) = (sorted(false), sorted(true));
                assert!(
                    sorted.iter().zip(mirrored.iter().rev()).all(|(a, b)| is_near(a + b, 1.0)),
                    "seed {seed}"
                );
                let step = 2.0 / passes as f64;
                assert!(sorted[0] >= 0.0 && sorted[0] < step && *sorted.last().unwrap() < 1.0);
                assert!(sorted.windows(2).all(|w| is_near(w[1] - w[0], step)), "seed {seed}");
                [sorted[0], mirrored[0]].map(|first| first / step)
            };
            let (first, second) = (of_half(0), of_half(1));
            let apart = |a: f64| second.iter().all(|b| (a - b).abs() > 0.05);
            assert!(first.into_iter().all(apart), "seed {seed}: {first:?}, {second:?}");
            // parts are apart: the longest wavelength of the three is in the last
            let mut counts = [[0_u64; PICKS]; PICKS];
            for picks in of_passes(&of, seed, passes) {
                for (band, pick) in picks.iter().enumerate() {
                    counts[band][picks.iter().filter(|other| other.lambda < pick.lambda).count()] += 1;
                }
            }
            assert!(counts.as_flattened().iter().all(|c| c.abs_diff(passes / 3) <= 1), "{counts:?}");
        }
        assert_ne!(offset(1, 0, 0), offset(2, 0, 0));
    }

    /// Each half of the passes alone has nearly the colours of both: what they differ by, which tells the error, is not much more than
    /// the error. Root mean squares over seeds, largest band.
    #[test]
    fn halves_differ_by_about_the_error() {
        let light = lamp("D65");
        let of = Distribution::new([(1.0, &light)]);
        for (name, on) in [("red", red()), ("tan", tan())] {
            let exact = colour(&light, &on);
            for (passes, limit) in [(8, 3.0), (16, 3.0), (64, 3.0)] {
                let [mut apart, mut off] = [0.0; 2];
                for seed in 0..200 {
                    let half = |half: usize| {
                        let all = (0..passes / 2).map(|place| of.of_pass(seed, half, place));
                        mean_colour(&light, &on, &all.collect::<Vec<_>>())
                    };
                    let [a, b] = [half(0), half(1)];
                    apart += (distance(a, b) / 2.0).powi(2);
                    off += distance(std::array::from_fn(|k| (a[k] + b[k]) / 2.0), exact).powi(2);
                }
                let ratio = (apart / off).sqrt();
                println!("{name}, {passes} passes: {:.5}, {ratio:.2}", (off / 200.0).sqrt());
                assert!(ratio < limit && ratio > 0.7, "{name}, {passes} passes: {ratio}");
            }
        }
    }

    /// The mean of 2^m passes nears the integral, for smooth spectra and for lamps with peaks. Errors are of the largest band of
    /// linear sRGB, root mean squares over seeds.
    #[test]
    fn passes_converge() {
        let scenes = [
            ("D65 on white", lamp("D65"), Spectrum::Constant(1.0), [0.008, 0.003, 0.0011, 0.0004]),
            ("D65 on tan", lamp("D65"), tan(), [0.09, 0.04, 0.006, 0.0009]),
            ("A on red", lamp("A"), red(), [0.28, 0.035, 0.003, 0.0006]),
            ("FL11 on white", lamp("FL11"), Spectrum::Constant(1.0), [0.013, 0.009, 0.0045, 0.002]),
            ("mercury on tan", lamp("mercury"), tan(), [0.24, 0.13, 0.04, 0.009]),
        ];
        for (name, light, on, limits) in scenes {
            let of = Distribution::new([(1.0, &light)]);
            let exact = colour(&light, &on);
            let seeds = 0..200;
            for (passes, limit) in [1, 4, 16, 64].into_iter().zip(limits) {
                let square = |seed| distance(rendered(&of, &light, &on, seed, passes), exact).powi(2);
                let error = (seeds.clone().map(square).sum::<f64>() / 200.0).sqrt() / exact[0].max(exact[1]);
                println!("{name}, {passes} passes: {error:.5}");
                assert!(error < limit, "{name}, {passes} passes: {error}");
            }
        }
    }

    /// White is white in every pass, whatever the lamps are, as far as three wavelengths can make it: for each band of linear sRGB
    /// the root mean square over passes of what is off, relative to the largest.
    #[test]
    fn white_is_right_in_every_pass() {
        let mixed = Emission { lines: lamp("mercury").lines, ..lamp("D65") };
        let green = Emission::continuous(Spectrum::emission_of_rgb([0.1, 1.0, 0.2]));
        let all =
            ["D65", "D50", "A", "FL2", "FL7", "FL11", "HP4", "LED-B1", "LED-B5"].map(|n| (n, lamp(n), 0.02));
        for (name, light, limit) in all.into_iter().chain([("mixed", mixed, 0.02), ("green", green, 0.02)]) {
            let of = Distribution::new([(2.0, &light)]);
            let exact = colour(&light, &Spectrum::Constant(1.0));
            let off = |pass| distance(rendered(&of, &light, &Spectrum::Constant(1.0), pass, 1), exact);
            let square = (0..500).map(|seed| off(seed).powi(2)).sum::<f64>() / 500.0;
            let error = square.sqrt() / exact[0].max(exact[1]);
            println!("{name}: {error:.4}");
            assert!(error < limit, "{name}: {error}");
        }
    }

    /// One line has no noise at all.
    #[test]
    fn a_scene_of_one_line_is_exact_in_every_pass() {
        let light = Emission::laser(532.0).unwrap().scaled(4.0);
        let of = Distribution::new([(0.3, &light)]);
        let exact = colour(&light, &red());
        for picks in of_passes(&of, 5, 20) {
            assert!(picks.iter().all(|pick| pick.atom == Some(0) && pick.lambda == 532.0));
            let bands = picks.map(|pick| light.value(&pick) * red().at(pick.lambda));
            assert!(distance(apply(&rgb_matrix(&picks), bands), exact) < 1e-9);
        }
    }

    /// Lines beside daylight come out right together, each by its own chance.
    #[test]
    fn lines_and_daylight_add_up() {
        let mixed = Emission {
            continuous: lamp("D65").scaled(0.5).continuous,
            lines: [lamp("sodium").lines, lamp("mercury").lines].concat(),
        };
        // other lights in the same scene, too, one with the same lines: they change what is picked but not what comes out
        let of = Distribution::new([(1.0, &mixed), (0.7, &lamp("A")), (0.5, &lamp("sodium"))]);
        let exact = colour(&mixed, &red());
        let error = distance(rendered(&of, &mixed, &red(), 3, 4096), exact);
        assert!(error < 2e-3 * exact[0], "{error} of {exact:?}");
    }

    /// Where lights have nothing but a wavelength that the eye hardly sees, nothing is starved.
    #[test]
    fn no_wavelength_is_starved() {
        let narrow = Spectrum::emission_table(vec![640.0, 650.0, 660.0], vec![0.0, 1.0, 0.0]).unwrap();
        let of = Distribution::new([(1.0, &Emission::continuous(narrow))]);
        let green: usize = (0..300)
            .map(|i| of.pick(f64::from(i) / 300.0))
            .filter(|pick| (500.0..600.0).contains(&pick.lambda))
            .count();
        assert!(green > 5, "{green} of 300");
    }
}
