//! Metals: complex indices of refraction over wavelength \[E40\].

use super::curve::Spectrum;
use super::table::{Outside, Table};
use super::{BANDS, Bands};

/// A metal of the catalogue: wavelength in nm, and the real and imaginary part of its index.
type Measured = &'static [[f64; 3]];

/// Names, sources and indices. From refractiveindex.info, in the public domain.
const METALS: [(&str, &str, Measured); 8] = [
    ("aluminium", "McPeak et al. 2015", ALUMINIUM),
    ("chromium", "Johnson & Christy 1974", CHROMIUM),
    ("copper", "Johnson & Christy 1972", COPPER),
    ("gold", "Johnson & Christy 1972", GOLD),
    ("iron", "Johnson & Christy 1974", IRON),
    ("nickel", "Johnson & Christy 1974", NICKEL),
    ("silver", "Johnson & Christy 1972", SILVER),
    ("titanium", "Johnson & Christy 1974", TITANIUM),
];

#[rustfmt::skip]
const ALUMINIUM: Measured = &[
    [380.0, 0.336, 4.003], [400.0, 0.375, 4.226], [420.0, 0.418, 4.447], [440.0, 0.464, 4.669], [460.0, 0.515, 4.888],
    [480.0, 0.568, 5.106], [500.0, 0.626, 5.320], [520.0, 0.688, 5.536], [540.0, 0.754, 5.746], [560.0, 0.829, 5.958],
    [580.0, 0.909, 6.165], [600.0, 0.992, 6.369], [620.0, 1.088, 6.567], [640.0, 1.190, 6.759], [660.0, 1.304, 6.942],
    [680.0, 1.426, 7.116], [700.0, 1.560, 7.274], [720.0, 1.707, 7.414], [740.0, 1.872, 7.528], [760.0, 2.054, 7.599],
    [780.0, 2.232, 7.604],
];

// one of its values is near π
#[allow(clippy::approx_constant)]
#[rustfmt::skip]
const CHROMIUM: Measured = &[
    [381.0, 1.92, 2.74], [397.0, 2.00, 2.83], [413.0, 2.08, 2.93], [431.0, 2.19, 3.04], [451.0, 2.33, 3.14],
    [471.0, 2.51, 3.24], [496.0, 2.75, 3.30], [521.0, 2.94, 3.33], [549.0, 3.18, 3.33], [582.0, 3.22, 3.30],
    [617.0, 3.17, 3.30], [659.0, 3.09, 3.34], [704.0, 3.05, 3.39], [756.0, 3.08, 3.42], [821.0, 3.20, 3.48],
];

#[rustfmt::skip]
const COPPER: Measured = &[
    [381.5, 1.33, 2.045], [397.4, 1.32, 2.116], [413.3, 1.28, 2.207], [430.5, 1.25, 2.305], [450.9, 1.24, 2.397],
    [471.4, 1.25, 2.483], [495.9, 1.22, 2.564], [520.9, 1.18, 2.608], [548.6, 1.02, 2.577], [582.1, 0.70, 2.704],
    [616.8, 0.30, 3.205], [659.5, 0.22, 3.747], [704.5, 0.21, 4.205], [756.0, 0.24, 4.665], [821.1, 0.26, 5.180],
];

#[rustfmt::skip]
const GOLD: Measured = &[
    [381.5, 1.46, 1.933], [397.4, 1.47, 1.952], [413.3, 1.46, 1.958], [430.5, 1.45, 1.948], [450.9, 1.38, 1.914],
    [471.4, 1.31, 1.849], [495.9, 1.04, 1.833], [520.9, 0.62, 2.081], [548.6, 0.43, 2.455], [582.1, 0.29, 2.863],
    [616.8, 0.21, 3.272], [659.5, 0.14, 3.697], [704.5, 0.13, 4.103], [756.0, 0.14, 4.542], [821.1, 0.16, 5.083],
];

#[rustfmt::skip]
const IRON: Measured = &[
    [381.0, 2.12, 2.50], [397.0, 2.24, 2.58], [413.0, 2.35, 2.65], [431.0, 2.48, 2.71], [451.0, 2.59, 2.77],
    [471.0, 2.67, 2.82], [496.0, 2.74, 2.88], [521.0, 2.86, 2.91], [549.0, 2.95, 2.93], [582.0, 2.94, 2.99],
    [617.0, 2.88, 3.05], [659.0, 2.92, 3.10], [704.0, 2.86, 3.19], [756.0, 2.87, 3.28], [821.0, 2.94, 3.39],
];

#[rustfmt::skip]
const NICKEL: Measured = &[
    [381.0, 1.72, 2.48], [397.0, 1.72, 2.57], [413.0, 1.70, 2.69], [431.0, 1.71, 2.82], [451.0, 1.73, 2.95],
    [471.0, 1.78, 3.09], [496.0, 1.82, 3.25], [521.0, 1.85, 3.42], [549.0, 1.92, 3.61], [582.0, 1.96, 3.80],
    [617.0, 1.99, 4.02], [659.0, 1.99, 4.26], [704.0, 2.06, 4.50], [756.0, 2.13, 4.73], [821.0, 2.26, 4.97],
];

#[rustfmt::skip]
const SILVER: Measured = &[
    [381.5, 0.05, 1.864], [397.4, 0.05, 2.070], [413.3, 0.05, 2.275], [430.5, 0.04, 2.462], [450.9, 0.04, 2.657],
    [471.4, 0.05, 2.869], [495.9, 0.05, 3.093], [520.9, 0.05, 3.324], [548.6, 0.06, 3.586], [582.1, 0.05, 3.858],
    [616.8, 0.06, 4.152], [659.5, 0.05, 4.483], [704.5, 0.04, 4.838], [756.0, 0.03, 5.242], [821.1, 0.04, 5.727],
];

#[rustfmt::skip]
const TITANIUM: Measured = &[
    [381.0, 1.99, 2.93], [397.0, 2.08, 2.95], [413.0, 2.14, 2.98], [431.0, 2.21, 3.01], [451.0, 2.27, 3.04],
    [471.0, 2.32, 3.10], [496.0, 2.36, 3.19], [521.0, 2.44, 3.30], [549.0, 2.54, 3.43], [582.0, 2.60, 3.58],
    [617.0, 2.67, 3.72], [659.0, 2.76, 3.84], [704.0, 2.86, 3.96], [756.0, 3.00, 4.01], [821.0, 3.21, 4.01],
];

/// Wavelengths that stand for blue, green and red, nm: the dominant ones of sRGB's primaries.
const OF_RGB: [f64; 3] = [464.2, 549.1, 611.4];
/// A colour may ask for more reflectance than a metal has.
const REFLECTANCE_MOST: f64 = 0.995;

/// A complex index η + ik, relative to air.
#[derive(Clone, Debug, PartialEq)]
pub struct Metal {
    eta: Table,
    k: Table,
}

impl Metal {
    /// Names of the catalogue.
    pub fn names() -> [&'static str; METALS.len()] {
        METALS.map(|(name, ..)| name)
    }

    /// A metal of the catalogue, in any case of letters.
    pub fn named(name: &str) -> Option<Self> {
        let (.., measured) = METALS.into_iter().find(|(known, ..)| known.eq_ignore_ascii_case(name))?;
        let table = |part: usize| {
            let lambdas = measured.iter().map(|m| m[0]).collect();
            Table::new(lambdas, measured.iter().map(|m| m[part]).collect(), Outside::Held)
        };
        Some(Self { eta: table(1).ok()?, k: table(2).ok()? })
    }

    /// One whose index is known in red, green and blue: linear over the wavelengths between.
    pub fn of_rgb(eta: [f32; 3], k: [f32; 3]) -> Option<Self> {
        let table = |[red, green, blue]: [f32; 3]| {
            Table::new(OF_RGB.into(), [blue, green, red].map(f64::from).into(), Outside::Held)
        };
        Some(Self { eta: table(eta).ok()?, k: table(k).ok()? })
    }

    /// η and k at a wavelength, nm.
    pub fn at(&self, lambda: f64) -> [f64; 2] {
        [self.eta.at(lambda), self.k.at(lambda)]
    }

    /// Reflectance head on at a wavelength, nm.
    fn head_on(&self, lambda: f64) -> f64 {
        let [eta, k] = self.at(lambda);
        ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k)
    }

    /// η and k for red, green and blue: η is that of a wavelength in the band, k such that the band reflects head on what the spectrum
    /// does as a colour.
    pub fn to_rgb(&self) -> [Bands; 2] {
        let lambdas: Vec<f64> = (0..=80).map(|i| 380.0 + 5.0 * f64::from(i)).collect();
        let values = lambdas.iter().map(|lambda| self.head_on(*lambda)).collect();
        let colour =
            Spectrum::reflectance_table(lambdas, values).map_or([0.5; 3], |s| s.reflectance_to_rgb());
        let mut parts = [[0.0f32; BANDS]; 2];
        for band in 0..BANDS {
            let eta = self.eta.at(OF_RGB[BANDS - 1 - band]);
            // no metal reflects less than its real part alone does
            let least = ((eta - 1.0) / (eta + 1.0)).powi(2);
            let reflectance = colour[band].clamp(least, REFLECTANCE_MOST);
            let k2 = (reflectance * (eta + 1.0).powi(2) - (eta - 1.0).powi(2)) / (1.0 - reflectance);
            (parts[0][band], parts[1][band]) = (eta as f32, k2.max(0.0).sqrt() as f32);
        }
        parts
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every metal reflects, head on, what its index says, and as a colour the same: gold is yellow, copper red, silver white.
    #[test]
    fn metals_have_their_colours() {
        let colour = |name: &str| {
            let metal = Metal::named(name).expect("a name of the catalogue");
            let [eta, k] = metal.to_rgb();
            [0, 1, 2].map(|b| {
                let (n, k) = (f64::from(eta[b]), f64::from(k[b]));
                ((n - 1.0).powi(2) + k * k) / ((n + 1.0).powi(2) + k * k)
            })
        };
        let names = Metal::names();
        for name in names {
            assert!(colour(name).iter().all(|r| (0.3..=REFLECTANCE_MOST + 1e-6).contains(r)), "{name}");
        }
        let [r, g, b] = colour("Gold");
        assert!(r > 0.95 && (0.6..0.85).contains(&g) && (0.25..0.45).contains(&b), "gold: {r} {g} {b}");
        let [r, g, b] = colour("copper");
        assert!(r > 0.9 && g > b && g < 0.75 && b > 0.4, "copper: {r} {g} {b}");
        let [r, g, b] = colour("silver");
        assert!(r > 0.95 && g > 0.95 && b > 0.88, "silver: {r} {g} {b}");
        assert!(Metal::named("unobtainium").is_none());
    }

    /// A metal of red, green and blue has their index at their wavelengths, and between them something between.
    #[test]
    fn metals_of_three_bands_are_linear_between() {
        let metal = Metal::of_rgb([0.2, 0.4, 1.4], [3.9, 2.4, 1.6]).expect("indices");
        for (lambda, wanted) in
            [(611.4, [0.2, 3.9]), (549.1, [0.4, 2.4]), (464.2, [1.4, 1.6]), (700.0, [0.2, 3.9])]
        {
            let found = metal.at(lambda);
            assert!((0..2).all(|i| (found[i] - wanted[i]).abs() < 1e-6), "{lambda}: {found:?}");
        }
        assert!((metal.at(580.25)[0] - 0.3).abs() < 1e-6);
        assert!(Metal::of_rgb([f32::NAN; 3], [1.0; 3]).is_none());
    }
}
