//! `joton plan SCENE`: what the scene needs, what is skipped and why.

use super::{DONE, say};
use clap::Args;
use joton::film::Layer;
use joton::pack::PackedScene;
use joton::plan::{Plan, Settings};
use joton::{Error, Result};
use serde_json::json;
use std::path::PathBuf;

/// Arguments of `joton plan`.
#[derive(Debug, Args)]
pub(super) struct PlanArguments {
    /// A scene file (.toml) or a mesh (.obj).
    scene: PathBuf,
    /// Light paths to render, e.g. "LS+DE".
    #[arg(long, value_name = "EXPR")]
    paths: Option<String>,
    /// Do what the scene does not need, too: all, or names as they are told here.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    no_skip: Vec<String>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(a: &PlanArguments) -> Result<u8> {
    let scene = joton::scene::load(&a.scene)?;
    let packed = PackedScene::new(&scene);
    let mut settings = Settings { keep: super::render::kept(&a.no_skip)?, ..Settings::default() };
    if let Some(paths) = &a.paths {
        settings.paths = joton::paths::LightPaths::parse(paths)?;
    }
    let plan = Plan::new(&packed, settings);
    let scale = packed.world_scale;
    let layers: Vec<&str> = Layer::ALL.into_iter().filter(|&l| plan.traces(l)).map(Layer::name).collect();
    if a.json {
        let value = json!({
            "triangles": packed.triangles.len(),
            "emitters": packed.emitters.len(),
            "layers": layers,
            "caustic_jotons": plan.caustic_jotons,
            "diffuse_jotons": plan.diffuse_jotons,
            "shadow_rays": plan.settings.shadow_rays,
            "warps": plan.guides.caustic.warps().len() + plan.guides.diffuse.warps().len(),
            "caustic_radius": plan.caustic.base * scale,
            "diffuse_radius": plan.diffuse.base * scale,
            "skipped": plan.skipped,
            "warnings": scene.warnings,
        });
        let text = serde_json::to_string_pretty(&value)
            .map_err(|e| Error::usage(e.to_string(), "report this as a bug of joton"))?;
        say(text);
        return Ok(DONE);
    }
    say(format_args!("{} triangles, {} emitters", packed.triangles.len(), packed.emitters.len()));
    say(format_args!("layers: {}", layers.join(", ")));
    for (what, jotons, schedule) in [
        ("caustic map", plan.caustic_jotons, &plan.caustic),
        ("diffuse map", plan.diffuse_jotons, &plan.diffuse),
    ] {
        if jotons > 0 {
            say(format_args!("{what}: {jotons} jotons a pass, radius {:.4}", schedule.base * scale));
        }
    }
    for (what, guide) in [
        ("caustic jotons", &plan.guides.caustic),
        ("diffuse jotons", &plan.guides.diffuse),
        ("shadow rays", &plan.guides.direct),
    ] {
        if !guide.is_empty() {
            let warps = guide.warps().len();
            say(format_args!("{what}: lamps picked by what the camera can use, {warps} of them warped"));
        }
    }
    if plan.traces(Layer::Direct) {
        say(format_args!("direct light: {} shadow rays a pixel and pass", plan.settings.shadow_rays));
    }
    for s in &plan.skipped {
        let (what, name, why, back) = (s.what.words(), s.what.name(), s.why.words(), s.why.back());
        say(format_args!("skipped {what} ({name}): {why}; back with {back}"));
    }
    for w in &scene.warnings {
        say(format_args!("warning {w}"));
    }
    Ok(DONE)
}
