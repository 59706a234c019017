//! Materials: what happens to light at a surface.

use super::MaterialSpectra;
use super::texture::{Opacity, Texture};
use crate::spectrum::{BLACK, Bands, is_black};
use std::sync::Arc;

/// A surface. An opaque one reflects `diffuse` (times its texels) + `glossy` + `specular` ≤ 1 per band; a dielectric has none of these
/// but reflects and transmits by Fresnel.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Lambertian reflectance per band …
    pub diffuse: Bands,
    /// … times the texels of this, in red, green and blue.
    pub diffuse_texture: Option<Texture>,
    /// How much of the surface is there; all of it where this is none.
    pub opacity: Option<Opacity>,
    /// Reflectance of the glossy lobe per band (normalised Phong about the mirror direction).
    pub glossy: Bands,
    /// Phong exponent of the glossy lobe.
    pub glossy_exponent: f32,
    /// Mirror reflectance per band.
    pub specular: Bands,
    /// Glass, water: the boundary of a transparent body.
    pub dielectric: Option<Dielectric>,
    /// The dielectric is a pane without thickness: both of its faces lie in one place \[E26\].
    pub thin: bool,
    /// Radiance emitted from the front, W/(m² sr) per band.
    pub emission: Bands,
    /// What of this is stated by wavelength; its bands say what it is in red, green and blue.
    pub spectra: Option<Arc<MaterialSpectra>>,
}

/// A smooth boundary between vacuum (outside, where the normal points) and a transparent body (inside).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    /// Index of refraction inside over outside.
    pub ior: f32,
    /// Factor on what is reflected, per band.
    pub reflection_tint: Bands,
    /// Factor on what is transmitted at each crossing, per band.
    pub transmission_tint: Bands,
}

impl Material {
    /// A matte material that neither emits nor mirrors.
    pub fn matte(name: impl Into<String>, diffuse: Bands) -> Self {
        Self {
            name: name.into(),
            diffuse,
            diffuse_texture: None,
            opacity: None,
            glossy: BLACK,
            glossy_exponent: 0.0,
            specular: BLACK,
            dielectric: None,
            thin: false,
            emission: BLACK,
            spectra: None,
        }
    }

    /// Whether a picture lies on it.
    pub fn has_texture(&self) -> bool {
        self.diffuse_texture.is_some() || self.opacity.as_ref().is_some_and(|o| o.texture.is_some())
    }

    /// Whether it emits in some band.
    pub fn emits(&self) -> bool {
        !is_black(&self.emission)
    }
}
