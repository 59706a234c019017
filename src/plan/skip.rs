//! Skips: what can be left out of a render, why it may be for a scene, and what would bring it back.

use crate::error::{Error, Result};
use serde::Serialize;

/// Something that a scene may not need. Leaving it out never changes the expected image.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Surfaces and lights outside of a closed room that the camera stands in.
    OutOfReach,
    /// Layer: emission seen by lamps' own pixels and through specular surfaces.
    Emission,
    /// Layer: direct light.
    DirectLight,
    /// Layer: the map of caustics.
    CausticMap,
    /// Layer: the map of diffusely reflected light.
    DiffuseMap,
    /// Code for mirrors.
    Mirrors,
    /// Code for refraction.
    Refraction,
    /// Code for textures.
    Textures,
    /// Code for roughness and metal that vary over a surface.
    FacetTextures,
    /// Code for normals and heights from pictures.
    Relief,
    /// Code for light whose texture says how bright it is.
    Glow,
    /// Code for surfaces of which some is not there.
    CutOuts,
    /// Code for what bodies absorb, and which of several counts.
    Media,
    /// Code for bands that part where the index of refraction differs between them.
    Dispersion,
    /// Code for glossy lobes.
    GlossyLobes,
    /// Code for light that is scattered through a surface.
    Translucency,
    /// Code for microfacets, and what reflects as metal or a coat does.
    Microfacets,
    /// Code for microfacets that are rougher one way than the other.
    Anisotropy,
    /// Code for clear coats, sheen and the like.
    Layers,
    /// Code for surfaces that are glass in part.
    Mixtures,
    /// Code and buffer for shading normals.
    ShadingNormals,
    /// Code for lights that are no surfaces.
    DeltaLights,
    /// Code for faces in one place.
    Contacts,
    /// Code for the automaton of light paths.
    PathFilter,
    /// Code for directions of jotons that were learned.
    Warps,
    /// All shadow rays of a gather point but one.
    FurtherShadowRays,
    /// Shadow rays to lights that would give little where others give much.
    FaintLight,
    /// Shadow rays to lights, and jotons of lights, that are of no use in view.
    UnseenLight,
    /// Jotons where the camera does not look.
    UnseenJotons,
    /// Jotons for pixels that see no surface.
    Background,
    /// Passes of pixels that need no more.
    Rest,
}

/// Why a [`Part`] is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Reason {
    /// Opaque walls without a gap lie between them and the camera.
    ClosedRoom,
    /// No surface mirrors or refracts.
    NoSpecularSurface,
    /// Every light turns its back on all that mirrors or refracts.
    SpecularInTheDark,
    /// No light has any flux.
    NoLight,
    /// No surface emits.
    NoEmissiveSurface,
    /// No surface is diffuse.
    NoDiffuseSurface,
    /// All surfaces that reflect lie in one plane.
    OnePlane,
    /// The user wants other paths.
    ExcludedByPaths,
    /// No surface mirrors.
    NoMirror,
    /// No surface refracts.
    NoDielectric,
    /// No index of refraction depends on the wavelength, or no wavelengths are rendered.
    NothingDisperses,
    /// No surface has a texture.
    NoTexture,
    /// Each surface is equally rough, and equally of metal, all over.
    SameFacetsAllOver,
    /// No surface has a picture of normals or heights.
    NoRelief,
    /// Each light is equally bright all over.
    LightsAreEven,
    /// All of every surface is there.
    NothingCut,
    /// No body absorbs light, and none has a priority.
    PlainBodies,
    /// No surface is glossy.
    NoGlossySurface,
    /// No surface scatters light through itself.
    NothingTranslucent,
    /// No surface is of microfacets.
    NoMicrofacets,
    /// All microfacets are as rough one way as the other.
    NothingBrushed,
    /// No material has layers.
    NoLayers,
    /// Each surface is glass all over, or nowhere.
    NothingMixed,
    /// No triangle has shading normals.
    AllFlat,
    /// No light is a point, a spot or a sun.
    AllLightsAreSurfaces,
    /// No two faces lie in one place.
    NothingTouches,
    /// The user wants all paths.
    AllPathsWanted,
    /// No way was found to be of more use to jotons than another.
    NothingLearned,
    /// The only light is a point or a direction.
    OneDirection,
    /// Of some light samples one, picked by what each may give, gets a shadow ray.
    FaintAmongStrong,
    /// Some lights, or some ways from them, never reach what the camera sees.
    LightElsewhere,
    /// Many jotons lie where the camera does not look.
    JotonsElsewhere,
    /// A large part of the image shows no surface.
    MuchBackground,
    /// Pixels whose passes are all alike are looked at less often.
    NothingChanges,
    /// Eye paths that go on, shared with neighbours, find the same light with less error.
    PathsServe,
}

/// Something that is not done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Skip {
    /// What is left out.
    pub what: Part,
    /// Why that changes nothing in the image.
    pub why: Reason,
}

impl Part {
    /// All parts, in the order in which they are told.
    pub const ALL: [Part; 31] = [
        Part::OutOfReach,
        Part::Emission,
        Part::DirectLight,
        Part::CausticMap,
        Part::DiffuseMap,
        Part::Mirrors,
        Part::Refraction,
        Part::Textures,
        Part::FacetTextures,
        Part::Relief,
        Part::Glow,
        Part::CutOuts,
        Part::Media,
        Part::Dispersion,
        Part::GlossyLobes,
        Part::Translucency,
        Part::Microfacets,
        Part::Anisotropy,
        Part::Layers,
        Part::Mixtures,
        Part::ShadingNormals,
        Part::DeltaLights,
        Part::Contacts,
        Part::PathFilter,
        Part::Warps,
        Part::FurtherShadowRays,
        Part::FaintLight,
        Part::UnseenLight,
        Part::UnseenJotons,
        Part::Background,
        Part::Rest,
    ];

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Part::OutOfReach => "out-of-reach",
            Part::Emission => "emission",
            Part::DirectLight => "direct-light",
            Part::CausticMap => "caustic-map",
            Part::DiffuseMap => "diffuse-map",
            Part::Mirrors => "mirrors",
            Part::Refraction => "refraction",
            Part::Textures => "textures",
            Part::FacetTextures => "facet-textures",
            Part::Relief => "relief",
            Part::Glow => "glow",
            Part::CutOuts => "cut-outs",
            Part::Media => "media",
            Part::Dispersion => "dispersion",
            Part::GlossyLobes => "glossy-lobes",
            Part::Translucency => "translucency",
            Part::Microfacets => "microfacets",
            Part::Anisotropy => "anisotropy",
            Part::Layers => "layers",
            Part::Mixtures => "mixtures",
            Part::ShadingNormals => "shading-normals",
            Part::DeltaLights => "delta-lights",
            Part::Contacts => "contacts",
            Part::PathFilter => "path-filter",
            Part::Warps => "warps",
            Part::FurtherShadowRays => "further-shadow-rays",
            Part::FaintLight => "faint-light",
            Part::UnseenLight => "unseen-light",
            Part::UnseenJotons => "unseen-jotons",
            Part::Background => "background",
            Part::Rest => "rest",
        }
    }

    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Part::OutOfReach => "surfaces and lights out of reach",
            Part::Emission => "emission",
            Part::DirectLight => "direct light",
            Part::CausticMap => "caustic map",
            Part::DiffuseMap => "diffuse map",
            Part::Mirrors => "mirrors",
            Part::Refraction => "refraction",
            Part::Textures => "textures",
            Part::FacetTextures => "roughness and metal that vary",
            Part::Relief => "normal and bump maps",
            Part::Glow => "textures of light",
            Part::CutOuts => "cut-outs",
            Part::Media => "absorption and priorities of bodies",
            Part::Dispersion => "dispersion",
            Part::GlossyLobes => "glossy lobes",
            Part::Translucency => "diffuse transmission",
            Part::Microfacets => "microfacets",
            Part::Anisotropy => "anisotropy",
            Part::Layers => "clear coats and sheen",
            Part::Mixtures => "surfaces that are glass in part",
            Part::ShadingNormals => "shading normals",
            Part::DeltaLights => "point, spot and sun lights",
            Part::Contacts => "order of faces in one place",
            Part::PathFilter => "light path filter",
            Part::Warps => "learned directions",
            Part::FurtherShadowRays => "further shadow rays",
            Part::FaintLight => "shadow rays to faint lights",
            Part::UnseenLight => "light of no use in view",
            Part::UnseenJotons => "jotons out of view",
            Part::Background => "jotons for the background",
            Part::Rest => "passes of pixels that do not change",
        }
    }

    /// The parts that a word of `--no-skip` means: one by its name, or `all`.
    ///
    /// # Errors
    /// [`Error::Usage`] with the names where there is no such part.
    pub fn parse(word: &str) -> Result<Vec<Part>> {
        if word == "all" {
            return Ok(Self::ALL.to_vec());
        }
        let found = Self::ALL.into_iter().find(|p| p.name() == word);
        found.map(|p| vec![p]).ok_or_else(|| {
            let names: Vec<&str> = Self::ALL.into_iter().map(Part::name).collect();
            let what = format!("--no-skip {word}: nothing of that name is ever skipped");
            Error::usage(what, format!("give all, or some of: {}", names.join(", ")))
        })
    }
}

impl Reason {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Reason::ClosedRoom => "closed walls lie between them and the camera",
            Reason::NoSpecularSurface => "no surface mirrors or refracts",
            Reason::SpecularInTheDark => "every light faces away from all that mirrors or refracts",
            Reason::NoLight => "no light has any flux",
            Reason::NoEmissiveSurface => "no surface emits",
            Reason::NoDiffuseSurface => "no surface is diffuse",
            Reason::OnePlane => "all that reflects lies in one plane",
            Reason::ExcludedByPaths => "--paths excludes it",
            Reason::NoMirror => "no surface mirrors",
            Reason::NoDielectric => "no surface refracts",
            Reason::NothingDisperses => "no surface bends one wavelength more than another",
            Reason::NoTexture => "no surface has a texture",
            Reason::LightsAreEven => "each light is equally bright all over",
            Reason::NoRelief => "no surface has a normal or bump map",
            Reason::SameFacetsAllOver => "each surface is equally rough and of metal all over",
            Reason::NothingCut => "all of every surface is there",
            Reason::PlainBodies => "no body absorbs light or has a priority",
            Reason::NoGlossySurface => "no surface is glossy",
            Reason::NothingTranslucent => "no surface scatters light through itself",
            Reason::NoMicrofacets => "no surface is metal, coated or rough by roughness",
            Reason::NothingBrushed => "no surface is rougher one way than the other",
            Reason::NoLayers => "no material has a clear coat, sheen or a specular factor",
            Reason::NothingMixed => "each surface is glass all over, or nowhere",
            Reason::AllFlat => "every triangle is flat",
            Reason::AllLightsAreSurfaces => "every light is a surface",
            Reason::NothingTouches => "no two faces lie in one place",
            Reason::AllPathsWanted => "all light paths are wanted",
            Reason::NothingLearned => "no way was found to be of more use to jotons than another",
            Reason::OneDirection => "the only light is a point or a direction",
            Reason::FaintAmongStrong => {
                "of a few light samples one, picked by what each may give, gets a ray"
            }
            Reason::LightElsewhere => {
                "lights, and ways from them, that do not reach the view get a small share"
            }
            Reason::JotonsElsewhere => "of those that no pixel will read one in eight is stored for all",
            Reason::MuchBackground => "as many jotons are traced as there are pixels that see a surface",
            Reason::NothingChanges => "they are looked at in one pass of some, which counts as many",
            Reason::PathsServe => {
                "eye paths that go on, shared with neighbours, find its light with less error"
            }
        }
    }

    /// What of a scene, or of the user's, would bring it back.
    pub fn back(self) -> &'static str {
        match self {
            Reason::ClosedRoom => "an opening in the walls, or a pane of glass",
            Reason::NoSpecularSurface => "a mirror or a dielectric",
            Reason::SpecularInTheDark => "a light that shines on a mirror or a dielectric",
            Reason::NoLight => "a light that has an area or an intensity",
            Reason::NoEmissiveSurface => "a material that emits",
            Reason::NoDiffuseSurface => "a diffuse or glossy surface",
            Reason::OnePlane => "a second surface that reflects",
            Reason::ExcludedByPaths => "--paths with such paths",
            Reason::NoMirror => "a mirror",
            Reason::NoDielectric => "a dielectric",
            Reason::NothingDisperses => "a named glass, or an Abbe number",
            Reason::NoTexture => "a texture",
            Reason::LightsAreEven => "a texture of ke",
            Reason::NoRelief => "a normal or bump map",
            Reason::SameFacetsAllOver => "a texture of roughness, metallic or the colour of metal",
            Reason::NothingCut => "an opacity",
            Reason::PlainBodies => "absorption, or a priority",
            Reason::NoGlossySurface => "a glossy surface",
            Reason::NothingTranslucent => "transmit of a matte surface",
            Reason::NoMicrofacets => "metal, plastic or rough glass",
            Reason::NothingBrushed => "an anisotropy",
            Reason::NoLayers => "clearcoat, sheen_color or specular",
            Reason::NothingMixed => "transmission between 0 and 1",
            Reason::AllFlat => "normals at vertices",
            Reason::AllLightsAreSurfaces => "a point, spot or sun light",
            Reason::NothingTouches => "faces that touch",
            Reason::AllPathsWanted => "--paths",
            Reason::NothingLearned => "a light whose ways differ in use",
            Reason::OneDirection => "a second light, or one that has a surface",
            Reason::FaintAmongStrong => "lights that are equally strong wherever the camera looks",
            Reason::LightElsewhere => "a view of what they light",
            Reason::JotonsElsewhere => "a view of more of the surfaces",
            Reason::MuchBackground => "a view with less background",
            Reason::NothingChanges => "something in view of them",
            Reason::PathsServe => "a lamp that eye paths hardly find",
        }
    }
}

/// What is skipped, as it is decided.
pub(super) struct Skips {
    pub(super) keep: Vec<Part>,
    pub(super) skipped: Vec<Skip>,
}

impl Skips {
    /// Skip a part, unless it is to be kept; whether it is skipped.
    pub(super) fn skip(&mut self, what: Part, why: Reason) -> bool {
        let skips = !self.keep.contains(&what);
        if skips {
            self.skipped.push(Skip { what, why });
        }
        skips
    }

    /// Skip a part that there is no way to keep.
    pub(super) fn must_skip(&mut self, what: Part, why: Reason) {
        self.skipped.push(Skip { what, why });
    }
}

impl Serialize for Skip {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> std::result::Result<S::Ok, S::Error> {
        use serde::ser::SerializeStruct;
        let mut s = serializer.serialize_struct("Skip", 5)?;
        s.serialize_field("what", self.what.words())?;
        s.serialize_field("why", self.why.words())?;
        s.serialize_field("name", self.what.name())?;
        s.serialize_field("reason", &self.why)?;
        s.serialize_field("back", self.why.back())?;
        s.end()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The list holds each part once, in the order of the enum, under a name of its own that means it.
    #[test]
    fn parts_have_names() {
        for (i, part) in Part::ALL.into_iter().enumerate() {
            assert_eq!(part as usize, i);
            assert_eq!(Part::parse(part.name()).expect("its name"), [part]);
        }
        assert_eq!(Part::parse("all").expect("a word"), Part::ALL);
        let refused = Part::parse("caustics").expect_err("no such part").to_string();
        assert!(refused.contains("caustics") && refused.contains("caustic-map"), "{refused}");
    }
}
