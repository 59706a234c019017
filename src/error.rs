//! The errors of the library: each tells what, where and what to do, in one line.

use std::path::PathBuf;

/// Result of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong, as one line for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene, mesh or material file cannot be used.
    #[error("{}{}: {what}; {remedy}", file.display(), line.map_or(String::new(), |l| format!(":{l}")))]
    Scene {
        /// The file at fault.
        file: PathBuf,
        /// Line in that file, from 1, where it is known.
        line: Option<usize>,
        /// What is wrong.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// A file could not be read or written.
    #[error("{}: cannot {action}: {what}", file.display())]
    Io {
        /// The file at fault.
        file: PathBuf,
        /// The verb: read, write, create.
        action: &'static str,
        /// The system's or the format's own words.
        what: String,
    },
    /// The command line asks for something that cannot be.
    #[error("{what}; {remedy}")]
    Usage {
        /// What is wrong.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// The device is missing or failed.
    #[error("{what}; {remedy}")]
    Device {
        /// What happened.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// A buffer would have to be larger than the device allows.
    #[error("{buffer} needs {need} bytes, the limit is {limit}; {remedy}")]
    Capacity {
        /// Name of the buffer.
        buffer: &'static str,
        /// Bytes needed.
        need: u64,
        /// Bytes allowed.
        limit: u64,
        /// What to do.
        remedy: String,
    },
    /// The machine has too little memory free.
    #[error(
        "the render needs {need} bytes of memory, {free} are free; close other programs, allow the device less (--memory) or render a smaller image (--size)"
    )]
    Memory {
        /// Bytes needed.
        need: u64,
        /// Bytes free.
        free: u64,
    },
}

impl Error {
    /// A scene error at a line of a file.
    pub fn scene(
        file: impl Into<PathBuf>,
        line: Option<usize>,
        what: impl Into<String>,
        remedy: impl Into<String>,
    ) -> Self {
        Self::Scene { file: file.into(), line, what: what.into(), remedy: remedy.into() }
    }

    /// A wrong argument.
    pub fn usage(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Usage { what: what.into(), remedy: remedy.into() }
    }

    /// A missing or failing device.
    pub fn device(what: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self::Device { what: what.into(), remedy: remedy.into() }
    }

    /// A file that the system does not let us read or write: its words, and what to do.
    pub fn system(file: impl Into<PathBuf>, action: &'static str, e: &std::io::Error) -> Self {
        Self::io(file, action, words(e))
    }

    /// A file that could not be read or written.
    pub fn io(file: impl Into<PathBuf>, action: &'static str, what: impl ToString) -> Self {
        Self::Io { file: file.into(), action, what: what.to_string() }
    }
}

/// The system's words for an error and what to do about it, where that is known.
pub(crate) fn words(e: &std::io::Error) -> String {
    use std::io::ErrorKind as K;
    let remedy = match e.kind() {
        K::NotFound => "check the name and the folder",
        K::PermissionDenied => "change its permissions or choose another",
        K::IsADirectory => "name a file, not a folder",
        K::ReadOnlyFilesystem => "choose another folder",
        K::StorageFull | K::QuotaExceeded => "make room or choose another disc",
        K::FileTooLarge => "choose another disc, or allow larger files (ulimit -f)",
        _ => return e.to_string(),
    };
    format!("{e}; {remedy}")
}
