//! Spectra: how much at which wavelength, of emission or of reflectance.
//!
//! Emission is in W/(m² sr nm) or whatever stands for it, and normalised such that Y = 1 where nothing else is said \[E32\];
//! reflectance has no unit.

use super::cie::{Illuminant, cmf, integral, xyz, xyz_to_rgb, y_integral};
use super::table::{Outside, Table};
use super::upsample::{Sigmoid, reflected_part};

/// The second radiation constant h c / k, nm K (CODATA 2018, exact).
const C2: f64 = 1.438_776_877e7;

/// A spectrum. [`Spectrum::at`] answers for every wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at all wavelengths.
    Constant(f64),
    /// Measured values.
    Table(Table),
    /// A smooth reflectance that was found for a colour.
    Sigmoid(Sigmoid),
    /// A smooth reflectance lit by daylight, D65: emission that was found for a colour.
    Daylit(Sigmoid),
    /// A black body, normalised to Y = 1.
    Blackbody(Blackbody),
    /// A published illuminant, normalised to Y = 1.
    Standard(Illuminant),
    /// Another spectrum times a factor.
    Scaled(f64, Box<Spectrum>),
}

/// Light of a black body, normalised to Y = 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blackbody {
    /// Temperature, K.
    kelvin: f64,
    /// What Planck's law is multiplied by for Y = 1.
    factor: f64,
}

impl Spectrum {
    /// Emission by a table of wavelengths, nm, and values; zero outside of it. Says what is wrong with it.
    pub fn emission_table(lambdas: Vec<f64>, values: Vec<f64>) -> Result<Self, String> {
        Table::new(lambdas, values, Outside::Zero).map(Self::Table)
    }

    /// A reflectance by a table of wavelengths, nm, and values in [0, 1]; its ends hold outside. Says what is wrong with it.
    pub fn reflectance_table(lambdas: Vec<f64>, values: Vec<f64>) -> Result<Self, String> {
        let table = Table::new(lambdas, values, Outside::Held)?;
        match table.lambdas().iter().zip(table.values()).find(|(_, v)| **v > 1.0) {
            Some((x, v)) => Err(format!("the reflectance at {x} nm is {v}, but must be 1 or less")),
            None => Ok(Self::Table(table)),
        }
    }

    /// A reflectance of this linear sRGB under D65, clamped to [0, 1] before  \[E33\].
    pub fn reflectance_of_rgb(rgb: [f64; 3]) -> Self {
        if rgb[0] == rgb[1] && rgb[1] == rgb[2] {
            return Self::Constant(reflected_part(rgb[0]));
        }
        Self::Sigmoid(Sigmoid::of_rgb(rgb))
    }

    /// Emission of this linear sRGB: a reflectance of half the brightness, lit by as much more of D65; white is D65 itself.
    /// Negative bands count as zero  \[E33\].
    pub fn emission_of_rgb(rgb: [f64; 3]) -> Self {
        let rgb = rgb.map(|c| c.max(0.0));
        let scale = 2.0 * rgb.into_iter().fold(0.0, f64::max);
        if scale == 0.0 || !scale.is_finite() {
            return Self::Constant(0.0);
        }
        Self::Daylit(Sigmoid::of_rgb(rgb.map(|c| c / scale))).scaled(scale)
    }

    /// Light of a black body of `kelvin`, normalised to Y = 1; says so where that is no temperature that glows.
    pub fn blackbody(kelvin: f64) -> Result<Self, String> {
        // below 500 K nothing can be seen, and Planck's law leaves the range of an f64 not far below
        if !(500.0..=1e6).contains(&kelvin) {
            return Err(format!("{kelvin} K is not a temperature of a light: it must be 500 to 1000000 K"));
        }
        let luminance = integral(|lambda| planck(lambda, kelvin) * cmf(lambda)[1]) / y_integral();
        Ok(Self::Blackbody(Blackbody { kelvin, factor: 1.0 / luminance }))
    }

    /// This spectrum times `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        match self {
            Self::Constant(value) => Self::Constant(factor * value),
            Self::Scaled(before, spectrum) => Self::Scaled(factor * before, spectrum),
            other => Self::Scaled(factor, Box::new(other)),
        }
    }

    /// Value at `lambda`, nm.
    pub fn at(&self, lambda: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Table(table) => table.at(lambda),
            Self::Sigmoid(sigmoid) => sigmoid.at(lambda),
            Self::Daylit(sigmoid) => sigmoid.at(lambda) * Illuminant::D65.at(lambda),
            Self::Blackbody(body) => body.factor * planck(lambda, body.kelvin),
            Self::Standard(illuminant) => illuminant.at(lambda),
            Self::Scaled(factor, spectrum) => factor * spectrum.at(lambda),
        }
    }

    /// XYZ as emission  \[E32\].
    pub fn to_xyz(&self) -> [f64; 3] {
        xyz(|lambda| self.at(lambda))
    }

    /// Linear sRGB as emission  \[E32\].
    pub fn to_rgb(&self) -> [f64; 3] {
        xyz_to_rgb(self.to_xyz())
    }

    /// Linear sRGB as a reflectance that D65 lights.
    pub fn reflectance_to_rgb(&self) -> [f64; 3] {
        xyz_to_rgb(xyz(|lambda| self.at(lambda) * Illuminant::D65.at(lambda)))
    }

    /// True where it is the same at all wavelengths.
    pub fn is_constant(&self) -> bool {
        match self {
            Self::Constant(_) => true,
            Self::Scaled(_, spectrum) => spectrum.is_constant(),
            _ => false,
        }
    }
}

/// Planck's law without its first constant, relative to 560 nm: (560/λ)⁵ / (exp(c₂/(λ T)) - 1), times exp(c₂/(560 T)) - 1,
/// which keeps the numbers of cold bodies within reach.
fn planck(lambda: f64, kelvin: f64) -> f64 {
    const MIDDLE: f64 = 560.0;
    let above = (C2 / (MIDDLE * kelvin)).exp_m1();
    (MIDDLE / lambda).powi(5) * above / (C2 / (lambda * kelvin)).exp_m1()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chromaticity([x, y, z]: [f64; 3]) -> [f64; 2] {
        [x / (x + y + z), y / (x + y + z)]
    }

    fn largest_error(a: [f64; 3], b: [f64; 3]) -> f64 {
        (0..3).map(|k| (a[k] - b[k]).abs()).fold(0.0, f64::max)
    }

    /// Kim et al. 2002, US patent 7024034: the Planckian locus as cubics, good to 1e-3 in this range.
    #[test]
    fn black_bodies_lie_on_the_planckian_locus() {
        for kelvin in [4500.0, 6504.0, 10000.0, 20000.0] {
            let k = 1e3 / kelvin;
            let x = -3.025_846_9 * k * k * k + 2.107_037_9 * k * k + 0.222_634_7 * k + 0.240_390;
            let y = 3.081_758 * x * x * x - 5.873_386_7 * x * x + 3.751_129_97 * x - 0.370_014_83;
            let xyz = Spectrum::blackbody(kelvin).unwrap().to_xyz();
            let [bx, by] = chromaticity(xyz);
            assert!((bx - x).abs() < 1e-3 && (by - y).abs() < 1e-3, "{kelvin} K: {bx}, {by}, not {x}, {y}");
            assert!((xyz[1] - 1.0).abs() < 1e-12);
        }
    }

    /// Illuminant A is a black body of 2848 K by the radiation constant of its time, 1.435e7 nm K.
    #[test]
    fn a_black_body_is_illuminant_a() {
        let body = Spectrum::blackbody(2848.0 * 1.438_776_877 / 1.435).unwrap();
        for lambda in (360..=830).step_by(5).map(f64::from) {
            let (here, published) = (body.at(lambda), Illuminant::A.at(lambda));
            assert!((here / published - 1.0).abs() < 1e-4, "{lambda} nm: {here}, not {published}");
        }
        for cold in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            assert!(Spectrum::blackbody(cold).unwrap_err().contains("not a temperature"));
        }
        assert!(Spectrum::blackbody(500.0).unwrap().at(400.0) >= 0.0);
    }

    /// What is found for an emission's colour has that colour, to 1e-4 of its scale.
    #[test]
    fn emission_comes_back() {
        for rgb in [[1.0, 1.0, 1.0], [12.0, 3.0, 0.5], [0.0, 0.0, 300.0], [1e-4, 2e-4, 0.0], [0.0; 3]] {
            let spectrum = Spectrum::emission_of_rgb(rgb);
            let scale = 2.0 * rgb.iter().fold(0.0_f64, |a, b| a.max(*b));
            let error = largest_error(spectrum.to_rgb(), rgb);
            assert!(error <= 1e-4 * scale, "{rgb:?}: {:?}", spectrum.to_rgb());
        }
        let white = Spectrum::emission_of_rgb([3.0; 3]);
        for lambda in [400.0, 555.0, 700.0] {
            assert!((white.at(lambda) - 3.0 * Illuminant::D65.at(lambda)).abs() < 1e-12);
        }
        let negative = Spectrum::emission_of_rgb([1.0, -0.5, 1.0]);
        assert_eq!(negative, Spectrum::emission_of_rgb([1.0, 0.0, 1.0]));
    }

    #[test]
    fn reflectances_come_back() {
        for rgb in [[0.8, 0.2, 0.1], [0.02, 0.5, 0.9], [0.18; 3], [0.0; 3], [1.0; 3]] {
            let error = largest_error(Spectrum::reflectance_of_rgb(rgb).reflectance_to_rgb(), rgb);
            assert!(error < 1e-4, "{rgb:?}: {error}");
        }
        assert_eq!(Spectrum::reflectance_of_rgb([2.0; 3]), Spectrum::Constant(1.0));
        assert_eq!(Spectrum::reflectance_of_rgb([f64::NAN, 0.0, 0.0]).at(500.0), 0.0);
    }

    #[test]
    fn factors_multiply() {
        let twice = Spectrum::Standard(Illuminant::D50).scaled(4.0).scaled(0.5);
        assert_eq!(twice, Spectrum::Scaled(2.0, Box::new(Spectrum::Standard(Illuminant::D50))));
        assert_eq!(twice.at(500.0), 2.0 * Illuminant::D50.at(500.0));
        assert!(Spectrum::Constant(0.5).scaled(0.5).is_constant() && !twice.is_constant());
    }

    /// Two spectra of one colour under D65 differ under incandescent light: metamers, which three bands cannot tell apart.
    #[test]
    fn metamers_part_under_another_light() {
        // three bands of 60 nm that have the grey's colour under D65, by Cramer's rule
        let bands = [(440.0, 460.0), (530.0, 550.0), (600.0, 620.0)];
        let under =
            |light: Illuminant, value: &dyn Fn(f64) -> f64| xyz(|lambda| value(lambda) * light.at(lambda));
        let band = |k: usize| move |lambda: f64| f64::from((bands[k].0..=bands[k].1).contains(&lambda));
        let columns = [0, 1, 2].map(|k| under(Illuminant::D65, &band(k)));
        let grey = under(Illuminant::D65, &|_| 0.05);
        let determinant = |c: [[f64; 3]; 3]| {
            let minor = |i: usize, j: usize| c[1][i] * c[2][j] - c[1][j] * c[2][i];
            c[0][0] * minor(1, 2) - c[0][1] * minor(0, 2) + c[0][2] * minor(0, 1)
        };
        let heights: [f64; 3] = std::array::from_fn(|k| {
            let mut replaced = columns;
            replaced[k] = grey;
            determinant(replaced) / determinant(columns)
        });
        assert!(heights.iter().all(|h| (0.0..=1.0).contains(h)), "{heights:?}");
        let metamer = |lambda: f64| (0..3).map(|k| heights[k] * band(k)(lambda)).sum::<f64>();
        assert!(largest_error(under(Illuminant::D65, &metamer), grey) < 1e-12);
        let (one, other) = (under(Illuminant::A, &metamer), under(Illuminant::A, &|_| 0.05));
        assert!(largest_error(one, other) > 0.02 * other[1], "{one:?} is {other:?}");
    }

    #[test]
    fn wrong_reflectances_are_refused() {
        let wrong = Spectrum::reflectance_table(vec![400.0, 500.0], vec![0.5, 1.5]).unwrap_err();
        assert_eq!(wrong, "the reflectance at 500 nm is 1.5, but must be 1 or less");
        let held = Spectrum::reflectance_table(vec![400.0, 500.0], vec![0.5, 0.7]).unwrap();
        assert_eq!((held.at(360.0), held.at(830.0)), (0.5, 0.7));
        let zero = Spectrum::emission_table(vec![400.0, 500.0], vec![0.5, 7.0]).unwrap();
        assert_eq!((zero.at(399.0), zero.at(500.0), zero.at(501.0)), (0.0, 7.0, 0.0));
    }
}
