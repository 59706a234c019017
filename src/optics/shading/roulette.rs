//! Roulette: which event light has at a surface, and where it goes [E3]. What follows light on the host asks here.

use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::Bsdf;
use crate::packed::constants::{SURE_EVENTS, SURVIVAL_MAX};
use crate::spectrum::{Bands, add, mul, scale};
use glam::Vec3;

/// Index of the D event among the ways; the delta lobes follow.
pub(crate) const SCATTERED: usize = 0;
/// Ways of a surface, at most.
const WAYS: usize = 3;

/// What a surface does with what arrives.
pub(crate) struct EventProbabilities {
    pub(crate) bsdf: Bsdf,
    /// Of each way.
    pub(crate) ways: [f32; WAYS],
}

impl EventProbabilities {
    /// p_x = max_b(ρ_x Φ)/max_b(Φ); where the maxima lie in different bands they can exceed one together, and are
    /// scaled down; late in a path they may not even be one together.
    pub(crate) fn new(s: &SurfaceInteraction, flux: &Bands, event: u32) -> Self {
        let bsdf = Bsdf::at(s);
        let shares = bsdf.shares(flux);
        let limit = if event < SURE_EVENTS { 1.0 } else { SURVIVAL_MAX };
        let fit = limit / shares.kept().max(limit);
        let [first, second] = shares.delta;
        Self { bsdf, ways: [shares.scatter, first, second].map(|share| share * fit) }
    }

    /// Reflectance or transmittance of a way, per band.
    pub(crate) fn albedo(&self, way: usize) -> Bands {
        if way == SCATTERED { self.bsdf.scatter.albedo() } else { self.bsdf.delta[way - 1].albedo() }
    }

    /// Of all ways together.
    pub(crate) fn total_albedo(&self) -> Bands {
        let scatter = self.bsdf.scatter.albedo();
        self.bsdf.delta.iter().fold(scatter, |sum, lobe| add(&sum, &lobe.albedo()))
    }

    /// Index of the way that `u` falls on; None is absorption.
    pub(crate) fn choose(&self, u: f32) -> Option<usize> {
        let mut below = 0.0;
        self.ways.iter().position(|&p| {
            below += p;
            p > 0.0 && u < below
        })
    }

    /// The direction in which light leaves by a way; None below the surface.
    pub(crate) fn direction(&self, way: usize, u_lobe: f32, u: [f32; 2]) -> Option<Vec3> {
        if way == SCATTERED {
            self.bsdf.sample_scatter(u_lobe, u)
        } else {
            self.bsdf.sample_delta(way - 1, u)
        }
    }

    /// What goes by a way of `flux`.
    pub(crate) fn carried(&self, way: usize, flux: &Bands) -> Bands {
        scale(&mul(flux, &self.albedo(way)), 1.0 / self.ways[way])
    }
}
