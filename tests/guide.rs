//! Claims about the user's guide: its scenes load without a warning, its pictures are there, its links lead somewhere.

use joton::packed::{PackedScene, doubts};
use std::fs::{read_dir, read_to_string};
use std::path::{Path, PathBuf};

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Files of a folder of the guide, by the end of their name.
fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let entries = read_dir(root().join("docs/guide").join(folder)).expect("a folder of the guide").flatten();
    let mut found: Vec<_> =
        entries.map(|e| e.path()).filter(|p| p.extension().is_some_and(|e| e == extension)).collect();
    found.sort();
    assert!(!found.is_empty(), "docs/guide/{folder} has no .{extension}");
    found
}

/// Each page of the guide with its text, without blocks of code.
fn pages() -> Vec<(PathBuf, String)> {
    let prose = |path: &PathBuf| -> String {
        let text = read_to_string(path).expect("a page");
        text.split("\n```").step_by(2).collect()
    };
    files("", "md").into_iter().map(|path| (path.clone(), prose(&path))).collect()
}

/// Where the links of a page lead; of pictures alone, or of all.
fn targets(page: &str, of_pictures: bool) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in page.match_indices("](") {
        let is_picture = page[..at].rsplit_once('[').is_some_and(|(before, _)| before.ends_with('!'));
        let target = page[at + 2..].split([')', '#']).next().unwrap_or_default();
        if !target.is_empty() && !target.contains("://") && (is_picture || !of_pictures) {
            found.push(target.to_owned());
        }
    }
    found
}

/// Pages and what they link to that is not there; how many links there are.
fn lost(of_pictures: bool) -> (Vec<String>, usize) {
    let (mut lost, mut count) = (Vec::new(), 0);
    for (path, page) in pages() {
        let folder = path.parent().expect("a folder");
        for target in targets(&page, of_pictures) {
            count += 1;
            if !folder.join(&target).exists() {
                lost.push(format!("{}: {target}", path.display()));
            }
        }
    }
    (lost, count)
}

/// No scene of the guide has a warning, neither when it is read nor when light is looked for.
#[test]
fn scenes_load_without_a_warning() {
    for path in files("scenes", "toml") {
        let scene = joton::scene::load(&path).unwrap_or_else(|e| panic!("{e}"));
        let packed = PackedScene::new(&scene);
        let warnings = [scene.warnings.clone(), doubts(&scene, &packed)].concat();
        assert!(warnings.is_empty(), "{}: {}", path.display(), warnings.join("; "));
    }
}

/// Pictures that pages show are there, and every scene of the guide has one that a page shows.
#[test]
fn pictures_exist() {
    let (lost, count) = lost(true);
    assert!(count > 0 && lost.is_empty(), "{count} pictures, not there: {}", lost.join(", "));
    let shown: Vec<String> = pages().iter().flat_map(|(_, page)| targets(page, true)).collect();
    for scene in files("scenes", "toml") {
        let name = scene.file_stem().expect("a name").to_string_lossy();
        assert!(shown.contains(&format!("images/{name}.png")), "no page shows {name}");
    }
}

/// Links that are not on the web lead to files of the repository.
#[test]
fn links_lead_to_files() {
    let (lost, count) = lost(false);
    assert!(count > 0 && lost.is_empty(), "{count} links, not there: {}", lost.join(", "));
}

/// The page about the library shows the example as it is compiled.
#[test]
fn the_example_is_shown_whole() {
    let example = read_to_string(root().join("examples/render.rs")).expect("an example");
    let page = read_to_string(root().join("docs/guide/library.md")).expect("a page");
    assert!(page.contains(&format!("```rust\n{example}```")), "library.md: examples/render.rs has changed");
}
