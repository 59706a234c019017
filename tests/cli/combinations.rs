//! Options in any combination, right ones and wrong ones: the contract holds of all of them. It ends with status 0, 1 or 2 and never in a
//! panic; a refusal is one line that names what is at fault; what is promised is there, and nothing else.

use crate::folder::{Ended, Folder};
use proptest::prelude::*;
use proptest::sample::{select, subsequence};
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

/// A command in parts: of each a choice; then some of the options.
struct Grammar {
    command: &'static str,
    parts: &'static [&'static [&'static str]],
    options: &'static [&'static str],
    /// How many command lines are tried.
    cases: u32,
}

/// What several commands have in common.
const RENDER_OPTIONS: &[&str] = &[
    "--seed 3",
    "--seed -1",
    "--seed 4294967295",
    "--seed 4294967296",
    "--paths LS+DE",
    "--paths LDE|EDL",
    "--paths LDX",
    "--paths L(",
    "--shadow-rays 2",
    "--shadow-rays 0",
    "--shadow-rays 33",
    "--no-skip all",
    "--no-skip nothing",
    "--resolve off",
    "--resolve maybe",
    "--bands 4",
    "--bands 450,650.5",
    "--bands 450,450",
    "--memory 64M",
    "--memory 1K",
    "--memory 0",
    "--memory 9e99G",
    "--reference",
    "--timings",
    "--threads 1",
    "--threads 0",
    "--exposure -3",
    "--exposure auto",
    "--exposure nan",
    "--exposure inf",
    "--exposure 1e30",
    "--transform filmic",
    "--transform none",
    "-o x.exr",
    "-o y.png",
    "-o x.jpg",
    "-o none/x.exr",
    "-o tiny.toml",
    "-o a.exr",
    "-o .",
    "--report r.json",
    "--report -",
    "--report x.exr",
    "--report tiny.mtl",
    "--checkpoint c.joton",
    "--checkpoint whole.joton",
    "--checkpoint none/c.joton",
    "--checkpoint tiny.obj",
    "--every 1e-9",
    "--every 0",
    "--every inf",
    "--every nan",
    "--progress json",
    "--progress plain",
    "--progress loud",
    "--quiet",
    "--size 9x7",
    "--size 1x1",
    "--size 0x1",
    "--size 3",
    "--size 65536x65536",
    "--nonsense",
    "extra",
];

const GRAMMARS: &[Grammar] = &[
    Grammar {
        command: "render",
        parts: &[
            &["tiny.toml", "tiny.toml", "tiny.toml", "tiny.obj", "none.toml", "a.exr", "tiny.mtl"],
            &["--device cpu", "--device cpu", "--device cpu", "--device nonesuch"],
            &[
                "--passes 1",
                "--passes 2",
                "--passes 1 --error 0.5",
                "--passes 1 --time 5",
                "--time 0.01",
                "--pass-range 0..2 --checkpoint p.joton",
                "--passes 0",
                "--passes 18446744073709551615",
                "--pass-range 3..2 --checkpoint p.joton",
                "--pass-range 0..2",
                "--error nan --passes 1",
                "--error inf",
                "--time -1",
            ],
        ],
        options: RENDER_OPTIONS,
        cases: 80,
    },
    Grammar {
        command: "resume",
        parts: &[&[
            "whole.joton",
            "whole.joton",
            "part0.joton",
            "junk.joton",
            "none.joton",
            "tiny.toml",
            ".",
        ]],
        options: &[
            "--passes 2",
            "--passes 1",
            "--passes 0",
            "--time 0.01",
            "--time nan",
            "--error 0.5",
            "--error 0",
            "--device cpu",
            "--device nonesuch",
            "-o x.exr",
            "-o y.png",
            "-o x.jpg",
            "-o tiny.obj",
            "-o whole.joton",
            "-o none/x.exr",
            "--report r.json",
            "--report -",
            "--report whole.joton",
            "--progress json",
            "--quiet",
            "--threads 1",
            "--size 3x3",
        ],
        cases: 30,
    },
    Grammar {
        command: "merge",
        parts: &[
            &[
                "part0.joton part1.joton",
                "part1.joton part0.joton",
                "part0.joton part1.joton",
                "part0.joton",
                "part1.joton",
                "part0.joton part0.joton",
                "whole.joton",
                "junk.joton",
                "part0.joton tiny.obj",
                "",
            ],
            &[
                "-o x.exr",
                "-o x.exr",
                "--checkpoint m.joton",
                "-o x.exr -o y.png --checkpoint m.joton",
                "-o x.jpg",
                "",
            ],
        ],
        options: &[
            "-o y.png",
            "-o part0.joton",
            "-o tiny.toml",
            "-o none/x.exr",
            "--checkpoint m.joton",
            "--checkpoint part0.joton",
            "--checkpoint x.exr",
            "--scene tiny.toml",
            "--scene tiny.obj",
            "--scene none.toml",
            "--report r.json",
            "--report -",
            "--report part1.joton",
            "--quiet",
        ],
        cases: 30,
    },
    Grammar {
        command: "slurm",
        parts: &[
            &["tiny.toml", "tiny.toml", "tiny.obj", "none.toml"],
            &["--tasks 3", "--tasks 3", "--tasks 1", "--tasks 10000", "--tasks 0", "--tasks 10001", ""],
            &[
                "--passes 64",
                "--passes 64",
                "--passes 64",
                "--passes 40",
                "--passes 1",
                "--passes 0",
                "--passes 18446744073709551615",
                "--passes 4294967296",
                "",
            ],
        ],
        options: &[
            "-o x.exr",
            "-o y.png",
            "-o x.jpg",
            "-o none/x.exr",
            "-o tiny.toml",
            "--folder f",
            "--folder none/f",
            "--folder tiny.obj",
            "--sbatch=--gres=gpu:1",
            "--sbatch",
            "-- --seed 3",
            "-- --seed x",
            "-- --passes 3",
            "-- -o z.exr",
            "-- --every 0",
            "-- --size 3x3 --device cpu",
            "-- --reference",
            "-- --threads 2",
            "-- --report r.json",
            "-- --help",
        ],
        cases: 40,
    },
    Grammar {
        command: "check",
        parts: &[&[
            "tiny.toml",
            "tiny.toml",
            "tiny.obj",
            "tiny.obj",
            "none.obj",
            "tiny.mtl",
            "a.exr",
            ".",
            "",
        ]],
        options: &["--strict", "--json", "--threads 1", "--size 3x3", "extra"],
        cases: 15,
    },
    Grammar {
        command: "plan",
        parts: &[&["tiny.toml", "tiny.toml", "tiny.obj", "none.obj"]],
        options: &[
            "--size 9x7",
            "--size 0x0",
            "--size 65536x65536",
            "--size 3",
            "--paths LDE",
            "--paths LDX",
            "--no-skip all",
            "--no-skip nothing",
            "--memory 64M",
            "--memory 1K",
            "--memory 2T",
            "--model h200",
            "--model 0.5T,1.5G",
            "--model nan,nan",
            "--model 0,0",
            "--model moon",
            "--json",
        ],
        cases: 25,
    },
    Grammar {
        command: "compare",
        parts: &[
            &["a.exr", "a.exr", "b.exr", "b.exr", "none.exr", "tiny.obj"],
            &["a.exr", "b.exr", "b.exr", "small.exr", ""],
        ],
        options: &[
            "--twin b.exr",
            "--twin small.exr",
            "--twin none.exr",
            "--heatmap h.png",
            "--heatmap a.exr",
            "--heatmap none/h.png",
            "--tolerance 0",
            "--tolerance 1e9",
            "--tolerance nan",
            "--tolerance -1",
            "--tolerance inf",
            "--regions 3",
            "--regions 0",
            "--regions 4294967295",
            "--regions -1",
            "--json",
        ],
        cases: 40,
    },
    Grammar {
        command: "export",
        parts: &[
            &["tiny.toml", "tiny.toml", "tiny.obj", "none.toml"],
            &["-o m.xml", "-o m.xml", "-o m.xml", "-o m.txt", "-o none/m.xml", "-o .", ""],
        ],
        options: &["--threads 1", "--size 3x3", "--size 0x3", "-o n.xml", "--json"],
        cases: 25,
    },
    Grammar {
        command: "bench",
        parts: &[
            &["tiny.toml", "tiny.toml", "tiny.toml tiny.toml", "tiny.obj --size 8x8", "none.toml", ""],
            &["--device cpu", "--device cpu", "--device cpu-reference", "--device nonesuch"],
            &["--times 0.01", "--times 0.01", "--times 0.01,0.02", "--times 0", "--times nan", "--times"],
        ],
        options: &[
            "--size 8x8",
            "--size 0x8",
            "--reference a.exr",
            "--reference small.exr",
            "--reference none.exr",
            "--reference tiny.obj",
            "--cpu-seconds",
            "--seeds 2",
            "--seeds 0",
            "--memory 64M",
            "--paths LDE",
            "--paths X",
            "--no-skip all",
            "--no-skip x",
            "--timings",
            "--model h200",
            "--model x --timings",
            "--versus moon",
            "--python none",
            "-o p",
            "-o none/p",
            "-o .",
            "-o tiny",
        ],
        cases: 30,
    },
    Grammar {
        command: "devices",
        parts: &[],
        options: &["--json", "--json", "--threads 1", "--quiet", "extra"],
        cases: 10,
    },
];

/// Command lines of a grammar: mostly few options, so that many are right.
fn command_lines(grammar: &'static Grammar) -> impl Strategy<Value = String> {
    let parts: Vec<_> = grammar.parts.iter().map(|part| select(*part)).collect();
    let options = subsequence(grammar.options, 0..=3);
    (parts, options).prop_map(|(parts, mut options)| {
        // what stands behind -- comes last
        options.sort_by_key(|option| option.starts_with("-- "));
        let words = [&[grammar.command][..], &parts, &options].concat();
        words.join(" ")
    })
}

/// Everything under a folder: its bytes, by its path from there.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    let mut open = vec![folder.to_owned()];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(fs::read_dir(&path).expect("a folder").map(|entry| entry.expect("an entry").path()));
        } else {
            let name = path.strip_prefix(folder).expect("inside").to_owned();
            found.insert(name, fs::read(&path).expect("a file"));
        }
    }
    found
}

/// What follows each of an option's names, as they stand in a command line.
fn values<'a>(words: &[&'a str], names: &[&str]) -> Vec<&'a str> {
    words.windows(2).filter(|pair| names.contains(&pair[0])).map(|pair| pair[1]).collect()
}

/// The files that a command promises: names, or what they begin with where there is a star.
fn promised(words: &[&str]) -> Vec<String> {
    let own: Vec<&str> = words.iter().copied().take_while(|word| *word != "--").collect();
    let outputs = values(&own, &["-o"]);
    let with = |names: &[&str]| -> Vec<String> {
        let named = values(&own, names).into_iter().filter(|name| *name != "-");
        outputs.iter().copied().chain(named).map(String::from).collect()
    };
    match own[0] {
        "render" | "resume" => {
            let mut all = with(&["--report", "--checkpoint"]);
            if outputs.is_empty() && !own.contains(&"--pass-range") && own[1] != "part0.joton" {
                all.extend(["tiny.png", "tiny.exr"].map(String::from));
            }
            if own[0] == "resume" {
                all.push(own[1].into());
            }
            all
        }
        "merge" => with(&["--report", "--checkpoint"]),
        "slurm" => {
            let folder = values(&own, &["--folder"]).first().copied().unwrap_or("tiny.slurm");
            ["render.sh", "merge.sh"].map(|name| format!("{folder}/{name}")).into()
        }
        "compare" => values(&own, &["--heatmap"]).into_iter().map(String::from).collect(),
        "export" => vec![outputs[0].into(), format!("{}.*", outputs[0].trim_end_matches(".xml"))],
        "bench" => {
            let prefix = outputs.first().copied().unwrap_or("bench");
            let kinds = ["csv", "summary.csv", "svg", "kernels.csv"];
            let kinds = if own.contains(&"--timings") { &kinds[..] } else { &kinds[..3] };
            kinds.iter().map(|kind| format!("{prefix}.{kind}")).collect()
        }
        _ => Vec::new(),
    }
}

/// Whether the contract holds of a run; what it changed is put back.
fn check(folder: &Folder, before: &BTreeMap<PathBuf, Vec<u8>>, line: &str) -> Result<i32, TestCaseError> {
    let Ended { code, stdout, stderr } = folder.ends(line);
    let after = contents(&folder.path(""));
    for name in after.keys().filter(|name| !before.contains_key(*name)) {
        fs::remove_file(folder.path("").join(name)).expect("removed");
    }
    for slurm in ["tiny.slurm", "f", "none"] {
        fs::remove_dir_all(folder.path(slurm)).ok();
    }
    for (name, bytes) in before.iter().filter(|(name, bytes)| after.get(*name) != Some(*bytes)) {
        fs::write(folder.path("").join(name), bytes).expect("put back");
    }
    let told = format!("joton {line}: {code:?}\n{stdout}{stderr}");
    let changed: Vec<&PathBuf> = after
        .iter()
        .filter(|(name, bytes)| before.get(*name) != Some(*bytes))
        .map(|(name, _)| name)
        .collect();
    prop_assert!(before.keys().all(|name| after.contains_key(name)), "a file is gone: {told}");
    prop_assert!(!told.contains("panicked"), "{told}");
    let words: Vec<&str> = line.split_whitespace().collect();
    let may_judge = ["check", "compare"].contains(&words[0]);
    match code {
        Some(2) => {
            prop_assert_eq!(stderr.lines().count(), 1, "one line: {}", told);
            prop_assert!(stderr.starts_with("joton: "), "{}", told);
            prop_assert!(!stderr.contains(|c: char| c.is_control() && c != '\n'), "{}", told);
            // the option, its value, the file; or what is missing
            let mut names =
                words[1..].iter().flat_map(|word| word.split([',', '='])).filter(|name| !name.is_empty());
            let is_missing = stderr.contains("--") || stderr.contains("required arguments");
            prop_assert!(names.any(|name| stderr.contains(name)) || is_missing, "it names nothing: {}", told);
            prop_assert!(changed.is_empty(), "refused, but it wrote {:?}: {}", changed, told);
        }
        Some(code @ (0 | 1)) => {
            prop_assert!(code == 0 || may_judge, "{}", told);
            let is_answer = words.contains(&"--help");
            let promised = if is_answer { Vec::new() } else { promised(&words) };
            for name in promised.iter().filter(|name| !name.ends_with('*')) {
                prop_assert!(after.contains_key(Path::new(name)), "{} is promised: {}", name, told);
            }
            let is_promised = |name: &&PathBuf| {
                let name = name.to_string_lossy();
                promised
                    .iter()
                    .any(|p| p.strip_suffix('*').map_or(name == *p, |begin| name.starts_with(begin)))
            };
            prop_assert!(changed.iter().all(is_promised), "it wrote {:?}: {}", changed, told);
        }
        _ => prop_assert!(false, "{}", told),
    }
    Ok(code.unwrap_or_default())
}

/// A folder with a scene of a few triangles, pictures, checkpoints, and what is none.
fn folder() -> Folder {
    let folder = Folder::empty();
    let toml = "[film]\nwidth = 8\nheight = 8\n[camera]\nposition = [0, 1, 4]\ntarget = [0, 0, 0]\n[[mesh]]\nfile = \"tiny.obj\"\n\
                [[shape]]\nkind = \"cube\"\ncenter = [0, 0.51, 0]\nmaterial = { type = \"mirror\" }\n[[light]]\nkind = \"point\"\n\
                position = [1, 3, 1]\nintensity = 20\n";
    let obj = "mtllib tiny.mtl\nusemtl floor\nv -3 0 -3\nv 3 0 -3\nv 3 0 3\nv -3 0 3\nf 4 3 2 1\n";
    for (name, text) in [
        ("tiny.toml", toml),
        ("tiny.obj", obj),
        ("tiny.mtl", "newmtl floor\nKd .7 .6 .5\n"),
        ("junk.joton", "junk"),
    ] {
        fs::write(folder.path(name), text).expect("a file");
    }
    let render = "render tiny.toml --device cpu --quiet";
    for line in [
        "--passes 1 -o a.exr",
        "--passes 1 --seed 2 -o b.exr",
        "--passes 1 --size 4x3 -o small.exr",
        "--passes 1 --checkpoint whole.joton",
        "--pass-range 0..16 --checkpoint part0.joton",
        "--pass-range 16..18 --checkpoint part1.joton",
    ] {
        folder.done(&format!("{render} {line}"));
    }
    for name in ["tiny.png", "tiny.exr"] {
        fs::remove_file(folder.path(name)).expect("the picture of the checkpoint");
    }
    folder
}

/// The contract of the command line holds of any combination of options. Some of each command's lines are right, and some wrong.
#[test]
fn any_combination_keeps_the_contract() {
    let folder = folder();
    let before = contents(&folder.path(""));
    let mut faults = Vec::new();
    for grammar in GRAMMARS {
        let rng = TestRng::deterministic_rng(RngAlgorithm::ChaCha);
        let config = Config { cases: grammar.cases, failure_persistence: None, ..Config::default() };
        let codes = std::cell::RefCell::new([0; 3]);
        let found = TestRunner::new_with_rng(config, rng).run(&command_lines(grammar), |line| {
            let code = check(&folder, &before, &line)?;
            codes.borrow_mut()[code as usize] += 1;
            Ok(())
        });
        if let Err(e) = found {
            faults.push(e.to_string());
            continue;
        }
        let [done, _, refused] = codes.into_inner();
        if done == 0 || refused == 0 {
            faults.push(format!("{}: {done} done, {refused} refused", grammar.command));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
}
