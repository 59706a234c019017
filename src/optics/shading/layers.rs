//! What layers leave to the base under them: a clear coat, and sheen under that \[E50, E51\]. Twin: shaders/shading/layers.wgsl.

use crate::optics::shading::fresnel::of_clear_coat;
use crate::optics::shading::sheen;
use crate::packed::PackedMaterial;
use crate::spectrum::{Bands, scale};

/// What lies over a base.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layers {
    /// How much of a clear coat there is.
    clear_coat: f32,
    /// Largest band of the sheen's colour.
    sheen: f32,
    sheen_roughness: f32,
}

impl Layers {
    /// Those of a material; none where it has none.
    pub(super) fn over(m: &PackedMaterial) -> Option<Self> {
        let [sheen_roughness, sheen] = m.sheen_numbers();
        m.flags().is_layered().then_some(Self { clear_coat: m.clear_coat, sheen, sheen_roughness })
    }

    /// Part of the light at this cosine that they let through.
    pub(super) fn passed(&self, cosine: f32) -> f32 {
        let cosine = cosine.clamp(0.0, 1.0);
        let coat = 1.0 - of_clear_coat(self.clear_coat, cosine);
        if self.sheen > 0.0 {
            coat * (1.0 - self.sheen * sheen::albedo(self.sheen_roughness, cosine))
        } else {
            coat
        }
    }

    /// Factor on what the base sends from one cosine to another: the lesser of what passes at the two, so that light goes both ways alike
    /// and no more leaves than has arrived.
    pub(super) fn to_base(self, cos_i: f32, cos_o: f32) -> f32 {
        self.passed(cos_i).min(self.passed(cos_o))
    }
}

/// What a base sends from one cosine to another, under what may lie over it.
pub(super) fn covered(layers: Option<Layers>, sent: Bands, cos_i: f32, cos_o: f32) -> Bands {
    layers.map_or(sent, |layers| scale(&sent, layers.to_base(cos_i, cos_o)))
}
