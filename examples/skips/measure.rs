//! Renders with and without a skip, timed in turns, and how far they are from a reference and from each other.

use super::Effort;
use super::twins::Case;
use cpu_time::ProcessTime;
use joton::backend::Backend;
use joton::backend::cpu::CpuBackend;
use joton::backend::gpu::{Context, GpuBackend};
use joton::film::Image;
use joton::film::paths::LightPaths;
use joton::film::stats::{Estimate, test_equal};
use joton::output::compare::compare;
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Settings};
use joton::render::{Stop, render};
use joton::spectrum::BANDS;
use std::sync::Arc;

/// First seed of the renders that a z-test compares, and of the reference: those of the timed renders lie below.
const TEST_SEED: u32 = 1 << 16;
const REFERENCE_SEED: u32 = 1 << 20;
/// Passes of the reference for each of a render: its own noise adds as little to the error.
const REFERENCE_PASSES: u64 = 16;
/// Renders of each kind that a z-test compares, and the edge of its blocks, pixels.
const TEST_RENDERS: u32 = 6;
const TEST_BLOCK: u32 = 8;
/// Part of the plan's radii, caustic and diffuse, in a z-test: skips that change how many jotons there are change the radii,
/// and so their bias, which is below the noise at these.
const NARROW: [f64; 2] = [0.06, 0.3];

/// Times that a plan is made, to know what it takes.
const PLANS: u32 = 5;

/// A scene, packed, and what is wanted of it.
pub struct Subject {
    effort: Effort,
    /// What is in reach of its camera, and all of it.
    scenes: [Arc<PackedScene>; 2],
    paths: LightPaths,
    /// What is kept of it in any case.
    always: &'static [Part],
}

/// What a kind of render took, and what came of it.
#[derive(Debug, Clone, Copy, Default)]
pub struct Cost {
    /// Processor seconds of a pass.
    pub pass: f64,
    /// Mean relMSE against the reference; 0 where the bits are the same.
    pub rel_mse: f64,
}

/// With the skip, and with what is skipped kept.
pub struct Pair {
    /// Medians over the seeds.
    pub costs: [Cost; 2],
    /// Median over the seeds of the times' ratio, kept over skipped, and the least and the largest.
    pub ratio: [f64; 3],
    /// All renders have the same bits.
    pub same_bits: bool,
}

fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn bits(image: &Image) -> Vec<[u32; BANDS]> {
    image.pixels.iter().map(|p| p.map(f32::to_bits)).collect()
}

impl Subject {
    /// Pack a scene.
    pub fn new(effort: &Effort, case: &Case) -> joton::Result<Self> {
        let scenes = [PackedScene::new(&case.scene), PackedScene::whole(&case.scene)].map(Arc::new);
        Ok(Self { effort: *effort, scenes, paths: LightPaths::parse(case.paths)?, always: case.keep })
    }

    /// The scene with some parts kept.
    fn scene(&self, keep: &[Part]) -> &Arc<PackedScene> {
        &self.scenes[usize::from(keep.contains(&Part::OutOfReach))]
    }

    /// A plan with some parts kept.
    pub fn plan(&self, seed: u32, keep: &[Part]) -> Plan {
        let keep = [self.always, keep].concat();
        let scene = self.scene(&keep);
        Plan::new(scene, Settings { seed, paths: self.paths.clone(), keep, ..Settings::default() })
    }

    /// The picture of so many passes, and the processor seconds of one.
    fn render(&self, plan: Plan, passes: u64) -> joton::Result<(Image, f64)> {
        let scene = Arc::clone(self.scene(&plan.settings.keep));
        let mut backend: Box<dyn Backend> = if self.effort.cpu {
            Box::new(CpuBackend::new(scene, plan))
        } else {
            Box::new(GpuBackend::new(Context::open(None)?, scene, plan)?)
        };
        let stop = Stop { passes: Some(passes), ..Stop::default() };
        let rendered = render(backend.as_mut(), self.scenes[0].size, stop, |_| true)?;
        Ok((rendered.picture.whole, rendered.cpu_seconds / passes as f64))
    }

    /// Render with and without a skip, in turns.
    pub fn pair(&self, keep: &[Part]) -> joton::Result<Pair> {
        let Effort { passes, runs, .. } = self.effort;
        let mut found: [Vec<(Image, Cost)>; 2] = Default::default();
        for seed in 0..runs {
            // who is first changes: what comes second finds warm caches
            for kind in if seed % 2 == 0 { [0, 1] } else { [1, 0] } {
                let plan = self.plan(seed, if kind == 0 { &[] } else { keep });
                let (image, pass) = self.render(plan, passes)?;
                found[kind].push((image, Cost { pass, rel_mse: 0.0 }));
            }
        }
        let same_bits = found[0].iter().zip(&found[1]).all(|(a, b)| bits(&a.0) == bits(&b.0));
        if !same_bits {
            let reference = self.render(self.plan(REFERENCE_SEED, &[]), passes * REFERENCE_PASSES)?.0;
            for (image, cost) in found.iter_mut().flatten() {
                cost.rel_mse = compare(image, &reference)?.rel_mse;
            }
        }
        let costs = found.each_ref().map(|renders| Cost {
            pass: median(renders.iter().map(|r| r.1.pass)),
            rel_mse: renders.iter().map(|r| r.1.rel_mse).sum::<f64>() / f64::from(runs),
        });
        let ratios = || found[0].iter().zip(&found[1]).map(|(a, b)| b.1.pass / a.1.pass);
        let ratio = [median(ratios()), ratios().fold(f64::INFINITY, f64::min), ratios().fold(0.0, f64::max)];
        Ok(Pair { costs, ratio, same_bits })
    }

    /// Probability that renders with and without a skip differ as much as some do, were their means the same.
    pub fn p_value(&self, keep: &[Part]) -> joton::Result<f64> {
        let radii = |keep: &[Part]| {
            let plan = self.plan(TEST_SEED, keep);
            (
                plan.indirect,
                plan.diffuse.base * self.scene(keep).world_scale,
                plan.caustic_wanted,
                plan.caustic_jotons,
            )
        };
        let narrow = if radii(&[]) == radii(keep) { [1.0; 2] } else { NARROW };
        let estimate = |keep: &[Part], first: u32| {
            let seeds = first..first + TEST_RENDERS;
            let images = seeds.map(|seed| {
                let mut plan = self.plan(seed, keep);
                // what neighbours share is a little biased, too
                plan.resolves = false;
                plan.caustic.base *= narrow[0];
                plan.diffuse.base *= narrow[1];
                Ok(self.render(plan, self.effort.passes)?.0)
            });
            Estimate::from_renders(&images.collect::<joton::Result<Vec<Image>>>()?, TEST_BLOCK)
        };
        Ok(test_equal(&estimate(&[], TEST_SEED)?, &estimate(keep, TEST_SEED + TEST_RENDERS)?)?.p_value)
    }

    /// The plan, and the processor seconds that it takes: the median of a few.
    pub fn timed_plan(&self, keep: &[Part]) -> (Plan, f64) {
        let seconds = median((0..PLANS).map(|_| {
            let since = ProcessTime::now();
            self.plan(0, keep);
            since.elapsed().as_secs_f64()
        }));
        (self.plan(0, keep), seconds)
    }

    /// Whether one render has the same bits with a part kept.
    pub fn is_same_with(&self, keep: &[Part]) -> joton::Result<bool> {
        let [own, kept] = [&[][..], keep].map(|keep| self.render(self.plan(0, keep), 1));
        Ok(bits(&own?.0) == bits(&kept?.0))
    }
}
