//! Claims about the README's figures: they are those that were measured, and what it shows and links to is there.

use std::collections::BTreeMap;
use std::fs::read_to_string;
use std::path::Path;

/// Devices, in the order of the table's columns.
const DEVICES: [&str; 3] = ["gpu", "cpu", "cpu-reference"];
/// CPU seconds of the table's figures.
const MOMENTS: [f64; 3] = [1.0, 3.0, 10.0];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What stands between a mark and its end, which are in the file once.
fn between(file: &str, mark: &str) -> String {
    let text = read_to_string(root().join(file)).expect("a text");
    let [begin, end] = ["", "/"].map(|slash| format!("\n<!-- {slash}{mark} -->\n"));
    assert_eq!([text.matches(&begin).count(), text.matches(&end).count()], [1, 1], "{file}: {mark}");
    let (_, rest) = text.split_once(&begin).expect("a mark");
    rest.split_once(&end).expect("its end comes after it").0.to_owned()
}

/// CPU seconds and relMSE of each picture, by scene, device and seed.
type Curves = BTreeMap<(String, String, u32), Vec<(f64, f64)>>;

fn measured() -> Curves {
    let text = read_to_string(root().join("docs/benchmarks/figures.csv")).expect("what was measured");
    let cells = |line: &str| -> Vec<String> {
        // commas in quotes are no cells' ends
        let parts = line.split('"').enumerate();
        let plain: String = parts.map(|(i, part)| if i % 2 == 0 { part } else { "" }).collect();
        plain.split(',').map(String::from).collect()
    };
    let mut lines = text.lines();
    let names = cells(lines.next().expect("a heading"));
    let mut curves = Curves::new();
    for line in lines {
        let cells = cells(line);
        let cell = |name: &str| &cells[names.iter().position(|n| n == name).expect("a column")];
        let number = |name: &str| -> f64 { cell(name).parse().expect("a number") };
        let key = (cell("scene").clone(), cell("device").clone(), number("seed") as u32);
        curves.entry(key).or_default().push((number("cpu_seconds"), number("rel_mse")));
    }
    curves
}

/// The error at a time, between two pictures by the logarithms; none before the first and after the last.
fn at(curve: &[(f64, f64)], time: f64) -> Option<f64> {
    let pair = curve.windows(2).find(|pair| pair[0].0 <= time && time <= pair[1].0)?;
    let share = (time / pair[0].0).ln() / (pair[1].0 / pair[0].0).ln();
    Some(((1.0 - share) * pair[0].1.ln() + share * pair[1].1.ln()).exp())
}

/// Every figure of the table is the mean of the seeds in figures.csv, to its two digits; – where a seed has no picture yet.
#[test]
fn the_table_is_what_was_measured() {
    let curves = measured();
    let table = between("README.md", "figures");
    for scene in ["cornell", "spheres", "pool"] {
        let row = table.lines().find(|line| line.contains(&format!("(scenes/{scene}.toml)")));
        let columns: Vec<&str> = row.unwrap_or_else(|| panic!("no row of {scene}")).split('|').collect();
        for (device, column) in DEVICES.iter().zip(&columns[2..]) {
            let seeds: Vec<_> = curves.iter().filter(|((s, d, _), _)| s == scene && d == device).collect();
            assert!(seeds.len() >= 3, "{scene} on {device}: {} seeds", seeds.len());
            let figures: Vec<&str> = column.split('·').map(str::trim).collect();
            assert_eq!(figures.len(), MOMENTS.len(), "{column}");
            for (figure, time) in figures.iter().zip(MOMENTS) {
                let errors: Option<Vec<f64>> = seeds.iter().map(|(_, curve)| at(curve, time)).collect();
                let what = format!("{scene} on {device} after {time} s: {figure}, measured {errors:?}");
                let Some(errors) = errors else {
                    assert_eq!(*figure, "–", "{what}");
                    continue;
                };
                let mean = errors.iter().sum::<f64>() / errors.len() as f64;
                let told: f64 = figure.parse().unwrap_or_else(|_| panic!("{what}"));
                assert!((told / mean - 1.0).abs() < 0.051, "{what}");
            }
        }
    }
}

/// The chart that is shown is there and has every scene; the README tells the command, which is there, too, and the date.
#[test]
fn the_chart_and_the_command_are_there() {
    let figures = between("README.md", "figures");
    assert!(figures.contains("](docs/images/figures.svg)"), "{figures}");
    assert!(figures.contains("`sh scripts/figures.sh`") && root().join("scripts/figures.sh").exists());
    assert!(figures.lines().any(|line| line.starts_with("20") && line.contains(", commit ")), "{figures}");
    let chart = read_to_string(root().join("docs/images/figures.svg")).expect("a chart");
    let document = roxmltree::Document::parse(&chart).expect("SVG");
    let texts: Vec<&str> = document
        .descendants()
        .filter(|n| n.has_tag_name("text"))
        .filter_map(|n| Some(n.text()?.trim()))
        .collect();
    for text in ["cornell", "spheres", "pool", "joton, gpu (software Vulkan)", "joton, cpu", "path tracer"] {
        assert!(texts.contains(&text), "{text} is not in {texts:?}");
    }
}

/// What each reference is worth is told.
#[test]
fn references_are_judged() {
    let table = between("docs/BENCHMARKS.md", "references");
    let rows = table.lines().filter(|line| line.starts_with('|') && line.contains('±')).count();
    assert_eq!(rows, 3, "a row for each scene: {table}");
}
