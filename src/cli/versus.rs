//! `joton bench --versus`: the other renderers of a bench, and the scenes as they read them.

use super::tell;
use joton::bench::versus::{self, Choice, PeerScene, Traits};
use joton::bench::{Row, Subject, Summary};
use joton::output::export::{Exported, Fidelity, write_mitsuba};
use joton::scene::Scene;
use joton::{Error, Result};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// The Python that runs the drivers, where none is named.
const PYTHON: &str = "python3";

/// The other renderers, installed and ready.
pub(super) struct Versus {
    choices: Vec<Choice>,
    python: PathBuf,
    /// Exported scenes, drivers and pictures; gone with this value.
    folder: TempDir,
}

/// A scene as others read it.
pub(super) struct Peer {
    file: PathBuf,
    exported: Exported,
}

impl Versus {
    /// Read the words of `--versus` and look for each renderer; none without words.
    pub(super) fn open(words: &[String], python: Option<&Path>) -> Result<Option<Self>> {
        if words.is_empty() {
            return Ok(None);
        }
        let mut choices: Vec<Choice> = Vec::new();
        for word in words {
            let choice = Choice::parse(word)?;
            if !choices.contains(&choice) {
                choices.push(choice);
            }
        }
        let folder = tempfile::Builder::new().prefix("joton-versus-").tempdir();
        let folder = folder.map_err(|e| Error::system(std::env::temp_dir(), "create a folder in", &e))?;
        let python = python.map_or(PYTHON.into(), Path::to_owned);
        let mut told: Vec<&str> = Vec::new();
        for choice in &choices {
            if told.contains(&choice.renderer.name) {
                continue;
            }
            told.push(choice.renderer.name);
            let (name, note) = versus::check(choice.renderer, &python, folder.path())?;
            let note = if note.is_empty() { note } else { format!(": {note}") };
            tell(format_args!("joton: {name}{note}"));
        }
        Ok(Some(Self { choices, python, folder }))
    }

    /// Export a scene; `index` tells scenes apart.
    pub(super) fn export(&self, scene: &Scene, source: &Path, index: usize) -> Result<Peer> {
        let file = self.folder.path().join(format!("scene{index}.xml"));
        if scene.wavelengths.are_rendered {
            let what = "other renderers are driven in red, green and blue, and the scene is by wavelength";
            return Err(Error::scene(source, None, what, "compare red, green and blue: --spectral off"));
        }
        let exported = write_mitsuba(scene, source, &file, Fidelity::Exact)?;
        // whatever is asked for in vain is told before anything renders
        self.devices(source, &exported)?;
        Ok(Peer { file, exported })
    }

    /// Renderers and their algorithms for a scene.
    fn devices(&self, scene: &Path, exported: &Exported) -> Result<Vec<(Choice, &'static str)>> {
        let name = scene.display().to_string();
        let traits = Traits { specular: exported.specular, spots: exported.spots };
        let mut all: Vec<(Choice, &'static str)> = Vec::new();
        for choice in &self.choices {
            for mode in choice.modes(&name, traits)? {
                if !all.iter().any(|(c, m)| c.renderer == choice.renderer && *m == mode) {
                    all.push((*choice, mode));
                }
            }
        }
        Ok(all)
    }

    /// Measure a scene with each; `collect` takes what was found.
    pub(super) fn measure(
        &self,
        subject: &Subject<'_>,
        peer: &Peer,
        mut see: impl FnMut(&Row) -> bool,
        stopped: impl Fn() -> bool,
        mut collect: impl FnMut((Vec<Row>, Vec<Summary>)),
    ) -> Result<()> {
        let scene = PeerScene { file: &peer.file, extent: peer.exported.extent, folder: self.folder.path() };
        for (choice, mode) in self.devices(Path::new(subject.scene), &peer.exported)? {
            let device = format!("{}-{mode}", choice.renderer.name);
            let subject = Subject { device: &device, ..*subject };
            let found =
                versus::measure(&subject, choice.renderer, mode, &self.python, scene, &mut see, &stopped)?;
            collect(found);
            if stopped() {
                break;
            }
        }
        Ok(())
    }
}
