//! Files that are there whole or not at all: written beside their target, then renamed over it.

use super::disc::{self, Written};
use super::names::{folder_of, resolve};
use super::scratch::{Scratch, remove_stale};
use crate::error::{Error, Result, words};
use std::fs::{self, OpenOptions};
use std::io::{self, BufWriter, Cursor, ErrorKind, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

/// What a format's encoder writes to.
pub(super) trait Sink: Write + Seek {}
impl<T: Write + Seek> Sink for T {}

/// What fills a file.
pub(super) type Encode<'a> = Box<dyn FnOnce(&mut dyn Sink) -> Result<(), String> + 'a>;

/// Let `encode` write a file at `path`. Whatever fails, what was at `path` before stays as it was.
///
/// A link is followed and its target replaced; what is no regular file (a device, a pipe) is written in place, in
/// one piece, once all of it is encoded.
pub(super) fn write_atomically(
    path: &Path,
    encode: impl FnOnce(&mut dyn Sink) -> Result<(), String>,
) -> Result<()> {
    write_all_atomically(vec![(path.to_owned(), Box::new(encode))])
}

/// Likewise several files: all are replaced, or none is.
pub(super) fn write_all_atomically(files: Vec<(PathBuf, Encode<'_>)>) -> Result<()> {
    let mut whole = Vec::new();
    let mut in_place = Vec::new();
    for (path, encode) in files {
        let fail = |what: String| Error::io(&path, "write", what);
        match kind_of(&path)? {
            Kind::Device => {
                let mut bytes = Cursor::new(Vec::new());
                encode(&mut bytes).map_err(fail)?;
                in_place.push((path, bytes.into_inner()));
            }
            Kind::File => {
                let target = resolve(&path);
                whole.push((scratch(&target, encode).map_err(fail)?, target));
            }
        }
    }
    for (path, bytes) in in_place {
        let device = disc::open(&path, OpenOptions::new().write(true));
        let written = device.and_then(|mut device| device.write_all(&bytes));
        written.map_err(|e| Error::system(path, "write", &e))?;
    }
    Scratch::rename_all(&whole).map_err(|(path, e)| Error::system(path, "write", &e))
}

/// What is written to.
enum Kind {
    /// A regular file, or nothing yet.
    File,
    /// A device or a pipe.
    Device,
}

/// What a name stands for, links followed.
fn kind_of(path: &Path) -> Result<Kind> {
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Err(Error::io(path, "write", "it is a folder; name a file")),
        Ok(meta) if !meta.is_file() => Ok(Kind::Device),
        // links that go round in a circle
        Err(e) if path.is_symlink() && e.kind() != ErrorKind::NotFound => {
            Err(Error::system(path, "write", &e))
        }
        _ => Ok(Kind::File),
    }
}

/// A file beside `target`, filled and on the disc before a name points to it: a crash leaves the old file or the new one,
/// whole.
fn scratch(target: &Path, encode: Encode<'_>) -> Result<Scratch, String> {
    let (scratch, file) = Scratch::beside(target).map_err(|e| words(&e))?;
    let mut watched = Watched { sink: BufWriter::new(file), failed: None };
    let encoded = encode(&mut watched);
    // what the system said, and not what the encoder made of it
    match watched.failed {
        Some(what) => return Err(what),
        None => encoded?,
    }
    let file = watched.sink.into_inner().map_err(|e| words(e.error()))?;
    file.sync().map_err(|e| words(&e))?;
    Ok(scratch)
}

/// A file that keeps what the system said when it first failed: encoders have words of their own for that, or none.
struct Watched {
    sink: BufWriter<Written>,
    failed: Option<String>,
}

impl Watched {
    fn keep<T>(&mut self, done: io::Result<T>) -> io::Result<T> {
        done.inspect_err(|e| {
            // who is interrupted asks again
            if e.kind() != ErrorKind::Interrupted {
                self.failed.get_or_insert_with(|| words(e));
            }
        })
    }
}

impl Write for Watched {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let done = self.sink.write(bytes);
        self.keep(done)
    }

    fn flush(&mut self) -> io::Result<()> {
        let done = self.sink.flush();
        self.keep(done)
    }
}

impl Seek for Watched {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let done = self.sink.seek(to);
        self.keep(done)
    }
}

/// Find out, before the work that fills it, whether a file can be written; nothing is changed, but for what killed processes
/// left half written in its folder.
///
/// # Errors
/// [`Error::Io`] with what stands in the way.
pub fn check_writable(path: &Path) -> Result<()> {
    let fail = |what: String| Error::io(path, "write", what);
    if let Kind::Device = kind_of(path)? {
        return Ok(());
    }
    let target = resolve(path);
    let folder = folder_of(&target);
    if !folder.is_dir() {
        return Err(fail(format!("the folder {} does not exist; create it first", folder.display())));
    }
    let (_scratch, file) = Scratch::beside(&target).map_err(|e| fail(words(&e)))?;
    if let Ok(own) = file.file().metadata() {
        remove_stale(folder, &own);
    }
    Ok(())
}
