//! How much a microfacet reflects, by the angle at which light meets it \[E40\]. Twin: shaders/shading/fresnel.wgsl.

use crate::optics::shading::dielectric::fresnel;
use crate::packed::PackedMaterial;
use crate::packed::constants::CLEAR_COAT_HEAD_ON;
use crate::spectrum::{BANDS, BLACK, Bands, scale};

/// What reflects.
#[derive(Debug, Clone, Copy)]
pub(super) enum Fresnel {
    /// Metal of index η + ik, and a factor.
    Conductor { tint: Bands, eta: Bands, k: Bands },
    /// Schlick's formula: what is reflected head on, and at grazing angles.
    Schlick { head_on: Bands, grazing: f32 },
    /// A clear coat of this index, and a factor.
    Coat { tint: Bands, ior: f32 },
}

impl Fresnel {
    /// Of an opaque material's microfacets; `tint` is what it says of the lobe.
    pub(super) fn of(m: &PackedMaterial, tint: Bands) -> Self {
        if m.flags().is_conductor() {
            Self::Conductor { tint, eta: m.iors, k: m.extinction }
        } else if m.flags().is_schlick() {
            // of a layered material's dielectric part less may be reflected there than of its metal
            let is_layered = m.flags().is_layered();
            let grazing = if is_layered { m.grazing + m.metallic * (1.0 - m.grazing) } else { 1.0 };
            Self::Schlick { head_on: tint, grazing }
        } else {
            Self::Coat { tint, ior: m.ior }
        }
    }

    /// Of the coat over a material's base, the same in all bands: by Schlick's formula where its lobe is.
    pub(super) fn of_bare_coat(m: &PackedMaterial) -> Self {
        if m.flags().is_schlick() {
            let grazing = if m.flags().is_layered() { m.grazing } else { 1.0 };
            Self::Schlick { head_on: [((m.ior - 1.0) / (m.ior + 1.0)).powi(2); BANDS], grazing }
        } else {
            Self::Coat { tint: [1.0; BANDS], ior: m.ior }
        }
    }

    /// Of so much of a clear coat over all else.
    pub(super) fn of_clear_coat(amount: f32) -> Self {
        Self::Schlick { head_on: [amount * CLEAR_COAT_HEAD_ON; BANDS], grazing: amount }
    }

    /// Reflectance for even light; none of a coat, of which so little goes on that it does not count.
    pub(super) fn of_even_light(&self) -> Bands {
        match self {
            Self::Conductor { tint, eta, k } => {
                std::array::from_fn(|b| tint[b] * even(of_conductor(1.0, eta[b], k[b]), 1.0))
            }
            Self::Schlick { head_on, grazing } => head_on.map(|r| even(r, *grazing)),
            Self::Coat { .. } => BLACK,
        }
    }

    /// Reflectance for light at this cosine to the facet's normal, unpolarised.
    pub(super) fn at(&self, cosine: f32) -> Bands {
        let cosine = cosine.clamp(0.0, 1.0);
        match self {
            Self::Conductor { tint, eta, k } => {
                let mut reflectance = *tint;
                for b in 0..BANDS {
                    reflectance[b] *= of_conductor(cosine, eta[b], k[b]);
                }
                reflectance
            }
            Self::Schlick { head_on, grazing } => head_on.map(|r| r + (grazing - r) * (1.0 - cosine).powi(5)),
            Self::Coat { tint, ior } => scale(tint, fresnel(cosine, *ior)),
        }
    }
}

/// Of even light, from what is reflected head on and at grazing angles: by Schlick's formula, 2 ∫ c (R₀ + (R₁ − R₀)(1 − c)⁵) dc.
fn even(head_on: f32, grazing: f32) -> f32 {
    (20.0 * head_on + grazing) / 21.0
}

/// Reflectance of so much of a smooth clear coat over all else, for light at this cosine \[E50\].
pub(super) fn of_clear_coat(amount: f32, cosine: f32) -> f32 {
    amount * (CLEAR_COAT_HEAD_ON + (1.0 - CLEAR_COAT_HEAD_ON) * (1.0 - cosine.clamp(0.0, 1.0)).powi(5))
}

/// Reflectance of smooth metal of index η + ik in air.
fn of_conductor(cosine: f32, eta: f32, k: f32) -> f32 {
    let cos2 = cosine * cosine;
    let sin2 = 1.0 - cos2;
    // p² − q² and p² + q² of the normal part p + iq of the wave vector inside
    let difference = eta * eta - k * k - sin2;
    let sum = (difference * difference + 4.0 * eta * eta * k * k).sqrt();
    let twice_p_cos = 2.0 * cosine * (0.5 * (sum + difference)).max(0.0).sqrt();
    let perpendicular = (sum + cos2 - twice_p_cos) / (sum + cos2 + twice_p_cos);
    let (a, b) = (cos2 * sum + sin2 * sin2, twice_p_cos * sin2);
    0.5 * perpendicular * (1.0 + (a - b) / (a + b))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values of the equations: ((η − 1)² + k²)/((η + 1)² + k²) head on, all at grazing; without k a dielectric's.
    #[test]
    fn metal_reflects_by_its_index() {
        for (eta, k) in [(0.2f32, 3.9f32), (1.5, 7.0), (3.0, 3.3), (0.05, 2.0)] {
            let head_on = ((eta - 1.0).powi(2) + k * k) / ((eta + 1.0).powi(2) + k * k);
            assert!((of_conductor(1.0, eta, k) - head_on).abs() < 1e-6, "{eta} + {k}i");
            assert!((of_conductor(0.0, eta, k) - 1.0).abs() < 1e-6, "{eta} + {k}i");
        }
        for i in 0..=20 {
            let cosine = i as f32 / 20.0;
            assert!((of_conductor(cosine, 1.5, 0.0) - fresnel(cosine, 1.5)).abs() < 1e-5, "{cosine}");
        }
    }
}
