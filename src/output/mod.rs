//! What leaves the renderer: image files, the display transform, and comparisons with a reference.

pub mod compare;
pub mod display;
pub mod exr;
pub mod png;

mod atomic;
mod heatmap;

pub use atomic::check_writable;

/// Write a text file, whole or not at all.
///
/// # Errors
/// [`crate::Error::Io`] where it cannot be written.
pub fn write_text(path: &std::path::Path, text: &str) -> crate::Result<()> {
    write_bytes(path, text.as_bytes())
}

/// Write a file, whole or not at all.
///
/// # Errors
/// [`crate::Error::Io`] where it cannot be written.
pub fn write_bytes(path: &std::path::Path, bytes: &[u8]) -> crate::Result<()> {
    atomic::write_atomically(path, |sink| sink.write_all(bytes).map_err(|e| e.to_string()))
}
