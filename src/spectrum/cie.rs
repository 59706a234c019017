//! The CIE's observer of 1931 and its illuminants; colours of spectra.
//!
//! XYZ = ∫ S (x̄, ȳ, z̄) dλ / ∫ ȳ dλ, and linear sRGB from it  \[E32\]  CIE 15:2018, IEC 61966-2-1. What has radiances in
//! W/(m² sr nm) thereby has Y = 1 for a constant spectrum of 1.

use super::table::{Table, published};
use super::{LAMBDA_MAX, LAMBDA_MIN};
use std::sync::LazyLock;

/// Steps of 1 nm between the shortest wavelength and the longest.
pub const STEPS: usize = (LAMBDA_MAX - LAMBDA_MIN) as usize;

/// Chromaticities x, y of the primaries red, green and blue of Rec. ITU-R BT.709, which are those of sRGB.
const PRIMARIES: [[f64; 2]; 3] = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]];

/// Rows of a matrix, 3×3.
pub type Matrix = [[f64; 3]; 3];

/// x̄, ȳ, z̄ at every nm from [`LAMBDA_MIN`] on.
static OBSERVER: LazyLock<Vec<[f64; 3]>> = LazyLock::new(|| {
    let [x, y, z] = ["xbar", "ybar", "zbar"].map(|name| published(name).values());
    assert!([x, y, z].iter().all(|values| values.len() == STEPS + 1));
    (0..=STEPS).map(|i| [x[i], y[i], z[i]]).collect()
});

/// ∫ ȳ dλ, nm.
static Y_INTEGRAL: LazyLock<f64> = LazyLock::new(|| integral(|lambda| cmf(lambda)[1]));

/// Linear sRGB to XYZ: the primaries, scaled to sum to the white of [`Illuminant::D65`].
static RGB_TO_XYZ: LazyLock<Matrix> = LazyLock::new(|| {
    let white = xyz(|lambda| Illuminant::D65.at(lambda));
    let columns = PRIMARIES.map(|[x, y]| [x / y, 1.0, (1.0 - x - y) / y]);
    let primaries = std::array::from_fn(|row| columns.map(|c| c[row]));
    let luminances = apply(&inverse(&primaries), white);
    primaries.map(|row| std::array::from_fn(|k| row[k] * luminances[k]))
});

static XYZ_TO_RGB: LazyLock<Matrix> = LazyLock::new(|| inverse(&RGB_TO_XYZ));

/// Colour-matching functions x̄, ȳ, z̄ of the 2° observer at `lambda`, nm; linear between whole nm, zero outside.
pub fn cmf(lambda: f64) -> [f64; 3] {
    let place = lambda - LAMBDA_MIN;
    if !(0.0..=STEPS as f64).contains(&place) {
        return [0.0; 3];
    }
    let below = (place as usize).min(STEPS - 1);
    let t = place - below as f64;
    std::array::from_fn(|c| (1.0 - t) * OBSERVER[below][c] + t * OBSERVER[below + 1][c])
}

/// How much light at `lambda`, nm, matters to a picture: the length of (r̄, ḡ, b̄), its linear sRGB before it is divided by
/// ∫ ȳ dλ. Zero nowhere from [`LAMBDA_MIN`] to [`LAMBDA_MAX`].
pub fn sensitivity(lambda: f64) -> f64 {
    xyz_to_rgb(cmf(lambda)).iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// ∫ ȳ dλ, nm: what XYZ and light that is integrated over wavelength are divided by.
pub fn y_integral() -> f64 {
    *Y_INTEGRAL
}

/// Wavelengths, nm, and weights, nm, of Simpson's rule in each nm from [`LAMBDA_MIN`] to [`LAMBDA_MAX`]: exact for the product
/// of any two curves of these tables, which are linear there.
fn quadrature() -> impl Iterator<Item = (f64, f64)> {
    (0..=2 * STEPS).map(|half| {
        let weight = match half {
            0 => 1.0,
            half if half == 2 * STEPS => 1.0,
            half if half % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (LAMBDA_MIN + half as f64 / 2.0, weight / 6.0)
    })
}

/// ∫ f dλ from [`LAMBDA_MIN`] to [`LAMBDA_MAX`].
pub fn integral(f: impl Fn(f64) -> f64) -> f64 {
    quadrature().map(|(lambda, weight)| weight * f(lambda)).sum()
}

/// XYZ of a spectrum per nm  \[E32\].
pub fn xyz(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for (lambda, weight) in quadrature() {
        let value = weight * spectrum(lambda);
        let matched = cmf(lambda);
        sum = std::array::from_fn(|k| sum[k] + value * matched[k]);
    }
    sum.map(|s| s / y_integral())
}

/// XYZ of a line at `lambda`, nm, of the power 1 integrated over wavelength.
pub fn line_xyz(lambda: f64) -> [f64; 3] {
    cmf(lambda).map(|c| c / y_integral())
}

/// Linear sRGB of XYZ; negative where the colour is outside of the triangle of the primaries.
pub fn xyz_to_rgb(xyz: [f64; 3]) -> [f64; 3] {
    apply(&XYZ_TO_RGB, xyz)
}

/// XYZ of linear sRGB.
pub fn rgb_to_xyz(rgb: [f64; 3]) -> [f64; 3] {
    apply(&RGB_TO_XYZ, rgb)
}

/// The matrix of [`xyz_to_rgb`].
pub fn xyz_to_rgb_matrix() -> Matrix {
    *XYZ_TO_RGB
}

/// Product of a matrix and a column.
pub fn apply(m: &Matrix, v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Inverse of a matrix by its cofactors.
pub fn inverse(m: &Matrix) -> Matrix {
    let minor = |r: usize, c: usize| {
        let ([r1, r2], [c1, c2]) = ([(r + 1) % 3, (r + 2) % 3], [(c + 1) % 3, (c + 2) % 3]);
        m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1]
    };
    let determinant: f64 = (0..3).map(|c| m[0][c] * minor(0, c)).sum();
    std::array::from_fn(|r| std::array::from_fn(|c| minor(c, r) / determinant))
}

/// Illuminants and lamps with a published spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Illuminant {
    /// Incandescent light, 2856 K.
    A,
    /// Daylight, 5003 K.
    D50,
    /// Daylight, 6504 K: the white of sRGB.
    D65,
    /// Fluorescent lamp, standard, 4230 K.
    Fl2,
    /// Fluorescent lamp, broad-band, 6500 K.
    Fl7,
    /// Fluorescent lamp, three-band, 4000 K.
    Fl11,
    /// High-pressure sodium lamp, 1959 K.
    Hp1,
    /// Metal halide lamp, 4002 K.
    Hp4,
    /// White LED: blue with a phosphor, 2733 K.
    LedB1,
    /// White LED: blue with a phosphor, 4103 K.
    LedB3,
    /// White LED: blue with a phosphor, 6598 K.
    LedB5,
}

impl Illuminant {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::A,
        Self::D50,
        Self::D65,
        Self::Fl2,
        Self::Fl7,
        Self::Fl11,
        Self::Hp1,
        Self::Hp4,
        Self::LedB1,
        Self::LedB3,
        Self::LedB5,
    ];

    /// The CIE's name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::D50 => "D50",
            Self::D65 => "D65",
            Self::Fl2 => "FL2",
            Self::Fl7 => "FL7",
            Self::Fl11 => "FL11",
            Self::Hp1 => "HP1",
            Self::Hp4 => "HP4",
            Self::LedB1 => "LED-B1",
            Self::LedB3 => "LED-B3",
            Self::LedB5 => "LED-B5",
        }
    }

    /// The illuminant of that name, in capitals or not.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|i| i.name().eq_ignore_ascii_case(name))
    }

    /// Spectrum at `lambda`, nm, normalised to Y = 1.
    pub fn at(self, lambda: f64) -> f64 {
        NORMALISED[self as usize].at(lambda)
    }
}

/// Every illuminant's table, normalised to Y = 1.
static NORMALISED: LazyLock<Vec<Table>> = LazyLock::new(|| {
    let normalised = |i: Illuminant| {
        let table = published(i.name());
        let luminance = integral(|lambda| table.at(lambda) * cmf(lambda)[1]) / y_integral();
        let values = table.values().iter().map(|v| v / luminance).collect();
        Table::new(table.lambdas().to_vec(), values, table.outside()).expect("as it was")
    };
    Illuminant::ALL.into_iter().map(normalised).collect()
});

#[cfg(test)]
mod tests {
    use super::*;

    fn chromaticity([x, y, z]: [f64; 3]) -> [f64; 2] {
        [x / (x + y + z), y / (x + y + z)]
    }

    fn assert_near<const N: usize>(a: [f64; N], b: [f64; N], tolerance: f64, what: &str) {
        let is_near = a.iter().zip(&b).all(|(a, b)| (a - b).abs() <= tolerance);
        assert!(is_near, "{what}: {a:?} is not {b:?} within {tolerance}");
    }

    /// Values of ISO/CIE 11664-1, and the integral that pbrt-v4 has.
    #[test]
    fn the_observer_is_the_published_one() {
        assert_near(cmf(555.0), [0.512_050_1, 1.0, 0.005_749_999], 1e-9, "555 nm");
        assert_near(cmf(446.0), [0.3483, 0.0303, 1.7826], 2e-3, "446 nm, near the peak of z");
        assert_near(cmf(360.0), [0.000_129_9, 0.000_003_917, 0.000_606_1], 1e-9, "360 nm");
        // which edition of the table, and half or all of its ends, move the fifth digit
        assert!((y_integral() - 106.8569).abs() < 5e-5, "{}", y_integral());
        let (a, b) = (cmf(600.0), cmf(601.0));
        assert_near(cmf(600.25), std::array::from_fn(|k| 0.75 * a[k] + 0.25 * b[k]), 1e-12, "600.25 nm");
        assert_eq!((cmf(359.9), cmf(830.1), cmf(f64::NAN)), ([0.0; 3], [0.0; 3], [0.0; 3]));
        assert!((360..=830).all(|nm| sensitivity(f64::from(nm)) > 0.0));
    }

    /// Chromaticities by CIE 15:2004 tables T.3 and T.8 and CIE 015:2018 for LEDs and HP lamps.
    #[test]
    fn white_points_are_the_published_ones() {
        let published = [
            (Illuminant::A, [0.447_58, 0.407_45]),
            (Illuminant::D50, [0.345_67, 0.358_51]),
            (Illuminant::D65, [0.312_72, 0.329_03]),
            (Illuminant::Fl2, [0.3721, 0.3751]),
            (Illuminant::Fl7, [0.3129, 0.3292]),
            (Illuminant::Fl11, [0.3805, 0.3769]),
            (Illuminant::Hp1, [0.5330, 0.4150]),
            (Illuminant::Hp4, [0.3812, 0.3797]),
            (Illuminant::LedB1, [0.4560, 0.4078]),
            (Illuminant::LedB3, [0.3756, 0.3723]),
            (Illuminant::LedB5, [0.3118, 0.3236]),
        ];
        assert_eq!(published.map(|(i, _)| i), Illuminant::ALL);
        for (illuminant, expected) in published {
            let xyz = xyz(|lambda| illuminant.at(lambda));
            assert!((xyz[1] - 1.0).abs() < 1e-12, "{illuminant:?}: Y = {}", xyz[1]);
            // sums of 5 nm in the tables, integrals here
            assert_near(chromaticity(xyz), expected, 3e-4, illuminant.name());
        }
    }

    #[test]
    fn daylight_is_white() {
        assert_near(xyz_to_rgb(xyz(|lambda| Illuminant::D65.at(lambda))), [1.0; 3], 1e-12, "D65");
        assert_near(xyz(|_| 1.0), [1.0; 3], 4e-4, "a constant spectrum");
    }

    /// The matrix of IEC 61966-2-1, which has four digits.
    #[test]
    fn srgb_is_the_published_one() {
        let columns = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(rgb_to_xyz);
        let published = [[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]];
        for k in 0..3 {
            assert_near(columns[k], published[k], 4e-4, ["red", "green", "blue"][k]);
            assert_near(chromaticity(columns[k]), PRIMARIES[k], 1e-12, "primary");
        }
        assert_near(xyz_to_rgb(rgb_to_xyz([0.2, 0.7, 0.4])), [0.2, 0.7, 0.4], 1e-12, "there and back");
        assert_near(apply(&xyz_to_rgb_matrix(), [0.3, 0.4, 0.5]), xyz_to_rgb([0.3, 0.4, 0.5]), 0.0, "matrix");
    }

    #[test]
    fn integrals_are_exact_where_curves_are_linear_in_each_nm() {
        assert!((integral(|_| 1.0) - 470.0).abs() < 1e-9);
        let cubic = |x: f64| x * x * x;
        let exact = (830f64.powi(4) - 360f64.powi(4)) / 4.0;
        assert!((integral(cubic) / exact - 1.0).abs() < 1e-12);
    }

    #[test]
    fn illuminants_have_names() {
        for illuminant in Illuminant::ALL {
            assert_eq!(Illuminant::named(&illuminant.name().to_lowercase()), Some(illuminant));
        }
        assert_eq!(Illuminant::named("D66"), None);
    }
}
