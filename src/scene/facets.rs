//! Facets: metal, plastic and the principled material, as surfaces of microfacets \[E40–E43\].
//!
//! - **Metal** reflects by its index: that of a name, or η and k; `ks` is a factor on it. With neither, `ks` is its colour head on.
//! - **Plastic** is matte (`kd`) under a clear coat of index `ior`; `ks` is a factor on what the coat reflects.
//! - **Principled** has a base colour (`kd`) and a part `metallic`: of that part it is metal of that colour, of the rest plastic.
//!   What lies over that, and how it reflects, is in `layers.rs`.
//! - A texture of the colour is the base colour at each place; of metal with an index it is a tint on what that reflects.
//! - Whatever its kind, roughness r is α = r² of GGX. Roughness and metallic part may be textures, too.

use super::layers;
use super::material::{GREY, WHITE};
use super::mtl::{At, Kind, RawMaterial};
use super::texture::{NumberMap, Texture};
use super::{Anisotropy, FacetKind, Facets, Inner, Material, Metallic};
use crate::spectrum::{self, BLACK, Bands};
use std::sync::Arc;

/// Index of refraction of a coat where nothing is said: that of most lacquers and plastics.
const COAT_IOR: f32 = 1.5;
/// α of GGX below which a surface is smooth.
const SMOOTH_ALPHA: f32 = 1e-4;
/// Roughness of a principled material where nothing is said.
pub(super) const PRINCIPLED_ROUGHNESS: f32 = 0.5;

/// What of it varies over the surface.
#[derive(Debug)]
pub(super) struct Numbers {
    /// Roughness.
    pub(super) roughness: Option<NumberMap>,
    /// Part that is metal.
    pub(super) metallic: Option<NumberMap>,
    /// What of the rest is metal is settled at each place.
    pub(super) is_rest: bool,
}

/// α of GGX, the most of it where it varies; `unstated` is a roughness.
fn alpha(raw: &RawMaterial, map: Option<&NumberMap>, unstated: f32) -> f32 {
    if let Some(map) = map {
        let [_, most] = map.range();
        return most * most;
    }
    let roughness = raw.pr.map_or(unstated, |pr| pr.value);
    raw.alpha.map_or(roughness * roughness, |alpha| alpha.value).clamp(0.0, 1.0)
}

/// The base colour, or the factor on a texture that is one, such that none reflects more than it gets.
fn base(raw: &RawMaterial, result: &Material) -> Bands {
    let (stated, most) = match &result.diffuse_texture {
        // in Blender's libraries the texture is all of the colour
        Some(texture) if raw.textured.is_some() => (WHITE, spectrum::from_rgb(texture.most())),
        Some(texture) => (result.diffuse, spectrum::from_rgb(texture.most())),
        // of a picture that could not be read a black factor says nothing
        None if raw.kd.is_some_and(|kd| raw.map_kd.is_none() || !spectrum::is_black(&kd.value)) => {
            (result.diffuse, WHITE)
        }
        None if raw.map_kd.is_none() && result.emits() => (BLACK, WHITE),
        None => (GREY, WHITE),
    };
    spectrum::scale(&stated, 1.0 / spectrum::max(&spectrum::mul(&stated, &most)).max(1.0))
}

/// Mean colour of a texture.
fn mean(texture: &Texture) -> Bands {
    spectrum::from_rgb(texture.mean()).map(|x| x.min(1.0))
}

/// Give a material the lobes of metal, plastic or a principled surface; says whether it is of such a kind.
pub(super) fn apply(
    raw: &RawMaterial,
    kind: Kind,
    numbers: Numbers,
    result: &mut Material,
    warn: &mut impl FnMut(Option<usize>, &str),
) -> bool {
    let within = |stated: Option<At<Bands>>, unstated: Bands| {
        stated.map_or(unstated, |x| x.value).map(|x| x.clamp(0.0, 1.0))
    };
    // exporters that do not know the index write 0
    let ior = raw.ni.filter(|ni| ni.value != 0.0).map_or(COAT_IOR, |ni| ni.value);
    let is_textured = result.diffuse_texture.is_some();
    let Numbers { roughness, metallic, is_rest } = numbers;
    let alpha = |unstated| alpha(raw, roughness.as_ref(), unstated);
    match kind {
        Kind::Metal => {
            result.glossy = match &result.diffuse_texture {
                Some(texture) => {
                    result.metallic = Some(Metallic { most: 1.0, map: None });
                    let factor = base(raw, result);
                    result.diffuse = factor;
                    spectrum::mul(&mean(texture), &factor)
                }
                None => {
                    result.diffuse = BLACK;
                    within(raw.ks.or(raw.kd), WHITE)
                }
            };
            let named = raw.metal.as_ref().map(|metal| metal.to_rgb());
            let stated = named.or_else(|| Some([raw.eta?.value, raw.k?.value]));
            let kind = match stated {
                Some([eta, k]) => FacetKind::Conductor { eta, k },
                None => FacetKind::Schlick { ior: 1.0 },
            };
            result.metal = raw.metal.clone().map(Arc::new);
            result.facets = Some(Facets { alpha: alpha(0.0), kind });
        }
        Kind::Plastic => {
            result.diffuse = base(raw, result);
            if is_textured && raw.saturated.is_some_and(|s| s.value) {
                warn(None, "saturated means nothing beside a texture");
            }
            result.glossy = within(raw.ks, WHITE);
            let inner = if raw.saturated.is_some_and(|s| s.value) { Inner::Coloured } else { Inner::Even };
            result.facets = Some(Facets { alpha: alpha(0.0), kind: FacetKind::Coat { ior, inner } });
        }
        Kind::Principled => {
            let factor = base(raw, result);
            let [least, most] = match &metallic {
                Some(map) => map.range(),
                None => [raw.pm.map_or(0.0, |pm| pm.value.clamp(0.0, 1.0)); 2],
            };
            let about = 0.5 * (least + most);
            let is_mixed = most > 0.0 && (is_textured || is_rest || least < most);
            let (head_on, _) = layers::of_dielectric(raw, ior);
            let colour = result.diffuse_texture.as_ref().map_or(factor, |t| spectrum::mul(&mean(t), &factor));
            result.diffuse = if is_mixed { factor } else { spectrum::scale(&factor, 1.0 - about) };
            result.glossy = std::array::from_fn(|b| head_on[b] + about * (colour[b] - head_on[b]));
            result.metallic = is_mixed.then_some(Metallic { most, map: metallic.filter(|_| least < most) });
            result.layers = layers::layers(raw, ior, about);
            let ior = result.layers.map_or(ior, |layers| layers::index_of(&layers.head_on));
            let kind = FacetKind::Schlick { ior };
            result.facets = Some(Facets { alpha: alpha(PRINCIPLED_ROUGHNESS), kind });
        }
        Kind::Glossy if raw.pr.is_some() || raw.alpha.is_some() || roughness.is_some() => {
            // a coat that reflects as much head on: what is matte lies under it
            let ks = within(raw.ks, BLACK);
            let root = spectrum::max(&ks).min(0.999).sqrt();
            result.glossy = ks;
            result.diffuse = base(raw, result);
            let kind = FacetKind::Schlick { ior: (1.0 + root) / (1.0 - root) };
            result.facets = (root > 0.0).then_some(Facets { alpha: alpha(0.0), kind });
        }
        Kind::Glass => {
            let alpha = alpha(0.0);
            result.facets = (alpha > 0.0).then_some(Facets { alpha, kind: FacetKind::Interface });
            result.roughness = roughness.filter(|_| result.facets.is_some());
            result.anisotropy = anisotropy(raw, result, warn);
            return false;
        }
        _ => return false,
    }
    result.roughness = roughness.filter(|_| result.facets.is_some());
    result.anisotropy = anisotropy(raw, result, warn);
    true
}

/// How the microfacets are brushed; smooth ones are not.
fn anisotropy(
    raw: &RawMaterial,
    result: &Material,
    warn: &mut impl FnMut(Option<usize>, &str),
) -> Option<Anisotropy> {
    let At { value, line } = raw.aniso.filter(|aniso| aniso.value > 0.0)?;
    if result.facets.is_none_or(|facets| facets.alpha < SMOOTH_ALPHA) {
        warn(Some(line), "anisotropy means nothing where it is smooth; give a roughness");
        return None;
    }
    let rotation = std::f32::consts::TAU * raw.anisor.map_or(0.0, |turns| turns.value);
    Some(Anisotropy { strength: value.min(1.0), rotation, is_around: false })
}
