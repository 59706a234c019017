//! Rendering with as many seeds as a test asks for.

pub use crate::common::renders::{Side, open, run};
use crate::common::renders::{plan_keeping, unresolved};
use joton::film::{Image, Layer, Picture};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan};
use joton::scene::Scene;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

/// Every path from a light to the eye.
pub const EVERYTHING: &str = "L.*E";

/// One of the scenes of the repository at `size` × `size` pixels.
pub fn file(name: &str, size: u32) -> Scene {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name);
    let mut scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
    scene.resize([size; 2]);
    scene
}

/// The plan of a packed scene.
pub fn plan(scene: &PackedScene, paths: &str, seed: u32) -> Plan {
    plan_keeping(scene, paths, seed, &[])
}

/// The plan with diffuse light by its map.
pub fn plan_by_map(scene: &PackedScene, paths: &str, seed: u32) -> Plan {
    plan_keeping(scene, paths, seed, &[Part::DiffuseMap])
}

/// Who makes plans.
pub type Planner = fn(&PackedScene, &str, u32) -> Plan;

/// Independent renders of a plan that `adjust` may change, bare means of their passes.
pub fn pictures(
    side: Side,
    scene: &Arc<PackedScene>,
    paths: &str,
    seeds: Range<u32>,
    passes: u64,
    adjust: impl Fn(&mut Plan),
) -> Vec<Picture> {
    pictures_of(plan, side, scene, paths, seeds, passes, adjust)
}

/// Likewise of the plans that `planner` makes.
pub fn pictures_of(
    planner: Planner,
    side: Side,
    scene: &Arc<PackedScene>,
    paths: &str,
    seeds: Range<u32>,
    passes: u64,
    adjust: impl Fn(&mut Plan),
) -> Vec<Picture> {
    // seeds of the sides are never the same
    let first = crate::chi_square::seed() * 10_000 + side as u32 * 1000;
    let render = |s| {
        let mut plan = unresolved(planner(scene, paths, first + s));
        adjust(&mut plan);
        run(side, scene, plan, passes).picture
    };
    seeds.map(render).collect()
}

/// One layer of each picture.
pub fn layer(pictures: &[Picture], layer: Layer) -> Vec<Image> {
    pictures.iter().map(|p| p.layers[layer as usize].clone()).collect()
}
