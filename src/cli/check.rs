//! `joton check SCENE`: reads a scene as a render would, and tells what is wrong with it.

use super::{DONE, FAULTY, pack, say, tell};
use clap::Args;
use joton::Result;
use joton::plan::Settings;
use std::path::PathBuf;

/// Arguments of `joton check`.
#[derive(Debug, Args)]
pub(super) struct CheckArguments {
    /// A scene file (.toml) or a mesh (.obj).
    scene: PathBuf,
    /// Exit with status 1 where there are warnings.
    #[arg(long)]
    strict: bool,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

/// What was read.
#[derive(serde::Serialize)]
struct Checked {
    scene: PathBuf,
    size: [u32; 2],
    triangles: usize,
    /// Outside of the closed room around the camera.
    out_of_reach: usize,
    materials: usize,
    /// Triangles that shine, and lights.
    emitters: usize,
    files: Vec<PathBuf>,
    warnings: Vec<String>,
}

pub(super) fn run(a: &CheckArguments) -> Result<u8> {
    let scene = joton::scene::load(&a.scene)?;
    let packed = pack(&scene, &Settings::default())?;
    let mut warnings = scene.warnings.clone();
    warnings.extend(joton::packed::doubts(&scene, &packed));
    let is_faulty = a.strict && !warnings.is_empty();
    let checked = Checked {
        scene: a.scene.clone(),
        size: scene.size,
        triangles: scene.mesh.triangles.len(),
        out_of_reach: packed.out_of_reach.triangles,
        // the rest of a mixture is in the list, too
        materials: scene.materials.iter().filter(|m| m.mixture.is_none()).count(),
        emitters: packed.emitters.len(),
        files: scene.files,
        warnings,
    };
    if a.json {
        super::say_json(&checked)?;
    } else {
        let [width, height] = checked.size;
        say(format_args!(
            "{}: {}, {}, {}, {width} × {height} pixels",
            a.scene.display(),
            counted(checked.triangles, "triangle"),
            counted(checked.materials, "material"),
            counted(checked.emitters, "emitter"),
        ));
        if checked.out_of_reach > 0 {
            let count = checked.out_of_reach;
            say(format_args!("{count} triangles outside of the closed room around the camera are left out"));
        }
        for warning in &checked.warnings {
            say(format_args!("warning: {warning}"));
        }
    }
    if is_faulty {
        tell(format_args!(
            "joton: {}, and --strict accepts none",
            counted(checked.warnings.len(), "warning")
        ));
    }
    Ok(if is_faulty { FAULTY } else { DONE })
}

/// So many of something.
fn counted(count: usize, what: &str) -> String {
    format!("{count} {what}{}", if count == 1 { "" } else { "s" })
}
