//! What leaves the renderer: image files, the display transform, and comparisons with a reference.

pub mod checkpoint;
pub mod compare;
pub mod display;
pub mod export;
pub mod exr;
pub mod png;
pub mod report;

mod atomic;
mod disc;
#[cfg(test)]
mod fault_tests;
mod heatmap;
mod names;
mod scratch;

pub use atomic::check_writable;
pub use names::{check_not_read, resolve};
pub use scratch::discard_unfinished;

/// Write a text file, whole or not at all.
///
/// # Errors
/// [`crate::Error::Io`] where it cannot be written.
pub fn write_text(path: &std::path::Path, text: &str) -> crate::Result<()> {
    atomic::write_atomically(path, |sink| sink.write_all(text.as_bytes()).map_err(|e| e.to_string()))
}

/// A file of a set: where it goes, and what makes its bytes.
pub type Part<'a> = (std::path::PathBuf, Box<dyn FnOnce() -> Vec<u8> + 'a>);

/// Write several files: all are replaced, or none is.
///
/// # Errors
/// [`crate::Error::Io`] with the first that cannot be written.
pub fn write_set(parts: Vec<Part<'_>>) -> crate::Result<()> {
    let mut files: Vec<(std::path::PathBuf, atomic::Encode<'_>)> = Vec::new();
    for (path, bytes) in parts {
        files.push((path, Box::new(move |sink| sink.write_all(&bytes()).map_err(|e| e.to_string()))));
    }
    atomic::write_all_atomically(files)
}
