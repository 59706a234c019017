//! The program's own estimate of its error, against the error that a closed form tells.

use crate::build::{Build, Look, glowing, matte, v};
use joton::backend::cpu::CpuBackend;
use joton::film::Image;
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{Reason, Stop, render};
use joton::scene::Scene;
use joton::spectrum::Spectrum;
use joton::spectrum::cie::{xyz, xyz_to_rgb};
use std::sync::Arc;

/// As in `joton compare`.
const OFFSET: f64 = 1e-2;
/// Seeds of each scene.
const SEEDS: u32 = 10;
/// Pixels across and down of a resolved image: of fewer, all share one error, which nothing can tell.
const SHARED: u32 = 64;
/// Passes after which estimates are looked at.
const PASSES: [u64; 3] = [4, 8, 16];
/// Least part of the renders whose error is below the estimate, and most that an estimate is above the error.
const HOLDS: f64 = 0.95;
const PESSIMISM: f64 = 3.0;

/// Scenes whose radiance is one number a band everywhere.
fn scenes(size: u32) -> [(&'static str, Scene, [f64; 3]); 2] {
    let mut room = Build::new(v(0.2, 0.1, -0.3), v(1., 0.3, 0.1), 1.0, size);
    room.cuboid(v(-1., -1., -1.), v(1., 1., 1.), false, &glowing([0.2, 0.5, 0.3], [0.8, 0.5, 0.3]));
    let mut ball = Build::new(v(0.1, 0.2, 0.3), v(1., 0.4, 0.2), 1.0, size);
    ball.sphere(v(0., 0., 0.), 1.0, 4, Look::Inward, &matte([0.2, 0.5, 0.8]));
    ball.point(v(0., 0., 0.), [1.0, 2.0, 3.0]);
    let lit = |albedo: f64, intensity: f64| albedo * intensity / std::f64::consts::PI / (1.0 - albedo);
    [("room", room.0, [1.0, 1.0, 0.3 / 0.7]), ("ball", ball.0, [lit(0.2, 1.0), lit(0.5, 2.0), lit(0.8, 3.0)])]
}

/// Relative error of an image of one radiance, root mean square.
fn truth(image: &Image, want: [f64; 3]) -> f64 {
    let errors = image.pixels.iter().flat_map(|x| {
        (0..3).map(move |b| (f64::from(x[b]) - want[b]).powi(2) / (want[b] * want[b] + OFFSET))
    });
    (errors.sum::<f64>() / (3 * image.pixels.len()) as f64).sqrt()
}

/// Render with a seed until `stop`; estimate and truth after each of [`PASSES`] and at the end.
fn errors(scene: &Scene, want: [f64; 3], seed: u32, resolve: bool, stop: Stop) -> (Vec<[f64; 2]>, Reason) {
    let packed = Arc::new(PackedScene::whole(scene));
    let plan = Plan::new(&packed, Settings { seed, resolve, ..Settings::default() });
    let mut found = Vec::new();
    let mut backend = CpuBackend::new(packed, plan);
    let rendered = render(&mut backend, scene.size, stop, |p| {
        if let (true, Some(estimate)) = (PASSES.contains(&p.passes), p.error) {
            found.push([estimate.total, truth(&p.picture().whole, want)]);
        }
        true
    })
    .expect("renders");
    let estimate = rendered.error_estimate.expect("passes enough for an estimate");
    found.push([estimate.total, truth(&rendered.picture.whole, want)]);
    (found, rendered.reason)
}

/// In at least 95 % of the renders the error is below its estimate, and the estimate below three times the error.
#[test]
fn error_estimate_holds_and_is_not_too_pessimistic() {
    let bare = scenes(16).map(|scene| (scene, false));
    for ((name, scene, want), resolve) in bare.into_iter().chain(scenes(SHARED).map(|scene| (scene, true))) {
        let stop = Stop { passes: PASSES.last().copied(), ..Stop::default() };
        let all: Vec<[f64; 2]> =
            (0..SEEDS).flat_map(|seed| errors(&scene, want, seed, resolve, stop).0).collect();
        let share = |holds: &dyn Fn(&[f64; 2]) -> bool| {
            all.iter().filter(|e| holds(e)).count() as f64 / all.len() as f64
        };
        let bounded = share(&|[estimate, truth]| truth <= estimate);
        let useful = share(&|[estimate, truth]| *estimate <= PESSIMISM * truth);
        println!("{name}: {bounded} bounded, {useful} useful, of {}", all.len());
        assert!(bounded >= HOLDS && useful >= HOLDS, "{name}: {bounded} bounded, {useful} useful: {all:.4?}");
    }
}

/// A plane under the sun, rendered by wavelength: its colours, which wavelengths make, are all that can be wrong; they follow by
/// integration. The passes that are compared have wavelengths of their own. What their difference tells is one to three times
/// the error, root mean square over seeds.
#[test]
fn by_wavelength_the_estimate_tells_the_error_of_colours() {
    let (albedo, sun) = ([0.7, 0.5, 0.3], [3.0; 3]);
    let reflectance = Spectrum::reflectance_of_rgb(albedo.map(f64::from));
    let light = Spectrum::emission_of_rgb(sun.map(f64::from));
    let want = xyz_to_rgb(xyz(|lambda| light.at(lambda) * reflectance.at(lambda) / std::f64::consts::PI));
    let mut plane = Build::new(v(0., 0., 2.), v(0., 0., 0.), 0.2, 8);
    plane.quad(v(-2., -2., 0.), v(4., 0., 0.), v(0., 4., 0.), &matte(albedo));
    plane.sun(v(0., 0., -1.), sun);
    let mut scene = plane.0;
    scene.wavelengths.are_rendered = true;
    let stop = Stop { passes: PASSES.last().copied(), ..Stop::default() };
    let last = |seed: u32| errors(&scene, want, seed, false, stop).0.pop().expect("an estimate");
    let all: Vec<[f64; 2]> = (0..4 * SEEDS).map(last).collect();
    let mean = |k: usize| (all.iter().map(|e| e[k].powi(2)).sum::<f64>() / all.len() as f64).sqrt();
    println!("told {:.5}, truth {:.5}", mean(0), mean(1));
    assert!((1.0..PESSIMISM).contains(&(mean(0) / mean(1))), "{all:.5?}");
}

/// A render that is asked for an error stops when its estimate is met, and the truth is below it.
#[test]
fn asked_for_an_error_it_stops_below_it() {
    let wanted = 0.02;
    for (name, scene, want) in scenes(SHARED) {
        let stop = Stop { error: Some(wanted), passes: Some(4096), ..Stop::default() };
        let (found, reason) = errors(&scene, want, 1, true, stop);
        assert_eq!(reason, Reason::Error, "{name}");
        let [estimate, truth] = found[found.len() - 1];
        assert!(truth <= estimate && estimate <= wanted, "{name}: estimate {estimate}, truth {truth}");
    }
}
