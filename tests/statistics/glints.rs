//! Glints: trees look where lamps are seen through glass. The mean stays, the noise goes [E25].

use crate::renders::{EVERYTHING, Side, file, open, plan};
use joton::estimators::split_paths::{Light, Look, SplitPaths};
use joton::film::{Layer, RELATIVE_OFFSET};
use joton::packed::PackedScene;
use joton::scene::Scene;
use joton::spectrum::BANDS;
use std::sync::Arc;

const SIDE: u32 = 48;
const PASSES: u64 = 64;

/// Sums over passes of a pixel's emission, and of its square, all bands together.
struct Moments {
    sum: Vec<f64>,
    square: Vec<f64>,
}

/// The emission of passes as they come, without more trees where it is noisy; of the host without any, if so wished.
fn emission(side: Side, scene: &Arc<PackedScene>, trees: bool) -> Moments {
    let mut backend = open(side, scene, plan(scene, EVERYTHING, 1));
    if !trees {
        let nothing = Look { light: Light::Nowhere, branched: false, square: 0.0, squared_mean: 0.0 };
        let none = SplitPaths::mark(scene.size, &vec![nothing; scene.pixels()], &[]);
        backend.set_split_paths(none).unwrap_or_else(|e| panic!("{e}"));
    }
    let mut m = Moments { sum: vec![0.0; scene.pixels()], square: vec![0.0; scene.pixels()] };
    for pass in 0..PASSES {
        let batch = backend.render(pass, 1).unwrap_or_else(|e| panic!("{e}"));
        for (i, x) in batch.layers[Layer::Emission as usize].iter().enumerate() {
            let x = x.iter().map(|b| f64::from(*b)).sum::<f64>();
            m.sum[i] += x;
            m.square[i] += x * x;
        }
    }
    m
}

impl Moments {
    /// Mean over the image of the standard deviation of a pass, relative to the radiance of `whole` (the variance would be that
    /// of a pixel or two); and mean of the emission with its standard error.
    fn tell(&self, whole: &[f64]) -> (f64, f64, f64) {
        let (passes, pixels) = (PASSES as f64, self.sum.len() as f64);
        let variance = |i: usize| self.square[i] / passes - (self.sum[i] / passes).powi(2);
        let relative = |i: usize| variance(i) / (whole[i] * whole[i] + RELATIVE_OFFSET * BANDS as f64);
        let noise = (0..self.sum.len()).map(|i| relative(i).max(0.0).sqrt()).sum::<f64>() / pixels;
        let error = ((0..self.sum.len()).map(variance).sum::<f64>() / passes).sqrt() / pixels;
        (noise, self.sum.iter().sum::<f64>() / passes / pixels, error)
    }
}

/// A box with a ball of glass and one of mirror, whose white walls glow: the balls show light everywhere.
fn glowing() -> Scene {
    let mut scene = file("spheres.toml", SIDE);
    for m in &mut scene.materials {
        let white = m.diffuse[0] > 0.0 && m.diffuse[0] == m.diffuse[1];
        m.emission = [if white { 1.0 } else { 0.0 }; 3];
    }
    scene
}

/// Beside eye paths alone the trees that the pilot asks for take most of the noise
/// and leave the mean; the device's do what the host's do.
#[test]
fn trees_take_the_noise_and_leave_the_mean() {
    let scene = Arc::new(PackedScene::new(&glowing()));
    let alone = emission(Side::Host, &scene, false);
    let whole: Vec<f64> = alone.sum.iter().map(|x| x / PASSES as f64).collect();
    let (noise_alone, mean_alone, error_alone) = alone.tell(&whole);
    let device = crate::common::device().map(|_| Side::Device);
    let mut noises = Vec::new();
    for side in [Side::Host].into_iter().chain(device) {
        let (noise, mean, error) = emission(side, &scene, true).tell(&whole);
        println!(
            "{side:?}: noise {noise:.3e} of {noise_alone:.3e}; mean {mean} ± {error}, {mean_alone} ± {error_alone}"
        );
        assert!(noise < 0.5 * noise_alone, "{side:?}: {noise} of {noise_alone}");
        let z = (mean - mean_alone) / error.hypot(error_alone);
        assert!(z.abs() < 4.0, "{side:?}: mean {mean} ± {error}, {mean_alone} ± {error_alone}");
        noises.push(noise);
    }
    // a few hundred pixels, each to a tenth
    assert!(noises.iter().all(|n| (n / noises[0] - 1.0).abs() < 0.05), "{noises:?}");
}
