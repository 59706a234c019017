//! Spectra of a scene: what materials and lights are by wavelength, where something says so, and whether they are rendered so.

use super::{Material, Scene};
use crate::spectrum::Spectrum;
use crate::spectrum::glass::Index;
use crate::spectrum::lamp::Emission;

/// What of a material is stated by wavelength; the rest follows from its bands.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct MaterialSpectra {
    /// Of [`Material::diffuse`].
    pub diffuse: Option<Spectrum>,
    /// Of [`Material::glossy`].
    pub glossy: Option<Spectrum>,
    /// Of [`Material::specular`], or of what a dielectric reflects.
    pub specular: Option<Spectrum>,
    /// Of what a dielectric transmits, or of [`Material::transmit`].
    pub transmission: Option<Spectrum>,
    /// Of [`Material::emission`].
    pub emission: Option<Emission>,
    /// Of the absorption inside of a dielectric, per world unit of length.
    pub absorption: Option<Spectrum>,
    /// Index of refraction.
    pub index: Option<Index>,
}

impl MaterialSpectra {
    /// True where nothing is stated so.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// What a scene says by wavelength beside its materials.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Wavelengths {
    /// Spectra of the first lights beside the emissive triangles; what has none, or comes later, follows from its bands.
    pub lights: Vec<Option<Emission>>,
    /// The scene is rendered by wavelength.
    pub are_rendered: bool,
}

/// Why a scene is rendered by wavelength, the first that holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WavelengthReason {
    /// The index of refraction of some surface depends on the wavelength.
    Dispersion,
    /// Some light shines in lines.
    Lines,
    /// Some spectrum is stated.
    Spectra,
}

impl Scene {
    /// Whether something shines in lines.
    pub fn shines_in_lines(&self) -> bool {
        self.stated_emissions().any(|e| !e.lines.is_empty())
    }

    /// What shines by a stated spectrum.
    fn stated_emissions(&self) -> impl Iterator<Item = &Emission> {
        let of_materials = self.materials.iter().filter_map(|m| m.spectra.as_deref()?.emission.as_ref());
        of_materials.chain(self.wavelengths.lights.iter().flatten())
    }

    /// What of the scene asks for wavelengths; none where red, green and blue say all that it does.
    pub fn asks_for_wavelengths(&self) -> Option<WavelengthReason> {
        let stated = || self.materials.iter().filter_map(|m: &Material| m.spectra.as_deref());
        if stated().any(|s| s.index.as_ref().is_some_and(Index::is_dispersive)) {
            return Some(WavelengthReason::Dispersion);
        }
        if self.shines_in_lines() {
            return Some(WavelengthReason::Lines);
        }
        (stated().any(|s| !s.is_empty()) || self.stated_emissions().next().is_some())
            .then_some(WavelengthReason::Spectra)
    }

    /// Spectrum of light `number` beside the emissive triangles, where it is stated.
    pub(crate) fn spectrum_of_light(&self, number: usize) -> Option<&Emission> {
        self.wavelengths.lights.get(number)?.as_ref()
    }
}
