//! Shading: what a surface does with light, as a short list of lobes. Each lobe is a file; here is the table of all; `bsdf` holds the
//! list at a hit, and all that follow light see that only. A new lobe is a file, a variant of those that scatter or of the delta
//! ones, and the line that makes it of a material. Twin: shaders/shading/lobes.wgsl.

mod anisotropy;
pub mod bsdf;
mod clear_coat;
pub(crate) mod cutout;
mod dielectric;
mod facet_textures;
pub(crate) mod frame;
mod fresnel;
mod lambert;
mod layers;
pub(crate) mod material;
mod microfacet;
mod mirror;
pub(crate) mod mixture;
pub mod phong;
pub(crate) mod relief;
mod rough_interface;
pub(crate) mod roulette;
mod sheen;
pub(crate) mod texture;
mod translucent;
mod undercoat;

use crate::packed::PackedMaterial;
use crate::spectrum::{Bands, is_black};
use arrayvec::ArrayVec;
use dielectric::Way;
use frame::Frame;
use glam::Vec3;
use lambert::Lambert;
use microfacet::Microfacet;
use mirror::Mirror;
use phong::Phong;
use rough_interface::RoughWay;
use sheen::Sheen;
use translucent::Translucent;
use undercoat::Undercoat;

/// Most lobes of a material that scatter …
pub(crate) const SCATTER_MOST: usize = 4;
/// … and most delta lobes.
pub(crate) const DELTA_MOST: usize = 2;

/// A lobe that scatters.
#[derive(Debug, Clone, Copy)]
pub(crate) enum ScatterLobe {
    Lambert(Lambert),
    Undercoat(Undercoat),
    Phong(Phong),
    Microfacet(Microfacet),
    Translucent(Translucent),
    Sheen(Sheen),
}

impl ScatterLobe {
    fn albedo(&self) -> Bands {
        match self {
            Self::Lambert(l) => l.albedo,
            Self::Undercoat(u) => u.albedo,
            Self::Phong(p) => p.albedo,
            Self::Microfacet(m) => m.albedo,
            Self::Translucent(t) => t.albedo,
            Self::Sheen(s) => s.albedo,
        }
    }

    fn eval(&self, wi: Vec3, wo: Vec3, n: Vec3) -> Bands {
        match self {
            Self::Lambert(l) => l.eval(),
            Self::Undercoat(u) => u.eval(wi, wo, n),
            Self::Phong(p) => p.eval(wi, wo, n),
            Self::Microfacet(m) => m.eval(wi, wo, n),
            Self::Translucent(t) => t.eval(),
            Self::Sheen(s) => s.eval(wi, wo, n),
        }
    }

    fn pdf(&self, wi: Vec3, wo: Vec3, n: Vec3) -> f32 {
        match self {
            Self::Lambert(l) => l.pdf(wi, n),
            Self::Undercoat(u) => u.pdf(wi, n),
            Self::Phong(p) => p.pdf(wi, wo, n),
            Self::Microfacet(m) => m.pdf(wi, wo, n),
            Self::Translucent(t) => t.pdf(wi, n),
            Self::Sheen(s) => s.pdf(wi, n),
        }
    }

    fn sample(&self, wo: Vec3, n: Vec3, u: [f32; 2]) -> Vec3 {
        match self {
            Self::Lambert(l) => l.sample(n, u),
            Self::Undercoat(c) => c.sample(n, u),
            Self::Phong(p) => p.sample(wo, n, u),
            Self::Microfacet(m) => m.sample(wo, n, u),
            Self::Translucent(t) => t.sample(n, u),
            Self::Sheen(s) => s.sample(n, u),
        }
    }

    /// True for light that goes to the other side of the surface.
    fn crosses(&self) -> bool {
        matches!(self, Self::Translucent(_))
    }

    /// True for light that goes into all directions by their cosine, or nearly so.
    fn is_diffuse(&self) -> bool {
        matches!(self, Self::Lambert(_) | Self::Undercoat(_) | Self::Translucent(_))
    }

    /// True where f_r depends on directions.
    fn varies(&self) -> bool {
        !matches!(self, Self::Lambert(_) | Self::Translucent(_))
    }
}

/// Those of a material, seen at this cosine to the normal.
fn scatter_lobes(m: &PackedMaterial, cosine: f32) -> ArrayVec<ScatterLobe, SCATTER_MOST> {
    let mut lobes = ArrayVec::new();
    if m.flags().has_lambert() {
        lobes.push(if m.flags().is_coated() {
            ScatterLobe::Undercoat(Undercoat::new(m, cosine))
        } else {
            ScatterLobe::Lambert(Lambert { albedo: m.diffuse })
        });
    }
    if m.flags().has_glossy() {
        lobes.push(if m.flags().has_facets() {
            ScatterLobe::Microfacet(Microfacet::new(m, m.glossy, cosine))
        } else {
            ScatterLobe::Phong(Phong { albedo: m.glossy, exponent: m.glossy_exponent })
        });
    }
    if m.flags().is_translucent() {
        lobes.push(ScatterLobe::Translucent(Translucent { albedo: m.transmission }));
    }
    if m.flags().is_layered() {
        if !is_black(&m.extinction) {
            lobes.push(ScatterLobe::Sheen(Sheen::new(m, cosine)));
        }
        if m.clear_coat > 0.0 && !m.flags().follows_clear_coat() {
            lobes.push(ScatterLobe::Microfacet(clear_coat::lobe(m, cosine)));
        }
    }
    lobes
}

/// A delta lobe, or one that is followed as if it were.
#[derive(Debug, Clone, Copy)]
pub(crate) enum DeltaLobe {
    Mirror(Mirror),
    Facets(Microfacet),
    Interface(Way),
    RoughInterface(RoughWay),
}

impl DeltaLobe {
    /// Reflectance or transmittance, per band; of a lobe with a width about that.
    pub(crate) fn albedo(&self) -> Bands {
        match self {
            Self::Mirror(m) => m.albedo,
            Self::Facets(m) => m.albedo,
            Self::Interface(w) => w.albedo,
            Self::RoughInterface(w) => w.albedo,
        }
    }

    /// Where light leaves; none below the surface.
    pub(crate) fn sample(&self, f: &Frame, u: [f32; 2]) -> Option<Vec3> {
        match self {
            Self::Mirror(m) => m.sample(f, u),
            Self::Facets(m) if !m.has_width() => Some(Mirror::direction(f)),
            Self::Facets(m) => {
                let w = m.sample(f.back, f.specular_normal(), u);
                Some(w).filter(|w| w.dot(f.ng) > 0.0 && w.dot(f.specular_normal()) > 0.0)
            }
            Self::Interface(w) => Some(w.direction),
            Self::RoughInterface(w) => w.sample(f, u),
        }
    }

    /// f cosθ / pdf_solid_angle of a direction that was sampled, as flux.
    pub(crate) fn through(&self, f: &Frame, w: Vec3) -> Bands {
        match self {
            Self::Mirror(m) => m.albedo,
            Self::Facets(m) if !m.has_width() => m.albedo,
            Self::Facets(m) => m.reflected(w, f.back, f.specular_normal()),
            Self::Interface(w) => w.albedo,
            Self::RoughInterface(way) => way.through(f, w),
        }
    }

    /// By how much radiance scales on the way to the eye [E9].
    pub(crate) fn radiance_scale(&self, f: &Frame) -> f32 {
        match self {
            Self::Mirror(_) | Self::Facets(_) => 1.0,
            Self::Interface(w) => w.radiance_scale,
            Self::RoughInterface(w) => w.radiance_scale(f),
        }
    }

    /// False where light leaves in one direction only.
    pub(crate) fn has_width(&self) -> bool {
        match self {
            Self::Mirror(m) => m.has_width(),
            Self::Facets(m) => m.has_width(),
            Self::Interface(_) => false,
            Self::RoughInterface(_) => true,
        }
    }

    /// pdf_solid_angle of [`DeltaLobe::sample`], where it has a width.
    pub(crate) fn pdf(&self, f: &Frame, w: Vec3) -> Option<f32> {
        self.has_width().then(|| match self {
            Self::Mirror(m) => m.pdf(f, w),
            Self::Facets(m) => m.pdf(w, f.back, f.specular_normal()),
            Self::Interface(_) => 0.0,
            Self::RoughInterface(way) => way.pdf(f, w),
        })
    }

    /// True where it sends light to the other side of the surface.
    fn crosses(&self) -> bool {
        match self {
            Self::Mirror(_) | Self::Facets(_) => false,
            // nobody asks: it has no width
            Self::Interface(_) => false,
            Self::RoughInterface(w) => w.is_transmission,
        }
    }
}

/// Those of a material, in a frame.
fn delta_lobes(m: &PackedMaterial, frame: &Frame) -> ArrayVec<DeltaLobe, DELTA_MOST> {
    let mut lobes = ArrayVec::new();
    let flags = m.flags();
    if flags.is_dielectric() && flags.has_facets() {
        lobes.extend(rough_interface::ways(m, frame).map(DeltaLobe::RoughInterface));
    } else if flags.is_dielectric() {
        lobes.extend(dielectric::ways(m, frame).map(DeltaLobe::Interface));
    } else if flags.has_delta() && flags.has_facets() {
        let cosine = frame.back.dot(frame.specular_normal());
        if flags.has_specular() {
            lobes.push(DeltaLobe::Facets(Microfacet::new(m, m.specular, cosine)));
        }
        if flags.follows_clear_coat() {
            lobes.push(DeltaLobe::Facets(clear_coat::lobe(m, cosine)));
        }
    } else if flags.has_delta() {
        lobes.push(DeltaLobe::Mirror(Mirror { albedo: m.specular, exponent: m.specular_exponent }));
    }
    lobes
}
