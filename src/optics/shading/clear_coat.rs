//! A clear coat of index 1.5 over all else: a lobe of GGX's microfacets that reflect by Schlick's formula \[E50\]. Twin:
//! shaders/shading/clear_coat.wgsl.

use crate::optics::shading::fresnel::Fresnel;
use crate::optics::shading::microfacet::{Ggx, Microfacet};
use crate::packed::PackedMaterial;

/// The lobe of a material's coat, seen at this cosine to the normal.
pub(super) fn lobe(m: &PackedMaterial, cosine: f32) -> Microfacet {
    Microfacet::once(Fresnel::of_clear_coat(m.clear_coat), Ggx::even(m.clear_coat_alpha), cosine)
}
