//! Random scenes: what must hold of any. A few in CI; `PROPTEST_CASES=n` renders n, the few first.

use crate::recipe::{Recipe, SIZE, recipe};
use crate::renders::{EVERYTHING, Planner, Side, open, plan, plan_by_map};
use joton::backend::Tally;
use joton::film::{LAYERS, Layer};
use joton::packed::PackedScene;
use joton::spectrum::BANDS;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::sync::Arc;

/// Scenes in CI.
const CASES: u32 = 12;
/// Passes of a scene, whose spread is the noise; of the path tracer more, since one path tells little.
const PASSES: u32 = 16;
const PATHS: u32 = 256;
/// Jotons a pass of each map.
const JOTONS: u32 = 8192;
/// Differences that are allowed, in standard errors. Passes of one seed are stratified against each other: their spread
/// is no smaller than the noise.
const SIGMAS: f64 = 6.0;

/// The same scenes in every run.
fn runner() -> TestRunner {
    let cases =
        std::env::var("PROPTEST_CASES").map_or(CASES, |n| n.parse().expect("PROPTEST_CASES is a number"));
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    let mut seed = [0; 32];
    seed[..4].copy_from_slice(&crate::chi_square::seed().to_le_bytes());
    TestRunner::new_with_rng(config, TestRng::from_seed(RngAlgorithm::ChaCha, &seed))
}

/// What a side made of a scene.
struct Rendered {
    side: Side,
    /// Means of each layer and band over the image, pass by pass.
    passes: Vec<[[f64; BANDS]; LAYERS]>,
    tallies: Vec<Tally>,
    /// Sums over the passes' mean image of what is positive and of what is negative, of each layer.
    parts: [[f64; 2]; LAYERS],
}

/// Render pass by pass; what is not finite fails at once.
fn render(side: Side, planner: Planner, scene: &Arc<PackedScene>, paths: &str, passes: u32) -> Rendered {
    let mut plan = planner(scene, paths, 1 + side as u32);
    for jotons in [&mut plan.caustic_jotons, &mut plan.diffuse_jotons] {
        *jotons = (*jotons).min(JOTONS);
    }
    let mut backend = open(side, scene, plan);
    let mut sums: [Vec<f64>; LAYERS] = std::array::from_fn(|_| vec![0.0; scene.pixels() * BANDS]);
    let mut rendered = Rendered { side, passes: Vec::new(), tallies: Vec::new(), parts: [[0.0; 2]; LAYERS] };
    for pass in 0..passes {
        let batch = backend.render(u64::from(pass), 1).unwrap_or_else(|e| panic!("{e}"));
        for (sum, x) in sums.iter_mut().flatten().zip(batch.layers.iter().flatten().flatten()) {
            assert!(x.to_bits() & 0x7f80_0000 != 0x7f80_0000, "{side:?}: {x} in the film");
            *sum += f64::from(*x);
        }
        rendered.passes.push(batch.layers.map(|layer| {
            std::array::from_fn(|b| layer.iter().map(|p| f64::from(p[b])).sum::<f64>() / layer.len() as f64)
        }));
        assert_eq!(batch.tally.non_finite.total(), 0, "{side:?}: {:?}", batch.tally.non_finite);
        rendered.tallies.push(batch.tally);
    }
    rendered.parts = sums.map(|layer| {
        let part = |sign: f64| layer.iter().map(|x| (x * sign).max(0.0)).sum::<f64>();
        [part(1.0), part(-1.0)]
    });
    rendered
}

/// A mean and its standard error.
type Seen = (f64, f64);

fn mean(values: impl Iterator<Item = f64> + Clone) -> Seen {
    let n = values.clone().count() as f64;
    let mean = values.clone().sum::<f64>() / n;
    let square: f64 = values.map(|v| (v - mean).powi(2)).sum();
    (mean, (square / (n - 1.0) / n).sqrt())
}

impl Rendered {
    fn layer(&self, layer: Layer, band: usize) -> Seen {
        mean(self.passes.iter().map(move |p| p[layer as usize][band]))
    }

    /// Emitted − absorbed − escaped over emitted.
    fn imbalance(&self) -> Seen {
        let total = |x: &[f64; BANDS]| x.iter().sum::<f64>();
        let emitted = self.tallies.iter().map(|t| total(&t.emitted)).sum::<f64>() / self.tallies.len() as f64;
        let lost = |t: &Tally| total(&t.emitted) - total(&t.absorbed) - total(&t.escaped);
        mean(self.tallies.iter().map(move |t| lost(t) / emitted.max(f64::MIN_POSITIVE)))
    }

    /// Light is balanced within its standard error. Slack for errors that have no expectation: a sixteenth of a per cent
    /// of the flux may be on long ways between mirrors, of which few jotons tell.
    fn check_energy(&self) -> Result<(), String> {
        const SLACK: f64 = 6e-4;
        let (off, error) = self.imbalance();
        let fine = off.abs() <= SIGMAS * error + SLACK;
        if fine { Ok(()) } else { Err(format!("{:?}: energy is off by {off:e} ± {error:e}", self.side)) }
    }

    /// Only the diffuse layer's weights can be negative, and they take back less than they give.
    fn check_sign(&self, unit: f64) -> Result<(), String> {
        let unit = unit * (self.passes.len() * BANDS * (SIZE * SIZE) as usize) as f64;
        for layer in Layer::ALL {
            let [plus, minus] = self.parts[layer as usize];
            let most = if layer == Layer::Diffuse { 0.5 * plus + unit } else { 0.0 };
            if minus > most {
                return Err(format!("{:?}, {}: {minus:e} is negative of {plus:e}", self.side, layer.name()));
            }
        }
        Ok(())
    }

    /// The same light as another side saw, but for `slack` of it and for what is nothing beside `unit`.
    fn check_alike(&self, other: &Rendered, layer: Layer, slack: f64, unit: f64) -> Result<(), String> {
        for band in 0..BANDS {
            let [a, b] = [self, other].map(|r| r.layer(layer, band));
            let allowed = SIGMAS * a.1.hypot(b.1) + slack * a.0.abs().max(b.0.abs()) + unit;
            if (a.0 - b.0).abs() > allowed {
                let [x, y] = [self.side, other.side];
                return Err(format!("{}, band {band}: {x:?} {a:?}, {y:?} {b:?}", layer.name()));
            }
        }
        Ok(())
    }
}

/// Everything that is claimed of a scene.
fn check(recipe: &Recipe) -> Result<(), String> {
    /// Part of the mean exitance that counts as none: a joton carries 1e-5 of the flux, and the camera may look at a
    /// hundredth of the surfaces, so this is what one joton or ten show. Where light is rarer, one side may see none.
    const NOTHING: f64 = 1e-4;
    let scene = Arc::new(PackedScene::new(&recipe.scene()));
    let area: f64 = scene.triangles.iter().map(|t| f64::from(t.area())).sum();
    let unit = NOTHING * scene.total_flux.iter().copied().fold(0.0, f64::max) / area;
    let host = render(Side::Host, plan, &scene, EVERYTHING, PASSES);
    host.check_energy()?;
    host.check_sign(unit)?;
    // jotons of the diffuse map tell most of the balance
    let by_map = render(Side::Host, plan_by_map, &scene, EVERYTHING, PASSES);
    by_map.check_energy()?;
    by_map.check_sign(unit)?;
    // light that one bounce brings, and no mirror: the path tracer finds all of it
    let bounced = [Side::Host, Side::PathTracer].map(|side| {
        let passes = if side == Side::Host { PASSES } else { PATHS };
        render(side, plan, &scene, "LDDE", passes)
    });
    bounced[0].check_alike(&bounced[1], Layer::Diffuse, 0.2, unit)?;
    let path_tracer = render(Side::PathTracer, plan, &scene, EVERYTHING, PATHS);
    for layer in [Layer::Emission, Layer::Direct] {
        host.check_alike(&path_tracer, layer, 0.02, unit)?;
    }
    if crate::common::device().is_some() {
        let device = render(Side::Device, plan, &scene, EVERYTHING, PASSES);
        device.check_energy()?;
        device.check_sign(unit)?;
        for layer in Layer::ALL {
            device.check_alike(&host, layer, 0.02, unit)?;
        }
        let device = render(Side::Device, plan_by_map, &scene, EVERYTHING, PASSES);
        device.check_energy()?;
        device.check_sign(unit)?;
        device.check_alike(&by_map, Layer::Diffuse, 0.02, unit)?;
    }
    Ok(())
}

#[test]
fn random_scenes_hold_what_any_must() {
    let outcome =
        runner().run(&recipe(), |recipe| check(&recipe).map_err(proptest::test_runner::TestCaseError::fail));
    if let Err(e) = outcome {
        panic!("{e}");
    }
}
