//! Subset: the materials and lights that have an exact counterpart in Mitsuba and LuxCore; the rest is refused.

use super::unsupported;
use crate::bands::{BLACK, Bands, is_black, max, scale};
use crate::error::Result;
use crate::scene::{Dielectric, Light, Material, Scene};
use std::path::Path;

/// What a material is in the words of other renderers. Emission comes on top of it.
#[derive(Debug, Clone, PartialEq)]
pub enum Bsdf {
    /// Lambertian on both sides.
    Diffuse(Bands),
    /// A perfect mirror on both sides.
    Mirror(Bands),
    /// Both at once: the mirror with this weight, the Lambertian lobe with what is left; `diffuse` and `mirror` are
    /// already divided by their weights.
    Blend {
        /// Share of the mirror.
        weight: f32,
        /// Lambertian reflectance over 1 − `weight`.
        diffuse: Bands,
        /// Mirror reflectance over `weight`.
        mirror: Bands,
    },
    /// The boundary of a transparent body, which is behind the front.
    Dielectric(Dielectric),
}

impl Bsdf {
    /// The counterpart of a material.
    ///
    /// # Errors
    /// [`crate::Error::Scene`] where there is none.
    pub fn of(material: &Material, source: &Path) -> Result<Self> {
        let refuse = |what: &str, remedy: &str| {
            Err(unsupported(source, format!("material \"{}\": {what}", material.name), remedy))
        };
        if let Some(dielectric) = material.dielectric {
            return Ok(Self::Dielectric(dielectric));
        }
        if !is_black(&material.glossy) {
            return refuse(
                "its glossy lobe (Phong) has no counterpart in other renderers",
                "make it matte or a mirror: a [[material]] with type in the scene file",
            );
        }
        let (diffuse, mirror) = (max(&material.diffuse), max(&material.specular));
        if mirror == 0.0 {
            return Ok(Self::Diffuse(material.diffuse));
        }
        if diffuse == 0.0 {
            return Ok(Self::Mirror(material.specular));
        }
        if diffuse + mirror > 1.0 {
            return refuse(
                "its diffuse and mirror reflectances, each in its largest band, exceed 1 together, which other \
                 renderers cannot blend",
                "lower Kd or Ks",
            );
        }
        let weight = mirror / (diffuse + mirror);
        // rounding may lead past 1, which is refused there
        let over = |c: &Bands, share: f32| scale(c, 1.0 / share).map(|x| x.min(1.0));
        Ok(Self::Blend {
            weight,
            diffuse: over(&material.diffuse, 1.0 - weight),
            mirror: over(&material.specular, weight),
        })
    }

    /// Whether it is black: nothing but emission comes from it.
    pub fn is_black(&self) -> bool {
        *self == Self::Diffuse(BLACK)
    }
}

/// The lights, if each has a counterpart.
pub(super) fn check_lights<'a>(scene: &'a Scene, source: &Path) -> Result<&'a [Light]> {
    for (i, light) in scene.lights.iter().enumerate() {
        if let Light::Spot { cos_inner, cos_outer, .. } = light
            && cos_inner != cos_outer
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
