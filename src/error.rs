//! The errors of the library: each tells what, where and what to do, in one line.

use std::borrow::Cow;
use std::path::PathBuf;

/// Result of this library.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Everything that can go wrong, as one line for the user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A scene, mesh or material file cannot be used.
    #[error("{}{}: {}; {}", escaped(&file.display().to_string()), line.map_or(String::new(), |l| format!(":{l}")), plain(what), plain(remedy))]
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
    #[error("{}: cannot {action}: {}", escaped(&file.display().to_string()), plain(what))]
    Io {
        /// The file at fault.
        file: PathBuf,
        /// The verb: read, write, create.
        action: &'static str,
        /// The system's or the format's own words.
        what: String,
    },
    /// The command line asks for something that cannot be.
    #[error("{}; {}", plain(what), plain(remedy))]
    Usage {
        /// What is wrong.
        what: String,
        /// What to do.
        remedy: String,
    },
    /// The device is missing or failed.
    #[error("{}; {}", plain(what), plain(remedy))]
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

/// Characters of a text that are told, at most: a name of a thousand is not read to its end, and one of a million drowns the rest.
const TOLD: usize = 1000;

/// A text as one plain line, whatever a file put into it: what would end the line or command a terminal is spelt out, and of what is long the
/// middle is left out.
pub(crate) fn plain(text: &str) -> Cow<'_, str> {
    let text = escaped(text);
    let count = text.chars().count();
    if count <= TOLD {
        return text;
    }
    let (first, last) = (text.chars().take(TOLD / 2), text.chars().skip(count - TOLD / 2));
    Cow::Owned(first.chain(['…']).chain(last).collect())
}

/// A text whose control characters are spelt out, as `\n` or `\u{1b}`.
pub(crate) fn escaped(text: &str) -> Cow<'_, str> {
    if !text.contains(char::is_control) {
        return Cow::Borrowed(text);
    }
    let mut plain = String::new();
    for c in text.chars() {
        if c.is_control() { plain.extend(c.escape_default()) } else { plain.push(c) }
    }
    Cow::Owned(plain)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whatever stands in a text, an error is one line that commands no terminal, and is not endless; its file and its end are whole.
    #[test]
    fn errors_are_one_plain_line() {
        let long = "ä".repeat(5000);
        for (e, wanted) in [
            (
                Error::scene("a\n.obj", Some(3), "\"x\u{1b}[2J\r\ty\" is no name", "go"),
                r#"a\n.obj:3: "x\u{1b}[2J\r\ty" is no name; go"#.to_string(),
            ),
            (Error::io("b\0", "read", "it\u{85}is"), r"b\u{0}: cannot read: it\u{85}is".into()),
            (Error::usage("grün", "schön"), "grün; schön".into()),
            (Error::device(format!("x{long}y"), "z"), format!("x{}…{}y; z", &long[..998], &long[..998])),
        ] {
            assert_eq!(e.to_string(), wanted);
        }
    }
}
