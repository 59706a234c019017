//! Mitsuba: its pictures of the scenes of tests/mitsuba, made by scripts/beside-mitsuba.py, are what the path tracer
//! renders. Stored are means of blocks with their standard errors.

use crate::chi_square::Claims;
use crate::renders::{EVERYTHING, Side, pictures};
use joton::film::Image;
use joton::film::stats::{Estimate, test_equal};
use joton::packed::PackedScene;
use joton::spectrum::BANDS;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Pixels across and down, and edge of a block.
const SIZE: u32 = 32;
const BLOCK: u32 = 4;
/// Independent renders, as many as Mitsuba's were.
const SEEDS: u32 = 16;
const PASSES: u64 = 12;

fn file(name: &str, extension: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba").join(name).with_extension(extension)
}

/// What Mitsuba rendered.
fn stored(name: &str) -> Estimate {
    let text = std::fs::read_to_string(file(name, "txt")).expect("a stored picture");
    let rows: Vec<Vec<f64>> = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split(' ').map(|x| x.parse().expect("a number")).collect())
        .collect();
    let across = SIZE / BLOCK;
    assert_eq!(rows.len(), (across * across) as usize);
    let of = |first: usize, power: i32| {
        rows.iter().map(|row| std::array::from_fn(|b| row[first + b].powi(power))).collect()
    };
    Estimate {
        blocks: [across; 2],
        block: BLOCK,
        mean: of(0, 1),
        variance: of(BANDS, 2),
        freedom: f64::from(SEEDS - 1),
    }
}

/// All blocks as one: what is a little wrong everywhere.
fn whole(blocks: &Estimate, renders: Option<&[Image]>) -> Estimate {
    if let Some(renders) = renders {
        return Estimate::from_renders(renders, SIZE).unwrap_or_else(|e| panic!("{e}"));
    }
    let count = blocks.mean.len() as f64;
    let sum = |of: &[[f64; BANDS]]| std::array::from_fn(|b| of.iter().map(|x| x[b]).sum::<f64>());
    Estimate {
        blocks: [1; 2],
        block: SIZE,
        mean: vec![sum(&blocks.mean).map(|x: f64| x / count)],
        variance: vec![sum(&blocks.variance).map(|x: f64| x / (count * count))],
        freedom: blocks.freedom * count,
    }
}

/// Gold; plastic whose colour deepens under its coat; textures and a cut-out with their filters and edges; lamp, paints and a
/// coat by tables of wavelengths.
#[test]
fn pictures_are_those_of_mitsuba() {
    let mut claims = Claims::default();
    for name in ["gold", "saturated-plastic", "leaf", "spectral-tables"] {
        let mut scene = joton::scene::load(&file(name, "toml")).unwrap_or_else(|e| panic!("{e}"));
        scene.resize([SIZE; 2]);
        let scene = Arc::new(PackedScene::new(&scene));
        let renders: Vec<Image> = pictures(Side::PathTracer, &scene, EVERYTHING, 0..SEEDS, PASSES, |_| ())
            .iter()
            .map(|p| p.whole.clone())
            .collect();
        let theirs = stored(name);
        let ours = Estimate::from_renders(&renders, BLOCK).unwrap_or_else(|e| panic!("{e}"));
        for [a, b] in [[&ours, &theirs], [&whole(&ours, Some(&renders)), &whole(&theirs, None)]] {
            let outcome = test_equal(a, b).unwrap_or_else(|e| panic!("{e}"));
            let (worst, at) = (outcome.worst_score, outcome.worst_at);
            println!("{name}, blocks of {}: {worst:+.1} at {at:?}, p = {:.2e}", a.block, outcome.p_value);
            claims.add(format!("{name}, blocks of {}", a.block), outcome.p_value);
        }
    }
    claims.hold();
}
