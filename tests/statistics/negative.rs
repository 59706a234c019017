//! Negative light: the weights that make up for what a disc loses at an edge [E15] can be negative, nothing else can. Without
//! any clamp it averages out.

use crate::renders::{EVERYTHING, Side, file, open, plan_by_map};
use joton::film::{Film, Layer};
use joton::packed::PackedScene;
use std::sync::Arc;

const SIZE: u32 = 24;
/// Jotons a pass: so few that single ones show.
const JOTONS: u32 = 512;
/// Passes after which the negative part is looked at.
const CHECKPOINTS: [u64; 4] = [1, 4, 16, 64];

/// From one checkpoint to the next, four times as many passes, the share falls to this at most: a third was seen.
const SHRINKS: f64 = 0.6;
/// What is left in the end, with a thirtieth of a render's jotons; 3e-4 was seen.
const TINY: f64 = 1e-3;

/// Sums of what is negative over what is positive, in a layer.
fn share(film: &Film, layer: Layer) -> f64 {
    let picture = film.picture();
    let sum = |sign: f32| {
        let pixels = picture.layers[layer as usize].pixels.iter().flatten();
        pixels.map(|x| f64::from((x * sign).max(0.0))).sum::<f64>()
    };
    let [plus, minus] = [1.0, -1.0].map(sum);
    if minus == 0.0 { 0.0 } else { minus / plus }
}

#[test]
fn negative_light_averages_out() {
    for name in ["cornell.toml", "spheres.toml"] {
        for side in [Side::Host, Side::Device] {
            if side == Side::Device && crate::common::device().is_none() {
                continue;
            }
            let scene = Arc::new(PackedScene::new(&file(name, SIZE)));
            let mut plan = plan_by_map(&scene, EVERYTHING, 1);
            plan.diffuse_jotons = JOTONS;
            let mut backend = open(side, &scene, plan);
            let mut film = Film::new(SIZE, SIZE);
            let mut shares = Vec::new();
            for pass in 0..CHECKPOINTS[CHECKPOINTS.len() - 1] {
                let batch = backend.render(pass, 1).unwrap_or_else(|e| panic!("{e}"));
                film.add(1, &batch.layers);
                if CHECKPOINTS.contains(&(pass + 1)) {
                    for layer in [Layer::Emission, Layer::Direct, Layer::Caustic] {
                        assert_eq!(share(&film, layer), 0.0, "{name}, {side:?}: {}", layer.name());
                    }
                    shares.push(share(&film, Layer::Diffuse));
                }
            }
            println!("{name}, {side:?}: {shares:?}");
            assert!(shares[0] > 1e-3, "{name}, {side:?}: there is nothing to see: {shares:?}");
            assert!(
                shares.windows(2).all(|w| w[1] <= (SHRINKS * w[0]).max(TINY)),
                "{name}, {side:?}: {shares:?}"
            );
            assert!(shares[3] < TINY, "{name}, {side:?}: {shares:?}");
        }
    }
}
