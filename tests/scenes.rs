//! Claims about the scenes of the repository.

use glam::DVec3;
use joton::scene::{self, Scene};
use std::path::{Path, PathBuf};

#[allow(dead_code, unreachable_pub, reason = "its main is not called here")]
#[path = "../examples/make_scenes.rs"]
mod make_scenes;

fn directory() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes")
}

fn load(name: &str) -> Scene {
    scene::load(&directory().join(name).with_extension("toml")).unwrap()
}

/// The committed files are what `examples/make_scenes.rs` makes, and small; a stray file would be noticed too.
#[test]
fn committed_scenes_are_generated() {
    let files = make_scenes::files();
    assert!(files.iter().map(|(_, text)| text.len()).sum::<usize>() < 2_000_000);
    for (name, text) in &files {
        let committed = std::fs::read_to_string(directory().join(name)).unwrap();
        assert!(committed == *text, "scenes/{name} differs: cargo run --example make_scenes");
    }
    let by_hand = ["README.md", "hello.toml", "prism.toml"];
    let is_made = |e: &std::fs::DirEntry| !by_hand.iter().any(|name| e.file_name() == *name);
    let entries = std::fs::read_dir(directory()).unwrap().flatten().filter(is_made);
    assert_eq!(entries.count(), files.len());
}

/// The README shows the first scene as it is.
#[test]
fn the_readme_shows_the_first_scene() {
    let readme = std::fs::read_to_string(directory().join("../README.md")).unwrap();
    let scene = std::fs::read_to_string(directory().join("hello.toml")).unwrap();
    assert!(readme.contains(&format!("```toml\n{scene}```\n")), "README.md shows another scenes/hello.toml");
}

/// The scenes load without a warning and stay within their promised sizes.
#[test]
fn committed_scenes_are_sound() {
    for (name, most_triangles) in [
        ("cornell", 100),
        ("spheres", 2 * 5120 + 100),
        ("pool", 5000),
        ("furnace", 12),
        ("ring", 5000),
        ("rooms", 1000),
        ("pedestal", 2000),
        ("hello", 2 * 20480 + 200),
        ("prism", 12 + 4 + 132),
    ] {
        let scene = load(name);
        assert_eq!(scene.warnings, Vec::<String>::new(), "{name}");
        assert!(scene.mesh.triangles.len() <= most_triangles, "{name}: {}", scene.mesh.triangles.len());
    }
}

/// Lights shine into the scene, and balls face outward.
#[test]
fn committed_scenes_face_the_right_way() {
    for name in ["cornell", "spheres", "pool", "ring"] {
        let scene = load(name);
        let centre = |material: &str| match (name, material) {
            ("spheres", "glass") => Some(DVec3::new(0.165, 0.1, 0.2)),
            ("spheres", "mirror") => Some(DVec3::new(0.385, 0.0901, 0.37)),
            _ => None,
        };
        let mut lights = 0;
        for t in &scene.mesh.triangles {
            let [a, b, c] = t.vertex.map(|v| scene.mesh.positions[v as usize]);
            let normal = (b - a).cross(c - a).normalize();
            let material = &scene.materials[t.material as usize];
            if material.name == "light" {
                lights += 1;
                let inward = if name == "ring" { -a.normalize() } else { DVec3::NEG_Y };
                assert!(normal.dot(inward) > 0.9, "{name}: light faces {normal}");
            } else if let Some(centre) = centre(&material.name) {
                assert!(normal.dot(a - centre) > 0.0, "{name}: {} faces inward", material.name);
            } else if material.name == "water" {
                assert!(normal.y > 0.9, "{name}: water faces {normal}");
            }
        }
        assert_eq!(lights, 2, "{name}: triangles of the light");
    }
}
