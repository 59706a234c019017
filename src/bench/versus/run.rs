//! Run: start a driver, read its lines, and take its pictures in.

use super::{Line, Renderer, SHARED};
use crate::bench::ladder::{Ladder, PictureRun};
use crate::bench::{Row, Subject, Summary};
use crate::error::{Error, Result};
use crate::film::Image;
use crate::output;
use crate::spectrum::BANDS;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, ChildStdout, Command, Stdio};
use std::thread::JoinHandle;

/// Bytes of a band of a pixel.
const BAND_BYTES: usize = size_of::<f32>();

/// An exported scene, and a folder of its own for drivers and pictures.
#[derive(Debug, Clone, Copy)]
pub struct PeerScene<'a> {
    /// Mitsuba XML.
    pub file: &'a Path,
    /// Longest side of the bounding box, world units.
    pub extent: f64,
    /// A folder that may be written.
    pub folder: &'a Path,
}

/// Find out what the renderer is, and whether it is installed for this Python: its name and version, and a note.
///
/// # Errors
/// [`Error::Device`] with what to install.
pub fn check(renderer: &Renderer, python: &Path, folder: &Path) -> Result<(String, String)> {
    let mut driver = Driver::start(renderer, python, folder, None)?;
    driver.introduction()
}

/// Let another renderer measure a subject with one of its algorithms, as [`crate::bench::measure`] does, but the steps
/// of the ladder are processor seconds. `see` is shown each row and returns false to stop; `stopped` tells whether to
/// stop without one.
///
/// # Errors
/// What the driver reports, or that it reports nothing.
pub fn measure(
    subject: &Subject<'_>,
    renderer: &Renderer,
    mode: &str,
    python: &Path,
    scene: PeerScene<'_>,
    mut see: impl FnMut(&Row) -> bool,
    stopped: impl Fn() -> bool,
) -> Result<(Vec<Row>, Vec<Summary>)> {
    let job = serde_json::json!({
        "scene": scene.file,
        "extent": scene.extent,
        "folder": scene.folder,
        "width": subject.size[0],
        "height": subject.size[1],
        "mode": mode,
        "seeds": subject.seeds,
        "times": subject.times,
    });
    let job_file = scene.folder.join("job.json");
    output::write_text(&job_file, &job.to_string())?;
    let mut driver = Driver::start(renderer, python, scene.folder, Some(&job_file))?;
    let (name, _) = driver.introduction()?;
    let mut ladder = Ladder::new(subject);
    loop {
        match driver.line() {
            Ok(Line::Picture { seed, step, seconds, cpu_seconds, samples, file }) => {
                if step >= subject.times.len() || seed >= subject.seeds {
                    return Err(driver.broken(&format!("step {step} of seed {seed} was not asked for")));
                }
                let image = read_raw(&scene.folder.join(file), subject.size)?;
                let seen = PictureRun {
                    device_name: format!("{name}, {mode}"),
                    seed,
                    seconds,
                    cpu_seconds,
                    passes: samples,
                    rays: None,
                    jotons: None,
                    device_bytes: None,
                    error_estimate: None,
                };
                if !see(ladder.add(step, seen, &image)?) {
                    break;
                }
            }
            Ok(Line::Done) => break,
            Ok(other) => return Err(driver.broken(&format!("unexpected {other:?}"))),
            // Ctrl-C ends the driver, too
            Err(_) if stopped() => break,
            Err(e) => return Err(e),
        }
    }
    Ok(ladder.finish())
}

/// A picture of a driver, which is removed.
fn read_raw(file: &Path, size: [u32; 2]) -> Result<Image> {
    let bytes = std::fs::read(file).map_err(|e| Error::system(file, "read", &e))?;
    std::fs::remove_file(file).map_err(|e| Error::system(file, "remove", &e))?;
    let mut image = Image::new(size[0], size[1]);
    let need = image.pixels.len() * BANDS * BAND_BYTES;
    if bytes.len() != need {
        return Err(Error::io(file, "read", format!("it has {} bytes instead of {need}", bytes.len())));
    }
    let (values, _) = bytes.as_chunks::<BAND_BYTES>();
    for (band, value) in image.pixels.as_flattened_mut().iter_mut().zip(values) {
        *band = f32::from_le_bytes(*value);
    }
    Ok(image)
}

/// A running driver; it ends with this value.
struct Driver<'a> {
    renderer: &'a Renderer,
    python: &'a Path,
    child: Child,
    lines: BufReader<ChildStdout>,
    /// Gives what the renderer printed, once it has ended.
    words: Option<JoinHandle<String>>,
}

impl<'a> Driver<'a> {
    /// Without a job it only introduces itself.
    fn start(renderer: &'a Renderer, python: &'a Path, folder: &Path, job: Option<&Path>) -> Result<Self> {
        for (name, text) in SHARED.into_iter().chain([renderer.driver]) {
            output::write_text(&folder.join(name), text)?;
        }
        let unusable = |what: &dyn std::fmt::Display| {
            let what = format!("{} cannot be run: {what}", python.display());
            Error::device(what, "install Python 3 or name it with --python")
        };
        let mut command = Command::new(python);
        command.arg(folder.join(renderer.driver.0)).args(job);
        command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().map_err(|e| unusable(&e))?;
        let (Some(lines), Some(mut stderr)) = (child.stdout.take(), child.stderr.take()) else {
            return Err(unusable(&"its output cannot be read"));
        };
        // read as it comes: a full pipe would stop the renderer
        let words = std::thread::spawn(move || {
            let mut bytes = Vec::new();
            stderr.read_to_end(&mut bytes).ok();
            String::from_utf8_lossy(&bytes).into_owned()
        });
        Ok(Self { renderer, python, child, lines: BufReader::new(lines), words: Some(words) })
    }

    /// The first line: what it is, and a note.
    fn introduction(&mut self) -> Result<(String, String)> {
        match self.line()? {
            Line::Renderer { name, note } => Ok((name, note)),
            other => Err(self.broken(&format!("{other:?} comes first"))),
        }
    }

    /// The next line; an error where there is none, or where the line says so.
    fn line(&mut self) -> Result<Line> {
        let mut text = String::new();
        let read = self.lines.read_line(&mut text);
        if !read.is_ok_and(|bytes| bytes > 0) {
            return Err(self.ended());
        }
        let name = self.renderer.name;
        match Line::parse(&text) {
            Ok(Line::Missing { module }) => {
                let python = self.python.display();
                Err(Error::device(
                    format!("--versus {name}: {python} has no package {module}"),
                    format!("run: {python} -m pip install {}", self.renderer.packages),
                ))
            }
            Ok(Line::Failed { what }) => {
                Err(Error::device(format!("{name}: {what}"), format!("leave {name} out of --versus")))
            }
            Ok(line) => Ok(line),
            Err(what) => Err(self.broken(&what)),
        }
    }

    /// The driver ended too early: with what it printed last.
    fn ended(&mut self) -> Error {
        let how = self.child.wait().map_or_else(|e| e.to_string(), |status| status.to_string());
        let words = self.words.take().and_then(|w| w.join().ok()).unwrap_or_default();
        let last = words.lines().rev().find(|l| !l.trim().is_empty()).unwrap_or("it said nothing").trim();
        let what = format!("{} ended before its work was done ({how}): {last}", self.renderer.name);
        Error::device(what, "name another Python with --python, or leave it out of --versus")
    }

    fn broken(&self, what: &str) -> Error {
        let what = format!("the driver of {} is not understood: {what}", self.renderer.name);
        Error::device(what, "name a Python 3 with --python")
    }
}

impl Drop for Driver<'_> {
    fn drop(&mut self) {
        // it may have ended by itself
        self.child.kill().ok();
        self.child.wait().ok();
    }
}
