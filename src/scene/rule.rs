//! The rule that turns what an MTL material says into a [`Material`].
//!
//! `illum` alone cannot decide: exporters write 2 for matte, glossy and light alike, and `Tf 1 1 1` for opaque.
//!
//! 1. **Emission** is Ke, radiance in W/(m² sr), from the front. An emitter keeps its other properties.
//! 2. **Glass** where illum is 4, 6, 7 or 9, or where illum is 5, 8 or 10 and the material says that it transmits
//!    (d < 1, Kt > 0, or Tf < 1 in a band but not black). Index: Ni as given, 1.0 included; below 1 it is kept too
//!    (a bubble); absent or 0 it is 1.5, with a warning. Tf, else Kt, multiplies what crosses the surface, at each
//!    crossing (a body filters twice); black or absent means 1. Ks multiplies what reflects; black or absent
//!    means 1. Kd is ignored.
//! 3. **Mirror** where illum is 3, 5 or 8: specular = Ks, diffuse = Kd.
//! 4. **Matte** where illum is 0 or 1: diffuse = Kd.
//! 5. Everything else (2, 10, absent): diffuse = Kd and, where Ks is not black, a **glossy** lobe Ks with exponent
//!    Ns, else 10; kept in 1 … 10⁶. Where the material states Pr, the lobe is of microfacets; where it states Pm, or Pr and no Ks,
//!    Pc or Ps, the material is principled (`facets.rs`, `layers.rs`). Glass is rough by Pr. map_Pr and map_Pm stand in place of Pr and Pm.
//! 6. Kd absent: black where the material emits or has Ks, otherwise grey 0.5. map_Kd multiplies Kd; where Kd is black or
//!    absent it stands alone, and in Blender's libraries it always does. Where it cannot be read, such a Kd is grey 0.5.
//! 7. Where the reflectances sum to more than 1 in a band, with what is transmitted, all are scaled down by one factor; of a texture the
//!    largest texel counts.
//! 8. map_d is the opacity of what is opaque and does not shine: its own, else its luminance. d or Tr alone never make an
//!    opaque material transparent.

use super::facets::{self, Numbers};
use super::layers::{self, Rest, Transmitting};
use super::material::{GREY, WHITE};
use super::mtl::{At, Kind, OtherMap, RawMaterial, RawSpectra};
use super::texture::store::{Role, Store};
use super::texture::{Opacity, Relief, ReliefKind, Texture};
use super::warnings::{Named, Warnings};
use super::{Dielectric, Interior, Material, MaterialSpectra, Mixture};
use crate::spectrum::{self, BLACK, Bands, Spectrum};
use crate::{Error, Result};
use std::sync::Arc;

/// Index of refraction where glass gives none: window glass.
const DEFAULT_IOR: f32 = 1.5;
/// Indices of refraction beyond this are a mistake in the file (diamond has 2.4, silicon 4).
const IOR_ACCEPTED: std::ops::RangeInclusive<f32> = 0.1..=10.0;
/// Parts of a metal's index: silver in red has .05, aluminium in infrared 20.
const INDEX_ACCEPTED: std::ops::RangeInclusive<f32> = 1e-3..=100.0;
/// Phong exponent where a glossy material gives none.
const DEFAULT_EXPONENT: f32 = 10.0;
/// Phong exponents: below 1 the lobe is all but diffuse, above 10⁶ it is a mirror to f32.
const EXPONENT_RANGE: std::ops::RangeInclusive<f32> = 1.0..=1e6;
/// A glass whose ignored Kd exceeds this was meant to have a body colour.
const NOTICED_DIFFUSE: f32 = 0.05;
/// Height of what `-bm 1` makes white, in widths of the picture: libraries know no unit.
const BUMP_UNIT: f32 = 0.01;
/// Reflectances may exceed 1 by this much: the rounding of decimal text.
const ALBEDO_SLACK: f32 = 1e-6;

/// Applies the rule; fails where a value is negative or not finite, or where a picture that a scene file names cannot be read.
pub(crate) fn material(raw: &RawMaterial, textures: &mut Store, warnings: &mut Warnings) -> Result<Material> {
    check(raw)?;
    let mut warn = |line: Option<usize>, what: &str| warn_of(raw, warnings, line, what);
    match layers::transmitting(raw, facets::PRINCIPLED_ROUGHNESS, &mut warn) {
        Some(transmitting) => transmits_in_part(raw, transmitting, textures, warnings),
        None => whole(raw, false, textures, warnings),
    }
}

/// A principled material that is glass, all of it or in part.
fn transmits_in_part(
    raw: &RawMaterial,
    Transmitting { mut glass, rest }: Transmitting,
    textures: &mut Store,
    warnings: &mut Warnings,
) -> Result<Material> {
    let tint = match glass.map_kd.take() {
        Some(stated) => textures.texture(&stated, Role::Colour, warnings)?,
        None => None,
    };
    let [transmission_map, metallic_map] = [&raw.map_transmission, &raw.map_pm].map(|stated| match stated {
        Some(stated) => textures.number(stated, warnings),
        None => Ok(None),
    });
    let (transmission_map, metallic_map) = (transmission_map?, metallic_map?);
    let mut result = whole(&glass, false, textures, warnings)?;
    result.diffuse_texture = tint;
    if let Some(Rest { raw: mut rest, transmission, metallic, varies }) = rest {
        // they have been told of
        rest.other_maps.clear();
        let rest = Box::new(whole(&rest, varies, textures, warnings)?);
        result.mixture =
            Some(Mixture { transmission, transmission_map, metallic, metallic_map, rest, number: 0 });
    }
    Ok(result)
}

/// A material that is the same thing all over; `is_rest` of one that is not: what of it is metal is settled at each place.
fn whole(
    raw: &RawMaterial,
    is_rest: bool,
    textures: &mut Store,
    warnings: &mut Warnings,
) -> Result<Material> {
    let kind = raw.kind.unwrap_or_else(|| kind(raw));
    let colour = match raw.map_kd.as_ref().filter(|_| kind != Kind::Glass) {
        Some(stated) => textures.texture(stated, Role::Colour, warnings)?,
        None => None,
    };
    let opacity = opacity(raw, kind, textures, warnings)?;
    let [roughness, metallic] = [raw.map_pr.as_ref(), raw.map_pm.as_ref()].map(|stated| match stated {
        Some(stated) => textures.number(stated, warnings),
        None => Ok(None),
    });
    let relief = relief(raw, textures, warnings)?;
    let emission = emission(raw, textures, warnings)?;
    let numbers = Numbers { roughness: roughness?, metallic: metallic?, is_rest };
    let mut warn = |line: Option<usize>, what: &str| warn_of(raw, warnings, line, what);
    for OtherMap { key, line, .. } in &raw.other_maps {
        warn(Some(*line), &format!("{key} is not read; its plain value is used"));
    }
    let ks = raw.ks.map_or(BLACK, |ks| ks.value);
    let mut result = Material::matte(raw.name.clone(), BLACK);
    if let Some((key, line)) = stated_of_interior(raw).filter(|_| kind != Kind::Glass) {
        let what = format!("material \"{}\": {key} of what is no glass", raw.name);
        return Err(Error::scene(&raw.file, Some(line), what, "give type = \"glass\", or leave it out"));
    }
    if let Some(transmit) = raw.transmit.filter(|_| !is_matte(raw, kind)) {
        let what = format!("material \"{}\": transmit of what is not matte", raw.name);
        let remedy = "give type = \"matte\", or \"glossy\" with an exponent; bodies of glass have tint";
        return Err(Error::scene(&raw.file, Some(transmit.line), what, remedy));
    }
    result.relief = relief;
    (result.emission, result.emission_texture) = emission;
    if kind == Kind::Glass {
        if let Some(kd) = raw.kd.filter(|kd| spectrum::max(&kd.value) > NOTICED_DIFFUSE) {
            warn(Some(kd.line), "Kd of a glass is ignored");
        }
        if let Some(stated) = raw.map_kd.as_ref().or(raw.map_d.as_ref()) {
            warn(Some(stated.line), "textures of a glass are not read");
        }
        result.dielectric = Some(dielectric(raw, &mut warn));
        result.interior = Interior {
            absorption: raw.absorption.map_or(BLACK, |a| a.value),
            priority: raw.priority.map(|p| p.value),
        };
        facets::apply(raw, kind, numbers, &mut result, &mut warn);
        result.spectra = spectra(raw, kind, false);
        return Ok(result);
    }
    if opacity.is_none() && raw.map_d.is_none() && transmits_like_cutout(raw) {
        warn(raw.d.or(raw.tr).map(|d| d.line), "d and Tr are no cut-outs; it is opaque");
    }
    if (opacity.is_some() || raw.opacity.is_some()) && result.emits() {
        warn(raw.opacity.map(|o| o.line), "what shines is opaque: its opacity is ignored");
    }
    result.opacity = opacity.filter(|_| !result.emits());
    result.diffuse = diffuse(raw, kind, colour.as_ref(), &mut warn);
    // the largest texel says how much is reflected
    let most = colour.as_ref().map_or(WHITE, |texture| spectrum::from_rgb(texture.most()));
    result.diffuse_texture = colour;
    result.spectra = spectra(raw, kind, is_rest || numbers.metallic.is_some());
    match kind {
        _ if facets::apply(raw, kind, numbers, &mut result, &mut warn) => return Ok(result),
        Kind::Mirror => {
            let diffuse = spectrum::mul(&result.diffuse, &most);
            result.specular = raw.ks.map_or(mirror_default(raw, &diffuse), |ks| ks.value);
        }
        Kind::Glossy if !spectrum::is_black(&ks) => {
            result.glossy = ks;
            result.glossy_exponent = exponent(raw);
        }
        _ => {}
    }
    result.transmit = raw.transmit.map_or(BLACK, |transmit| transmit.value);
    let matte = spectrum::mul(&spectrum::add(&result.diffuse, &result.transmit), &most);
    let albedo = spectrum::add(&spectrum::add(&matte, &result.glossy), &result.specular);
    let largest = spectrum::max(&albedo);
    if largest > 1.0 {
        if largest > 1.0 + ALBEDO_SLACK {
            warn(None, "reflects more than it receives; its reflectances are scaled down to a sum of 1");
        }
        for lobe in [&mut result.diffuse, &mut result.transmit, &mut result.glossy, &mut result.specular] {
            *lobe = spectrum::scale(lobe, 1.0 / largest);
        }
    }
    Ok(result)
}

/// Says what is done with a material.
fn warn_of(raw: &RawMaterial, warnings: &mut Warnings, line: Option<usize>, what: &str) {
    let what = format!(": {what}");
    let kind = Named { noun: ["material", "materials"], what: [&what, &what] };
    warnings.add_named(&raw.file, line.or(Some(raw.line)), kind, &raw.name, String::new);
}

/// What is stated by wavelength, for the lobes that a material of this kind has; none where nothing is. Where how much of it is metal
/// varies, `kd` is the colour of both.
fn spectra(raw: &RawMaterial, kind: Kind, is_mixed: bool) -> Option<Arc<MaterialSpectra>> {
    let RawSpectra { kd, ks, tf, transmit, ke, absorption, ni } = raw.spectra.clone();
    let of = |is_meant: bool, spectrum: Option<Spectrum>| spectrum.filter(|_| is_meant);
    let is_glass = kind == Kind::Glass;
    // what is diffuse then follows from its colour
    let is_half_metal = kind == Kind::Principled && !is_mixed && raw.pm.is_some_and(|pm| pm.value > 0.0);
    let spectra = MaterialSpectra {
        diffuse: of(!is_glass && !is_half_metal, kd),
        glossy: of(matches!(kind, Kind::Glossy | Kind::Metal | Kind::Plastic), ks.clone()),
        specular: of(is_glass || kind == Kind::Mirror, ks),
        transmission: if is_glass { tf } else { transmit },
        emission: ke,
        absorption: of(is_glass, absorption),
        index: ni.filter(|_| is_glass),
    };
    (!spectra.is_empty()).then(|| Arc::new(spectra))
}

/// A statement about the inside of a body, and its line.
fn stated_of_interior(raw: &RawMaterial) -> Option<(&'static str, usize)> {
    let absorption = raw.absorption.map(|a| ("absorption", a.line));
    absorption.or(raw.priority.map(|p| ("priority", p.line)))
}

/// True for what has no lobe but Lambert's and Phong's: none lies under a coat.
fn is_matte(raw: &RawMaterial, kind: Kind) -> bool {
    let has_facets = raw.pr.is_some() || raw.alpha.is_some() || raw.map_pr.is_some();
    kind == Kind::Matte || (kind == Kind::Glossy && !has_facets)
}

/// What `illum` and its companions ask for.
fn kind(raw: &RawMaterial) -> Kind {
    let illum = raw.illum.map_or(2, |illum| illum.value as i32);
    match illum {
        4 | 6 | 7 | 9 => Kind::Glass,
        5 | 8 | 10 if transmits(raw) => Kind::Glass,
        3 | 5 | 8 => Kind::Mirror,
        0 | 1 => Kind::Matte,
        _ if raw.pm.is_some() || raw.map_pm.is_some() || layers::has_any(raw) => Kind::Principled,
        _ if (raw.pr.is_some() || raw.map_pr.is_some()) && raw.ks.is_none() => Kind::Principled,
        _ => Kind::Glossy,
    }
}

fn transmits(raw: &RawMaterial) -> bool {
    let filters =
        raw.tf.is_some_and(|tf| tf.value.iter().any(|&t| t < 1.0) && !spectrum::is_black(&tf.value));
    filters || raw.kt.is_some_and(|kt| !spectrum::is_black(&kt.value)) || raw.d.is_some_and(|d| d.value < 1.0)
}

/// d < 1, or Tr strictly between opaque and clear: Tr 0 and Tr 1 both mean opaque in some exporter.
fn transmits_like_cutout(raw: &RawMaterial) -> bool {
    let opacity = raw.d.map(|d| d.value).or(raw.tr.filter(|tr| tr.value > 0.0).map(|tr| tr.value));
    opacity.is_some_and(|opacity| opacity < 1.0)
}

fn dielectric(raw: &RawMaterial, warn: &mut impl FnMut(Option<usize>, &str)) -> Dielectric {
    let tint = |stated: Option<At<Bands>>| stated.map(|t| t.value).filter(|t| !spectrum::is_black(t));
    // Exporters that do not know the index write 0.
    let ior = raw.ni.filter(|ni| ni.value != 0.0).map_or_else(
        || {
            if raw.kind.is_none() {
                warn(None, "glass without an index of refraction (Ni); 1.5 is used");
            }
            DEFAULT_IOR
        },
        |ni| ni.value,
    );
    let transmission = tint(raw.tf).or(tint(raw.kt)).unwrap_or(WHITE);
    let reflection = tint(raw.ks).unwrap_or(WHITE);
    if spectrum::max(&transmission) > 1.0 || spectrum::max(&reflection) > 1.0 {
        warn(raw.tf.map(|tf| tf.line), "a tint above 1 would make light; it is clamped to 1");
    }
    Dielectric {
        ior,
        reflection_tint: reflection.map(|t| t.min(1.0)),
        transmission_tint: transmission.map(|t| t.min(1.0)),
    }
}

/// Radiance, and the texture that it is multiplied by; in a library the texture stands alone where Ke is black.
fn emission(
    raw: &RawMaterial,
    textures: &mut Store,
    warnings: &mut Warnings,
) -> Result<(Bands, Option<Texture>)> {
    let plain = raw.ke.map_or(BLACK, |ke| ke.value);
    let Some(stated) = &raw.map_ke else { return Ok((plain, None)) };
    let Some(texture) = textures.texture(stated, Role::Emission, warnings)? else { return Ok((plain, None)) };
    let stands_alone = spectrum::is_black(&plain) && !stated.is_required;
    let factor = if stands_alone { WHITE } else { plain };
    // a black picture is no light
    let shines = texture.most() != [0.0; 3] && !spectrum::is_black(&factor);
    Ok(if shines { (factor, Some(texture)) } else { (BLACK, None) })
}

/// Which way the surface faces beside its triangles.
fn relief(raw: &RawMaterial, textures: &mut Store, warnings: &mut Warnings) -> Result<Option<Relief>> {
    let Some(stated) = raw.norm.as_ref().or(raw.bump.as_ref()) else { return Ok(None) };
    let Some(texture) = textures.texture(stated, Role::Number, warnings)? else { return Ok(None) };
    let is_library = !stated.is_required;
    let normals = ReliefKind::Normals { strength: stated.relief };
    let kind = if raw.norm.is_some() {
        normals
    } else if is_library && texture.bitmap.is_of_normals() {
        let what = format!("{} has the colours of normals and is read so", stated.what());
        warnings.add(&raw.file, Some(stated.line), what);
        normals
    } else {
        let height = stated.relief * if is_library { BUMP_UNIT } else { 1.0 };
        ReliefKind::Heights { channel: stated.channel, height, is_relative: is_library }
    };
    Ok(Some(Relief { texture, kind }))
}

/// How much of a surface is there; none where all of it is.
fn opacity(
    raw: &RawMaterial,
    kind: Kind,
    textures: &mut Store,
    warnings: &mut Warnings,
) -> Result<Option<Opacity>> {
    if kind == Kind::Glass {
        return Ok(None);
    }
    let texture = match &raw.map_d {
        Some(stated) => textures.texture(stated, Role::Opacity, warnings)?,
        None => None,
    };
    let factor = raw.opacity.map_or(1.0, |opacity| opacity.value);
    Ok((texture.is_some() || factor < 1.0).then_some(Opacity { factor, texture }))
}

fn diffuse(
    raw: &RawMaterial,
    kind: Kind,
    texture: Option<&Texture>,
    warn: &mut impl FnMut(Option<usize>, &str),
) -> Bands {
    let stated = raw.kd.map(|kd| kd.value);
    if texture.is_some() {
        let alone = raw.textured.unwrap_or(WHITE);
        return stated.filter(|kd| raw.textured.is_none() && !spectrum::is_black(kd)).unwrap_or(alone);
    }
    if raw.map_kd.is_some() && stated.is_none_or(|kd| spectrum::is_black(&kd)) {
        return GREY;
    }
    stated.unwrap_or_else(|| {
        let shines = |value: Option<At<Bands>>| value.is_some_and(|v| !spectrum::is_black(&v.value));
        if shines(raw.ke) || raw.map_ke.is_some() || shines(raw.ks) || kind == Kind::Mirror {
            return BLACK;
        }
        if raw.kind.is_none() {
            warn(None, "no Kd; grey 0.5 is used");
        }
        // or what is left of what is not transmitted
        raw.transmit
            .map_or(GREY, |through| std::array::from_fn(|b| GREY[b].min((1.0 - through.value[b]).max(0.0))))
    })
}

/// A mirror that a scene file asks for without Ks reflects all that Kd leaves; one of an MTL reflects nothing.
fn mirror_default(raw: &RawMaterial, diffuse: &Bands) -> Bands {
    match raw.kind {
        None => BLACK,
        Some(_) => diffuse.map(|kd| (1.0 - kd).max(0.0)),
    }
}

fn exponent(raw: &RawMaterial) -> f32 {
    let exponent = raw.ns.map_or(DEFAULT_EXPONENT, |ns| ns.value);
    exponent.clamp(*EXPONENT_RANGE.start(), *EXPONENT_RANGE.end())
}

/// Negative and non-finite values are errors: no repair could guess what was meant.
fn check(raw: &RawMaterial) -> Result<()> {
    let fail = |line: usize, key: &str, what: &str| {
        let what = format!("material \"{}\": {key} {what}", raw.name);
        Err(Error::scene(&raw.file, Some(line), what, "give finite values of at least 0"))
    };
    let bands = [
        ("Kd", raw.kd),
        ("Ks", raw.ks),
        ("Ke", raw.ke),
        ("Tf", raw.tf),
        ("Kt", raw.kt),
        ("transmit", raw.transmit),
        ("eta", raw.eta),
        ("k", raw.k),
    ];
    for (key, value) in bands {
        let Some(At { value, line }) = value else { continue };
        if value.iter().any(|band| !band.is_finite()) {
            return fail(line, key, "is not finite");
        }
        if value.iter().any(|&band| band < 0.0) {
            return fail(line, key, "is negative");
        }
        if matches!(key, "eta" | "k") && value.iter().any(|part| !INDEX_ACCEPTED.contains(part)) {
            let what = format!("material \"{}\": {key} of a metal's index {value:?}", raw.name);
            let remedy = "give values from 0.001 to 100 (gold in red: eta 0.2, k 3.3)";
            return Err(Error::scene(&raw.file, Some(line), what, remedy));
        }
    }
    let numbers = [
        ("Ns", raw.ns),
        ("Pr", raw.pr),
        ("Pm", raw.pm),
        ("alpha", raw.alpha),
        ("aniso", raw.aniso),
        ("anisor", raw.anisor),
        ("d", raw.d),
        ("Tr", raw.tr),
        ("illum", raw.illum),
    ];
    for (key, value) in numbers {
        let Some(At { value, line }) = value else { continue };
        if !value.is_finite() {
            return fail(line, key, "is not finite");
        }
        if matches!(key, "Pr" | "Pm" | "alpha" | "aniso") && !(0.0..=1.0).contains(&value) {
            // what a scene file says is meant; libraries hold all sorts of numbers
            if value < 0.0 || raw.kind.is_some() && !raw.is_of_blender {
                let what = format!("material \"{}\": {} of {value}", raw.name, in_words(key));
                return Err(Error::scene(&raw.file, Some(line), what, "give 0 to 1"));
            }
        }
    }
    layers::check(raw)?;
    match raw.ni {
        Some(At { value, line })
            if !value.is_finite() || (value != 0.0 && !ior_accepted(raw).contains(&value)) =>
        {
            let what = format!("material \"{}\": index of refraction {value}", raw.name);
            Err(Error::scene(
                &raw.file,
                Some(line),
                what,
                "give an index from 0.1 to 10, of a coat from 1 (water 1.33, glass 1.5)",
            ))
        }
        _ => Ok(()),
    }
}

/// Indices that a material of this kind may have.
fn ior_accepted(raw: &RawMaterial) -> std::ops::RangeInclusive<f32> {
    match raw.kind.unwrap_or_else(|| kind(raw)) {
        Kind::Glass => IOR_ACCEPTED,
        Kind::Plastic | Kind::Principled => 1.0..=*IOR_ACCEPTED.end(),
        _ => f32::MIN..=f32::MAX,
    }
}

/// What a scene file calls a statement of a library.
fn in_words(key: &str) -> &str {
    match key {
        "Pr" => "roughness",
        "Pm" => "metallic",
        "aniso" => "anisotropy",
        key => key,
    }
}
