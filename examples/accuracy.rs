//! Bias and variance over the passes, by class of light path, and how well the error estimate tells them.
//!
//! `cargo run --release --example accuracy -- OUT_PREFIX PASSES RUNS SIZE SCENE…`
//!
//! Renders each scene (its film SIZE pixels wide) RUNS times on the CPU backend, with seeds 0, 1, …, up to PASSES passes,
//! and looks at the pictures after 1, 2, 4, … passes. The reference is the same backend with other seeds and radii a third
//! as large (a ninth of the blur), in two halves, so that its own noise drops out of the products:
//!
//! bias² = mean (Ī − R₁)(Ī − R₂) − s²/RUNS,  variance = s²,  both over (R² + 0.01), a class's over the whole image's R.
//!
//! Writes OUT_PREFIX.csv (one line for each scene, class and number of passes), OUT_PREFIX-estimate.csv (one line for each
//! run: error estimate and truth) and OUT_PREFIX-SCENE.svg; prints slopes and how the estimate held, as Markdown.

use joton::backend::cpu::CpuBackend;
use joton::film::{LAYERS, Layer, Picture, RELATIVE_OFFSET};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use joton::render::{ErrorEstimate, Stop, render};
use plotters::prelude::*;
use std::error::Error;
use std::fmt::Write as _;
use std::path::Path;
use std::sync::Arc;

/// Radii of the reference, as part of the render's.
const REFERENCE_RADIUS: f64 = 1.0 / 3.0;
/// Passes of the reference for each of the longest render.
const REFERENCE_PASSES: u64 = 4;
/// First seed of the reference.
const REFERENCE_SEED: u32 = 1 << 20;
/// The classes and, last, their sum.
const CLASSES: usize = LAYERS + 1;

/// Radiance of each class in each pixel and band, one after the other.
type Values = [Vec<f64>; CLASSES];

fn main() -> Result<(), Box<dyn Error>> {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let [prefix, passes, runs, size, scenes @ ..] = args.as_slice() else {
        return Err("accuracy OUT_PREFIX PASSES RUNS SIZE SCENE…".into());
    };
    let (passes, runs, size): (u64, u32, u32) = (passes.parse()?, runs.parse()?, size.parse()?);
    let mut table = "scene,class,passes,relmse,bias_squared,variance\n".to_string();
    let mut estimates = "scene,seed,passes,estimate,noise,bias,truth\n".to_string();
    println!(
        "| scene | passes | relMSE after 1 | after all | slope | slope of the last decade | bias² in it | variance in it |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    let mut ratios = Vec::new();
    for path in scenes {
        let name = Path::new(path).file_stem().map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
        let mut scene = joton::scene::load(Path::new(path))?;
        scene.size = [size, size * scene.size[1] / scene.size[0]];
        let packed = Arc::new(PackedScene::new(&scene));
        let reference = reference(&packed, passes * REFERENCE_PASSES)?;
        eprintln!("{name}: reference done");
        let steps = measure(&packed, passes, runs, &reference, |seed, n, e, truth| {
            ratios.push(e.total / truth);
            writeln!(
                estimates,
                "{name},{seed},{n},{:.4e},{:.4e},{:.4e},{truth:.4e}",
                e.total, e.noise, e.bias
            )
            .ok();
        })?;
        for (n, moments) in &steps {
            for (c, parts) in moments.parts(&reference).iter().enumerate() {
                let class = Layer::ALL.get(c).map_or("whole", |l| l.name());
                let [bias, variance] = *parts;
                writeln!(table, "{name},{class},{n},{:.4e},{bias:.4e},{variance:.4e}", bias + variance)?;
            }
        }
        print_slopes(&name, &steps, &reference);
        std::fs::write(format!("{prefix}-{name}.svg"), plot(&name, &steps, &reference)?)?;
        std::fs::write(format!("{prefix}.csv"), &table)?;
        std::fs::write(format!("{prefix}-estimate.csv"), &estimates)?;
    }
    ratios.sort_by(f64::total_cmp);
    let share = |held: usize| 100.0 * held as f64 / ratios.len() as f64;
    println!();
    println!(
        "Estimate over truth, {} pictures: at least 1 in {:.1} %, at most 3 in {:.1} %; median {:.2}.",
        ratios.len(),
        share(ratios.iter().filter(|r| **r >= 1.0).count()),
        share(ratios.iter().filter(|r| **r <= 3.0).count()),
        ratios.get(ratios.len() / 2).unwrap_or(&f64::NAN)
    );
    Ok(())
}

/// One row of the table: how relMSE falls with the passes, by least squares through the logarithms.
fn print_slopes(name: &str, steps: &[(u64, Moments)], reference: &[Values; 2]) {
    let parts: Vec<(f64, [f64; 2])> =
        steps.iter().map(|(n, m)| (*n as f64, m.parts(reference)[LAYERS])).collect();
    let slope = |from: f64| {
        let points: Vec<(f64, f64)> = parts
            .iter()
            .filter(|(n, p)| *n >= from && p[0] + p[1] > 0.0)
            .map(|(n, p)| (n.ln(), (p[0] + p[1]).ln()))
            .collect();
        let mean = |f: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(f).sum::<f64>() / points.len() as f64;
        let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
        mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2))
    };
    let (Some((_, first)), Some((n, last))) = (parts.first(), parts.last()) else { return };
    println!(
        "| {name} | {n} | {:.1e} | {:.1e} | {:.2} | {:.2} | {:.1e} | {:.1e} |",
        first[0] + first[1],
        last[0] + last[1],
        slope(1.0),
        slope(n / 10.0),
        last[0],
        last[1]
    );
}

fn values(picture: &Picture) -> Values {
    let flat = |image: &joton::film::Image| image.pixels.iter().flatten().map(|x| f64::from(*x)).collect();
    std::array::from_fn(|c| flat(picture.layers.get(c).unwrap_or(&picture.whole)))
}

/// Two halves.
fn reference(packed: &Arc<PackedScene>, passes: u64) -> joton::Result<[Values; 2]> {
    let half = |seed: u32| -> joton::Result<Values> {
        let mut plan = Plan::new(packed, Settings { seed, ..Settings::default() });
        plan.caustic.base *= REFERENCE_RADIUS;
        plan.diffuse.base *= REFERENCE_RADIUS;
        let mut backend = CpuBackend::new(packed.clone(), plan);
        let stop = Stop { passes: Some(passes / 2), ..Stop::default() };
        Ok(values(&render(&mut backend, packed.size, stop, |_| true)?.picture))
    };
    Ok([half(REFERENCE_SEED)?, half(REFERENCE_SEED + 1)?])
}

/// Sums over the runs.
struct Moments {
    runs: f64,
    sums: Values,
    squares: Values,
}

impl Moments {
    fn new(n: usize) -> Self {
        let zeros = || std::array::from_fn(|_| vec![0.0; n]);
        Self { runs: 0.0, sums: zeros(), squares: zeros() }
    }

    fn add(&mut self, v: &Values) {
        self.runs += 1.0;
        for (c, class) in v.iter().enumerate() {
            for (i, x) in class.iter().enumerate() {
                self.sums[c][i] += x;
                self.squares[c][i] += x * x;
            }
        }
    }

    /// Squared bias and variance of each class.
    fn parts(&self, reference: &[Values; 2]) -> [[f64; 2]; CLASSES] {
        std::array::from_fn(|c| {
            let mut parts = [0.0; 2];
            for i in 0..self.sums[c].len() {
                let mean = self.sums[c][i] / self.runs;
                let variance = (self.squares[c][i] / self.runs - mean * mean) * self.runs / (self.runs - 1.0);
                let [a, b] = reference.each_ref().map(|r| mean - r[c][i]);
                let weight = weight(reference, i);
                parts[0] += (a * b - variance / self.runs) * weight;
                parts[1] += variance * weight;
            }
            parts.map(|p| p / self.sums[c].len() as f64)
        })
    }
}

/// One over R² + 0.01.
fn weight(reference: &[Values; 2], i: usize) -> f64 {
    let r = reference.iter().map(|r| r[LAYERS][i]).sum::<f64>() / 2.0;
    1.0 / (r * r + RELATIVE_OFFSET)
}

fn measure(
    packed: &Arc<PackedScene>,
    passes: u64,
    runs: u32,
    reference: &[Values; 2],
    mut estimated: impl FnMut(u32, u64, ErrorEstimate, f64),
) -> joton::Result<Vec<(u64, Moments)>> {
    let ladder: Vec<u64> = (0..).map(|i| 1u64 << i).take_while(|n| *n <= passes).collect();
    let length = reference[0][0].len();
    let mut steps: Vec<(u64, Moments)> = ladder.iter().map(|n| (*n, Moments::new(length))).collect();
    for seed in 0..runs {
        let plan = Plan::new(packed, Settings { seed, ..Settings::default() });
        let mut backend = CpuBackend::new(packed.clone(), plan);
        render(&mut backend, packed.size, Stop { passes: Some(passes), ..Stop::default() }, |p| {
            if let Some(step) = ladder.iter().position(|n| *n == p.passes) {
                let seen = values(&p.picture());
                steps[step].1.add(&seen);
                if let Some(e) = p.error {
                    let whole = &seen[LAYERS];
                    let product = |i: usize| {
                        (whole[i] - reference[0][LAYERS][i])
                            * (whole[i] - reference[1][LAYERS][i])
                            * weight(reference, i)
                    };
                    let truth = (0..length).map(product).sum::<f64>() / length as f64;
                    estimated(seed, p.passes, e, truth.max(0.0).sqrt());
                }
            }
            true
        })?;
        eprintln!("seed {seed} done");
    }
    Ok(steps)
}

/// Squared bias (thin) and variance (thick) of each class over the passes.
fn plot(name: &str, steps: &[(u64, Moments)], reference: &[Values; 2]) -> Result<String, Box<dyn Error>> {
    const COLOURS: [RGBColor; CLASSES] = [
        RGBColor(86, 180, 233),
        RGBColor(0, 114, 178),
        RGBColor(213, 94, 0),
        RGBColor(0, 158, 115),
        RGBColor(0, 0, 0),
    ];
    let mut svg = String::new();
    {
        let root = SVGBackend::with_string(&mut svg, (900, 600)).into_drawing_area();
        root.fill(&WHITE)?;
        let last = steps.last().map_or(1.0, |s| s.0 as f64);
        let mut chart = ChartBuilder::on(&root)
            .caption(format!("{name}: bias² (thin) and variance (thick)"), ("sans-serif", 20))
            .margin(12)
            .x_label_area_size(42)
            .y_label_area_size(72)
            .build_cartesian_2d((1.0..last).log_scale(), (1e-9..1.0).log_scale())?;
        chart
            .configure_mesh()
            .light_line_style(TRANSPARENT)
            .x_desc("passes")
            .y_desc("relative to the whole image")
            .y_label_formatter(&|v| format!("{v:.0e}"))
            .draw()?;
        let parts: Vec<(f64, [[f64; 2]; CLASSES])> =
            steps.iter().map(|(n, m)| (*n as f64, m.parts(reference))).collect();
        for (c, colour) in COLOURS.iter().enumerate() {
            let class = Layer::ALL.get(c).map_or("whole", |l| l.name());
            for (part, width) in [(0, 1), (1, 3)] {
                let points: Vec<(f64, f64)> =
                    parts.iter().map(|(n, p)| (*n, p[c][part])).filter(|(_, y)| *y > 1e-9).collect();
                let series = chart.draw_series(LineSeries::new(points, colour.stroke_width(width)))?;
                if part == 1 {
                    let colour = *colour;
                    series.label(class).legend(move |(x, y)| {
                        PathElement::new([(x, y), (x + 20, y)], colour.stroke_width(3))
                    });
                }
            }
        }
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE.mix(0.8))
            .draw()?;
        root.present()?;
    }
    Ok(svg)
}
