//! Rendering with and without skips.

pub use crate::common::renders::{Side, plan_keeping as plan, run, unresolved};
use joton::film::stats::{Estimate, test_equal};
use joton::film::{Image, Layer, Picture};
use joton::packed::PackedScene;
use joton::plan::Part;
use joton::scene::Scene;
use joton::spectrum::BANDS;
use std::sync::Arc;

/// Scenes of the repository.
pub const SCENES: [&str; 7] = ["cornell", "furnace", "pedestal", "pool", "ring", "rooms", "spheres"];

/// The photon mapper on threads and, where there is one, on a device.
pub fn both() -> Vec<Side> {
    let device = crate::common::device().map(|_| Side::Device);
    [Side::Host].into_iter().chain(device).collect()
}

/// A packed scene with some parts kept.
pub fn packed(scene: &Scene, keep: &[Part]) -> Arc<PackedScene> {
    let whole = keep.contains(&Part::OutOfReach);
    Arc::new(if whole { PackedScene::whole(scene) } else { PackedScene::new(scene) })
}

/// The bits of all layers.
pub fn bits(picture: &Picture) -> Vec<[u32; BANDS]> {
    picture.layers.iter().flat_map(|l| &l.pixels).map(|p| p.map(f32::to_bits)).collect()
}

/// Chance that one comparison of equal images fails, over random seeds.
pub const SIGNIFICANCE: f64 = 1e-4;

/// Assert that two sets of pictures have the same mean in every layer, by blocks of so many pixels across.
pub fn is_alike(name: &str, a: &[Picture], b: &[Picture], blocks: &[u32]) {
    for layer in Layer::ALL {
        for &block in blocks {
            let [x, y] = [a, b].map(|pictures| {
                let images: Vec<Image> = pictures.iter().map(|p| p.layers[layer as usize].clone()).collect();
                Estimate::from_renders(&images, block).unwrap_or_else(|e| panic!("{e}"))
            });
            let outcome = test_equal(&x, &y).unwrap_or_else(|e| panic!("{e}"));
            println!("{name}, {}, blocks of {block}: p = {:.2e}", layer.name(), outcome.p_value);
            assert!(
                outcome.accepts(SIGNIFICANCE),
                "{name}, {}, blocks of {block}: {outcome:?}",
                layer.name()
            );
        }
    }
}

/// True where a layer holds no light at all.
pub fn is_black(picture: &Picture, layer: Layer) -> bool {
    picture.layers[layer as usize].pixels.iter().flatten().all(|x| *x == 0.0)
}
