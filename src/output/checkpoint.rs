//! Checkpoint: all that a render needs to go on, in a file.
//!
//! ```text
//! joton checkpoint 3\n       what it is, and the version of this layout
//! { … }\n                    a header of the program's, JSON in one line
//! …                          a RenderState, by postcard
//! 8 bytes                    FNV-1a of everything before, little endian
//! ```
//!
//! It is written whole or not at all. What is not whole, or changed since, is refused.

use super::atomic;
use crate::error::{Error, Result};
use crate::host::files;
use crate::render::RenderState;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::hash::Hasher;
use std::io::{self, BufRead, Read, Write};
use std::path::Path;

/// First line.
const MAGIC: &str = "joton checkpoint 3\n";
/// Bytes that are read at a time.
const CHUNK: usize = 1 << 16;
/// Bytes of the first two lines, at most: what is no checkpoint may have no lines.
const HEADER_MAX: u64 = 1 << 24;

/// Write a state and a header.
///
/// # Errors
/// [`Error::Io`] where it cannot be written; what was at `path` before stays then.
pub fn write(path: &Path, header: &impl Serialize, state: &RenderState) -> Result<()> {
    atomic::write_atomically(path, |sink| {
        let sink = io::BufWriter::with_capacity(CHUNK, sink);
        let mut hashed = Hashed { sink, hash: Fnv::default() };
        let written = (|| -> Result<(), Box<dyn std::error::Error>> {
            hashed.write_all(MAGIC.as_bytes())?;
            hashed.write_all(serde_json::to_string(header)?.as_bytes())?;
            hashed.write_all(b"\n")?;
            postcard::to_io(state, &mut hashed)?;
            let hash = hashed.hash.finish().to_le_bytes();
            hashed.sink.write_all(&hash)?;
            Ok(hashed.sink.flush()?)
        })();
        written.map_err(|e| e.to_string())
    })
}

/// An error of what was read.
fn fault(path: &Path, what: &str) -> Error {
    Error::usage(format!("{}: {what}", path.display()), "name a file that joton render --checkpoint wrote")
}

/// What stands in the first line of another file.
const NO_CHECKPOINT: &str = "is no checkpoint of this version of joton";
/// What of another joton cannot be read.
const OTHER_VERSION: &str = "is of another version of joton";

/// Read a header alone. Whether the state behind it is whole is not looked at.
///
/// # Errors
/// As for [`read`].
pub fn read_header<H: DeserializeOwned>(path: &Path) -> Result<H> {
    let fail = |e: io::Error| Error::system(path, "read", &e);
    let (file, _) = files::open(path)?;
    let mut file = io::BufReader::new(file.take(HEADER_MAX));
    let mut magic = vec![0; MAGIC.len()];
    let is_whole = match file.read_exact(&mut magic) {
        Err(e) if e.kind() == io::ErrorKind::UnexpectedEof => false,
        read => read.map(|()| magic == MAGIC.as_bytes()).map_err(fail)?,
    };
    if !is_whole {
        return Err(fault(path, NO_CHECKPOINT));
    }
    let mut line = Vec::new();
    file.read_until(b'\n', &mut line).map_err(fail)?;
    serde_json::from_slice(&line).map_err(|_| fault(path, OTHER_VERSION))
}

/// Read a header and a state.
///
/// # Errors
/// [`Error::Io`] where it cannot be read, [`Error::Usage`] where it is no checkpoint, is damaged, or is of another version.
pub fn read<H: DeserializeOwned>(path: &Path) -> Result<(H, RenderState)> {
    let bytes = files::read_of_any_length(path)?;
    let rest = bytes.strip_prefix(MAGIC.as_bytes()).ok_or_else(|| fault(path, NO_CHECKPOINT))?;
    let damaged = || fault(path, "is damaged");
    let (_, hash) = bytes.split_last_chunk::<8>().ok_or_else(damaged)?;
    let (body, _) = rest.split_last_chunk::<8>().ok_or_else(damaged)?;
    let mut found = Fnv::default();
    found.write(&bytes[..bytes.len() - hash.len()]);
    if found.finish().to_le_bytes() != *hash {
        return Err(damaged());
    }
    let end = body.iter().position(|b| *b == b'\n').ok_or_else(damaged)?;
    let other = || fault(path, OTHER_VERSION);
    let header = serde_json::from_slice(&body[..end]).map_err(|_| other())?;
    let (state, rest) = postcard::take_from_bytes::<RenderState>(&body[end + 1..]).map_err(|_| other())?;
    if !rest.is_empty() || !state.is_sound() {
        return Err(damaged());
    }
    Ok((header, state))
}

/// A number that tells whether a file is the same as before, as 16 digits.
///
/// # Errors
/// [`Error::Io`] where it cannot be read.
pub fn fingerprint(path: &Path) -> Result<String> {
    let (file, _) = files::open(path)?;
    fingerprint_of(file).map_err(|e| Error::system(path, "read", &e))
}

fn fingerprint_of(file: impl Read) -> io::Result<String> {
    let mut hashed = Hashed { sink: io::sink(), hash: Fnv::default() };
    io::copy(&mut io::BufReader::with_capacity(CHUNK, file), &mut hashed)?;
    Ok(format!("{:016x}", hashed.hash.finish()))
}

/// FNV-1a, 64 bits: the same in every version of Rust.
struct Fnv(u64);

impl Default for Fnv {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hasher for Fnv {
    fn write(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x100_0000_01b3);
        }
    }

    fn finish(&self) -> u64 {
        self.0
    }
}

/// Hashes what passes through.
struct Hashed<W> {
    sink: W,
    hash: Fnv,
}

impl<W: Write> Write for Hashed<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.sink.write(bytes)?;
        self.hash.write(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Published values of FNV-1a.
    #[test]
    fn hashes_are_those_of_the_paper() {
        for (text, hash) in
            [("", 0xcbf2_9ce4_8422_2325), ("a", 0xaf63_dc4c_8601_ec8c), ("foobar", 0x8594_4171_f739_67e8)]
        {
            let mut fnv = Fnv::default();
            fnv.write(text.as_bytes());
            assert_eq!(fnv.finish(), hash, "{text}");
        }
    }

    /// Who is interrupted while a file is read finds the same number.
    #[test]
    fn fingerprints_outlast_interruptions() {
        let reader = files::Stuttering { reader: &b"foobar"[..], reads: 0 };
        assert_eq!(fingerprint_of(reader).expect("read"), "85944171f73967e8");
    }

    /// What is written comes back; a file that is cut, or has one byte changed, is refused, wherever that is.
    #[test]
    fn damage_is_found() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.joton");
        write(&path, &"header", &RenderState::new([3, 2])).expect("written");
        let (header, state) = read::<String>(&path).expect("read");
        assert_eq!((header.as_str(), state.size(), state.passes()), ("header", [3, 2], 0));
        let whole = std::fs::read(&path).expect("bytes");
        for i in 0..whole.len() {
            std::fs::write(&path, &whole[..i]).expect("written");
            assert!(read::<String>(&path).is_err(), "{i} bytes of it");
            let mut changed = whole.clone();
            changed[i] ^= 1;
            std::fs::write(&path, &changed).expect("written");
            assert!(read::<String>(&path).is_err(), "byte {i}");
        }
    }
}
