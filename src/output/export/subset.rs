//! Subset: the materials and lights that have an exact counterpart in Mitsuba and LuxCore; the rest is refused.

use super::unsupported;
use crate::error::Result;
use crate::scene::{Dielectric, Light, Material, Scene};
use crate::spectrum::{BLACK, Bands, is_black};
use std::path::Path;

/// What to do about a material of several lobes.
const ONE_LOBE: &str = "make it matte or a mirror: a [[material]] with type in the scene file";

/// What a material is in the words of other renderers. Emission comes on top of it.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Bsdf {
    /// Lambertian on both sides.
    Diffuse(Bands),
    /// A perfect mirror on both sides.
    Mirror(Bands),
    /// The interface of a transparent body, which is behind the front.
    Dielectric(Dielectric),
    /// Both interfaces of such a body in one place.
    Pane(Dielectric),
}

impl Bsdf {
    /// The counterpart of a material.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] where there is none.
    pub(super) fn of(material: &Material, source: &Path) -> Result<Self> {
        let refuse = |what: &str, remedy: &str| {
            Err(unsupported(source, format!("material \"{}\": {what}", material.name), remedy))
        };
        if material.facets.is_some() {
            let remedy =
                "make it matte, a mirror or smooth glass: a [[material]] with type in the scene file";
            return refuse("its microfacets have no exact counterpart in other renderers", remedy);
        }
        if !is_black(&material.interior.absorption) {
            let remedy = "leave its absorption out, or give it a tint";
            return refuse("what its inside absorbs is not written for other renderers", remedy);
        }
        if material.interior.priority.is_some() {
            let remedy = "leave it out, and give each boundary an index over what is around it";
            return refuse("its priority has no counterpart in other renderers", remedy);
        }
        if let Some(dielectric) = material.dielectric {
            return Ok(if material.thin { Self::Pane(dielectric) } else { Self::Dielectric(dielectric) });
        }
        if material.has_texture() || material.opacity.is_some() {
            let remedy = "give it a plain kd, and leave its opacity out";
            return refuse("textures and opacities are not written for other renderers", remedy);
        }
        if !is_black(&material.transmit) {
            let remedy = "leave its transmit out";
            return refuse("what it scatters through has no counterpart in other renderers", remedy);
        }
        if !is_black(&material.glossy) {
            return refuse("its glossy lobe (Phong) has no counterpart in other renderers", ONE_LOBE);
        }
        match (is_black(&material.diffuse), is_black(&material.specular)) {
            (_, true) => Ok(Self::Diffuse(material.diffuse)),
            (true, false) => Ok(Self::Mirror(material.specular)),
            // Mitsuba's blendbsdf weighs a mirror's direction by the Lambertian lobe, too, and changes its colour
            (false, false) => refuse(
                "its sum of a matte and a mirror lobe has no exact counterpart in other renderers",
                ONE_LOBE,
            ),
        }
    }

    /// Whether it is black: nothing but emission comes from it.
    pub(super) fn is_black(&self) -> bool {
        *self == Self::Diffuse(BLACK)
    }
}

/// The lights, if each has a counterpart.
pub(super) fn check_lights<'a>(scene: &'a Scene, source: &Path) -> Result<&'a [Light]> {
    if scene.wavelengths.are_rendered {
        let what = "light by wavelength is not written for other renderers".to_string();
        return Err(unsupported(source, what, "write it in red, green and blue: --spectral off"));
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
