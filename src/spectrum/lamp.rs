//! Emission with lines: lamps of gas at low pressure, and lasers.
//!
//! A line has no width: what it carries is integrated over wavelength, and only a pass that has exactly its wavelength sees it
//! \[E34\].

use super::cie::{Illuminant, line_xyz, xyz_to_rgb};
use super::curve::Spectrum;
use super::pick::Pick;

/// Light of one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Line {
    /// nm.
    pub lambda: f64,
    /// Radiance integrated over the line, W/(m² sr).
    pub power: f64,
}

/// What a light emits: a continuous spectrum, lines, or both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Emission {
    /// W/(m² sr nm).
    pub continuous: Option<Spectrum>,
    /// In any order; two of one wavelength add up.
    pub lines: Vec<Line>,
}

/// Lamps by name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lamp {
    /// Low-pressure sodium: the doublet D₂, D₁.
    Sodium,
    /// Low-pressure mercury: its five strong visible lines.
    Mercury,
    /// One with a published spectrum.
    Standard(Illuminant),
}

/// D₂ and D₁ of sodium in air: nm, relative power. 2:1 is the ratio of the weights of their upper levels, which a thin vapour
/// shows; a lamp, whose vapour absorbs its own light, comes nearer to 1:1. The eye can't tell. Wavelengths: NIST Atomic
/// Spectra Database.
const SODIUM: [[f64; 2]; 2] = [[588.995, 2.0], [589.592, 1.0]];

/// Lines of mercury in air: nm, relative power. Powers are what rises above the phosphor in the CIE's fluorescent lamps FL1 to
/// FL4 and FL6, which are such discharges in a coated bulb. They agree to 5 %, but for the last two, which are not told apart
/// there and stand where the phosphor is brightest. Wavelengths: Sansonetti et al. 1996.
const MERCURY: [[f64; 2]; 5] =
    [[404.6565, 0.40], [435.8335, 1.0], [546.0750, 0.47], [576.9610, 0.11], [579.0670, 0.11]];

impl Lamp {
    /// The lamp of that name: `sodium`, `mercury`, or what [`Illuminant::named`] knows.
    pub fn named(name: &str) -> Option<Self> {
        match name.to_ascii_lowercase().as_str() {
            "sodium" => Some(Self::Sodium),
            "mercury" => Some(Self::Mercury),
            other => Illuminant::named(other).map(Self::Standard),
        }
    }

    /// Names of lamps with lines, as [`Lamp::named`] takes them.
    pub fn names() -> [&'static str; 2] {
        ["sodium", "mercury"]
    }

    /// What it emits, normalised to Y = 1.
    pub fn emission(self) -> Emission {
        match self {
            Self::Sodium => Emission::normalised(&SODIUM),
            Self::Mercury => Emission::normalised(&MERCURY),
            Self::Standard(illuminant) => Emission::continuous(Spectrum::Standard(illuminant)),
        }
    }
}

/// Says so where nobody could see light of this wavelength, nm.
fn check_seen(lambda: f64) -> Result<(), String> {
    if line_xyz(lambda)[1] > 0.0 {
        return Ok(());
    }
    Err(format!("a line at {lambda} nm cannot be seen: it must be from 360 to 830 nm"))
}

impl Emission {
    /// Emission without lines.
    pub fn continuous(spectrum: Spectrum) -> Self {
        Self { continuous: Some(spectrum), lines: Vec::new() }
    }

    /// One line of Y = 1. Says so where nobody could see it.
    pub fn laser(lambda: f64) -> Result<Self, String> {
        check_seen(lambda)?;
        Ok(Self::normalised(&[[lambda, 1.0]]))
    }

    /// Lines. Says so where one of them could not be seen, or has no power.
    pub fn of_lines(lines: Vec<Line>) -> Result<Self, String> {
        if lines.is_empty() {
            return Err("there is no line".into());
        }
        for Line { lambda, power } in &lines {
            check_seen(*lambda)?;
            if !(*power > 0.0 && power.is_finite()) {
                return Err(format!("the line at {lambda} nm has the power {power}"));
            }
        }
        Ok(Self { continuous: None, lines })
    }

    /// Lines of wavelength, nm, and relative power, scaled to Y = 1.
    fn normalised(lines: &[[f64; 2]]) -> Self {
        let luminance: f64 = lines.iter().map(|[lambda, power]| power * line_xyz(*lambda)[1]).sum();
        let line = |[lambda, power]: &[f64; 2]| Line { lambda: *lambda, power: power / luminance };
        Self { continuous: None, lines: lines.iter().map(line).collect() }
    }

    /// This times `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        let scaled = |line: Line| Line { power: factor * line.power, ..line };
        Self {
            continuous: self.continuous.map(|spectrum| spectrum.scaled(factor)),
            lines: self.lines.into_iter().map(scaled).collect(),
        }
    }

    /// XYZ of all that is emitted  \[E32\].
    pub fn to_xyz(&self) -> [f64; 3] {
        let mut sum = self.continuous.as_ref().map_or([0.0; 3], Spectrum::to_xyz);
        for line in &self.lines {
            let colour = line_xyz(line.lambda);
            sum = std::array::from_fn(|k| sum[k] + line.power * colour[k]);
        }
        sum
    }

    /// Linear sRGB of all that is emitted  \[E32\].
    pub fn to_rgb(&self) -> [f64; 3] {
        xyz_to_rgb(self.to_xyz())
    }

    /// What is emitted at a picked wavelength  \[E34\]: where it is an atom, the power of the lines that are exactly there and
    /// nothing else, W/(m² sr); elsewhere the continuous spectrum, W/(m² sr nm), and no line.
    pub fn value(&self, pick: &Pick) -> f64 {
        match pick.atom {
            Some(_) => self.lines.iter().filter(|l| l.lambda == pick.lambda).map(|l| l.power).sum(),
            None => self.continuous.as_ref().map_or(0.0, |spectrum| spectrum.at(pick.lambda)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chromaticity([x, y, z]: [f64; 3]) -> [f64; 2] {
        [x / (x + y + z), y / (x + y + z)]
    }

    /// Yellow of 589 nm, on the border of the chart: between the CIE's chromaticities at 585 and 590 nm.
    #[test]
    fn sodium_is_yellow() {
        let [x, y] = chromaticity(Lamp::Sodium.emission().to_xyz());
        let (at_585, at_590) = ([0.5448, 0.4544], [0.5752, 0.4242]);
        let t = (589.2 - 585.0) / 5.0;
        assert!((x - (at_585[0] + t * (at_590[0] - at_585[0]))).abs() < 1e-3, "x = {x}");
        assert!((y - (at_585[1] + t * (at_590[1] - at_585[1]))).abs() < 1e-3, "y = {y}");
        let rgb = Lamp::Sodium.emission().to_rgb();
        assert!(rgb[0] > rgb[1] && rgb[1] > 0.0 && rgb[2] < 0.0, "{rgb:?}");
    }

    #[test]
    fn lamps_have_the_same_luminance() {
        let names = ["sodium", "Mercury", "d65", "HP1"];
        let lamps = names.map(|name| Lamp::named(name).unwrap().emission());
        for lamp in lamps.into_iter().chain([450.0, 532.0, 632.8].map(|nm| Emission::laser(nm).unwrap())) {
            assert!((lamp.to_xyz()[1] - 1.0).abs() < 1e-12, "{lamp:?}");
            assert!((lamp.scaled(3.0).to_xyz()[1] - 3.0).abs() < 1e-11);
        }
        assert_eq!(Lamp::named("candle"), None);
        assert!(Emission::laser(1064.0).unwrap_err().contains("cannot be seen"));
        assert!(Emission::laser(f64::NAN).is_err());
    }

    /// Mercury vapour without phosphor is bluish white.
    #[test]
    fn mercury_is_bluish() {
        let [x, y] = chromaticity(Lamp::Mercury.emission().to_xyz());
        assert!(x < 0.28 && y < 0.26, "{x}, {y}");
    }

    /// An atom sees its own line alone, the density the continuous part alone.
    #[test]
    fn lines_and_the_rest_are_apart() {
        let line = |lambda, power| Line { lambda, power };
        let light = Emission {
            continuous: Some(Spectrum::Constant(7.0)),
            lines: vec![line(500.0, 2.0), line(600.0, 5.0), line(500.0, 1.0)],
        };
        let value = |lambda, atom| light.value(&Pick { lambda, atom, pdf: 1.0 });
        assert_eq!(value(500.0, None), 7.0);
        assert_eq!((value(500.0, Some(0)), value(600.0, Some(1)), value(550.0, Some(2))), (3.0, 5.0, 0.0));
        assert_eq!(Emission::default().value(&Pick { lambda: 500.0, atom: None, pdf: 1.0 }), 0.0);
    }
}
