//! A folder with scenes, runs of the program there, and what they leave behind.

use joton::film::Image;
use joton::output::exr as exr_file;
use serde_json::Value;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// After this a program that should have ended counts as hung.
const HUNG: Duration = Duration::from_secs(60);

/// A folder with some scenes in it, and the program to run there.
pub struct Folder(TempDir);

impl Folder {
    /// Without anything in it.
    pub fn empty() -> Self {
        Self(tempfile::tempdir().expect("a folder"))
    }

    pub fn new() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
        for scene in ["cornell", "ring", "spheres"] {
            for kind in ["toml", "obj", "mtl"] {
                let file = format!("{scene}.{kind}");
                fs::copy(scenes.join(&file), folder.path().join(&file)).expect("a copy of the scene");
            }
        }
        Self(folder)
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_joton"));
        command.args(words.split_whitespace()).current_dir(self.0.path()).stdin(Stdio::null());
        // without one, Vulkan loaders complain on stderr
        command.env("XDG_RUNTIME_DIR", self.0.path());
        command
    }

    pub fn run(&self, words: &str) -> Ended {
        Ended::of(self.command(words).output().expect("joton runs"))
    }

    /// A run on a machine without any Vulkan driver.
    pub fn run_without_vulkan(&self, words: &str) -> Ended {
        let mut command = self.command(words);
        command.env("VK_DRIVER_FILES", "/nonexistent").env("VK_ICD_FILENAMES", "/nonexistent");
        Ended::of(command.output().expect("joton runs"))
    }

    /// A run that must succeed.
    pub fn done(&self, words: &str) -> Ended {
        let ended = self.run(words);
        assert_eq!(ended.code, Some(0), "joton {words}: {}", ended.stderr);
        ended
    }

    /// A run that must fail with status 2, nothing on stdout and one line on stderr that holds all of `parts`.
    pub fn fails(&self, words: &str, parts: &[&str]) {
        self.run(words).is_refusal(words, parts);
    }

    /// A run that must end.
    pub fn ends(&self, words: &str) -> Ended {
        let pipes = || Stdio::piped();
        let mut child = self.command(words).stdout(pipes()).stderr(pipes()).spawn().expect("joton runs");
        let begin = Instant::now();
        while child.try_wait().expect("a status").is_none() {
            if begin.elapsed() > HUNG {
                child.kill().expect("killed");
                panic!("joton {words} does not end");
            }
            std::thread::sleep(Duration::from_millis(5));
        }
        Ended::of(child.wait_with_output().expect("its words"))
    }

    /// Like [`Folder::fails`], of what might wait for ever.
    pub fn fails_in_time(&self, words: &str, parts: &[&str]) {
        self.ends(words).is_refusal(words, parts);
    }

    /// Run `render` and, once it has left the checkpoint, `joton resume` of it; kill each run, but the one that comes to its end first. Each lives a
    /// little longer than the ones before, so that a slow machine comes to the end, too. How many were killed: at least one.
    #[cfg(unix)]
    pub fn done_though_killed(&self, render: &str, checkpoint: &str) -> usize {
        let mut kills = 0;
        for i in 0..200 {
            let is_begun = self.path(checkpoint).exists();
            let words = if is_begun { format!("resume {checkpoint}") } else { render.into() };
            let mut child = self.command(&words).stderr(Stdio::null()).spawn().expect("joton runs");
            std::thread::sleep(Duration::from_millis(150 + 37 * (i % 7) + 10 * i));
            if let Some(ended) = child.try_wait().expect("its state") {
                assert_eq!(ended.code(), Some(0), "{words}");
                break;
            }
            child.kill().expect("it is killed");
            child.wait().expect("it ends");
            kills += 1;
        }
        assert!(kills > 0, "it was never killed");
        kills
    }

    pub fn image(&self, name: &str) -> Image {
        exr_file::read_image(&self.path(name)).expect("a readable EXR")
    }

    pub fn report(&self, name: &str) -> Value {
        serde_json::from_slice(&fs::read(self.path(name)).expect("a report")).expect("a report in JSON")
    }
}

/// What a run left behind.
pub struct Ended {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    pub fn of(output: Output) -> Self {
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("messages in UTF-8");
        Self { code: output.status.code(), stdout: text(output.stdout), stderr: text(output.stderr) }
    }

    pub fn is_refusal(&self, words: &str, parts: &[&str]) {
        assert_eq!(self.code, Some(2), "joton {words}: {}", self.stderr);
        assert_eq!(self.stdout, "", "joton {words} prints nothing to stdout");
        assert_eq!(self.stderr.lines().count(), 1, "joton {words}: one line, not\n{}", self.stderr);
        assert!(self.stderr.starts_with("joton: "), "{}", self.stderr);
        for part in parts {
            assert!(self.stderr.contains(part), "joton {words}: {:?} does not say {part:?}", self.stderr);
        }
    }
}

/// The devices that are tested.
pub fn devices() -> Vec<&'static str> {
    if without_gpu() { vec!["cpu"] } else { vec!["cpu", "gpu"] }
}

/// Whether tests of GPUs are left out, as was asked.
pub fn without_gpu() -> bool {
    std::env::var("JOTON_TEST_NO_GPU").is_ok_and(|v| v == "1")
}

/// Bits of a picture.
pub fn bits(folder: &Folder, name: &str) -> Vec<u32> {
    folder.image(name).pixels.iter().flatten().map(|x| x.to_bits()).collect()
}

/// The fastest render there is.
pub const QUICK: &str = "render cornell.toml --size 32x32 --device cpu";

pub fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

pub fn names(folder: &Folder) -> Vec<String> {
    let entries = fs::read_dir(folder.0.path()).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().into_string().expect("a name")).collect();
    names.sort();
    names
}
