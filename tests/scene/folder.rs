//! Folders of small scenes, and what is said of them.

use joton::Error;
use joton::scene::{self, Scene};
use std::path::PathBuf;

/// A folder with files that vanishes with the test.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new(files: &[(&str, &[u8])]) -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, bytes) in files {
            std::fs::write(folder.path(name), bytes).unwrap();
        }
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn load(&self, name: &str) -> Result<Scene, Error> {
        scene::load(&self.path(name))
    }
}

pub const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

pub fn load_obj(obj: impl AsRef<[u8]>) -> Result<Scene, Error> {
    Folder::new(&[("a.obj", obj.as_ref())]).load("a.obj")
}

/// A scene with one triangle of material `m`, defined by `mtl`.
pub fn with_mtl(mtl: impl AsRef<[u8]>) -> Result<Scene, Error> {
    let obj = format!("mtllib m.mtl\n{TRIANGLE}usemtl m\nf 1 2 3\n");
    Folder::new(&[("a.obj", obj.as_bytes()), ("m.mtl", mtl.as_ref())]).load("a.obj")
}

/// Asserts where an error is and which words it has.
#[track_caller]
pub fn refused(result: Result<Scene, Error>, at: &str, words: &str) {
    let error = result.expect_err(words).to_string();
    assert!(error.contains(&format!("/{at}: ")), "not at {at}: {error}");
    assert!(error.contains(words), "without \"{words}\": {error}");
}

/// Asserts that some warning is at a place and has some words.
#[track_caller]
pub fn warned(scene: &Scene, at: &str, words: &str) {
    let found = scene.warnings.iter().any(|w| w.contains(&format!("/{at}: ")) && w.contains(words));
    assert!(found, "no \"{at}: … {words}\" in {:#?}", scene.warnings);
}
