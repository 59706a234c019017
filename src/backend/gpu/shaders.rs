//! The WGSL sources, linked: a file names what it needs in `// import: room/x.wgsl` lines; WGSL takes declarations
//! in any order, so each file is appended once.

use crate::error::{Error, Result};
use crate::packed::{heap, wgsl};
use std::sync::LazyLock;

/// Every shader file: path under shaders/, text.
pub const SOURCES: &[(&str, &str)] = include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// Which of two files a kernel is linked with.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Hash)]
pub struct Variant {
    /// Lanes share loads by subgroup operations.
    pub subgroups: bool,
    /// The scene lies in uniform buffers.
    pub small_scene: bool,
    /// The heap is more than one binding holds.
    pub split_heap: bool,
    /// No surface is of microfacets.
    pub no_facets: bool,
    /// No microfacets are rougher one way than the other.
    pub no_anisotropy: bool,
    /// No microfacets vary over a surface.
    pub no_facet_textures: bool,
    /// No surface has a picture of normals or heights.
    pub no_relief: bool,
    /// Nothing shines by a texture.
    pub no_glow: bool,
    /// No surface has a texture, and none is cut.
    pub no_textures: bool,
    /// No light sample may lie in a lobe that is followed.
    pub no_followed_light: bool,
    /// No body's inside matters.
    pub no_media: bool,
    /// No material has layers.
    pub no_layers: bool,
}

impl Variant {
    /// The file that is linked where `path` is imported; none where nothing is.
    fn choose<'a>(&self, path: &'a str) -> Option<&'a str> {
        let (wanted, other) = match path {
            "maps/lanes.wgsl" => (!self.subgroups, Some("maps/lanes_alone.wgsl")),
            "scene/scene.wgsl" => (self.small_scene, Some("scene/scene_small.wgsl")),
            "scene/heap.wgsl" => (self.split_heap, Some("scene/heap_split.wgsl")),
            "shading/fresnel.wgsl" => (self.no_facets, Some("shading/no_facets.wgsl")),
            "shading/undercoat.wgsl" | "shading/microfacet.wgsl" | "shading/rough_interface.wgsl" => {
                (self.no_facets, None)
            }
            "shading/anisotropy.wgsl" => (self.no_anisotropy, Some("shading/no_anisotropy.wgsl")),
            "shading/brushed_way.wgsl" => (self.no_anisotropy, Some("shading/no_brushed_way.wgsl")),
            "shading/layers.wgsl" => (self.no_layers || self.no_facets, Some("shading/no_layers.wgsl")),
            "shading/layered_lobes.wgsl" => (self.no_layers || self.no_facets, None),
            "shading/facet_textures.wgsl" => (self.no_facet_textures, Some("shading/no_facet_textures.wgsl")),
            "shading/relief.wgsl" => (self.no_relief, Some("shading/no_relief.wgsl")),
            "lights/glow.wgsl" => (self.no_glow, Some("lights/no_glow.wgsl")),
            "shading/texture.wgsl" => (self.no_textures, Some("shading/no_textures.wgsl")),
            "accel/cutout.wgsl" => (self.no_textures, Some("accel/no_cutouts.wgsl")),
            "lights/followed.wgsl" => (self.no_followed_light, Some("lights/no_followed_light.wgsl")),
            "shading/media.wgsl" => (self.no_media, Some("shading/no_media.wgsl")),
            _ => (false, None),
        };
        if wanted { other } else { Some(path) }
    }
}

/// A kernel file with everything it imports and the shared structs.
///
/// # Errors
/// [`Error::Device`] where an import names no file.
pub fn link(path: &str, variant: Variant) -> Result<String> {
    link_source(find(path)?, variant)
}

/// Like [`link`], for a text that is no file (tests of shared functions).
///
/// # Errors
/// [`Error::Device`] where an import names no file.
pub fn link_source(text: &str, variant: Variant) -> Result<String> {
    let mut linked = wgsl::declarations();
    let mut done: Vec<&str> = Vec::new();
    append(text, variant, &mut linked, &mut done)?;
    Ok(linked)
}

fn append<'a>(text: &'a str, variant: Variant, linked: &mut String, done: &mut Vec<&'a str>) -> Result<()> {
    for line in text.lines() {
        if let Some(path) = line.strip_prefix("// import: ") {
            let Some(path) = variant.choose(path.trim()) else { continue };
            if !done.contains(&path) {
                done.push(path);
                append(find(path)?, variant, linked, done)?;
            }
        }
    }
    linked.push_str(text);
    Ok(())
}

/// The file that Rust writes: functions that read the records of the scene.
static READERS: LazyLock<String> = LazyLock::new(heap::readers);

fn find(path: &str) -> Result<&'static str> {
    if path == "scene/readers.wgsl" {
        return Ok(READERS.as_str());
    }
    SOURCES.iter().find(|(name, _)| *name == path).map(|(_, text)| *text).ok_or_else(|| {
        Error::device(format!("shader file {path} does not exist"), "write it, or correct the import")
    })
}
