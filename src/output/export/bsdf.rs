//! BSDFs: what surfaces do with light, in Mitsuba's words.

use super::colour::Colour;
use super::pfm::{Factor, PictureFile};
use super::subset::{Bsdf, Look};
use super::xml::{colour, float, list};

use crate::scene::texture::{Filter, Opacity, Texture, Wrap};

/// Writes BSDFs, and keeps the pictures that they name.
#[derive(Debug)]
pub(super) struct Bsdfs<'a> {
    /// What names of files begin with.
    stem: &'a str,
    /// Files beside the scene file.
    pub(super) pictures: Vec<PictureFile>,
}

impl<'a> Bsdfs<'a> {
    /// None yet.
    pub(super) fn new(stem: &'a str) -> Self {
        Self { stem, pictures: Vec::new() }
    }

    /// A material, by its number and name.
    pub(super) fn text(&mut self, look: &Look, number: u32, id: &str) -> String {
        let inner_id = if look.opacity.is_some() { String::new() } else { format!(" id=\"{id}\"") };
        let inner = self.bsdf(&look.bsdf, number, &inner_id);
        let Some(opacity) = &look.opacity else { return inner };
        let opacity = match opacity {
            Opacity { factor, texture: None } => float("opacity", factor),
            Opacity { factor, texture: Some(texture) } => {
                self.picture("opacity", number, texture, Factor::Opacity(*factor))
            }
        };
        format!("<bsdf type=\"mask\" id=\"{id}\">{opacity}{inner}</bsdf>")
    }

    fn bsdf(&mut self, bsdf: &Bsdf, number: u32, id: &str) -> String {
        let two_sided = |kind: &str, inner: String| {
            format!("<bsdf type=\"twosided\"{id}><bsdf type=\"{kind}\">{inner}</bsdf></bsdf>")
        };
        let prefix = |alpha: f32| if alpha > 0.0 { "rough" } else { "" };
        match bsdf {
            Bsdf::Diffuse(kd) => two_sided("diffuse", self.colour("reflectance", number, kd)),
            Bsdf::Mirror(ks) => {
                let none = "<string name=\"material\" value=\"none\"/>";
                two_sided("conductor", format!("{none}{}", colour("specular_reflectance", ks)))
            }
            Bsdf::Metal { eta, k, tint, alpha } => {
                let tint = self.colour("specular_reflectance", number, tint);
                let inner = format!("{}{}{}{tint}", microfacets(*alpha), colour("eta", eta), colour("k", k));
                two_sided(&format!("{}conductor", prefix(*alpha)), inner)
            }
            Bsdf::Tinted { colour: tint, alpha } => {
                let tint = self.colour("base_color", number, tint);
                let roughness = float("roughness", alpha.sqrt());
                two_sided("principled", format!("{}{roughness}{tint}", float("metallic", 1)))
            }
            Bsdf::Plastic { ior, diffuse, reflectance, is_saturated, alpha } => {
                let inner = [
                    microfacets(*alpha),
                    indices(*ior),
                    format!("<boolean name=\"nonlinear\" value=\"{is_saturated}\"/>"),
                    self.colour("diffuse_reflectance", number, diffuse),
                    colour("specular_reflectance", reflectance),
                ];
                two_sided(&format!("{}plastic", prefix(*alpha)), inner.concat())
            }
            Bsdf::Dielectric { dielectric, tints, alpha } => {
                let kind = format!("{}dielectric", prefix(*alpha));
                format!(
                    "<bsdf type=\"{kind}\"{id}>{}{}{}</bsdf>",
                    microfacets(*alpha),
                    indices(dielectric.ior),
                    glass(tints)
                )
            }
            Bsdf::Pane { dielectric, tints } => {
                let inner = format!("{}{}", indices(dielectric.ior), glass(tints));
                format!("<bsdf type=\"thindielectric\"{id}>{inner}</bsdf>")
            }
        }
    }

    fn colour(&mut self, name: &str, number: u32, shown: &Colour) -> String {
        match shown {
            Colour::Picture { texture, factor } => {
                self.picture(name, number, texture, Factor::Colour(*factor))
            }
            other => colour(name, other),
        }
    }

    /// A picture of the material of this number. Its rows run down in Mitsuba, where texture coordinates run up.
    fn picture(&mut self, name: &str, number: u32, texture: &Texture, factor: Factor) -> String {
        let file = format!("{}.{number}.{name}.pfm", self.stem);
        let filter = match texture.filter {
            Filter::Linear => "bilinear",
            Filter::Nearest => "nearest",
        };
        let wrap = match texture.wrap {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
            Wrap::Clamp => "clamp",
        };
        let ([across, up], [right, above]) = (texture.scale, texture.offset);
        let text = format!(
            "<texture type=\"bitmap\" name=\"{name}\"><string name=\"filename\" value=\"{}\"/><boolean \
             name=\"raw\" value=\"true\"/><string name=\"filter_type\" value=\"{filter}\"/><string name=\"wrap_mode\" \
             value=\"{wrap}\"/><transform name=\"to_uv\"><scale value=\"{}\"/><translate value=\"{}\"/></transform>\
             </texture>",
            super::xml::escaped(&file),
            list(&[across, -up, 1.0]),
            list(&[right, 1.0 - above, 0.0])
        );
        self.pictures.push(PictureFile { name: file, texture: texture.clone(), factor });
        text
    }
}

fn indices(ior: f32) -> String {
    format!("{}{}", float("int_ior", ior), float("ext_ior", 1.0))
}

fn glass([reflected, crossing]: &[Colour; 2]) -> String {
    let reflected = colour("specular_reflectance", reflected);
    format!("{reflected}{}", colour("specular_transmittance", crossing))
}

/// Nothing where it is smooth.
fn microfacets(alpha: f32) -> String {
    if alpha == 0.0 {
        return String::new();
    }
    format!("<string name=\"distribution\" value=\"ggx\"/>{}", float("alpha", alpha))
}
