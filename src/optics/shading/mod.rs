//! Shading: what a surface does with light, as a short list of lobes. Each lobe is a file; here is the table of all; `bsdf` holds the
//! list at a hit, and all that follow light see that only. A new lobe is a file, a variant of those that scatter or of the delta
//! ones, and the line that makes it of a material. Twin: shaders/shading/lobes.wgsl.

pub mod bsdf;
pub(crate) mod cutout;
mod dielectric;
pub(crate) mod frame;
mod lambert;
mod material;
mod mirror;
pub mod phong;
pub(crate) mod roulette;
pub(crate) mod texture;

use crate::packed::PackedMaterial;
use crate::spectrum::Bands;
use arrayvec::ArrayVec;
use dielectric::Way;
use frame::Frame;
use glam::Vec3;
use lambert::Lambert;
use mirror::Mirror;
use phong::Phong;

/// Most lobes of a material that scatter …
pub(crate) const SCATTER_MOST: usize = 2;
/// … and most delta lobes.
pub(crate) const DELTA_MOST: usize = 2;

/// A lobe that scatters.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ScatterLobe {
    Lambert(Lambert),
    Phong(Phong),
}

impl ScatterLobe {
    fn albedo(&self) -> Bands {
        match self {
            Self::Lambert(l) => l.albedo,
            Self::Phong(p) => p.albedo,
        }
    }

    fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        match self {
            Self::Lambert(l) => l.eval(),
            Self::Phong(p) => p.eval(wi, wo, n),
        }
    }

    fn pdf(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        match self {
            Self::Lambert(l) => l.pdf(wi, n),
            Self::Phong(p) => p.pdf(wi, wo, n),
        }
    }

    fn sample(&self, wo: Vec3, n: Vec3, u: [f32; 2]) -> Vec3 {
        match self {
            Self::Lambert(l) => l.sample(n, u),
            Self::Phong(p) => p.sample(wo, n, u),
        }
    }

    /// True where f_r depends on directions.
    fn varies(&self) -> bool {
        !matches!(self, Self::Lambert(_))
    }
}

/// Those of a material.
fn scatter_lobes(m: &PackedMaterial) -> ArrayVec<ScatterLobe, SCATTER_MOST> {
    let mut lobes = ArrayVec::new();
    if m.flags().has_lambert() {
        lobes.push(ScatterLobe::Lambert(Lambert { albedo: m.diffuse }));
    }
    if m.flags().has_glossy() {
        lobes.push(ScatterLobe::Phong(Phong { albedo: m.glossy, exponent: m.glossy_exponent }));
    }
    lobes
}

/// A delta lobe.
#[derive(Debug, Clone, Copy)]
pub(crate) enum DeltaLobe {
    Mirror(Mirror),
    Interface(Way),
}

impl DeltaLobe {
    /// Reflectance or transmittance, per band.
    pub(crate) fn albedo(&self) -> Bands {
        match self {
            Self::Mirror(m) => m.albedo,
            Self::Interface(w) => w.albedo,
        }
    }

    /// Where light leaves; none below the surface.
    pub(crate) fn sample(&self, f: &Frame, u: [f32; 2]) -> Option<Vec3> {
        match self {
            Self::Mirror(m) => m.sample(f, u),
            Self::Interface(w) => Some(w.direction),
        }
    }

    /// By how much radiance scales on the way to the eye [E9].
    pub(crate) fn radiance_scale(&self) -> f32 {
        match self {
            Self::Mirror(_) => 1.0,
            Self::Interface(w) => w.radiance_scale,
        }
    }
    /// The lobe where it has a width, for lights without area: following it never meets them [E6].
    fn narrow(&self) -> Option<Phong> {
        match self {
            Self::Mirror(m) => m.narrow(),
            Self::Interface(_) => None,
        }
    }
}

/// Those of a material, in a frame.
fn delta_lobes(m: &PackedMaterial, frame: &Frame) -> ArrayVec<DeltaLobe, DELTA_MOST> {
    let mut lobes = ArrayVec::new();
    if m.flags().is_dielectric() {
        let [reflection, transmission] = dielectric::ways(m, frame);
        lobes.push(DeltaLobe::Interface(reflection));
        lobes.push(DeltaLobe::Interface(transmission));
    } else if m.flags().has_delta() {
        lobes.push(DeltaLobe::Mirror(Mirror { albedo: m.specular, exponent: m.specular_exponent }));
    }
    lobes
}
