//! Arrows: who imports whom, as docs/ARCHITECTURE.md says; who names obvhs and wgpu; what the kernels say of themselves.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Every module and what it may import, from the top down: an arrow to a module further up needs a reason.
/// `bands` and `error` are free for all.
const ARROWS: [(&str, &[&str]); 30] = [
    ("main", &["cli", "system"]),
    (
        "cli",
        &[
            "bench", "export", "render", "report", "output", "gpu", "cpu", "plan", "pack", "scene", "paths",
            "film", "backend", "system",
        ],
    ),
    ("system", &[]),
    ("export", &["output", "pack", "scene"]),
    ("bench", &["render", "output", "backend", "film"]),
    ("report", &["render", "backend", "plan", "pack", "memory"]),
    ("render", &["halves", "quiet", "glints", "backend", "film", "rest"]),
    ("halves", &["film", "rest"]),
    ("quiet", &["glints", "film", "rest"]),
    ("gpu", &["backend", "plan", "glints", "layout", "pack", "film", "paths", "rng", "rest", "memory"]),
    (
        "cpu",
        &[
            "backend",
            "plan",
            "glints",
            "optics",
            "layout",
            "pack",
            "film",
            "paths",
            "rng",
            "rest",
            "neighbours",
        ],
    ),
    ("plan", &["glints", "optics", "layout", "pack", "paths", "film", "rng"]),
    ("optics", &["layout", "pack"]),
    ("backend", &["glints", "film", "rest"]),
    ("glints", &["layout", "film", "rng", "neighbours"]),
    // up: structs are declared by layout's macro
    ("pack", &["scene", "bvh", "rng", "layout", "memory"]),
    ("layout", &["pack", "paths", "rest", "bvh"]),
    ("stats", &["film"]),
    ("output", &["film", "input", "memory"]),
    ("paths", &["film"]),
    ("scene", &["input"]),
    ("input", &["memory"]),
    ("film", &["memory", "rest"]),
    ("bvh", &[]),
    ("rng", &[]),
    ("memory", &[]),
    ("rest", &[]),
    ("neighbours", &[]),
    ("bands", &[]),
    ("error", &[]),
];
/// Free for all.
const FREE: [&str; 2] = ["bands", "error"];
/// Arrows that run against the order of the table.
const LOOPS: [(&str, &str); 1] = [("layout", "pack")];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in
        std::fs::read_dir(folder).expect("a folder of the repository").map(|e| e.expect("an entry").path())
    {
        if entry.is_dir() {
            found.extend(files(&entry, extension));
        } else if entry.extension().is_some_and(|e| e == extension) {
            found.push(entry);
        }
    }
    found.sort();
    found
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// The module that a file under src belongs to: its first folder or its name.
fn module_of(path: &Path) -> String {
    let inside = path.strip_prefix(root().join("src")).expect("a file under src");
    let first = inside.iter().next().expect("not empty").to_string_lossy();
    first.trim_end_matches(".rs").to_string()
}

/// Code without comments, and without unit tests, which stand at the end and may use anything.
fn code(text: &str) -> String {
    let text = text.split("#[cfg(test)]").next().unwrap_or("");
    text.lines().map(|l| l.split("//").next().unwrap_or("")).collect::<Vec<_>>().join("\n")
}

/// Modules that a text names by `crate::x` or, in main and cli, `joton::x`; `use crate::{a, b::c}` names a and b.
fn imports(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let code = code(text);
    for root in ["crate::", "joton::"] {
        for (at, _) in code.match_indices(root) {
            // not the end of another word
            if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
                continue;
            }
            let rest = &code[at + root.len()..];
            let names: Vec<String> = if let Some(group) = rest.strip_prefix('{') {
                heads(group)
            } else {
                vec![rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()]
            };
            found.extend(names);
        }
    }
    found.remove("");
    found.remove("self");
    found
}

/// First words of the parts of a group: `a, b::{c, d}}` gives a and b.
fn heads(group: &str) -> Vec<String> {
    let (mut depth, mut head, mut all) = (0, String::new(), Vec::new());
    for c in group.chars() {
        match c {
            '}' if depth == 0 => break,
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => all.push(std::mem::take(&mut head)),
            c if depth == 0 => head.push(c),
            _ => {}
        }
    }
    all.push(head);
    all.iter().map(|h| h.trim().split("::").next().unwrap_or("").to_string()).collect()
}

/// What a file imports that its module may not.
fn violations(module: &str, text: &str) -> Vec<String> {
    let Some((_, allowed)) = ARROWS.iter().find(|(m, _)| *m == module) else {
        return vec![format!("{module} is in no arrow")];
    };
    imports(text)
        .into_iter()
        .filter(|to| to != module && !FREE.contains(&to.as_str()) && !allowed.contains(&to.as_str()))
        // Error and Result are named at the root
        .filter(|to| to != "Error" && to != "Result")
        .map(|to| format!("{module} imports {to}"))
        .collect()
}

#[test]
fn imports_follow_the_arrows() {
    let mut used: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in files(&root().join("src"), "rs") {
        let module = module_of(&file);
        if module == "lib" {
            continue;
        }
        let text = read(&file);
        let wrong = violations(&module, &text);
        assert!(wrong.is_empty(), "{}: {}", file.display(), wrong.join(", "));
        used.entry(module).or_default().extend(imports(&text));
    }
    // what is written down exists
    for (module, allowed) in ARROWS {
        let used = used.get(module).unwrap_or_else(|| panic!("there is no module {module}"));
        for to in allowed {
            assert!(
                used.contains(*to) || module == "main",
                "{module} does not import {to} any more: drop the arrow"
            );
        }
    }
}

#[test]
fn arrows_point_one_way() {
    let place = |m: &str| ARROWS.iter().position(|(module, _)| *module == m);
    for (from, (module, allowed)) in ARROWS.iter().enumerate() {
        for to in *allowed {
            let at = place(to).unwrap_or_else(|| panic!("{to} is in no arrow"));
            assert!(at > from || LOOPS.contains(&(module, to)), "{module} → {to} points up");
        }
    }
}

/// The table in the documents is the one that is checked.
#[test]
fn the_documents_tell_the_same_arrows() {
    let text = read(&root().join("docs/ARCHITECTURE.md"));
    let section =
        text.split("## Arrows").nth(1).expect("a section Arrows").split("\n## ").next().unwrap_or("");
    let mut told: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for line in section.split("```").nth(1).expect("a table").lines() {
        let Some((from, to)) = line.split_once('→') else { continue };
        // remarks stand in parentheses
        let to = to.split('(').next().unwrap_or("");
        for module in from.split(',') {
            let words =
                to.split(',').map(|w| w.trim().to_string()).filter(|w| w != "nothing" && !w.is_empty());
            told.insert(module.trim().to_string(), words.collect());
        }
    }
    let checked: BTreeMap<String, BTreeSet<String>> =
        ARROWS.iter().map(|(m, to)| (m.to_string(), to.iter().map(|t| t.to_string()).collect())).collect();
    assert_eq!(told, checked);
}

/// Files whose code names a crate as a path.
fn naming(crate_name: &str) -> Vec<PathBuf> {
    let path = format!("{crate_name}::");
    files(&root().join("src"), "rs").into_iter().filter(|f| code(&read(f)).contains(&path)).collect()
}

#[test]
fn obvhs_and_wgpu_are_named_in_one_place() {
    assert_eq!(naming("obvhs"), [root().join("src/bvh.rs")]);
    let gpu = root().join("src/gpu");
    let named = naming("wgpu");
    assert!(!named.is_empty());
    for file in named {
        assert!(file.starts_with(&gpu), "{} names wgpu", file.display());
    }
}

/// The standard library has no safe counterpart of what one file does; what it says of each use is read with it.
#[test]
fn unsafe_code_is_in_one_place() {
    let has_unsafe = |file: &PathBuf| code(&read(file)).contains("unsafe {");
    let found: Vec<_> = files(&root().join("src"), "rs").into_iter().filter(has_unsafe).collect();
    assert_eq!(found, [root().join("src/system.rs")]);
    let text = read(&found[0]);
    assert_eq!(text.matches("unsafe {").count(), text.matches("// SAFETY: ").count());
}

/// Names of a kernel's own bindings.
fn bindings(text: &str) -> Vec<String> {
    code(text)
        .lines()
        .filter(|l| l.trim_start().starts_with("@group"))
        .filter_map(|l| l.split("> ").nth(1)?.split(':').next().map(|n| n.trim().to_string()))
        .collect()
}

/// The head of a file: its comment up to the first line that is none.
fn head(text: &str) -> String {
    text.lines().take_while(|l| l.starts_with("//")).collect::<Vec<_>>().join("\n")
}

/// Bindings that a head does not name; `pass_info` and `status` are every kernel's.
fn untold(text: &str) -> Vec<String> {
    let head = head(text).to_lowercase();
    bindings(text)
        .into_iter()
        .filter(|b| b != "pass_info" && b != "status")
        .filter(|b| !head.split(|c: char| !c.is_alphanumeric() && c != '_').any(|word| word == b))
        .collect()
}

#[test]
fn kernels_tell_what_they_read_and_write() {
    let mut kernels = 0;
    for file in files(&root().join("shaders"), "wgsl") {
        if file.parent().is_some_and(|p| p.ends_with("shared")) {
            continue;
        }
        kernels += 1;
        let text = read(&file);
        let head = head(&text);
        for word in ["reads", "writes"] {
            assert!(head.contains(word), "{}: the head does not say what it {word}", file.display());
        }
        assert!(untold(&text).is_empty(), "{}: the head does not name {:?}", file.display(), untold(&text));
        assert!(joton::gpu::SOURCES.iter().any(|(_, t)| *t == text), "{} is not linked", file.display());
    }
    assert!(kernels > 10);
}

/// Files under src and shaders that comments name with their folder, and that are not there. `x` stands for any.
fn gone(text: &str) -> Vec<String> {
    let comments = text.lines().filter_map(|l| l.split_once("//")).map(|(_, comment)| comment);
    let words = comments.flat_map(|c| c.split(|c: char| !c.is_alphanumeric() && !"_/.".contains(c)));
    let names = words.map(|w| w.trim_end_matches('.')).filter(|w| {
        (w.starts_with("src/")
            || w.starts_with("shaders/")
            || w.starts_with("docs/")
            || w.starts_with("tests/"))
            && w.rsplit('/').next().is_some_and(|name| name.contains('.'))
    });
    names.filter(|w| !root().join(w).exists()).map(String::from).collect()
}

#[test]
fn comments_name_files_that_exist() {
    for (folder, extension) in [("src", "rs"), ("shaders", "wgsl"), ("tests", "rs")] {
        for file in files(&root().join(folder), extension) {
            let gone = gone(&read(&file));
            assert!(gone.is_empty(), "{}: {}", file.display(), gone.join(", "));
        }
    }
}

/// The checks see what they are for.
#[test]
fn a_wrong_import_is_found() {
    assert_eq!(violations("scene", "use crate::gpu::Context;"), ["scene imports gpu"]);
    assert_eq!(
        violations("plan", "use crate::{bands, pack::{PackedScene, Target}, gpu};"),
        ["plan imports gpu"]
    );
    assert_eq!(violations("cpu", "fn f() { crate::gpu::link(\"\") }"), ["cpu imports gpu"]);
    assert_eq!(violations("gpu", "use crate::cpu;\nuse crate::render::Stop;").len(), 2);
    assert_eq!(violations("output", "pub(crate) fn f(p: &crate::plan::Plan)"), ["output imports plan"]);
    assert_eq!(violations("news", ""), ["news is in no arrow"]);
    assert!(violations("gpu", "// use crate::cpu;\nuse crate::layout::{self, Joton};").is_empty());
    let kernel = "// Kernel.\n// reads  a      writes  b\n@group(0) @binding(0) var<storage, read> a: array<u32>;\n\
        @group(0) @binding(1) var<storage, read_write> c: array<u32>;";
    assert_eq!(bindings(kernel), ["a", "c"]);
    assert_eq!(untold(kernel), ["c"]);
    let twin = concat!("/", "/ Twin: src/cpu/no_such.rs, src/cpu/eye.rs.");
    assert_eq!(gone(twin), ["src/cpu/no_such.rs"]);
}
