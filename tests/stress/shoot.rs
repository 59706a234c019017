//! Rendering for stresses: whole images of several seeds, every value looked at by its bits, and the tests of two such sets.

use crate::harness::Renderer;
use crate::sheet::Sheet;
use joton::backend::cpu::{CpuBackend, PathTracer};
use joton::backend::gpu::GpuBackend;
use joton::backend::{Backend, Batch};
use joton::film::stats::{Estimate, test_equal};
use joton::film::{Film, Image, Layer, Picture};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Settings};
use joton::scene::Scene;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

/// A probability at which two sets of renders count as different. The table has some hundred rows.
pub const SIGNIFICANCE: f64 = 1e-5;

/// A backend for a scene; `adjust` may change its plan.
pub fn open(
    who: Renderer,
    scene: &Scene,
    settings: Settings,
    adjust: &dyn Fn(&mut Plan),
) -> Box<dyn Backend> {
    let packed = Arc::new(PackedScene::whole(scene));
    let mut plan = Plan::new(&packed, settings);
    adjust(&mut plan);
    match who {
        Renderer::Cpu => Box::new(CpuBackend::new(packed, plan)),
        Renderer::PathTracer => Box::new(PathTracer::new(packed, plan)),
        Renderer::Device => {
            let context = crate::common::device().expect("a device").clone();
            Box::new(GpuBackend::new(context, packed, plan).unwrap_or_else(|e| panic!("{e}")))
        }
    }
}

/// A seed and else what everyone gets.
pub fn seed(seed: u32) -> Settings {
    Settings { seed, ..Settings::default() }
}

/// Likewise, with diffuse light by its map.
pub fn seed_by_map(seed: u32) -> Settings {
    Settings { seed, keep: vec![Part::DiffuseMap], ..Settings::default() }
}

/// Finite, by its bits: no compiler may assume the answer.
pub fn is_finite(x: f32) -> bool {
    const EXPONENT: u32 = 0x7f80_0000;
    x.to_bits() & EXPONENT != EXPONENT
}

/// Render passes and look at what no render may have: values that are not finite, in the film or left out of it, and
/// paths that were cut.
pub fn batch(backend: &mut dyn Backend, first: u64, count: u32) -> Batch {
    let batch = backend.render(first, count).unwrap_or_else(|e| panic!("{e}"));
    let values = || batch.layers.iter().flatten().flatten();
    assert!(values().all(|&x| is_finite(x)), "{}: a value of the film is not finite", backend.describe());
    assert_eq!(batch.tally.non_finite.total(), 0, "{}: values were left out of the film", backend.describe());
    let cut = batch.tally.truncated as f64 / batch.tally.rays.max(1) as f64;
    assert!(cut <= CUT_MAX, "{}: {} paths were cut", backend.describe(), batch.tally.truncated);
    LOOKED_AT.fetch_add(values().count() as u64, Ordering::Relaxed);
    batch
}

/// Paths that may be cut at the hard limit of their length, of all rays: light that facets of clear bodies trap.
const CUT_MAX: f64 = 1e-5;

/// Values of films that [`batch`] has looked at.
static LOOKED_AT: AtomicU64 = AtomicU64::new(0);

/// Values of films that were found finite so far.
pub fn values_looked_at() -> u64 {
    LOOKED_AT.load(Ordering::Relaxed)
}

/// Jotons of each map that are enough for the small images here; a plan's own are for larger ones.
pub fn few_jotons(plan: &mut Plan) {
    const FEW: u32 = 1 << 12;
    plan.diffuse_jotons = plan.diffuse_jotons.min(FEW);
    plan.caustic_jotons = plan.caustic_jotons.min(FEW);
}

/// Groups of passes: their spread is the noise. Sobol's sequence covers its square over all passes, so groups differ
/// rather more than independent renders would.
const GROUPS: u32 = 8;
/// Paths of the path tracer for a pass of a photon mapper.
const PATHS: u32 = 8;

/// A picture for each group of passes, of few jotons.
pub fn shots(who: Renderer, scene: &Scene, settings: Settings, passes: u32) -> Vec<Picture> {
    shots_of(who, scene, settings, passes, &few_jotons)
}

/// A picture for each group of passes of a changed plan.
pub fn shots_of(
    who: Renderer,
    scene: &Scene,
    settings: Settings,
    passes: u32,
    adjust: &dyn Fn(&mut Plan),
) -> Vec<Picture> {
    let mut backend = open(who, scene, settings, adjust);
    let each = if who == Renderer::PathTracer { passes * PATHS } else { passes };
    let group = |g: u32| {
        let mut film = Film::new(scene.size[0], scene.size[1]);
        film.add(u64::from(each), &batch(&mut *backend, u64::from(g * each), each).layers);
        film.picture()
    };
    (0..GROUPS).map(group).collect()
}

/// Sums of some layers, times a factor.
pub fn images(pictures: &[Picture], layers: &[Layer], factor: f32) -> Vec<Image> {
    let sum = |p: &Picture| {
        let mut image = Image::new(p.whole.width, p.whole.height);
        for &layer in layers {
            let from = p.layers[layer as usize].pixels.iter().flatten();
            image.pixels.iter_mut().flatten().zip(from).for_each(|(s, x)| *s += x * factor);
        }
        image
    };
    pictures.iter().map(sum).collect()
}

/// Hold two sets of images against each other, block by block and as a whole.
pub fn alike(sheet: &mut Sheet, tried: &str, backend: impl ToString, a: &[Image], b: &[Image], block: u32) {
    let estimate =
        |images: &[Image], block| Estimate::from_renders(images, block).unwrap_or_else(|e| panic!("{e}"));
    let whole = a[0].width.max(a[0].height);
    let parts = [("blocks", block), ("mean", whole)];
    for (blocks, block) in parts.into_iter().filter(|p| p.0 == "mean" || p.1 < whole) {
        let (x, y) = (estimate(a, block), estimate(b, block));
        let outcome = test_equal(&x, &y).unwrap_or_else(|e| panic!("{e}"));
        let (at, band) = outcome.worst_at;
        let i = (at[1] * x.blocks[0] + at[0]) as usize;
        let ratio = x.mean[i][band] / y.mean[i][band] - 1.0;
        let noise = (x.variance[i][band] + y.variance[i][band]).sqrt() / y.mean[i][band].abs();
        sheet.row(
            format!("{tried}: {blocks}"),
            backend.to_string(),
            format!("{:+.2} % ± {:.2} %, p = {:.1e}", 100.0 * ratio, 100.0 * noise, outcome.p_value),
            format!("p ≥ {SIGNIFICANCE:e}"),
            outcome.accepts(SIGNIFICANCE),
        );
    }
}
