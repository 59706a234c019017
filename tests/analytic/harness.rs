//! Rendering a scene in groups of passes, and holding a mean against its closed form.

use joton::backend::Backend;
use joton::backend::cpu::{CpuBackend, PathTracer};
use joton::backend::gpu::{Context, GpuBackend};
use joton::film::paths::LightPaths;
use joton::film::{LAYERS, Layer};
use joton::packed::PackedScene;
use joton::plan::{Part, Plan, Settings};
use joton::scene::Scene;
use joton::spectrum::BANDS;
use std::sync::{Arc, Mutex, PoisonError};

/// One value per band.
pub type Values = [f64; BANDS];

/// Every path from a light to the eye.
pub const EVERYTHING: &str = "L.*E";

/// Set to 1 to leave out the device, on machines that cannot have one.
const OPT_OUT: &str = "JOTON_TEST_NO_GPU";

/// Groups of passes: their spread is the noise.
const GROUPS: u64 = 8;

/// Who renders.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Renderer {
    /// The photon mapper on threads.
    Cpu,
    /// The photon mapper on a device.
    Device,
    /// The path tracer.
    PathTracer,
}

/// The two photon mappers; without the device where the environment opts out.
pub fn mappers() -> Vec<Renderer> {
    if std::env::var(OPT_OUT).is_ok_and(|v| v == "1") {
        eprintln!("{OPT_OUT}=1: the device is left out");
        return vec![Renderer::Cpu];
    }
    vec![Renderer::Cpu, Renderer::Device]
}

/// The photon mappers and the path tracer.
pub fn everyone() -> Vec<Renderer> {
    let mut all = mappers();
    all.push(Renderer::PathTracer);
    all
}

/// Who renders all of a scene's light, with the parts that are kept: everyone as planned, and the photon mappers with diffuse
/// light by its map, too, where the plan has another way.
pub fn everyone_both_ways(scene: &Scene) -> impl Iterator<Item = (Renderer, &'static [Part])> {
    let by_map = !Plan::new(&PackedScene::whole(scene), Settings::default()).has_indirect_paths();
    let ways: [&'static [Part]; 2] = [&[], &[Part::DiffuseMap]];
    let count = move |who| if by_map || who == Renderer::PathTracer { 1 } else { 2 };
    everyone().into_iter().flat_map(move |who| ways.into_iter().take(count(who)).map(move |keep| (who, keep)))
}

/// A mean and its standard error.
#[derive(Debug, Clone, Copy)]
pub struct Seen {
    pub mean: Values,
    pub error: Values,
}

/// The radiance of each layer and pixel, for each group of passes.
pub struct Shot {
    pub renderer: Renderer,
    pub size: [u32; 2],
    groups: Vec<[Vec<Values>; LAYERS]>,
}

/// The device, one renderer at a time: software devices share the machine's threads anyway. What it compiles for one test is
/// there for the next.
static DEVICE: Mutex<Option<Context>> = Mutex::new(None);

/// Passes of the path tracer for one of a photon mapper: a single path a pixel tells little.
const PATHS: u64 = 8;
/// … and of a photon mapper where diffuse light comes by single paths, too, and not by a map.
const SINGLE: u64 = 4;

/// Render `scene`; about `passes` passes, more of the path tracer.
pub fn render(renderer: Renderer, scene: &Scene, paths: &str, passes: u64) -> Shot {
    render_keeping(renderer, scene, paths, passes, &[])
}

/// Likewise with some parts kept.
pub fn render_keeping(renderer: Renderer, scene: &Scene, paths: &str, passes: u64, keep: &[Part]) -> Shot {
    render_packed(renderer, PackedScene::whole(scene), paths, passes, keep)
}

/// Likewise of what is packed.
pub fn render_packed(
    renderer: Renderer,
    packed: PackedScene,
    paths: &str,
    passes: u64,
    keep: &[Part],
) -> Shot {
    let size = packed.size;
    let packed = Arc::new(packed);
    let paths = LightPaths::parse(paths).expect("a valid expression");
    let plan = Plan::new(&packed, Settings { paths, keep: keep.to_vec(), ..Settings::default() });
    let passes = match renderer {
        Renderer::PathTracer => passes * PATHS,
        _ if plan.has_indirect_paths() => passes * SINGLE,
        _ => passes,
    };
    let mut device = DEVICE.lock().unwrap_or_else(PoisonError::into_inner);
    let mut backend: Box<dyn Backend> = match renderer {
        Renderer::Cpu => Box::new(CpuBackend::new(packed, plan)),
        Renderer::PathTracer => Box::new(PathTracer::new(packed, plan)),
        Renderer::Device => {
            let open = || {
                Context::open(None)
                    .unwrap_or_else(|e| panic!("{e}\nwithout a device these tests fail, unless {OPT_OUT}=1"))
            };
            let context = device.get_or_insert_with(open).clone();
            Box::new(GpuBackend::new(context, packed, plan).expect("the scene fits the device"))
        }
    };
    let each = passes.div_ceil(GROUPS);
    let groups = (0..GROUPS).map(|g| {
        let batch = backend.render(g * each, each as u32).expect("renders");
        assert_eq!((batch.tally.non_finite.total(), batch.tally.truncated), (0, 0), "{renderer:?}");
        batch.layers.map(|l| l.iter().map(|p| p.map(|x| f64::from(x) / each as f64)).collect())
    });
    Shot { renderer, size, groups: groups.collect() }
}

/// The sum of `layers` of one pixel.
fn pixel(group: &[Vec<Values>; LAYERS], layers: &[Layer], i: usize) -> Values {
    std::array::from_fn(|b| layers.iter().map(|&l| group[l as usize][i][b]).sum())
}

impl Shot {
    /// The sum of `layers`, weighed pixel by pixel; x runs right and y down, in 0 to 1 at pixel centres.
    pub fn weighed(&self, layers: &[Layer], weight: impl Fn(f64, f64) -> f64) -> Seen {
        let [width, height] = self.size;
        let weights: Vec<f64> = (0..width * height)
            .map(|i| {
                let x = (f64::from(i % width) + 0.5) / f64::from(width);
                let y = (f64::from(i / width) + 0.5) / f64::from(height);
                weight(x, y)
            })
            .collect();
        let sums: Vec<Values> = self
            .groups
            .iter()
            .map(|g| {
                std::array::from_fn(|b| {
                    weights.iter().enumerate().map(|(i, w)| w * pixel(g, layers, i)[b]).sum()
                })
            })
            .collect();
        let n = sums.len() as f64;
        let mean: Values = std::array::from_fn(|b| sums.iter().map(|s| s[b]).sum::<f64>() / n);
        let error = std::array::from_fn(|b| {
            (sums.iter().map(|s| (s[b] - mean[b]).powi(2)).sum::<f64>() / (n - 1.0) / n).sqrt()
        });
        Seen { mean, error }
    }

    /// The mean of `layers` over the pixels whose centres lie where `inside` says.
    pub fn mean(&self, layers: &[Layer], inside: impl Fn(f64, f64) -> bool) -> Seen {
        let [width, height] = self.size;
        let centre = |i: u32, n: u32| (f64::from(i) + 0.5) / f64::from(n);
        let count = (0..width * height)
            .filter(|i| inside(centre(i % width, width), centre(i / width, height)))
            .count();
        assert!(count > 0, "no pixel is inside");
        self.weighed(layers, |x, y| if inside(x, y) { 1.0 / count as f64 } else { 0.0 })
    }

    /// The mean of a layer over the image.
    pub fn layer(&self, layer: Layer) -> Seen {
        self.mean(&[layer], |_, _| true)
    }

    /// The mean of all layers over each block of an n × n grid.
    pub fn blocks(&self, n: u32) -> Vec<Seen> {
        let at = move |v: f64| (v * f64::from(n)) as u32;
        (0..n * n).map(|i| self.mean(&Layer::ALL, |x, y| (at(x), at(y)) == (i % n, i / n))).collect()
    }

    /// The mean of `layers` in each pixel.
    pub fn pixels(&self, layers: &[Layer]) -> Vec<Values> {
        let n = self.groups.len() as f64;
        (0..self.groups[0][0].len())
            .map(|i| {
                std::array::from_fn(|b| self.groups.iter().map(|g| pixel(g, layers, i)[b]).sum::<f64>() / n)
            })
            .collect()
    }

    /// Claim that `seen` is `want`, within `tolerance` of it (of one where it is zero), in every band.
    pub fn claim(&self, what: &str, seen: Seen, want: Values, tolerance: f64) {
        for (b, want) in want.into_iter().enumerate() {
            self.claim_band(what, seen, b, want, tolerance);
        }
    }

    /// The same for one band.
    pub fn claim_band(&self, what: &str, seen: Seen, b: usize, want: f64, tolerance: f64) {
        let unit = if want == 0.0 { 1.0 } else { want.abs() };
        let (mean, off, noise) = (seen.mean[b], (seen.mean[b] - want) / unit, seen.error[b] / unit);
        println!("{what}, {:?}, band {b}: {off:+.5} ± {noise:.5} of {tolerance}", self.renderer);
        assert!(
            off.abs() <= tolerance,
            "{what}, {:?}, band {b}: {mean} where {want} is right ({off:+.4} ± {noise:.4} of {tolerance})",
            self.renderer
        );
        assert!(3.0 * noise <= tolerance, "{what}, {:?}: noise {noise} hides {tolerance}", self.renderer);
    }
}
