//! Splits: where a camera tree takes both ways, and how likely an eye path is to go where a tree goes anyway [E25].
//! Twin: shaders/paths/splits.wgsl.

use crate::optics::ray::SurfaceInteraction;
use crate::optics::shading::bsdf::DielectricInterface;
use crate::packed::layout::SPLIT_MIN;
use crate::spectrum::{Bands, max, mul, scale};
use glam::Vec3;

/// Along a path from the eye.
#[derive(Debug, Clone, Copy)]
pub(super) struct Splits {
    /// Flux kept so far of all that set out.
    share: f32,
    /// Chance that an eye path, which picks one way by its flux, took these where a tree takes both.
    chance: f32,
}

impl Splits {
    /// At the eye.
    pub(super) fn start() -> Self {
        Self { share: 1.0, chance: 1.0 }
    }

    /// Whether a tree takes both ways at an interface; `carried` is the flux of what arrives.
    pub(super) fn takes_both(&self, ways: &[Branch; 2], carried: f32) -> bool {
        ways[0].kept.min(ways[1].kept) / carried * self.share >= SPLIT_MIN
    }

    /// After the way `taken` of these at an interface.
    pub(super) fn after(&self, ways: &[Branch; 2], taken: usize, carried: f32) -> Self {
        let kept = ways[0].kept + ways[1].kept;
        if self.takes_both(ways, carried) {
            self.mirrored(ways[taken].kept / carried, ways[taken].kept / kept)
        } else {
            Self { share: self.share * kept / carried, ..*self }
        }
    }

    /// After a mirror that keeps this part of what arrives; an eye path is mirrored with probability `chance`.
    pub(super) fn mirrored(&self, kept: f32, chance: f32) -> Self {
        Self { share: self.share * kept, chance: self.chance * chance }
    }

    /// Weight of the emission that an eye path meets, beside so many trees a pass: the balance heuristic.
    pub(super) fn weight_of_eye(&self, trees: f32) -> f32 {
        self.chance / (self.chance + trees)
    }

    /// Weight of the emission that each of so many trees a pass meets.
    pub(super) fn weight_of_tree(&self, trees: f32) -> f32 {
        1.0 / (self.chance + trees)
    }
}

/// One way at a dielectric interface.
#[derive(Debug, Clone, Copy)]
pub(super) struct Branch {
    /// Unit vector.
    pub(super) direction: Vec3,
    /// What of a path's throughput goes this way. Radiance scales by (η_i/η_t)² on crossing [E9]; a joton's flux does not.
    pub(super) throughput: Bands,
    /// The flux of it, in the path's largest band: without the scale.
    pub(super) kept: f32,
}

/// Off a dielectric interface, and through it.
pub(super) fn branches(s: &SurfaceInteraction, throughput: &Bands) -> [Branch; 2] {
    let b = DielectricInterface::at(s);
    let reflected = scale(&mul(throughput, &s.material.specular), b.fresnel);
    let transmitted = scale(&mul(throughput, &s.material.transmission), 1.0 - b.fresnel);
    let radiance_scale = b.eta_i_over_t * b.eta_i_over_t;
    [
        Branch { direction: b.reflected, throughput: reflected, kept: max(&reflected) },
        Branch {
            direction: b.refracted,
            throughput: scale(&transmitted, radiance_scale),
            kept: max(&transmitted),
        },
    ]
}

/// One of two branches, each as often as its share of the flux, and which.
pub(super) fn pick(ways: &[Branch; 2], u: f32) -> Option<(usize, Branch)> {
    let kept = ways[0].kept + ways[1].kept;
    if kept <= 0.0 {
        return None;
    }
    let p = ways[0].kept / kept;
    let (taken, p) = if u < p { (0, p) } else { (1, 1.0 - p) };
    Some((taken, Branch { throughput: scale(&ways[taken].throughput, 1.0 / p), kept, ..ways[taken] }))
}
