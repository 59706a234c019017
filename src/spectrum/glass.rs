//! Indices of refraction over wavelength.
//!
//! Sellmeier: n² = 1 + Σ B λ²/(λ² - C). Cauchy: n = A + B/λ². λ in µm \[E35\]. Of clear media: what they absorb is not told
//! here.

use super::table::{Outside, Table};

/// Lines of Fraunhofer that catalogues of glass state indices at, nm: F and C of hydrogen, d of helium.
pub const LINE_F: f64 = 486.1327;
/// See [`LINE_F`].
pub const LINE_D: f64 = 587.5618;
/// See [`LINE_F`].
pub const LINE_C: f64 = 656.2725;

/// Abbe numbers from which on a stated glass counts as one without dispersion: beyond every glass, diamond has 55, calcium
/// fluoride 95.
const NO_DISPERSION: f64 = 1e4;

/// An index of refraction, relative to vacuum or air as its source has it.
#[derive(Clone, Debug, PartialEq)]
pub enum Index {
    /// The same at all wavelengths.
    Constant(f64),
    /// n = A + B/λ².
    Cauchy {
        /// No unit.
        a: f64,
        /// µm².
        b: f64,
    },
    /// n² = 1 + Σ B λ²/(λ² - C): pairs of B, without unit, and C, µm².
    Sellmeier(Vec<[f64; 2]>),
    /// Measured values.
    Table(Table),
}

/// A medium of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    /// As scene files call it.
    pub name: &'static str,
    /// Where its figures come from.
    pub source: &'static str,
    /// Sellmeier's pairs of B and C, µm².
    terms: &'static [[f64; 2]],
}

/// Media with published coefficients.
pub const MEDIA: [Medium; 12] = [
    Medium {
        name: "bk7",
        source: "N-BK7, SCHOTT 2017",
        terms: &[
            [1.039_612_12, 0.006_000_698_67],
            [0.231_792_344, 0.020_017_914_4],
            [1.010_469_45, 103.560_653],
        ],
    },
    Medium {
        name: "sf10",
        source: "SF10, SCHOTT 2017",
        terms: &[
            [1.616_259_77, 0.012_753_455_9],
            [0.259_229_334, 0.058_198_395_4],
            [1.077_623_17, 116.607_68],
        ],
    },
    Medium {
        name: "sf11",
        source: "SF11, SCHOTT 2017",
        terms: &[
            [1.738_484_03, 0.013_606_860_4],
            [0.311_168_974, 0.061_596_046_3],
            [1.174_908_71, 121.922_711],
        ],
    },
    Medium {
        name: "f2",
        source: "F2, SCHOTT 2017",
        terms: &[
            [1.345_333_59, 0.009_977_438_71],
            [0.209_073_176, 0.047_045_076_7],
            [0.937_357_162, 111.886_764],
        ],
    },
    Medium {
        name: "baf10",
        source: "N-BAF10, SCHOTT 2017",
        terms: &[
            [1.585_149_5, 0.009_266_812_82],
            [0.143_559_385, 0.042_448_980_5],
            [1.085_212_69, 105.613_573],
        ],
    },
    Medium {
        name: "lak9",
        source: "N-LAK9, SCHOTT 2017",
        terms: &[
            [1.462_319_05, 0.007_242_701_56],
            [0.344_399_589, 0.024_335_313_1],
            [1.155_083_72, 85.468_686_8],
        ],
    },
    Medium {
        name: "silica",
        source: "fused silica, 20 °C, Malitson 1965",
        terms: &[
            [0.696_166_3, 0.068_404_3 * 0.068_404_3],
            [0.407_942_6, 0.116_241_4 * 0.116_241_4],
            [0.897_479_4, 9.896_161 * 9.896_161],
        ],
    },
    Medium {
        name: "sapphire",
        source: "Al₂O₃, ordinary ray, 20 °C, Malitson & Dodge 1972",
        terms: &[
            [1.431_349_3, 0.072_663_1 * 0.072_663_1],
            [0.650_547_13, 0.119_324_2 * 0.119_324_2],
            [5.341_402_1, 18.028_251 * 18.028_251],
        ],
    },
    Medium {
        name: "diamond",
        source: "Peter 1923",
        terms: &[[0.3306, 0.175 * 0.175], [4.3356, 0.106 * 0.106]],
    },
    Medium {
        name: "water",
        source: "distilled, 20 °C, Daimon & Masumura 2007",
        terms: &[
            [0.568_402_756_5, 0.005_101_829_712],
            [0.172_617_739_1, 0.018_211_539_36],
            [0.020_861_895_78, 0.026_207_222_93],
            [0.113_074_868_8, 10.697_927_21],
        ],
    },
    Medium { name: "acrylic", source: "PMMA, 20 °C, Sultanova et al. 2009", terms: &[[1.1819, 0.011_313]] },
    Medium { name: "polycarbonate", source: "20 °C, Sultanova et al. 2009", terms: &[[1.4182, 0.021_304]] },
];

/// Index of ice, 266 K, at every 50 nm from 350 on: Warren & Brandt 2008.
const ICE: [f64; 11] =
    [1.3249, 1.3194, 1.3157, 1.3130, 1.3110, 1.3094, 1.3080, 1.3069, 1.3059, 1.3049, 1.3040];

impl Index {
    /// The medium of that name in [`MEDIA`], or `ice`.
    pub fn named(name: &str) -> Option<Self> {
        if name.eq_ignore_ascii_case("ice") {
            let lambdas = (0..ICE.len()).map(|i| 350.0 + 50.0 * i as f64).collect();
            return Table::new(lambdas, ICE.to_vec(), Outside::Held).ok().map(Self::Table);
        }
        let medium = MEDIA.iter().find(|m| m.name.eq_ignore_ascii_case(name))?;
        Some(Self::Sellmeier(medium.terms.to_vec()))
    }

    /// Names that [`Index::named`] knows.
    pub fn names() -> impl Iterator<Item = &'static str> {
        MEDIA.iter().map(|m| m.name).chain(["ice"])
    }

    /// A glass by its index at the d line and its Abbe number V = (n_d - 1)/(n_F - n_C): Cauchy's formula that has both. Says
    /// what is wrong with them.
    pub fn of_abbe(n_d: f64, v_d: f64) -> Result<Self, String> {
        if !(n_d.is_finite() && n_d > 0.0) {
            return Err(format!("an index of refraction is above zero, not {n_d}"));
        }
        if v_d.is_nan() || v_d <= 0.0 {
            return Err(format!("an Abbe number is above zero, not {v_d}"));
        }
        if v_d >= NO_DISPERSION || n_d == 1.0 {
            return Ok(Self::Constant(n_d));
        }
        let inverse_square = |nm: f64| (nm * 1e-3).powi(-2);
        let b = (n_d - 1.0) / v_d / (inverse_square(LINE_F) - inverse_square(LINE_C));
        Self::Cauchy { a: n_d - b * inverse_square(LINE_D), b }.checked()
    }

    /// An index by a table of wavelengths, nm, and values; its ends hold outside. Says what is wrong with it.
    pub fn table(lambdas: Vec<f64>, values: Vec<f64>) -> Result<Self, String> {
        Table::new(lambdas, values, Outside::Held).map(Self::Table)?.checked()
    }

    /// This index, unless it is no positive number somewhere from 360 to 830 nm: what a file's coefficients are checked by.
    pub fn checked(self) -> Result<Self, String> {
        let wavelengths = (0..=super::cie::STEPS).map(|i| super::LAMBDA_MIN + i as f64);
        let is_wrong = |n: f64| !n.is_finite() || n <= 0.0;
        let own = match &self {
            Self::Table(table) => table.lambdas().to_vec(),
            _ => Vec::new(),
        };
        match wavelengths.chain(own).find(|lambda| is_wrong(self.at(*lambda))) {
            Some(lambda) => Err(format!("the index of refraction is no number above zero at {lambda} nm")),
            None => Ok(self),
        }
    }

    /// Index at `lambda`, nm  \[E35\].
    pub fn at(&self, lambda: f64) -> f64 {
        let square = (lambda * 1e-3) * (lambda * 1e-3);
        match self {
            Self::Constant(n) => *n,
            Self::Cauchy { a, b } => a + b / square,
            Self::Sellmeier(terms) => {
                (1.0 + terms.iter().map(|[b, c]| b * square / (square - c)).sum::<f64>()).sqrt()
            }
            Self::Table(table) => table.at(lambda),
        }
    }

    /// Abbe number V = (n_d - 1)/(n_F - n_C); infinite where F and C have the same index.
    pub fn abbe(&self) -> f64 {
        (self.at(LINE_D) - 1.0) / (self.at(LINE_F) - self.at(LINE_C))
    }

    /// True where wavelengths take different ways.
    pub fn is_dispersive(&self) -> bool {
        match self {
            Self::Constant(_) => false,
            Self::Cauchy { b, .. } => *b != 0.0,
            Self::Sellmeier(terms) => terms.iter().any(|[b, c]| *b != 0.0 && *c != 0.0),
            Self::Table(table) => table.values().windows(2).any(|w| w[0] != w[1]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// n_d and V_d as SCHOTT's data sheets and the sources' own tables have them.
    #[test]
    fn media_have_their_published_figures() {
        let published = [
            ("bk7", 1.5168, 64.17),
            ("sf10", 1.72825, 28.41),
            ("sf11", 1.78472, 25.76),
            ("f2", 1.62004, 36.37),
            ("baf10", 1.67003, 47.11),
            ("lak9", 1.69100, 54.71),
            ("silica", 1.45846, 67.82),
            ("sapphire", 1.76817, 72.31),
            ("diamond", 2.41749, 55.30),
            ("water", 1.33340, 55.76),
            ("acrylic", 1.49062, 53.18),
            ("polycarbonate", 1.58476, 27.86),
            ("ice", 1.3098, 53.0),
        ];
        assert!(published.iter().map(|(name, ..)| *name).eq(Index::names()));
        for (name, n_d, v_d) in published {
            let index = Index::named(name).unwrap().checked().unwrap();
            // ice has four digits each 50 nm
            let (n_tolerance, v_tolerance) = if name == "ice" { (2e-4, 4.0) } else { (6e-6, 6e-3) };
            assert!((index.at(LINE_D) - n_d).abs() < n_tolerance, "{name}: n_d = {}", index.at(LINE_D));
            assert!((index.abbe() - v_d).abs() < v_tolerance, "{name}: V_d = {}", index.abbe());
            assert!(index.is_dispersive());
        }
        assert_eq!(Index::named("bk8"), None);
    }

    /// Other lines than those that figures are made of: SCHOTT's n of N-BK7 and SF11 at g and r, Malitson's of silica.
    #[test]
    fn indices_at_other_lines_are_the_published_ones() {
        for (name, lambda, n) in [
            ("bk7", 435.8343, 1.526_68),
            ("bk7", 706.5188, 1.512_89),
            ("silica", 404.6561, 1.469_618),
            ("silica", 706.5188, 1.455_145),
        ] {
            let here = Index::named(name).unwrap().at(lambda);
            assert!((here - n).abs() < 6e-6, "{name} at {lambda} nm: {here}");
        }
    }

    #[test]
    fn an_abbe_number_makes_a_glass() {
        let glass = Index::of_abbe(1.62, 36.4).unwrap();
        assert!((glass.at(LINE_D) - 1.62).abs() < 1e-12 && (glass.abbe() - 36.4).abs() < 1e-9);
        // two terms follow F2, which has about these figures, to a few thousandths
        let f2 = Index::named("f2").unwrap();
        for lambda in [400.0, 450.0, 700.0] {
            assert!((glass.at(lambda) - f2.at(lambda)).abs() < 5e-3, "{lambda} nm");
        }
        assert!(!Index::of_abbe(1.5, f64::INFINITY).unwrap().is_dispersive());
        assert!(Index::of_abbe(1.5, 0.0).unwrap_err().contains("Abbe number"));
        assert!(Index::of_abbe(f64::NAN, 50.0).unwrap_err().contains("index of refraction"));
        // so much dispersion that red light would have no index
        assert!(Index::of_abbe(1.5, 1e-3).unwrap_err().contains("no number above zero"));
    }

    #[test]
    fn wrong_indices_are_refused() {
        assert!(Index::table(vec![400.0, 500.0], vec![1.5, 0.0]).unwrap_err().contains("at 500 nm"));
        // a resonance within the visible
        assert!(Index::Sellmeier(vec![[1.0, 0.25]]).checked().is_err());
        let table = Index::table(vec![400.0, 700.0], vec![1.53, 1.50]).unwrap();
        assert!((table.at(500.0) - 1.52).abs() < 1e-12);
        assert!(table.is_dispersive() && table.abbe() > 0.0);
        assert!(!Index::Constant(1.5).is_dispersive() && !Index::Cauchy { a: 1.5, b: 0.0 }.is_dispersive());
    }
}
