//! Subset: the materials and lights that have a counterpart in Mitsuba; the rest is refused, with the reason.

use super::colour::Colour;
use super::{Fidelity, unsupported};
use crate::error::Result;
use crate::scene::texture::{Opacity, Texture};
use crate::scene::{Dielectric, FacetKind, Facets, Inner, Light, Material, Scene};
use crate::spectrum::glass::Index;
use crate::spectrum::metal::Metal;
use crate::spectrum::{Bands, Spectrum, is_black};
use std::path::Path;

/// What to do about a material of several lobes.
const ONE_LOBE: &str = "make it matte or a mirror: a [[material]] with type in the scene file";
/// α of GGX below which a surface is smooth.
const SMOOTH_ALPHA: f32 = 1e-4;

/// A material in the words of other renderers. Emission comes on top of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Look {
    /// What of it is there.
    pub(super) bsdf: Bsdf,
    /// How much of it is there; all of it where this is none.
    pub(super) opacity: Option<Opacity>,
}

/// What a surface does with light.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Bsdf {
    /// Lambertian on both sides.
    Diffuse(Colour),
    /// A perfect mirror on both sides.
    Mirror(Colour),
    /// Metal by its complex index on both sides; rough where α of GGX is above 0.
    Metal { eta: Colour, k: Colour, tint: Colour, alpha: f32 },
    /// Metal by its colour head on, rough.
    Tinted { colour: Colour, alpha: f32 },
    /// Matte under a clear coat, on both sides.
    Plastic { ior: f32, diffuse: Colour, reflectance: Colour, is_saturated: bool, alpha: f32 },
    /// The interface of a transparent body, which is behind the front; rough where α is above 0.
    Dielectric { dielectric: Dielectric, tints: [Colour; 2], alpha: f32 },
    /// Both interfaces of such a body in one place.
    Pane { dielectric: Dielectric, tints: [Colour; 2] },
}

impl Look {
    /// The counterpart of a material, by wavelength or in red, green and blue.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] where there is none.
    pub(super) fn of(
        material: &Material,
        by_wavelength: bool,
        fidelity: Fidelity,
        source: &Path,
    ) -> Result<Self> {
        let bsdf = counterpart(material, by_wavelength, fidelity).map_err(|refusal| {
            let what = format!("material \"{}\": {}", material.name, refusal.what);
            unsupported(source, what, refusal.remedy)
        })?;
        Ok(Self { bsdf, opacity: material.opacity.clone() })
    }

    /// Whether it is black: nothing but emission comes from it.
    pub(super) fn is_black(&self) -> bool {
        matches!(&self.bsdf, Bsdf::Diffuse(Colour::Bands(kd)) if is_black(kd))
    }

    /// Whether it mirrors or refracts.
    pub(super) fn is_specular(&self) -> bool {
        !matches!(self.bsdf, Bsdf::Diffuse(_))
    }

    /// Whether some picture lies on it.
    pub(super) fn has_texture(&self) -> bool {
        let colours: &[&Colour] = match &self.bsdf {
            Bsdf::Diffuse(kd) => &[kd],
            Bsdf::Metal { tint, .. } => &[tint],
            Bsdf::Tinted { colour, .. } => &[colour],
            Bsdf::Plastic { diffuse, .. } => &[diffuse],
            Bsdf::Mirror(_) | Bsdf::Dielectric { .. } | Bsdf::Pane { .. } => &[],
        };
        let is_picture = |colour: &&Colour| matches!(colour, Colour::Picture { .. });
        colours.iter().any(is_picture) || self.opacity.iter().any(|opacity| opacity.texture.is_some())
    }
}

/// Why a material has no counterpart.
struct Refusal {
    what: &'static str,
    remedy: &'static str,
}

fn refuse<T>(what: &'static str, remedy: &'static str) -> std::result::Result<T, Refusal> {
    Err(Refusal { what, remedy })
}

/// What of any material is refused, whatever it is else.
fn check(material: &Material, by_wavelength: bool) -> std::result::Result<(), Refusal> {
    if material.mixture.is_some() {
        return refuse(
            "what is glass in part is not written for other renderers",
            "make its transmission 0 or 1",
        );
    }
    if material.dielectric.is_some() && material.has_texture() {
        return refuse("glass with a picture is not written for other renderers", "give it a plain colour");
    }
    if material.layers.is_some() {
        let remedy = "make it plastic or metal: a [[material]] with type in the scene file";
        return refuse("its layers (principled) are not written for other renderers", remedy);
    }
    if material.relief.is_some() {
        return refuse("its normals or bumps are others there", "leave its normal and bump out");
    }
    if material.roughness.is_some() || material.anisotropy.is_some() {
        let remedy = "give it one roughness, and leave its anisotropy out";
        return refuse("roughness that varies by place or way is not written for other renderers", remedy);
    }
    if material.emission_texture.is_some() {
        let remedy = "give it a plain ke";
        return refuse("light from pictures is not written for other renderers", remedy);
    }
    if by_wavelength && material.surface_textures().next().is_some() {
        let remedy = "give it a plain kd, or write it in red, green and blue: --spectral off";
        return refuse("between colours of a texture, other renderers have other spectra", remedy);
    }
    if !is_black(&material.interior.absorption) {
        let remedy = "leave its absorption out, or give it a tint";
        return refuse("what its inside absorbs is not written for other renderers", remedy);
    }
    if material.interior.priority.is_some() {
        let remedy = "leave it out, and give each boundary an index over what is around it";
        return refuse("its priority has no counterpart in other renderers", remedy);
    }
    let index = material.spectra.as_deref().and_then(|spectra| spectra.index.as_ref());
    if by_wavelength && index.is_some_and(Index::is_dispersive) {
        let remedy = "give it one number as ior, or write it in red, green and blue: --spectral off";
        return refuse("glass that parts colours has no counterpart in other renderers", remedy);
    }
    if !is_black(&material.transmit) && material.dielectric.is_none() {
        let remedy = "leave its transmit out";
        return refuse("what it scatters through has no counterpart in other renderers", remedy);
    }
    Ok(())
}

fn counterpart(
    material: &Material,
    by_wavelength: bool,
    fidelity: Fidelity,
) -> std::result::Result<Bsdf, Refusal> {
    check(material, by_wavelength)?;
    let alpha = material.facets.map_or(0.0, |f| if f.alpha < SMOOTH_ALPHA { 0.0 } else { f.alpha });
    let nearest = nearest(material, alpha, by_wavelength)?;
    if alpha > 0.0 && fidelity == Fidelity::Exact {
        let remedy = "make it smooth (roughness = 0), or write it nearly (--near)";
        return refuse(
            "other renderers shadow rough surfaces by the product of both sides, and leave out what facets \
             mask from each other",
            remedy,
        );
    }
    Ok(nearest)
}

/// The nearest that there is.
fn nearest(material: &Material, alpha: f32, by_wavelength: bool) -> std::result::Result<Bsdf, Refusal> {
    let spectra = material.spectra.as_deref().filter(|_| by_wavelength);
    let stated = |bands: &Bands, spectrum: Option<&Spectrum>| {
        spectrum.map_or(Colour::Bands(*bands), Colour::reflectance)
    };
    if let Some(dielectric) = material.dielectric {
        let tints = [
            stated(&dielectric.reflection_tint, spectra.and_then(|s| s.specular.as_ref())),
            stated(&dielectric.transmission_tint, spectra.and_then(|s| s.transmission.as_ref())),
        ];
        if material.thin && alpha > 0.0 {
            return refuse(
                "rough panes have no counterpart in other renderers",
                "make it smooth (roughness = 0)",
            );
        }
        return Ok(match material.thin {
            true => Bsdf::Pane { dielectric, tints },
            false => Bsdf::Dielectric { dielectric, tints, alpha },
        });
    }
    let diffuse = match &material.diffuse_texture {
        Some(texture) => picture(texture, &material.diffuse),
        None => stated(&material.diffuse, spectra.and_then(|s| s.diffuse.as_ref())),
    };
    let glossy = stated(&material.glossy, spectra.and_then(|s| s.glossy.as_ref()));
    if let Some(Facets { kind, .. }) = material.facets {
        return faceted(material, kind, alpha, by_wavelength, diffuse, glossy);
    }
    if !is_black(&material.glossy) {
        return refuse("its glossy lobe (Phong) has no counterpart in other renderers", ONE_LOBE);
    }
    match (is_black(&material.diffuse), is_black(&material.specular)) {
        (_, true) => Ok(Bsdf::Diffuse(diffuse)),
        (true, false) => {
            Ok(Bsdf::Mirror(stated(&material.specular, spectra.and_then(|s| s.specular.as_ref()))))
        }
        // Mitsuba's blendbsdf weighs a mirror's direction by the Lambertian lobe, too, and changes its colour
        (false, false) => refuse(
            "its sum of a matte and a mirror lobe has no exact counterpart in other renderers",
            ONE_LOBE,
        ),
    }
}

fn faceted(
    material: &Material,
    kind: FacetKind,
    alpha: f32,
    by_wavelength: bool,
    diffuse: Colour,
    glossy: Colour,
) -> std::result::Result<Bsdf, Refusal> {
    match kind {
        FacetKind::Conductor { eta, k } => {
            let tint = if material.diffuse_texture.is_some() { diffuse } else { glossy };
            let named = material.metal.as_deref().cloned();
            let [eta, k] = match named.or_else(|| Metal::of_rgb(eta, k)).filter(|_| by_wavelength) {
                Some(metal) => Colour::index(&metal),
                None => [eta, k].map(Colour::Bands),
            };
            Ok(Bsdf::Metal { eta, k, tint, alpha })
        }
        FacetKind::Coat { inner: Inner::Coloured, .. } if material.diffuse_texture.is_some() => {
            refuse("a texture under a coat that saturates is another one there", "leave saturated out")
        }
        FacetKind::Coat { ior, inner } if inner != Inner::Once => {
            let is_saturated = inner == Inner::Coloured;
            Ok(Bsdf::Plastic { ior, diffuse, reflectance: glossy, is_saturated, alpha })
        }
        FacetKind::Schlick { .. } if is_black(&material.diffuse) && alpha > 0.0 => {
            Ok(Bsdf::Tinted { colour: glossy, alpha })
        }
        FacetKind::Schlick { .. } | FacetKind::Coat { .. } | FacetKind::Interface => refuse(
            "metal by its colour, and what is matte under a coat without an index, have no exact counterpart in \
             other renderers",
            "give metal its eta and k, or make it plastic",
        ),
    }
}

fn picture(texture: &Texture, factor: &Bands) -> Colour {
    Colour::Picture { texture: texture.clone(), factor: *factor }
}

/// The lights, if each has a counterpart.
pub(super) fn check_lights<'a>(scene: &'a Scene, source: &Path) -> Result<&'a [Light]> {
    if scene.wavelengths.are_rendered && scene.shines_in_lines() {
        let what = "light of lines (lasers, lamp, lines) has no counterpart in other renderers".to_string();
        return Err(unsupported(source, what, "state it as a spectrum with peaks of some width"));
    }
    for (i, light) in scene.lights.iter().enumerate() {
        if let Light::Spot { angle_inner, angle_outer, .. } = light
            && angle_inner != angle_outer
        {
            return Err(unsupported(
                source,
                format!("light {}: the soft edge of a spot has no counterpart in other renderers", i + 1),
                "give angle_inner = angle_outer",
            ));
        }
    }
    Ok(&scene.lights)
}
