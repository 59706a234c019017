//! Brush: how microfacets are brushed, packed into the bits of a number \[E56\].

use crate::packed::constants::{BRUSH_ANGLE_BITS, BRUSH_STRENGTH_BITS};
use crate::scene::Anisotropy;

/// Which way microfacets are brushed, and how much, in the bits of [`super::PackedMaterial::glossy_exponent`]: of a number from 1 to 2, which no
/// device takes for another, the square of the strength in the low bits and the angle above. Of a material the angle is that of the
/// anisotropy; where a surface has been met, that of the rougher way in the basis of its shading normal.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brush {
    /// Square of the strength, 0 to 1.
    pub strength_squared: f32,
    /// Radians from 0 to π: a way has no sense.
    pub angle: f32,
}

impl Brush {
    const STRENGTHS: u32 = (1 << BRUSH_STRENGTH_BITS) - 1;
    const ANGLES: u32 = 1 << BRUSH_ANGLE_BITS;

    /// Of a material.
    pub(super) fn of(anisotropy: Anisotropy) -> Self {
        Self { strength_squared: anisotropy.strength * anisotropy.strength, angle: anisotropy.rotation }
    }

    /// As a number that is never computed with.
    pub fn packed(self) -> f32 {
        let strength = (self.strength_squared.clamp(0.0, 1.0) * Self::STRENGTHS as f32).round() as u32;
        let half_turns = (self.angle / std::f32::consts::PI).rem_euclid(1.0);
        let angle = (half_turns * Self::ANGLES as f32 + 0.5) as u32 % Self::ANGLES;
        f32::from_bits(1f32.to_bits() | angle << BRUSH_STRENGTH_BITS | strength)
    }

    /// Of a material.
    pub fn unpacked(bits: f32) -> Self {
        let bits = bits.to_bits();
        let strength_squared = (bits & Self::STRENGTHS) as f32 / Self::STRENGTHS as f32;
        let angle = (bits >> BRUSH_STRENGTH_BITS) % Self::ANGLES;
        Self { strength_squared, angle: angle as f32 * (std::f32::consts::PI / Self::ANGLES as f32) }
    }

    /// α along the rougher way and across it.
    pub fn alphas(self, alpha: f32) -> [f32; 2] {
        [alpha + (1.0 - alpha) * self.strength_squared, alpha]
    }

    /// α of even microfacets of the same solid angle.
    pub fn mean_alpha(self, alpha: f32) -> f32 {
        let [along, across] = self.alphas(alpha);
        (along * across).sqrt()
    }
}
