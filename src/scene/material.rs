//! Materials: what happens to light at a surface.

use super::MaterialSpectra;
use super::texture::{NumberMap, Opacity, Relief, Texture};
use crate::spectrum::metal::Metal;
use crate::spectrum::{BANDS, BLACK, Bands, is_black};
use std::sync::Arc;

/// Reflectance where a file says nothing: middle grey.
pub(crate) const GREY: Bands = [0.5; BANDS];
/// All light.
pub(crate) const WHITE: Bands = [1.0; BANDS];

/// A surface. An opaque one reflects `diffuse` (times its texels) + `glossy` + `specular` ≤ 1 per band, and what it scatters through itself
/// counts there, too; a dielectric has none of these but reflects and transmits by Fresnel.
#[derive(Debug, Clone, PartialEq)]
pub struct Material {
    /// Name in the file.
    pub name: String,
    /// Lambertian reflectance per band …
    pub diffuse: Bands,
    /// … times the texels of this, in red, green and blue. What a dielectric transmits is times their root, of a thin pane times them.
    pub diffuse_texture: Option<Texture>,
    /// How much of the surface is there; all of it where this is none.
    pub opacity: Option<Opacity>,
    /// Reflectance of the glossy lobe per band, of microfacets head on or their tint.
    pub glossy: Bands,
    /// Phong exponent of the glossy lobe, where it is none of microfacets.
    pub glossy_exponent: f32,
    /// The glossy lobe, or the boundary of a transparent body, is of microfacets.
    pub facets: Option<Facets>,
    /// The microfacets are brushed: rougher one way than the other.
    pub anisotropy: Option<Anisotropy>,
    /// Roughness of the microfacets where it varies: the square root of their α at each place. `facets` says the most of it.
    pub roughness: Option<NumberMap>,
    /// What of it is metal of the colour that `diffuse` and its texture make at each place; none where that is the same all over, as
    /// `diffuse` and `glossy` say. Else `diffuse` is the colour of both, and `glossy` an even picture of what is reflected.
    pub metallic: Option<Metallic>,
    /// Which way its surface faces beside its triangles.
    pub relief: Option<Relief>,
    /// Mirror reflectance per band.
    pub specular: Bands,
    /// Part of light per band that is scattered through to the other side of the surface, as paper does; where `diffuse_texture` is
    /// there, of its texels \[E55\].
    pub transmit: Bands,
    /// Glass, water: the boundary of a transparent body.
    pub dielectric: Option<Dielectric>,
    /// The dielectric is a pane without thickness: both of its faces lie in one place \[E26\].
    pub thin: bool,
    /// What light meets inside of the body that the dielectric bounds.
    pub interior: Interior,
    /// Radiance emitted from the front, W/(m² sr) per band …
    pub emission: Bands,
    /// … times the texels of this, in red, green and blue.
    pub emission_texture: Option<Texture>,
    /// By wavelength, the index of what [`FacetKind::Conductor`] says in red, green and blue; none where that is all that is known.
    pub metal: Option<Arc<Metal>>,
    /// What of this is stated by wavelength; its bands say what it is in red, green and blue.
    pub spectra: Option<Arc<MaterialSpectra>>,
    /// What lies over a principled base, whose microfacets reflect by Schlick's formula.
    pub layers: Option<Layers>,
    /// A part of the dielectric is opaque: something else is there.
    pub mixture: Option<Mixture>,
}

/// What is transmitted of a surface that is glass in part and opaque in part: of that which is no metal some \[E57\].
#[derive(Debug, Clone, PartialEq)]
pub struct Mixture {
    /// Part of what is no metal that is glass …
    pub transmission: f32,
    /// … where that varies.
    pub transmission_map: Option<NumberMap>,
    /// Part that is metal …
    pub metallic: f32,
    /// … where that varies.
    pub metallic_map: Option<NumberMap>,
    /// What is there in place of glass. Its `metallic`, where there is one, is that of all of the surface.
    pub rest: Box<Material>,
    /// Its number in the scene's list of materials, once this is whole.
    pub number: u32,
}

/// Puts what of glass is no glass at the end of a list of materials, and says there where it is.
pub fn number_rests(materials: &mut Vec<Material>) {
    for i in 0..materials.len() {
        let number = materials.len() as u32;
        let Some(mixture) = &mut materials[i].mixture else { continue };
        mixture.number = number;
        let rest = (*mixture.rest).clone();
        materials.push(rest);
    }
}

/// A smooth boundary between vacuum (outside, where the normal points) and a transparent body (inside).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dielectric {
    /// Index of refraction inside over outside; over vacuum where some body of the scene has a priority.
    pub ior: f32,
    /// Factor on what is reflected, per band.
    pub reflection_tint: Bands,
    /// Factor on what is transmitted at each crossing, per band.
    pub transmission_tint: Bands,
}

/// What light meets inside of a transparent body.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Interior {
    /// What is absorbed, per band and world unit of length: of light, exp(−absorption · length) is left \[E44\].
    pub absorption: Bands,
    /// Which of several bodies in one place counts: that of the lowest number, and of those without one the one entered last \[E45\].
    pub priority: Option<i64>,
}

/// How much of a surface is metal, from 0 to 1.
#[derive(Debug, Clone, PartialEq)]
pub struct Metallic {
    /// All over; where there is a texture this is the most of it …
    pub most: f32,
    /// … and this says how much there is at each place.
    pub map: Option<NumberMap>,
}

/// A surface of tiny mirrors, whose slopes are distributed as GGX has it \[E41\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Facets {
    /// Roughness α of GGX, 0 to 1: the square of what most programs call roughness. 0 is smooth.
    pub alpha: f32,
    /// What they are of.
    pub kind: FacetKind,
}

/// Microfacets that are rougher one way than the other, as glTF has it: α goes to 1 with the square of the strength along one way of the
/// surface, and stays across it \[E56\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Anisotropy {
    /// 0 to 1.
    pub strength: f32,
    /// From the way of the surface to that in which it is rougher, counter-clockwise as seen from its front, radians.
    pub rotation: f32,
    /// The way of the surface goes around an axis, across which its texture coordinates are; else it is where these grow to the right.
    pub is_around: bool,
}

/// What reflects, by Fresnel \[E40\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FacetKind {
    /// Metal of a complex index η + ik, over that of air; `glossy` is a tint.
    Conductor {
        /// Real part per band.
        eta: Bands,
        /// Imaginary part per band.
        k: Bands,
    },
    /// By Schlick's formula: `glossy` is what is reflected head on. What of it is diffuse lies under a coat of index `ior`.
    Schlick {
        /// Of the coat.
        ior: f32,
    },
    /// A clear coat over a diffuse base; `glossy` is a tint.
    Coat {
        /// Of the coat.
        ior: f32,
        /// What light does under it.
        inner: Inner,
    },
    /// The boundary of a transparent body: its index and tints are those of the dielectric.
    Interface,
}

impl FacetKind {
    /// Index of the coat over what is diffuse; none where there is none.
    pub(crate) fn coat(self) -> Option<f32> {
        match self {
            Self::Schlick { ior } | Self::Coat { ior, .. } => Some(ior),
            Self::Conductor { .. } | Self::Interface => None,
        }
    }
}

/// What a principled material has beside its base \[E50–E52\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layers {
    /// How much of a clear coat of index 1.5 is there, 0 to 1.
    pub clear_coat: f32,
    /// Roughness α of its microfacets.
    pub clear_coat_alpha: f32,
    /// Colour of the sheen per band; black where there is none.
    pub sheen: Bands,
    /// Roughness of the sheen, 0.3 to 1: the square root of Charlie's α.
    pub sheen_roughness: f32,
    /// What the dielectric part of the base reflects head on, per band …
    pub head_on: Bands,
    /// … and at grazing angles.
    pub grazing: f32,
    /// Part of the base that is metal, where that is the same all over.
    pub metallic: f32,
}

impl Layers {
    /// Nothing beside a base of index 1.5.
    pub const PLAIN: Self = Self {
        clear_coat: 0.0,
        clear_coat_alpha: 0.0,
        sheen: BLACK,
        sheen_roughness: 0.5,
        head_on: [0.04; BANDS],
        grazing: 1.0,
        metallic: 0.0,
    };
}

/// What light does between a diffuse base and the coat over it \[E42\].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Inner {
    /// It leaves at once: some of it is lost.
    Once,
    /// It is reflected to and fro without taking on more of the base's colour: white stays white.
    Even,
    /// Each turn takes on the base's colour, which becomes more saturated.
    Coloured,
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
            facets: None,
            anisotropy: None,
            roughness: None,
            metallic: None,
            relief: None,
            specular: BLACK,
            transmit: BLACK,
            dielectric: None,
            thin: false,
            interior: Interior::default(),
            emission: BLACK,
            emission_texture: None,
            metal: None,
            spectra: None,
            layers: None,
            mixture: None,
        }
    }

    /// Whether a picture lies on it.
    pub fn has_texture(&self) -> bool {
        self.textures().next().is_some()
    }

    /// The pictures that lie on it.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let opacity = self.opacity.iter().filter_map(|o| o.texture.as_ref());
        self.surface_textures().chain(opacity)
    }

    /// Change them, and those of the opaque part of a mixture.
    pub(crate) fn change_textures(&mut self, change: &mut impl FnMut(&mut Texture)) {
        let opacity = self.opacity.iter_mut().filter_map(|o| o.texture.as_mut());
        let metallic = self.metallic.iter_mut().filter_map(|m| m.map.as_mut());
        let mixed = self.mixture.iter_mut();
        let mixed = mixed.flat_map(|m| m.transmission_map.iter_mut().chain(&mut m.metallic_map));
        let numbers = self.roughness.iter_mut().chain(metallic).chain(mixed).map(|map| &mut map.texture);
        let relief = self.relief.iter_mut().map(|relief| &mut relief.texture);
        let colours = self.diffuse_texture.iter_mut().chain(&mut self.emission_texture);
        colours.chain(numbers).chain(relief).chain(opacity).for_each(&mut *change);
        if let Some(mixture) = &mut self.mixture {
            mixture.rest.change_textures(change);
        }
    }

    /// Those of them that are looked up where a ray has met it.
    pub fn surface_textures(&self) -> impl Iterator<Item = &Texture> {
        let metallic = self.metallic.iter().filter_map(|m| m.map.as_ref());
        let mixed = self.mixture.iter().flat_map(|m| m.transmission_map.iter().chain(&m.metallic_map));
        let numbers = self.roughness.iter().chain(metallic).chain(mixed).map(|map| &map.texture);
        let relief = self.relief.iter().map(|relief| &relief.texture);
        self.diffuse_texture.iter().chain(numbers).chain(relief).chain(&self.emission_texture)
    }

    /// Whether it emits in some band.
    pub fn emits(&self) -> bool {
        !is_black(&self.emission)
    }
}
