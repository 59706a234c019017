//! Layers: what a principled material has over its base, as glTF's extensions say it: a clear coat, sheen, and how much its dielectric part
//! reflects \[E50–E52\]; and what it lets through.
//!
//! - **Clear coat** of index 1.5 over everything else: `clearcoat` is how much of it is there, 0 to 1.
//! - **Sheen**, of fibres, between the coat and the base: a colour, and a roughness.
//! - **Specular**: a factor on what the dielectric part reflects, and a colour on what it reflects head on.
//! - **Transmission**: how much of what is no metal is glass \[E57\].

use super::Layers;
use super::material::WHITE;
use super::mtl::{At, Kind, RawLayers, RawMaterial};
use super::table::Table;
use crate::spectrum::{self, BLACK, Bands};
use crate::{Error, Result};

/// Keys of scene files that this file reads.
pub(super) const KEYS: [&str; 7] = [
    "clearcoat",
    "clearcoat_roughness",
    "sheen_color",
    "sheen_roughness",
    "specular",
    "specular_color",
    "transmission",
];

/// Sheen that is less rough than this reflects more than it gets at grazing angles: it counts as this rough.
const SHEEN_ROUGHNESS_LEAST: f32 = 0.3;

/// What a scene file says of them in numbers; transmission may be a texture.
pub(super) fn read(table: &Table, has_map: bool) -> Result<RawLayers> {
    let single = |key| Ok::<_, Error>(table.number(key)?.map(|v| At { value: v.value as f32, line: v.line }));
    Ok(RawLayers {
        clear_coat: single("clearcoat")?,
        clear_coat_roughness: single("clearcoat_roughness")?,
        sheen: table.bands("sheen_color")?,
        sheen_roughness: single("sheen_roughness")?,
        specular: single("specular")?,
        specular_colour: table.bands("specular_color")?,
        transmission: if has_map { None } else { single("transmission")? },
    })
}

/// Of two statements about each the second counts.
pub(super) fn overridden(first: RawLayers, second: &RawLayers) -> RawLayers {
    RawLayers {
        clear_coat: second.clear_coat.or(first.clear_coat),
        clear_coat_roughness: second.clear_coat_roughness.or(first.clear_coat_roughness),
        sheen: second.sheen.or(first.sheen),
        sheen_roughness: second.sheen_roughness.or(first.sheen_roughness),
        specular: second.specular.or(first.specular),
        specular_colour: second.specular_colour.or(first.specular_colour),
        transmission: second.transmission.or(first.transmission),
    }
}

/// Numbers from 0 to 1, and colours that none is negative of; libraries hold all sorts of numbers, which are cut where they are used.
pub(super) fn check(raw: &RawMaterial) -> Result<()> {
    let of = &raw.layers;
    let is_of_library = raw.kind.is_none() || raw.is_of_blender;
    let words = if is_of_library { ["Pc", "Pcr", "Ps"] } else { [KEYS[0], KEYS[1], KEYS[2]] };
    let fault = |key: &str, line: usize, value: &dyn std::fmt::Debug, remedy: &str| {
        let what = format!("material \"{}\": {key} of {value:?}", raw.name);
        Err(Error::scene(&raw.file, Some(line), what, remedy))
    };
    let numbers = [
        (words[0], of.clear_coat),
        (words[1], of.clear_coat_roughness),
        (KEYS[3], of.sheen_roughness),
        (KEYS[4], of.specular),
        (KEYS[6], of.transmission),
    ];
    for (key, stated) in numbers {
        let Some(At { value, line }) = stated else { continue };
        if !value.is_finite() || value < 0.0 || (value > 1.0 && !is_of_library) {
            return fault(key, line, &value, "give 0 to 1");
        }
    }
    for (key, stated, most) in [(words[2], of.sheen, 1.0), (KEYS[5], of.specular_colour, f32::MAX)] {
        let Some(At { value, line }) = stated else { continue };
        let is_accepted = |x: &f32| x.is_finite() && *x >= 0.0 && (*x <= most || is_of_library);
        if !value.iter().all(is_accepted) {
            let remedy = if most == 1.0 { "give 0 to 1 per band" } else { "give numbers of at least 0" };
            return fault(key, line, &value, remedy);
        }
    }
    Ok(())
}

/// True where a library asks for a layer: its material is a principled one.
pub(super) fn has_any(raw: &RawMaterial) -> bool {
    let coat = raw.layers.clear_coat.is_some_and(|coat| coat.value > 0.0);
    coat || raw.layers.sheen.is_some_and(|sheen| !spectrum::is_black(&sheen.value))
}

/// What is reflected head on by the dielectric part, per band, of index `ior`; and at grazing angles.
pub(super) fn of_dielectric(raw: &RawMaterial, ior: f32) -> (Bands, f32) {
    let weight = raw.layers.specular.map_or(1.0, |s| s.value).clamp(0.0, 1.0);
    let colour = raw.layers.specular_colour.map_or(WHITE, |c| c.value);
    let head_on = ((ior - 1.0) / (ior + 1.0)).powi(2);
    (colour.map(|c| (head_on * c).min(1.0) * weight), weight)
}

/// The layers of a principled material, whose base is `metallic` where that is the same all over; none where it has none.
pub(super) fn layers(raw: &RawMaterial, ior: f32, metallic: f32) -> Option<Layers> {
    let of = &raw.layers;
    let within =
        |stated: Option<At<f32>>, unstated: f32| stated.map_or(unstated, |x| x.value.clamp(0.0, 1.0));
    let (head_on, grazing) = of_dielectric(raw, ior);
    let sheen = of.sheen.map_or(BLACK, |sheen| sheen.value.map(|x| x.clamp(0.0, 1.0)));
    let clear_coat = within(of.clear_coat, 0.0);
    let is_plain = grazing == 1.0 && of.specular_colour.is_none_or(|colour| colour.value == WHITE);
    if clear_coat == 0.0 && spectrum::is_black(&sheen) && is_plain {
        return None;
    }
    Some(Layers {
        clear_coat,
        clear_coat_alpha: within(of.clear_coat_roughness, 0.0).powi(2),
        sheen,
        sheen_roughness: within(of.sheen_roughness, Layers::PLAIN.sheen_roughness).max(SHEEN_ROUGHNESS_LEAST),
        head_on,
        grazing,
        metallic,
    })
}

/// Index of the grey coat over a base that reflects at most this head on.
pub(super) fn index_of(head_on: &Bands) -> f32 {
    let root = spectrum::max(head_on).min(0.999).sqrt();
    (1.0 + root) / (1.0 - root)
}

/// A principled material that transmits.
pub(super) struct Transmitting {
    /// It as the glass that it is; or the part of it that is glass …
    pub(super) glass: RawMaterial,
    /// … and the opaque rest.
    pub(super) rest: Option<Rest>,
}

/// What of a material is no glass.
pub(super) struct Rest {
    /// The material. Its metallic part is its own, or of all of the surface where it varies.
    pub(super) raw: RawMaterial,
    /// What is transmitted of what is no metal …
    pub(super) transmission: f32,
    /// … and the part that is metal: where these are stated by numbers.
    pub(super) metallic: f32,
    /// It is settled at each place what is metal.
    pub(super) varies: bool,
}

/// What of a material transmits; none where it is opaque. Where no roughness is stated it is `roughness`.
pub(super) fn transmitting(
    raw: &RawMaterial,
    roughness: f32,
    warn: &mut impl FnMut(Option<usize>, &str),
) -> Option<Transmitting> {
    if raw.kind != Some(Kind::Principled) {
        return None;
    }
    let stated = raw.layers.transmission;
    let line = stated.map(|t| t.line).or(raw.map_transmission.as_ref().map(|map| map.line))?;
    let transmission = stated.map_or(1.0, |t| t.value.clamp(0.0, 1.0));
    let metallic = raw.pm.map_or(0.0, |pm| pm.value.clamp(0.0, 1.0));
    let maps = [&raw.map_transmission, &raw.map_pm].map(Option::is_some);
    // metal lets nothing through
    let part = transmission * (1.0 - metallic);
    if part == 0.0 {
        return None;
    }
    let layers = RawLayers { transmission: None, ..raw.layers };
    let is_all_glass = part == 1.0 && maps == [false; 2];
    if let Some(line) = raw.opacity.map(|o| o.line).or(raw.map_d.as_ref().map(|map| map.line)) {
        // a body has no holes
        let is_opaque = part < 0.5;
        let what =
            if is_opaque { "transmission of what has an opacity" } else { "opacity of what transmits" };
        warn(Some(line), &format!("{what} is ignored"));
        if is_opaque {
            return None;
        }
    }
    if layers != RawLayers::default() {
        let what = if is_all_glass { "" } else { ", which lie over the rest of it alone" };
        warn(Some(line), &format!("clearcoat, sheen and specular of what transmits are ignored{what}"));
    }
    // a body is passed by two faces
    let is_thin = raw.thin.is_some_and(|thin| thin.value);
    let crossed = |kd: Bands| if is_thin { kd } else { kd.map(|x| x.max(0.0).sqrt()) };
    let is_plain = raw.pr.is_none() && raw.alpha.is_none() && raw.map_pr.is_none();
    let mut glass = RawMaterial {
        kind: Some(Kind::Glass),
        // a texture of Blender's libraries is the whole of the colour
        tf: raw.kd.filter(|_| raw.textured.is_none()).map(|kd| At { value: crossed(kd.value), ..kd }),
        pr: if is_plain { Some(At { value: roughness, line }) } else { raw.pr },
        layers: RawLayers::default(),
        opacity: None,
        map_d: None,
        ..raw.clone()
    };
    (glass.kd, glass.pm, glass.spectra.kd, glass.map_pm) = (None, None, None, None);
    let rest = (!is_all_glass).then(|| {
        let varies = maps != [false; 2] || (metallic > 0.0 && raw.map_kd.is_some());
        let own = if varies { metallic } else { metallic / (1.0 - part) };
        let mut rest = RawMaterial { layers, absorption: None, priority: None, ..raw.clone() };
        rest.pm = raw.pm.map(|pm| At { value: own, ..pm });
        (rest.map_transmission, rest.opacity, rest.map_d, rest.thin) = (None, None, None, None);
        (rest.spectra.absorption, rest.spectra.ni) = (None, None);
        Rest { raw: rest, transmission, metallic, varies }
    });
    Some(Transmitting { glass, rest })
}
