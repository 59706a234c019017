//! Roulette: which event light has at a surface, and where it goes [E3]. What follows light on the host asks here.

use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::{DielectricInterface, reflectance_d, sample_d, sample_mirror};
use crate::packed::layout::{SURE_EVENTS, SURVIVAL_MAX};
use crate::spectrum::{BANDS, Bands, max, mul, scale};
use glam::Vec3;

/// Index of the D event among the ways; a mirror's or an interface's reflection is the next.
pub(crate) const SCATTERED: usize = 0;
/// Index of transmission.
const TRANSMITTED: usize = 2;

/// What a surface does with a joton: the probabilities and reflectances of its events.
pub(crate) struct EventProbabilities {
    /// Reflectance per band and probability of each way.
    pub(crate) ways: [(Bands, f32); 3],
    interface: Option<DielectricInterface>,
}

impl EventProbabilities {
    /// p_x = max_b(ρ_x Φ)/max_b(Φ); where the maxima lie in different bands they can exceed one together, and are
    /// scaled down; late in a path they may not even be one together.
    pub(crate) fn new(s: &SurfaceInteraction, flux: &Bands, event: u32) -> Self {
        let m = s.material;
        let interface = s.flags().is_dielectric().then(|| DielectricInterface::at(s));
        let reflectances = match &interface {
            Some(b) => {
                [reflectance_d(m), scale(&m.specular, b.fresnel), scale(&m.transmission, 1.0 - b.fresnel)]
            }
            None => [reflectance_d(m), m.specular, [0.0; BANDS]],
        };
        let p = reflectances.map(|r| max(&mul(&r, flux)) / max(flux));
        let limit = if event < SURE_EVENTS { 1.0 } else { SURVIVAL_MAX };
        let fit = limit / p.iter().sum::<f32>().max(limit);
        Self { ways: std::array::from_fn(|i| (reflectances[i], p[i] * fit)), interface }
    }

    /// Index of the way that `u` falls on; None is absorption.
    pub(crate) fn choose(&self, u: f32) -> Option<usize> {
        let mut below = 0.0;
        self.ways.iter().position(|&(_, p)| {
            below += p;
            p > 0.0 && u < below
        })
    }

    /// The direction in which light leaves by a way; None below the surface.
    pub(crate) fn direction(
        &self,
        s: &SurfaceInteraction,
        way: usize,
        u_lobe: f32,
        u: [f32; 2],
    ) -> Option<Vec3> {
        match (&self.interface, way) {
            (_, SCATTERED) => sample_d(s.material, s.back, s.ns, u_lobe, u),
            (Some(interface), TRANSMITTED) => Some(interface.refracted),
            (Some(interface), _) => Some(interface.reflected),
            (None, _) => sample_mirror(s, u),
        }
    }

    /// What goes by a way of `flux`.
    pub(crate) fn carried(&self, way: usize, flux: &Bands) -> Bands {
        let (reflectance, probability) = self.ways[way];
        scale(&mul(flux, &reflectance), 1.0 / probability)
    }
}
