//! Random numbers at the addresses that the renderers use: uniform, and independent of those of every other purpose, of
//! the other outputs of one address, and of neighbouring passes, paths, pixels and seeds.
//!
//! The device's numbers are the host's bit for bit (gpu_shared, rng), so the host's are tested at both sides' addresses.

use crate::chi_square::{Claims, SIGNIFICANCE, both_tails, seed, upper_tail};
use joton::backend::cpu::harness;
use joton::film::stats::sidak;
use joton::sampling::rng::{purpose, random4, seed_at, sequence_seed, sequence2, sobol2};
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

/// Constants of sampling/rng.wgsl whose names start so.
fn constants(prefix: &str) -> Vec<u32> {
    let (_, text) = joton::backend::gpu::SOURCES
        .iter()
        .find(|(name, _)| name.ends_with("rng.wgsl"))
        .expect("the file is linked");
    let value = |line: &str| {
        let rest = line.strip_prefix("const ")?.strip_prefix(prefix)?;
        let value = rest.split('=').nth(1)?.trim().trim_end_matches("u;");
        let hex = value.strip_prefix("0x").map(|h| u32::from_str_radix(h, 16));
        Some(hex.unwrap_or_else(|| value.parse()).expect("a number"))
    };
    text.lines().filter_map(value).collect()
}

/// A side's streams and first dimensions.
struct Addresses {
    side: &'static str,
    streams: Vec<u32>,
    dimensions: Vec<u32>,
}

fn sides() -> [Addresses; 2] {
    [
        Addresses {
            side: "host",
            streams: harness::STREAMS.to_vec(),
            dimensions: harness::DIMENSIONS.to_vec(),
        },
        Addresses { side: "device", streams: constants("STREAM_"), dimensions: constants("DIMENSION_") },
    ]
}

/// Longest path times draws of an event: no purpose runs into the next one's dimensions.
const DIMENSIONS_OF_A_PURPOSE: u32 = 4 * 257;

/// No two purposes share an address: those of a side, and those of set-up, which both have.
#[test]
fn purposes_have_addresses_of_their_own() {
    for Addresses { side, mut streams, mut dimensions } in sides() {
        assert!(streams.len() >= 8 && dimensions.len() >= 5, "{side}: {streams:?} {dimensions:?}");
        streams.extend(purpose::STREAMS);
        dimensions.extend(purpose::DIMENSIONS);
        streams.sort_unstable();
        assert!(streams.windows(2).all(|w| w[0] < w[1]), "{side}: {streams:?}");
        dimensions.sort_unstable();
        let apart = |w: &[u32]| w[1] - w[0] >= DIMENSIONS_OF_A_PURPOSE;
        assert!(dimensions.windows(2).all(apart), "{side}: {dimensions:?}");
    }
}

/// Source files, and the folder of each.
fn sources(folder: &Path) -> Vec<(String, String)> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").path());
    let read = |path: PathBuf| match path.is_dir() {
        true => sources(&path),
        false => vec![(path.display().to_string(), std::fs::read_to_string(&path).expect("text"))],
    };
    entries.flat_map(read).collect()
}

/// Purposes are where the test above looks for them, and none is dead: something draws from each.
#[test]
fn purposes_are_listed_and_used() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let is_purpose = |word: &str| word.starts_with("STREAM_") || word.starts_with("DIMENSION_");
    let words = |text: &str| -> Vec<String> {
        let text = text.split("#[cfg(test)]").next().unwrap_or("");
        let code = text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n");
        let words = code.split(|c: char| !c.is_alphanumeric() && c != '_');
        words.filter(|w| is_purpose(w)).map(String::from).collect()
    };
    for (folder, lists) in [
        ("src", &["src/sampling/rng.rs", "src/backend/cpu/streams.rs", "src/backend/cpu/harness.rs"][..]),
        ("shaders", &["sampling/rng.wgsl"]),
    ] {
        let files = sources(&root.join(folder));
        let (listing, using): (Vec<_>, Vec<_>) =
            files.iter().partition(|(name, _)| lists.iter().any(|list| name.ends_with(list)));
        let used: BTreeSet<String> = using.iter().flat_map(|(_, text)| words(text)).collect();
        let listed: BTreeSet<String> = listing.iter().flat_map(|(_, text)| words(text)).collect();
        assert!(listed.len() > 8, "{listed:?}");
        assert_eq!(listed, used, "{folder}");
    }
}

/// Sequences go on behind their 2^32 points with others: the same index in another high word is as far away as any, and
/// every one of the first 2^16 high words has a seed of its own.
#[test]
fn sequences_do_not_come_again() {
    let seeds: BTreeSet<u32> = (0..1 << 16).map(|high| seed_at(seed(), high)).collect();
    assert_eq!(seeds.len(), 1 << 16);
    assert_eq!(seed_at(seed(), 0), seed(), "the first points are those of the seed itself");
    // starts of the jotons of passes p and p + 2^32 / jotons
    let at = |pass: u64, number: u64| sequence2(pass * u64::from(JOTONS) + number, seed(), 0, 2);
    let period = (1u64 << 32) / u64::from(JOTONS);
    let mut same = 0;
    let mut correlation = 0.0;
    for number in 0..u64::from(JOTONS) {
        let (a, b) = (at(3, number), at(3 + period, number));
        same += u32::from(a == b);
        correlation += 12.0 * f64::from((a[0] - 0.5) * (b[0] - 0.5));
    }
    assert_eq!(same, 0, "pass {period} begins again");
    assert!((correlation / f64::from(JOTONS)).abs() < 5.0 / f64::from(JOTONS).sqrt(), "{correlation}");
    // a pass that lies across a multiple of 2^32: numbers before and behind it
    let across = |number: u64| sequence2((1 << 32) - 2 + number, seed(), 0, 2);
    assert_eq!(across(1), sobol2(u32::MAX, sequence_seed(seed(), 0, 2)));
    assert_eq!(across(2), sobol2(0, sequence_seed(seed_at(seed(), 1), 0, 2)));
}

/// An address: seed, pass, path or pixel.
type Address = [u32; 3];

/// A block of neighbours: small numbers, which weak hashes mix least.
const BLOCK: Address = [16, 32, 32];

fn block() -> impl Iterator<Item = Address> {
    let [seeds, passes, paths] = BLOCK;
    (0..seeds * passes * paths).map(move |i| [seed() + i / (passes * paths), i / paths % passes, i % paths])
}

/// The way to an address's neighbour.
type Step = fn(Address) -> Address;

/// Neighbours of an address.
const NEIGHBOURS: [(&str, Step); 8] = [
    ("itself", |a| a),
    ("next pass", |[s, p, x]| [s, p + 1, x]),
    ("next path", |[s, p, x]| [s, p, x + 1]),
    ("next row of pixels", |[s, p, x]| [s, p, x + 256]),
    ("next seed", |[s, p, x]| [s + 1, p, x]),
    ("seed up, pass down", |[s, p, x]| [s + 1, p.wrapping_sub(1), x]),
    ("pass and path exchanged", |[s, p, x]| [s, x + 1000, p + 1000]),
    ("seed and pass exchanged", |[s, p, x]| [p + 1000, s + 1000, x]),
];

/// Bits of a number that pairs are tested by.
const BITS: u32 = 3;
const CELLS: usize = 1 << (2 * BITS);

/// A number of each address in turn, in few bits.
struct Column {
    name: String,
    /// Stream of a Sobol sequence, whose numbers are more even than independent ones.
    stream: Option<u32>,
    cells: Vec<u8>,
}

fn cell(u: f32) -> u8 {
    (u * (1 << BITS) as f32) as u8
}

/// Jotons of a pass, as their streams count.
const JOTONS: u32 = 1 << 14;

/// Columns of every stream and of the first events of every purpose at an address's neighbour.
fn columns(a: &Addresses, events: u32, at: Step) -> Vec<Column> {
    let mut all = Vec::new();
    for &first in &a.dimensions {
        for dimension in first..first + events {
            let draws: Vec<[f32; 4]> = block().map(at).map(|[s, p, x]| random4(s, p, x, dimension)).collect();
            all.extend((0..4).map(|k| Column {
                name: format!("dimension {dimension:#x}.{k}"),
                stream: None,
                cells: draws.iter().map(|u| cell(u[k])).collect(),
            }));
        }
    }
    for &stream in &a.streams {
        for joint in [false, true] {
            // a sequence for each pixel over the passes, or one for all jotons of all passes
            let draw = |[s, p, x]: Address| match joint {
                false => sobol2(p, sequence_seed(s, x, stream)),
                true => sobol2(p.wrapping_mul(JOTONS).wrapping_add(x), sequence_seed(s, 0, stream)),
            };
            let draws: Vec<[f32; 2]> = block().map(at).map(draw).collect();
            all.extend((0..2).map(|k| Column {
                name: format!("stream {stream}.{k} of {}", if joint { "jotons" } else { "pixels" }),
                stream: Some(stream),
                cells: draws.iter().map(|u| cell(u[k])).collect(),
            }));
        }
    }
    all
}

/// p-value of the independence of two columns.
fn pair(a: &Column, b: &Column) -> f64 {
    let mut counts = [0u32; CELLS];
    for (x, y) in a.cells.iter().zip(&b.cells) {
        counts[usize::from(x << BITS | y)] += 1;
    }
    let expected = a.cells.len() as f64 / CELLS as f64;
    let statistic = counts.iter().map(|&c| (f64::from(c) - expected).powi(2)).sum::<f64>() / expected;
    let upper = upper_tail(statistic, CELLS - 1);
    if a.stream.or(b.stream).is_some() { upper } else { both_tails(upper) }
}

/// Every pair of numbers of one address, and of an address and its neighbours.
#[test]
fn pairs_of_numbers_are_independent() {
    for side in sides() {
        for (neighbour, at) in NEIGHBOURS {
            let same = neighbour == "itself";
            let events = if same { 6 } else { 2 };
            let (here, there) = (columns(&side, events, |a| a), columns(&side, events, at));
            let (mut worst, mut tests) = ((2.0, String::new()), 0);
            for (i, a) in here.iter().enumerate() {
                for (j, b) in there.iter().enumerate() {
                    // a Sobol sequence avoids its own neighbours by design
                    if same && j <= i || a.stream.is_some() && a.stream == b.stream {
                        continue;
                    }
                    let p = pair(a, b);
                    tests += 1;
                    if p < worst.0 {
                        worst = (p, format!("{} and {}", a.name, b.name));
                    }
                }
            }
            let p = sidak(worst.0, tests);
            println!("{}, {neighbour}: {tests} pairs, p = {p:.3}, {}", side.side, worst.1);
            assert!(p >= SIGNIFICANCE, "{}, {neighbour}: p = {p:e}, {}", side.side, worst.1);
        }
    }
}

/// χ² of counts that should all be alike.
fn alike(counts: &[u32]) -> f64 {
    let expected = f64::from(counts.iter().sum::<u32>()) / counts.len() as f64;
    let statistic = counts.iter().map(|&c| (f64::from(c) - expected).powi(2)).sum::<f64>() / expected;
    upper_tail(statistic, counts.len() - 1)
}

/// High and low digits of every number that is used; low ones come to light where an emitter is picked among many.
#[test]
fn digits_are_uniform() {
    let mut claims = Claims::default();
    let mut claim = |name: String, numbers: &mut dyn Iterator<Item = f32>| {
        let (mut high, mut low) = ([0u32; 256], [0u32; 256]);
        for u in numbers {
            let word = (u * 16_777_216.0) as u32;
            high[(word >> 16) as usize] += 1;
            low[(word & 0xff) as usize] += 1;
        }
        claims.add(format!("{name}, high digits"), both_tails(alike(&high)));
        claims.add(format!("{name}, low digits"), both_tails(alike(&low)));
    };
    for side in sides() {
        for &dimension in &side.dimensions {
            for k in 0..4 {
                let numbers = block().map(|[s, p, x]| random4(s, p, x, dimension)[k]);
                claim(format!("{}, dimension {dimension:#x}.{k}", side.side), &mut numbers.into_iter());
            }
        }
        for &stream in &side.streams {
            for (k, pass) in [(0, 0), (1, 0), (0, 7), (1, 7)] {
                // one point of each pixel's own sequence: independent
                let numbers = (0..1 << 14).map(|x| sobol2(pass, sequence_seed(seed(), x, stream))[k]);
                claim(format!("{}, stream {stream}.{k}, pass {pass}", side.side), &mut numbers.into_iter());
            }
        }
    }
    claims.hold();
}

/// Neighbouring pixels, streams and seeds get sequences of their own: no more seeds coincide than chance has it.
#[test]
fn sequences_have_seeds_of_their_own() {
    for Addresses { side, streams, .. } in sides() {
        let mut seeds: Vec<u32> = streams
            .iter()
            .flat_map(|&stream| {
                (0..1u32 << 16)
                    .flat_map(move |pixel| [0, 1].map(|more| sequence_seed(seed() + more, pixel, stream)))
            })
            .collect();
        let count = seeds.len() as f64;
        seeds.sort_unstable();
        seeds.dedup();
        let coincide = count - seeds.len() as f64;
        // pairs over 2³²: Poisson
        let expected = count * count / 2.0 / 2f64.powi(32);
        assert!(
            (coincide - expected).abs() < 5.0 * expected.sqrt(),
            "{side}: {coincide}, {expected} expected"
        );
    }
}
