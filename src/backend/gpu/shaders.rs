//! The WGSL sources, linked: a file names what it needs in `// import: shared/x.wgsl` lines; WGSL takes declarations
//! in any order, so each file is appended once.

use crate::error::{Error, Result};
use crate::packed::layout;

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        /// Every shader file: path under shaders/, text.
        pub const SOURCES: &[(&str, &str)] = &[$(($path, include_str!(concat!("../../../shaders/", $path)))),*];
    };
}

sources![
    "eye.wgsl",
    "glint.wgsl",
    "glint_mark.wgsl",
    "glint_sum.wgsl",
    "direct.wgsl",
    "trace.wgsl",
    "lane_counts.wgsl",
    "scan.wgsl",
    "map_keys.wgsl",
    "radix.wgsl",
    "map_starts.wgsl",
    "map_reorder.wgsl",
    "boundary.wgsl",
    "clip.wgsl",
    "gather.wgsl",
    "caustic_count.wgsl",
    "caustic_radius.wgsl",
    "shared/rng.wgsl",
    "shared/sampling.wgsl",
    "shared/reservoir.wgsl",
    "shared/bsdf.wgsl",
    "shared/intersect.wgsl",
    "shared/crossing.wgsl",
    "shared/surface.wgsl",
    "shared/scatter.wgsl",
    "shared/emitter.wgsl",
    "shared/emit.wgsl",
    "shared/cone.wgsl",
    "shared/warp.wgsl",
    "shared/marks.wgsl",
    "shared/camera.wgsl",
    "shared/survival.wgsl",
    "shared/paths.wgsl",
    "shared/splits.wgsl",
    "shared/trees.wgsl",
    "shared/clip.wgsl",
    "shared/grid.wgsl",
    "shared/index.wgsl",
    "shared/live.wgsl",
    "shared/count.wgsl",
    "shared/strip.wgsl",
    "shared/lanes.wgsl",
    "shared/lanes_alone.wgsl",
    "shared/scene.wgsl",
    "shared/scene_small.wgsl",
    "shared/triangles.wgsl",
    "shared/triangles_split.wgsl",
    "shared/features.wgsl",
];

/// Which of two files a kernel is linked with.
#[derive(Debug, Clone, Copy, Default)]
pub struct Variant {
    /// Lanes share loads by subgroup operations.
    pub subgroups: bool,
    /// The scene lies in uniform buffers.
    pub small_scene: bool,
    /// The triangles are more than one binding holds.
    pub split_scene: bool,
}

/// A kernel file with everything it imports and the shared structs.
///
/// # Errors
/// [`Error::Device`] where an import names no file.
pub fn link(path: &str, variant: Variant) -> Result<String> {
    let mut linked = link_source(find(path)?)?;
    for (wanted, file, other) in [
        (!variant.subgroups, "shared/lanes.wgsl", "shared/lanes_alone.wgsl"),
        (variant.small_scene, "shared/scene.wgsl", "shared/scene_small.wgsl"),
        (variant.split_scene, "shared/triangles.wgsl", "shared/triangles_split.wgsl"),
    ] {
        if wanted {
            linked = linked.replace(find(file)?, find(other)?);
        }
    }
    Ok(linked)
}

/// Like [`link`], for a text that is no file (tests of shared functions).
///
/// # Errors
/// [`Error::Device`] where an import names no file.
pub fn link_source(text: &str) -> Result<String> {
    let mut linked = layout::declarations();
    let mut done: Vec<&str> = Vec::new();
    append(text, &mut linked, &mut done)?;
    Ok(linked)
}

fn append<'a>(text: &'a str, linked: &mut String, done: &mut Vec<&'a str>) -> Result<()> {
    for line in text.lines() {
        if let Some(path) = line.strip_prefix("// import: ") {
            let path = path.trim();
            if !done.contains(&path) {
                done.push(path);
                append(find(path)?, linked, done)?;
            }
        }
    }
    linked.push_str(text);
    Ok(())
}

fn find(path: &str) -> Result<&'static str> {
    SOURCES.iter().find(|(name, _)| *name == path).map(|(_, text)| *text).ok_or_else(|| {
        Error::device(format!("shader file {path} does not exist"), "add it to gpu/shaders.rs")
    })
}
