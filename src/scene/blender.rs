//! Blender: what the materials mean that its OBJ exporter writes.
//!
//! The exporter puts the values of its principled surface into statements that mean something else elsewhere: Ks is the level of the
//! reflection of a dielectric, of which 0.5 is an index of 1.5; Ns tells the roughness r as 1000 (1 − r)²; illum 3 is metal, by Pm or Ka,
//! whose colour is Kd; and Tf, which PBR extensions add, is the part of the light that is transmitted. Without these extensions the
//! picture of the roughness is map_Ns, and that of the metallic part map_refl.

use super::mtl::{At, Kind, RawMaterial};
use super::texture::stated::StatedTexture;
use crate::spectrum::{self, BANDS};

/// Reflectance at normal incidence where Ks is 1.
const REFLECTANCE: f32 = 0.08;
/// Exponent Ns where nothing is rough.
const NS_MOST: f32 = 1000.0;

/// State a material as the other rules read it.
pub(crate) fn restate(raw: &mut RawMaterial) {
    let from_ns = |ns: f32| 1.0 - (ns.clamp(0.0, NS_MOST) / NS_MOST).sqrt();
    let roughness = raw.pr.or(raw.ns.map(|ns| At { value: from_ns(ns.value), line: ns.line }));
    let is_metal = raw.illum.is_some_and(|illum| illum.value == 3.0);
    let from_ka = raw.ka.filter(|_| is_metal).map(|ka| spectrum::max(&ka.value));
    let metallic = raw.pm.map(|pm| pm.value).or(from_ka).unwrap_or(0.0).clamp(0.0, 1.0);
    let transmission = raw.tf.map(|tf| At { value: spectrum::max(&tf.value).clamp(0.0, 1.0), line: tf.line });
    let transmission = transmission.filter(|t| t.value > 0.0);
    raw.map_pr = raw.map_pr.take().or_else(|| other_map(raw, "map_ns"));
    raw.map_pm = raw.map_pm.take().or_else(|| other_map(raw, "map_refl"));
    // a texture is the whole of the colour
    raw.textured = raw.map_kd.as_ref().map(|_| [1.0 - metallic; BANDS]);
    (raw.pr, raw.ns) = (roughness, None);
    let is_all_glass = metallic == 0.0 && raw.map_pm.is_none();
    if is_all_glass && transmission.is_some_and(|t| t.value == 1.0) {
        raw.kind = Some(Kind::Glass);
        // it passes two faces
        raw.tf = raw.kd.map(|kd| At { value: kd.value.map(|v| v.max(0.0).sqrt()), ..kd });
        (raw.kd, raw.ks) = (None, None);
    } else {
        raw.kind = Some(Kind::Principled);
        let head_on = raw.ks.map_or(0.5, |ks| spectrum::max(&ks.value)) * REFLECTANCE;
        let root = head_on.clamp(0.0, 0.9).sqrt();
        let of_ks = At { value: (1.0 + root) / (1.0 - root), line: raw.ni.map_or(raw.line, |ni| ni.line) };
        // of glass the index itself
        raw.ni = raw.ni.filter(|ni| transmission.is_some() && ni.value >= 1.0).or(Some(of_ks));
        raw.layers.transmission = transmission;
        raw.pm = Some(At { value: metallic, line: raw.line }).filter(|_| raw.map_pm.is_none());
        (raw.ks, raw.tf) = (None, None);
    }
}

/// Takes a texture that other libraries mean otherwise.
fn other_map(raw: &mut RawMaterial, key: &str) -> Option<StatedTexture> {
    let at = raw.other_maps.iter().position(|map| map.key == key && map.stated.is_some())?;
    raw.other_maps.remove(at).stated
}
