//! EventProbabilities: the roulette of a joton at a surface [E3].

use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::{DielectricInterface, reflectance_d};
use crate::packed::layout::{SURE_EVENTS, SURVIVAL_MAX};
use crate::spectrum::{BANDS, Bands, max, mul, scale};

/// What a surface does with a joton: the probabilities and reflectances of its events.
pub(crate) struct EventProbabilities {
    /// Reflectance per band and probability of D, of mirror or reflection, of transmission.
    pub(crate) ways: [(Bands, f32); 3],
}

impl EventProbabilities {
    /// p_x = max_b(ρ_x Φ)/max_b(Φ); where the maxima lie in different bands they can exceed one together, and are
    /// scaled down; late in a path they may not even be one together.
    pub(crate) fn new(
        s: &SurfaceInteraction,
        interface: Option<&DielectricInterface>,
        flux: &Bands,
        event: u32,
    ) -> Self {
        let m = s.material;
        let reflectances = match interface {
            Some(b) => {
                [reflectance_d(m), scale(&m.specular, b.fresnel), scale(&m.transmission, 1.0 - b.fresnel)]
            }
            None => [reflectance_d(m), m.specular, [0.0; BANDS]],
        };
        let p = reflectances.map(|r| max(&mul(&r, flux)) / max(flux));
        let limit = if event < SURE_EVENTS { 1.0 } else { SURVIVAL_MAX };
        let fit = limit / p.iter().sum::<f32>().max(limit);
        Self { ways: std::array::from_fn(|i| (reflectances[i], p[i] * fit)) }
    }

    /// Index of the way that `u` falls on; None is absorption.
    pub(crate) fn choose(&self, u: f32) -> Option<usize> {
        let mut below = 0.0;
        self.ways.iter().position(|&(_, p)| {
            below += p;
            p > 0.0 && u < below
        })
    }
}
