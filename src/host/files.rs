//! Input: files that are read. What is no regular file, or larger than can be meant, is refused before it is read.

use crate::error::{Error, Result};
use crate::host::memory;
use std::fs::{File, Metadata};
use std::io::Read;
use std::path::Path;

/// Bytes of a text file (scene, mesh, material library), at most: 4 GiB, a mesh of about 40 million triangles.
pub(crate) const TEXT_BYTES_MAX: u64 = 4 << 30;
/// Bytes of memory that are in use for each byte of a text while it is read, at least: those of the file, and those of the text.
const MEMORY_PER_BYTE: u64 = 2;

/// Open a file to read it: a regular file or a link to one. A device or a pipe may have no end, and opening a pipe waits for its
/// writer.
///
/// # Errors
/// [`Error::Io`] with what it is instead, or why it does not open.
pub(crate) fn open(path: &Path) -> Result<(File, Metadata)> {
    let fail = |e: std::io::Error| Error::system(path, "read", &e);
    let meta = std::fs::metadata(path).map_err(fail)?;
    if let Some(kind) = other_kind(&meta) {
        return Err(Error::io(path, "read", format!("it is a {kind}; name a file")));
    }
    let file = File::open(path).map_err(fail)?;
    Ok((file, meta))
}

/// What it is, where it is no regular file.
pub(crate) fn other_kind(meta: &Metadata) -> Option<&'static str> {
    match () {
        () if meta.is_file() => None,
        () if meta.is_dir() => Some("directory"),
        () => Some("device or pipe"),
    }
}

/// Read a text file whole, at most [`TEXT_BYTES_MAX`] bytes.
///
/// # Errors
/// [`Error::Io`] where it is no regular file, too large, or more than the memory that is left.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, TEXT_BYTES_MAX, memory::allowed())
}

/// Read a file whole, however long it is.
///
/// # Errors
/// [`Error::Io`] where it is no regular file, or more than the memory that is left.
pub(crate) fn read_of_any_length(path: &Path) -> Result<Vec<u8>> {
    read_at_most(path, u64::MAX - 1, memory::available())
}

/// Refuse to read what takes more memory than is left.
///
/// # Errors
/// [`Error::Io`] with need and limit.
pub(crate) fn check_memory(path: &Path, need: u64) -> Result<()> {
    check_left(path, need, memory::allowed())
}

fn check_left(path: &Path, need: u64, left: Option<u64>) -> Result<()> {
    match left {
        Some(left) if need > left => {
            let what = format!(
                "that takes {need} bytes of memory, {left} are left; split it, free some or allow more (--memory)"
            );
            Err(Error::io(path, "read", what))
        }
        _ => Ok(()),
    }
}

fn read_at_most(path: &Path, most: u64, left: Option<u64>) -> Result<Vec<u8>> {
    let (file, meta) = open(path)?;
    read_from(file, path, meta.len(), most, left)
}

/// Likewise from a reader of a file that says it has `length` bytes.
fn read_from(file: impl Read, path: &Path, length: u64, most: u64, left: Option<u64>) -> Result<Vec<u8>> {
    let fail = |what: String| Err(Error::io(path, "read", what));
    if length > most {
        return fail(format!("it has {length} bytes, {most} is the most that is read; split it"));
    }
    check_left(path, length.saturating_mul(MEMORY_PER_BYTE), left)?;
    let mut bytes = Vec::new();
    if bytes.try_reserve_exact(length as usize).is_err() {
        return fail(format!("there is no memory for its {length} bytes; split it or free some"));
    }
    // files of some systems are longer than they say, and files grow
    file.take(most + 1).read_to_end(&mut bytes).map_err(|e| Error::system(path, "read", &e))?;
    let found = bytes.len() as u64;
    if found > most {
        return fail(format!("it has more than {most} bytes, the most that is read; split it"));
    }
    if found < length {
        let what = format!("it had {length} bytes and ends after {found}");
        return fail(format!("{what}; wait until no other program writes it"));
    }
    Ok(bytes)
}

/// Reads a few bytes at a time and is interrupted every other time, as the system may do.
#[cfg(test)]
pub(crate) struct Stuttering<R> {
    pub(crate) reader: R,
    pub(crate) reads: usize,
}

#[cfg(test)]
impl<R: Read> Read for Stuttering<R> {
    fn read(&mut self, into: &mut [u8]) -> std::io::Result<usize> {
        self.reads += 1;
        if self.reads % 2 == 1 {
            return Err(std::io::ErrorKind::Interrupted.into());
        }
        let few = into.len().min(1 + self.reads % 7);
        self.reader.read(&mut into[..few])
    }
}

#[cfg(test)]
impl<R: std::io::Seek> std::io::Seek for Stuttering<R> {
    fn seek(&mut self, to: std::io::SeekFrom) -> std::io::Result<u64> {
        self.reader.seek(to)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A file of as many bytes as are allowed is read; one byte more, or more than the memory holds, is refused with both numbers.
    #[test]
    fn limits_are_kept() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("text");
        std::fs::write(&path, [7; 10]).expect("written");
        assert_eq!(read_at_most(&path, 10, Some(20)).expect("read"), [7; 10]);
        assert_eq!(read_at_most(&path, 10, None).expect("read"), [7; 10]);
        for (most, left, parts) in [(9, None, ["10 bytes", "9 is the most"]), (10, Some(19), ["20", "19"])] {
            let e = read_at_most(&path, most, left).expect_err("refused").to_string();
            assert!(parts.iter().all(|part| e.contains(part)), "{e}");
        }
    }

    /// A system that gives a few bytes at a time, and is interrupted, gives all of them; a file that becomes shorter while it is read, at
    /// whatever length, is refused, and so is one that cannot be read on.
    #[test]
    fn short_reads_are_gone_on_with_and_short_files_refused() {
        let bytes: Vec<u8> = (0..200).collect();
        let path = Path::new("mesh.obj");
        let read = |reader: &mut dyn Read| read_from(reader, path, 200, 1000, None);
        let stuttering = |length: usize| Stuttering { reader: &bytes[..length], reads: 0 };
        assert_eq!(read(&mut stuttering(200)).expect("read"), bytes);
        for length in 0..200 {
            let e = read(&mut stuttering(length)).expect_err("refused").to_string();
            let parts = ["mesh.obj: cannot read", "200 bytes", &format!("after {length};"), "wait"];
            assert!(parts.iter().all(|part| e.contains(part)), "{e}");
        }
        struct Broken;
        impl Read for Broken {
            fn read(&mut self, _: &mut [u8]) -> std::io::Result<usize> {
                Err(std::io::ErrorKind::PermissionDenied.into())
            }
        }
        let e = read(&mut (&bytes[..100]).chain(Broken)).expect_err("refused").to_string();
        assert!(e.contains("mesh.obj: cannot read") && e.contains("change its permissions"), "{e}");
    }

    /// A file that says it is empty, as those of /proc do, is read to its end, and refused where that is too far.
    #[cfg(target_os = "linux")]
    #[test]
    fn files_longer_than_they_say_are_read_to_the_limit() {
        let path = Path::new("/proc/self/status");
        assert_eq!(std::fs::metadata(path).expect("a file").len(), 0);
        assert!(read_at_most(path, TEXT_BYTES_MAX, None).expect("read").len() > 100);
        let e = read_at_most(path, 100, None).expect_err("refused").to_string();
        assert!(e.contains("more than 100 bytes"), "{e}");
    }
}
