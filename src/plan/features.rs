//! Features: what the kernels must be able to do for a scene; the rest is compiled out.

use super::Settings;
use super::facts;
use super::skip::{Part, Reason, Skips};
use crate::packed::{PackedScene, TEXTURED};

/// What the kernels must be able to do for this scene; the rest is compiled out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Features {
    /// Some triangle has shading normals.
    pub smooth_normals: bool,
    /// Some surface mirrors.
    pub specular: bool,
    /// Some surface is a dielectric.
    pub dielectric: bool,
    /// Some surface has a texture.
    pub textures: bool,
    /// Some surface has microfacets that vary.
    pub facet_textures: bool,
    /// Some surface has a picture of normals or heights.
    pub relief: bool,
    /// Some surface shines by a texture.
    pub glow: bool,
    /// Some of some surface is not there.
    pub cutouts: bool,
    /// The inside of some body matters: what it absorbs, or its priority.
    pub media: bool,
    /// What the bands are differs from pass to pass.
    pub wavelengths: bool,
    /// Some dielectric's index differs between the bands.
    pub dispersion: bool,
    /// Some surface has a glossy lobe.
    pub glossy: bool,
    /// Some surface scatters light through itself.
    pub translucent: bool,
    /// Some surface is of microfacets.
    pub facets: bool,
    /// Some microfacets are rougher one way than the other.
    pub anisotropy: bool,
    /// Some material has layers.
    pub layers: bool,
    /// Some surface is glass in part.
    pub mixtures: bool,
    /// Some lobe that is followed has a width, and there are lights.
    pub followed_light: bool,
    /// Some emitter is not a triangle.
    pub delta_lights: bool,
    /// Some faces may lie in one place.
    pub contacts: bool,
    /// Only some light paths are wanted.
    pub path_filter: bool,
}

impl Features {
    /// What a scene needs.
    pub(super) fn of(scene: &PackedScene, settings: &Settings, skips: &mut Skips) -> Self {
        let mut needs = |needed: bool, part, why| needed || !skips.skip(part, why);
        Self {
            specular: needs(
                facts::has(scene, |m| m.has_delta() && !m.is_dielectric()),
                Part::Mirrors,
                Reason::NoMirror,
            ),
            dielectric: needs(
                facts::has(scene, |m| m.is_dielectric()),
                Part::Refraction,
                Reason::NoDielectric,
            ),
            textures: needs(
                scene.triangles.iter().any(|t| t.flags & TEXTURED != 0),
                Part::Textures,
                Reason::NoTexture,
            ),
            facet_textures: needs(
                facts::has(scene, |m| m.is_varied()),
                Part::FacetTextures,
                Reason::SameFacetsAllOver,
            ),
            relief: needs(facts::has(scene, |m| m.has_relief()), Part::Relief, Reason::NoRelief),
            glow: needs(facts::shines_by_pictures(scene), Part::Glow, Reason::LightsAreEven),
            cutouts: needs(scene.textures.has_cutouts, Part::CutOuts, Reason::NothingCut),
            media: needs(!scene.media.is_empty(), Part::Media, Reason::PlainBodies),
            wavelengths: scene.spectra.is_some(),
            dispersion: needs(
                scene.spectra.as_ref().is_some_and(|spectra| spectra.disperses()),
                Part::Dispersion,
                Reason::NothingDisperses,
            ),
            glossy: needs(facts::has(scene, |m| m.has_glossy()), Part::GlossyLobes, Reason::NoGlossySurface),
            translucent: needs(
                facts::has(scene, |m| m.is_translucent()),
                Part::Translucency,
                Reason::NothingTranslucent,
            ),
            facets: needs(facts::has(scene, |m| m.has_facets()), Part::Microfacets, Reason::NoMicrofacets),
            anisotropy: needs(
                facts::has(scene, |m| m.is_anisotropic()),
                Part::Anisotropy,
                Reason::NothingBrushed,
            ),
            layers: needs(facts::has(scene, |m| m.is_layered()), Part::Layers, Reason::NoLayers),
            mixtures: needs(facts::has_mixtures(scene), Part::Mixtures, Reason::NothingMixed),
            followed_light: facts::shows_lights_in_followed_lobes(scene),
            smooth_normals: needs(!scene.shading_normals.is_empty(), Part::ShadingNormals, Reason::AllFlat),
            delta_lights: needs(
                scene.emitters.iter().any(|e| !e.has_area()),
                Part::DeltaLights,
                Reason::AllLightsAreSurfaces,
            ),
            contacts: needs(scene.has_contacts, Part::Contacts, Reason::NothingTouches),
            path_filter: needs(!settings.paths.is_everything(), Part::PathFilter, Reason::AllPathsWanted),
        }
    }

    /// Name and value of each feature's override.
    pub fn named(&self) -> [(&'static str, bool); 21] {
        [
            ("HAS_SMOOTH", self.smooth_normals),
            ("HAS_SPECULAR", self.specular),
            ("HAS_DIELECTRIC", self.dielectric),
            ("HAS_TEXTURES", self.textures),
            ("HAS_FACET_TEXTURES", self.facet_textures),
            ("HAS_RELIEF", self.relief),
            ("HAS_GLOW", self.glow),
            ("HAS_CUTOUTS", self.cutouts),
            ("HAS_MEDIA", self.media),
            ("HAS_WAVELENGTHS", self.wavelengths),
            ("HAS_DISPERSION", self.dispersion),
            ("HAS_GLOSSY", self.glossy),
            ("HAS_TRANSLUCENT", self.translucent),
            ("HAS_FACETS", self.facets),
            ("HAS_ANISOTROPY", self.anisotropy),
            ("HAS_LAYERS", self.layers),
            ("HAS_MIXTURES", self.mixtures),
            ("HAS_FOLLOWED_LIGHT", self.followed_light),
            ("HAS_DELTA_LIGHTS", self.delta_lights),
            ("HAS_CONTACTS", self.contacts),
            ("HAS_PATH_FILTER", self.path_filter),
        ]
    }
}
