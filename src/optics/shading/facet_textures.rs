//! Microfacets whose roughness, or whose part that is metal, is looked up at each place \[E47\]. Twin:
//! shaders/shading/facet_textures.wgsl.

use super::mixture::Met;
use super::texture;
use crate::packed::constants::{FOLLOWED_ALPHA, SMOOTH_ALPHA};
use crate::packed::{MaterialFlags, PackedMaterial, Textures};
use crate::spectrum::{BLACK, is_black, scale};
use half::f16;

/// The material at texture coordinates, to who sees so much of these at once. Its `diffuse` is the colour of base and metal there,
/// over what its coat takes.
pub(super) fn at(
    m: &PackedMaterial,
    textures: &Textures,
    uv: [f32; 2],
    width: f32,
    met: Option<Met>,
) -> PackedMaterial {
    let number = |map: Option<u32>| map.map(|map| texture::number(textures, map, uv, width).min(1.0));
    let alpha = number(m.roughness_texture()).map_or(m.alpha, |roughness| roughness * roughness);
    let metallic = number(m.metallic_texture()).unwrap_or(m.metallic);
    // of what is glass in part what is stated is of all of it
    let rest = met.filter(|_| m.flags().is_mixed());
    let metallic = rest.map_or(metallic, |met| met.metallic_of_rest(metallic));
    // what a gather point keeps of them on a device
    let [alpha, metallic] = [alpha, metallic].map(|x| f16::from_f32(x).to_f32());
    let alpha = if alpha < SMOOTH_ALPHA { 0.0 } else { alpha };
    let mut result = PackedMaterial { alpha, metallic, ..*m };
    let flags = m.flags();
    if flags.is_dielectric() {
        if alpha == 0.0 {
            result.flag_bits &= !MaterialFlags::FACETS;
        }
        return result;
    }
    // where it is followed at some places and not at others the two say the same
    let mut tint = if flags.has_glossy() { m.glossy } else { m.specular };
    if flags.is_mixed() {
        let head_on = ((m.ior - 1.0) / (m.ior + 1.0)).powi(2);
        // of even light the coat lets in what it lets out
        let coat = if flags.is_coated() { m.coat_transmittance } else { 1.0 };
        tint = m.diffuse.map(|base| (1.0 - metallic) * head_on + metallic * (base * coat));
        if flags.is_layered() {
            // coloured, and what is diffuse lies under a grey coat
            tint = std::array::from_fn(|b| (1.0 - metallic) * m.iors[b] + metallic * (m.diffuse[b] * coat));
        }
        result.diffuse = scale(&m.diffuse, 1.0 - metallic);
    }
    let is_followed = m.brush().map_or(alpha, |brush| brush.mean_alpha(alpha)) <= FOLLOWED_ALPHA;
    (result.glossy, result.specular) = if is_followed { (BLACK, tint) } else { (tint, BLACK) };
    result.flag_bits &= !(MaterialFlags::GLOSSY | MaterialFlags::SPECULAR);
    if !is_black(&tint) {
        result.flag_bits |= if is_followed { MaterialFlags::SPECULAR } else { MaterialFlags::GLOSSY };
    }
    result
}
