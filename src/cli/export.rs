//! `joton export SCENE -o OUT.xml`: the scene as other renderers read it.

use super::render::Spectral;
use super::{DONE, tell};
use clap::Args;
use joton::output;
use joton::output::export::{self, Fidelity};
use joton::{Error, Result};
use std::path::PathBuf;

/// Arguments of `joton export`.
#[derive(Debug, Args)]
pub(super) struct ExportArguments {
    /// A scene file (.toml) or a mesh (.obj).
    scene: PathBuf,
    /// Where to write: Mitsuba 3 XML, with meshes (.ply) beside it.
    #[arg(short, long, value_name = "OUT.xml")]
    output: PathBuf,
    /// Image size, instead of the scene's.
    #[arg(long, value_name = "WxH", value_parser = super::render::parse_size)]
    size: Option<[u32; 2]>,
    /// Write for Mitsuba's spectral variants: auto where the scene has spectra; off for its rgb variants.
    #[arg(long, default_value = "auto")]
    spectral: Spectral,
    /// Write rough surfaces, too, which others define a little differently.
    #[arg(long)]
    near: bool,
}

pub(super) fn run(a: &ExportArguments) -> Result<u8> {
    if a.output.extension().is_none_or(|e| !e.eq_ignore_ascii_case("xml")) {
        let what = format!("{}: the kind of file is not known", a.output.display());
        return Err(Error::usage(what, "give a name that ends in .xml"));
    }
    output::check_writable(&a.output)?;
    let mut scene = joton::scene::load(&a.scene)?;
    a.spectral.set(&mut scene);
    if let Some(size) = a.size {
        scene.resize(size);
    }
    for warning in &scene.warnings {
        tell(format_args!("joton: warning: {warning}"));
    }
    let fidelity = if a.near { Fidelity::Near } else { Fidelity::Exact };
    let exported = export::write_mitsuba(&scene, &a.scene, &a.output, fidelity)?;
    let variant = if scene.wavelengths.are_rendered { "spectral" } else { "rgb" };
    let others = exported.files.len() - 1;
    tell(format_args!(
        "joton: {} for variants of {variant}, and {others} files beside it",
        a.output.display()
    ));
    Ok(DONE)
}
