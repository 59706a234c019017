//! Facets: metal, plastic and the principled material, as surfaces of microfacets \[E40–E43\].
//!
//! - **Metal** reflects by its index: that of a name, or η and k; `ks` is a factor on it. With neither, `ks` is its colour head on.
//! - **Plastic** is matte (`kd`) under a clear coat of index `ior`; `ks` is a factor on what the coat reflects.
//! - **Principled** has a base colour (`kd`) and a part `metallic`: of that part it is metal of that colour, of the rest plastic.
//! - A texture is the colour of what is diffuse; metal, whose colour is one, has its mean.
//! - Whatever its kind, roughness r is α = r² of GGX.

use super::material::GREY;
use super::mtl::{At, Kind, RawMaterial};
use super::texture::Texture;
use super::{FacetKind, Facets, Inner, Material};
use crate::spectrum::{self, BANDS, BLACK, Bands};
use std::sync::Arc;

/// All light.
const WHITE: Bands = [1.0; BANDS];
/// Index of refraction of a coat where nothing is said: that of most lacquers and plastics.
const COAT_IOR: f32 = 1.5;
/// Roughness of a principled material where nothing is said.
const PRINCIPLED_ROUGHNESS: f32 = 0.5;

/// α of GGX; `unstated` is a roughness.
pub(super) fn alpha(raw: &RawMaterial, unstated: f32) -> f32 {
    let roughness = raw.pr.map_or(unstated, |pr| pr.value);
    raw.alpha.map_or(roughness * roughness, |alpha| alpha.value).clamp(0.0, 1.0)
}

/// Factor on a texture that is the base colour, such that none of its texels reflects more than it gets; none where there is no texture.
fn base(raw: &RawMaterial, result: &Material) -> Option<Bands> {
    let texture = result.diffuse_texture.as_ref()?;
    // in Blender's libraries the texture is all of the colour
    let stated = if raw.textured.is_some() { WHITE } else { result.diffuse };
    let most = spectrum::mul(&stated, &spectrum::from_rgb(texture.most()));
    Some(spectrum::scale(&stated, 1.0 / spectrum::max(&most).max(1.0)))
}

/// Mean colour of a texture.
fn mean(texture: &Texture) -> Bands {
    spectrum::from_rgb(texture.mean()).map(|x| x.min(1.0))
}

/// Give a material the lobes of metal, plastic or a principled surface; says whether it is of such a kind.
pub(super) fn apply(raw: &RawMaterial, kind: Kind, result: &mut Material) -> bool {
    let within = |stated: Option<At<Bands>>, unstated: Bands| {
        stated.map_or(unstated, |x| x.value).map(|x| x.clamp(0.0, 1.0))
    };
    let ior = raw.ni.map_or(COAT_IOR, |ni| ni.value.max(1.0));
    match kind {
        Kind::Metal => {
            result.diffuse = BLACK;
            let texture = result.diffuse_texture.take();
            result.glossy = texture.map_or(within(raw.ks.or(raw.kd), WHITE), |t| mean(&t));
            let named = raw.metal.as_ref().map(|metal| metal.to_rgb());
            let stated = named.or_else(|| Some([raw.eta?.value, raw.k?.value]));
            let kind = match stated {
                Some([eta, k]) => FacetKind::Conductor { eta, k },
                None => FacetKind::Schlick { ior: 1.0 },
            };
            result.metal = raw.metal.clone().map(Arc::new);
            result.facets = Some(Facets { alpha: alpha(raw, 0.0), kind });
        }
        Kind::Plastic => {
            result.diffuse = base(raw, result).unwrap_or(within(raw.kd, GREY));
            result.glossy = within(raw.ks, WHITE);
            let inner = if raw.saturated.is_some_and(|s| s.value) { Inner::Coloured } else { Inner::Even };
            result.facets = Some(Facets { alpha: alpha(raw, 0.0), kind: FacetKind::Coat { ior, inner } });
        }
        Kind::Principled => {
            let textured = base(raw, result);
            let factor = textured.unwrap_or(within(raw.kd, GREY));
            let metallic = raw.pm.map_or(0.0, |pm| pm.value.clamp(0.0, 1.0));
            let head_on = ((ior - 1.0) / (ior + 1.0)).powi(2);
            let colour = result.diffuse_texture.as_ref().map_or(factor, |t| spectrum::mul(&mean(t), &factor));
            result.diffuse = spectrum::scale(&factor, 1.0 - metallic);
            result.glossy = colour.map(|colour| head_on + metallic * (colour - head_on));
            let kind = FacetKind::Schlick { ior };
            result.facets = Some(Facets { alpha: alpha(raw, PRINCIPLED_ROUGHNESS), kind });
        }
        Kind::Glossy if raw.pr.is_some() || raw.alpha.is_some() => {
            // a coat that reflects as much head on: what is matte lies under it
            let ks = within(raw.ks, BLACK);
            let root = spectrum::max(&ks).min(0.999).sqrt();
            result.glossy = ks;
            let kind = FacetKind::Schlick { ior: (1.0 + root) / (1.0 - root) };
            result.facets = (root > 0.0).then_some(Facets { alpha: alpha(raw, 0.0), kind });
        }
        Kind::Glass => {
            let alpha = alpha(raw, 0.0);
            result.facets = (alpha > 0.0).then_some(Facets { alpha, kind: FacetKind::Interface });
            return false;
        }
        _ => return false,
    }
    true
}
