//! Files that are there whole or not at all: written beside their target, then renamed over it.

use crate::error::{Error, Result, words};
use std::ffi::OsString;
use std::fs::{self, File, OpenOptions};
use std::io::{BufWriter, Cursor, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};

/// What a format's encoder writes to.
pub(super) trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// Let `encode` write a file at `path`. Whatever fails, what was at `path` before stays as it was.
///
/// A link is followed and its target replaced; what is no regular file (a device, a pipe) is written in place, in
/// one piece, once all of it is encoded.
pub(super) fn write_atomically(
    path: &Path,
    encode: impl FnOnce(&mut dyn Sink) -> Result<(), String>,
) -> Result<()> {
    let fail = |what: String| Error::io(path, "write", what);
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => return Err(fail("it is a folder; name a file".into())),
        Ok(meta) if !meta.is_file() => {
            let mut bytes = Cursor::new(Vec::new());
            encode(&mut bytes).map_err(fail)?;
            let mut device = OpenOptions::new().write(true).open(path).map_err(|e| fail(words(&e)))?;
            return device.write_all(bytes.get_ref()).map_err(|e| fail(words(&e)));
        }
        _ => {}
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    let (scratch, file) = Scratch::beside(&target).map_err(|e| fail(words(&e)))?;
    let mut buffered = BufWriter::new(file);
    encode(&mut buffered).map_err(fail)?;
    let file = buffered.into_inner().map_err(|e| fail(words(e.error())))?;
    // On the disc before the name points to it: a crash leaves the old file or the new one, whole.
    file.sync_all().map_err(|e| fail(words(&e)))?;
    drop(file);
    scratch.rename(&target).map_err(|e| fail(words(&e)))
}

/// Find out, before the work that fills it, whether a file can be written; nothing is changed.
///
/// # Errors
/// [`Error::Io`] with what stands in the way.
pub fn check_writable(path: &Path) -> Result<()> {
    let fail = |what: String| Error::io(path, "write", what);
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => return Err(fail("it is a folder; name a file".into())),
        Ok(meta) if !meta.is_file() => return Ok(()),
        _ => {}
    }
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(fail(format!("the folder {} does not exist; create it first", folder.display())));
    }
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_owned());
    Scratch::beside(&target).map(drop).map_err(|e| fail(words(&e)))
}

/// A file that is removed unless it is renamed.
struct Scratch(Option<PathBuf>);

impl Scratch {
    /// A new file in the folder of `target`: renaming works only within one file system.
    fn beside(target: &Path) -> std::io::Result<(Self, File)> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let mut name = OsString::from(".");
        name.push(target.file_name().ok_or_else(|| std::io::Error::other("it names no file"))?);
        name.push(format!(".{}-{}.part", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
        let path = target.with_file_name(name);
        let file = OpenOptions::new().write(true).create_new(true).open(&path)?;
        Ok((Self(Some(path)), file))
    }

    fn rename(mut self, target: &Path) -> std::io::Result<()> {
        let path = self.0.as_ref().expect("renamed once");
        fs::rename(path, target)?;
        self.0 = None;
        Ok(())
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        if let Some(path) = &self.0 {
            // Nothing better can be done where even removing fails.
            let _ = fs::remove_file(path);
        }
    }
}
