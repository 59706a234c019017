//! Arrows: who imports whom, as docs/ARCHITECTURE.md says; who names obvhs and wgpu; what the kernels say of themselves.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Every folder under src and what it may import, from the top down: an arrow points to a folder further down.
/// `spectrum` and `error` are free for all.
const ARROWS: [(&str, &[&str]); 17] = [
    ("main", &["cli", "system"]),
    ("cli", &["bench", "output", "render", "backend", "plan", "packed", "scene", "film", "host", "system"]),
    ("system", &[]),
    ("bench", &["output", "render", "backend", "film"]),
    ("output", &["render", "backend", "plan", "estimators", "packed", "scene", "film", "host"]),
    ("render", &["backend", "resolve", "estimators", "film"]),
    ("backend", &["plan", "resolve", "optics", "estimators", "packed", "sampling", "film", "host"]),
    ("resolve", &["optics", "packed", "sampling", "film"]),
    ("plan", &["optics", "estimators", "packed", "sampling", "film"]),
    ("optics", &["packed", "sampling"]),
    ("estimators", &["packed", "sampling", "film"]),
    ("packed", &["scene", "sampling", "film", "host"]),
    ("scene", &["host"]),
    ("sampling", &[]),
    ("film", &["host"]),
    ("host", &[]),
    ("spectrum", &[]),
];
/// Free for all.
const FREE: [&str; 2] = ["spectrum", "error"];

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

/// Paths that a text names from the crate's root or relative to its own module `me`: of `use` trees every leaf.
fn paths(me: &[String], text: &str) -> BTreeSet<Vec<String>> {
    let code = code(text);
    let mut found = BTreeSet::new();
    let mut rest = String::new();
    let mut at = 0;
    for (start, _) in code.match_indices("use ") {
        let is_word = !code[..start].ends_with(|c: char| c.is_alphanumeric() || c == '_');
        if start < at || !is_word {
            continue;
        }
        let end = start + code[start..].find(';').unwrap_or(code.len() - start);
        rest.push_str(&code[at..start]);
        leaves(&[], &code[start + 4..end], &mut found);
        at = end;
    }
    rest.push_str(&code[at..]);
    let is_part = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    for word in rest.split(|c: char| !is_part(c)).filter(|w| w.contains("::")) {
        found.insert(word.split("::").map(String::from).collect());
    }
    found.into_iter().filter_map(|path| from_root(me, &path)).collect()
}

/// The leaves of a `use` tree: `a::{b, c::{d, e}}` gives a::b, a::c::d and a::c::e.
fn leaves(prefix: &[String], tree: &str, found: &mut BTreeSet<Vec<String>>) {
    let (mut depth, mut part, mut parts) = (0, String::new(), Vec::new());
    for c in tree.chars() {
        match c {
            '{' => depth += 1,
            '}' => depth -= 1,
            _ => {}
        }
        if c == ',' && depth == 0 { parts.push(std::mem::take(&mut part)) } else { part.push(c) }
    }
    parts.push(part);
    for part in parts.iter().map(|p| p.trim()).filter(|p| !p.is_empty()) {
        let (head, group) = part.split_once('{').map_or((part, None), |(h, g)| (h, Some(g)));
        let head = head.split(" as ").next().unwrap_or("");
        let words = head.split("::").map(|w| w.trim().to_string()).filter(|w| !w.is_empty());
        let path: Vec<String> = prefix.iter().cloned().chain(words).collect();
        match group {
            Some(group) => leaves(&path, group.trim_end().trim_end_matches('}'), found),
            None => _ = found.insert(path),
        }
    }
}

/// A path as it is named in module `me`, from the crate's root; none of another crate.
fn from_root(me: &[String], path: &[String]) -> Option<Vec<String>> {
    let mut base = match path.first()?.as_str() {
        "crate" => Vec::new(),
        "self" => me.to_vec(),
        "super" => me[..me.len() - 1].to_vec(),
        _ => return None,
    };
    for word in &path[1..] {
        match word.as_str() {
            "super" => _ = base.pop(),
            "self" => {}
            word => base.push(word.to_string()),
        }
    }
    Some(base)
}

/// The module of a file, from the crate's root.
fn path_of(file: &Path) -> Vec<String> {
    let inside = file.strip_prefix(root().join("src")).expect("a file under src").with_extension("");
    let words = inside.iter().map(|w| w.to_string_lossy().into_owned());
    words.filter(|w| w != "mod").collect()
}

/// Circles among modules that import each other, each with its modules. What a file imports from the file of its own folder or one
/// above it is that folder's own business.
fn circles(texts: &BTreeMap<Vec<String>, String>) -> Vec<BTreeSet<Vec<String>>> {
    let file_of = |path: &[String]| {
        let longest = (1..=path.len()).rev().find_map(|n| texts.get_key_value(&path[..n]));
        longest.map(|(file, _)| &file[..])
    };
    let imports: BTreeMap<&[String], BTreeSet<&[String]>> = texts
        .iter()
        .map(|(me, text)| {
            let named = paths(me, text);
            let files = named.iter().filter_map(|path| file_of(path));
            (&me[..], files.filter(|to| !me.starts_with(to)).collect())
        })
        .collect();
    let reached = |from: &[String]| {
        let (mut seen, mut next) = (BTreeSet::new(), vec![from.to_vec()]);
        while let Some(at) = next.pop() {
            for to in &imports[&at[..]] {
                if seen.insert(to.to_vec()) {
                    next.push(to.to_vec());
                }
            }
        }
        seen
    };
    let reaches: BTreeMap<&[String], BTreeSet<Vec<String>>> =
        imports.keys().map(|me| (*me, reached(me))).collect();
    let mut found: Vec<BTreeSet<Vec<String>>> = Vec::new();
    for (me, reach) in &reaches {
        let circle: BTreeSet<Vec<String>> =
            reach.iter().filter(|to| reaches[&to[..]].contains(*me)).cloned().collect();
        if !circle.is_empty() && !found.contains(&circle) {
            found.push(circle);
        }
    }
    found
}

#[test]
fn no_files_import_each_other() {
    let all = files(&root().join("src"), "rs").into_iter();
    // the program's own files name the library by its name
    let library = all.filter(|f| !["main", "cli", "system", "lib"].contains(&module_of(f).as_str()));
    let texts: BTreeMap<Vec<String>, String> = library.map(|f| (path_of(&f), read(&f))).collect();
    assert!(texts.len() > 100);
    assert_eq!(circles(&texts), Vec::<BTreeSet<Vec<String>>>::new());
}

/// Two backends that know each other would make the same mistakes.
#[test]
fn backends_do_not_know_each_other() {
    for (one, other) in [("cpu", "gpu"), ("gpu", "cpu")] {
        for file in files(&root().join("src/backend").join(one), "rs") {
            let named = paths(&path_of(&file), &read(&file));
            let wrong = named.iter().find(|path| path.starts_with(&["backend".into(), other.into()]));
            assert!(wrong.is_none(), "{} imports {wrong:?}", file.display());
        }
    }
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
        if module == "lib" || module == "error" {
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
            assert!(at > from, "{module} → {to} points up");
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
    assert_eq!(naming("obvhs"), [root().join("src/packed/accel/mod.rs")]);
    let gpu = root().join("src/backend/gpu");
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
        if !file.parent().is_some_and(|p| p.ends_with("passes")) {
            continue;
        }
        kernels += 1;
        let text = read(&file);
        let head = head(&text);
        for word in ["reads", "writes"] {
            assert!(head.contains(word), "{}: the head does not say what it {word}", file.display());
        }
        assert!(untold(&text).is_empty(), "{}: the head does not name {:?}", file.display(), untold(&text));
        assert!(
            joton::backend::gpu::SOURCES.iter().any(|(_, t)| *t == text),
            "{} is not linked",
            file.display()
        );
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
    assert_eq!(violations("scene", "use crate::backend::gpu::Context;"), ["scene imports backend"]);
    assert_eq!(
        violations("plan", "use crate::{spectrum, packed::{PackedScene, Target}, render};"),
        ["plan imports render"]
    );
    assert_eq!(violations("plan", "fn f() { crate::render::link(\"\") }"), ["plan imports render"]);
    assert_eq!(violations("backend", "use crate::bench;\nuse crate::render::Stop;").len(), 2);
    assert_eq!(violations("packed", "pub(crate) fn f(p: &crate::plan::Plan)"), ["packed imports plan"]);
    assert_eq!(violations("news", ""), ["news is in no arrow"]);
    assert!(violations("backend", "// use crate::bench;\nuse crate::packed::{self, Joton};").is_empty());
    let path = |text: &str| text.split("::").map(String::from).collect::<Vec<String>>();
    let text = |of: &[(&str, &str)]| of.iter().map(|(me, text)| (path(me), text.to_string())).collect();
    let round = [
        ("a", "mod b; use b::B;"),
        ("a::b", "use super::A; use crate::{c::{C, D}};"),
        ("c", "fn f(b: crate::a::b::B)"),
    ];
    assert_eq!(circles(&text(&round)), [BTreeSet::from([path("a::b"), path("c")])]);
    let siblings = [("a", ""), ("a::b", "use super::c::C;"), ("a::c", "use super::{A, b::B};")];
    assert_eq!(circles(&text(&siblings)), [BTreeSet::from([path("a::b"), path("a::c")])]);
    assert!(circles(&text(&siblings[..2])).is_empty());
    let kernel = "// Kernel.\n// reads  a      writes  b\n@group(0) @binding(0) var<storage, read> a: array<u32>;\n\
        @group(0) @binding(1) var<storage, read_write> c: array<u32>;";
    assert_eq!(bindings(kernel), ["a", "c"]);
    assert_eq!(untold(kernel), ["c"]);
    let twin = concat!("/", "/ Twin: src/backend/cpu/no_such.rs, src/backend/cpu/eye.rs.");
    assert_eq!(gone(twin), ["src/backend/cpu/no_such.rs"]);
}
