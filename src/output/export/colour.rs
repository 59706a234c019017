//! Colours: what of a surface or a light goes by band, by wavelength or by place.

use crate::scene::texture::Texture;
use crate::spectrum::lamp::Emission;
use crate::spectrum::metal::Metal;
use crate::spectrum::table::{Outside, Table};
use crate::spectrum::{Bands, LAMBDA_MAX, LAMBDA_MIN, Spectrum};

/// Steps of a spectrum that is no table, nm.
const STEP: f64 = 1.0;

/// What goes into a colour of other renderers.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Colour {
    /// Red, green and blue.
    Bands(Bands),
    /// Wavelength, nm, and value: straight between, nothing outside.
    Spectrum(Vec<[f64; 2]>),
    /// A factor on the texels of a picture.
    Picture { texture: Texture, factor: Bands },
}

impl Colour {
    /// A reflectance by wavelength: its ends hold outside of what is stated.
    pub(super) fn reflectance(spectrum: &Spectrum) -> Self {
        sampled(nodes(spectrum, true), |lambda| spectrum.at(lambda))
    }

    /// What a light or a lamp emits; its bands where nothing is stated by wavelength. Lines are refused before.
    pub(super) fn emission(bands: &Bands, stated: Option<&Emission>) -> Self {
        match stated.and_then(|emission| emission.continuous.as_ref()) {
            Some(spectrum) => sampled(nodes(spectrum, false), |lambda| spectrum.at(lambda)),
            None => Self::Bands(*bands),
        }
    }

    /// η and k.
    pub(super) fn index(metal: &Metal) -> [Self; 2] {
        [0, 1].map(|part| sampled(even(), |lambda| metal.at(lambda)[part]))
    }
}

fn sampled(lambdas: Vec<f64>, at: impl Fn(f64) -> f64) -> Colour {
    Colour::Spectrum(lambdas.into_iter().map(|lambda| [lambda, at(lambda)]).collect())
}

/// Where a spectrum is to be known, that straight lines between are what it is.
fn nodes(spectrum: &Spectrum, is_held: bool) -> Vec<f64> {
    match spectrum {
        Spectrum::Scaled(_, inner) => nodes(inner, is_held),
        Spectrum::Table(table) => of_table(table, is_held),
        _ => even(),
    }
}

fn of_table(table: &Table, is_held: bool) -> Vec<f64> {
    let mut lambdas = table.lambdas().to_vec();
    let ends = [lambdas[0], lambdas[lambdas.len() - 1]];
    if is_held && table.outside() == Outside::Held {
        lambdas.splice(0..0, (ends[0] > LAMBDA_MIN).then_some(LAMBDA_MIN));
        lambdas.extend((ends[1] < LAMBDA_MAX).then_some(LAMBDA_MAX));
    }
    lambdas
}

fn even() -> Vec<f64> {
    let count = ((LAMBDA_MAX - LAMBDA_MIN) / STEP).round() as u32;
    (0..=count).map(|i| LAMBDA_MIN + STEP * f64::from(i)).collect()
}
