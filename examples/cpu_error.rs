//! Error against passes of the CPU backend or the path tracer, without the command line around it.
//!
//! `cargo run --release --example cpu_error -- SCENE OUT_PREFIX REFERENCE.exr|- PASSES[,PASSES…] [map|path] [PATHS]`

use joton::backend::Backend;
use joton::backend::cpu::{CpuBackend, PathTracer};
use joton::film::paths::LightPaths;
use joton::film::{Film, Layer};
use joton::output::{compare, display::Display, exr, png};
use joton::packed::PackedScene;
use joton::plan::{Plan, Settings};
use std::path::Path;
use std::sync::Arc;
use std::time::Instant;

fn main() -> joton::Result<()> {
    let args: Vec<String> = std::env::args().collect();
    let start = Instant::now();
    let scene = joton::scene::load(Path::new(&args[1]))?;
    let packed = Arc::new(PackedScene::new(&scene));
    let mut settings = Settings::default();
    if let Some(expression) = args.get(6) {
        settings.paths = LightPaths::parse(expression)?;
    }
    let plan = Plan::new(&packed, settings);
    println!(
        "set-up {:.2} s; jotons {} caustic {} diffuse; radius {:.3} caustic {:.3} diffuse; footprint {:.3}",
        start.elapsed().as_secs_f64(),
        plan.caustic_jotons,
        plan.diffuse_jotons,
        plan.caustic.base,
        plan.diffuse.base,
        plan.pilot.footprint_median
    );
    let mut backend: Box<dyn Backend> = if args.get(5).is_some_and(|a| a == "path") {
        Box::new(PathTracer::new(packed.clone(), plan))
    } else {
        Box::new(CpuBackend::new(packed.clone(), plan))
    };
    println!("{}", backend.describe());
    let reference = if args[3] == "-" { None } else { Some(exr::read_image(Path::new(&args[3]))?) };
    let mut film = Film::new(packed.size[0], packed.size[1]);
    let mut seconds = 0.0;
    for until in args[4].split(',').map(|n| n.parse::<u64>().expect("a number of passes")) {
        let start = Instant::now();
        let batch = backend.render(film.passes(), (until - film.passes()) as u32)?;
        seconds += start.elapsed().as_secs_f64();
        film.add(until - film.passes(), &batch.layers);
        let picture = film.picture();
        print!("{until:6} passes {seconds:8.3} s");
        if let Some(r) = &reference {
            let c = compare::compare(&picture.whole, r)?;
            print!("  {c:?}");
        }
        println!();
        let t = batch.tally;
        let balance: Vec<f64> = (0..3).map(|b| (t.absorbed[b] + t.escaped[b]) / t.emitted[b]).collect();
        println!(
            "        rays {} emitted {} stored {} (absorbed+escaped)/emitted {balance:.5?} non-finite {} truncated {}",
            t.rays,
            t.jotons_emitted,
            t.jotons_stored,
            t.non_finite.total(),
            t.truncated
        );
    }
    let picture = film.picture();
    for (layer, image) in Layer::ALL.iter().zip(&picture.layers) {
        let mean =
            |b: usize| image.pixels.iter().map(|p| f64::from(p[b])).sum::<f64>() / image.pixels.len() as f64;
        println!("{:9} mean {:.5} {:.5} {:.5}", layer.name(), mean(0), mean(1), mean(2));
    }
    exr::write_picture(Path::new(&format!("{}.exr", args[2])), &picture, "")?;
    png::write_image(Path::new(&format!("{}.png", args[2])), &picture.whole, &Display::default())
}
