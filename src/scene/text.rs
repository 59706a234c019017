// Text: from the bytes of a scene, mesh or material file to lines with their numbers.
//
// Files in the wild are UTF-8, UTF-16 with a byte order mark, or Latin-1 (comments, material names); end their
// lines with LF, CRLF or CR; continue a statement with a trailing backslash; and carry control characters at
// their end. Every reader of this crate sees plain `&str` statements with the number of their first line.

use crate::Result;
use crate::host::files;
use std::borrow::Cow;
use std::path::Path;

/// Reads a file and decodes it.
pub(crate) fn read(path: &Path) -> Result<String> {
    Ok(decode(&files::read(path)?))
}

/// Decodes UTF-8, UTF-16 (by its byte order mark) or else Latin-1, in which every byte is a character.
pub(crate) fn decode(bytes: &[u8]) -> String {
    match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => decode_bytes(rest),
        [0xFF, 0xFE, rest @ ..] => decode_utf16(rest, u16::from_le_bytes),
        [0xFE, 0xFF, rest @ ..] => decode_utf16(rest, u16::from_be_bytes),
        _ => decode_bytes(bytes),
    }
}

fn decode_bytes(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_owned(),
        Err(_) => bytes.iter().map(|&b| char::from(b)).collect(),
    }
}

fn decode_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.as_chunks::<2>().0.iter().map(|&pair| unit(pair));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

/// A statement: its first line, from 1, and its text without line end, continuations or control characters.
pub(crate) struct Statement<'a> {
    /// Number of its first line, from 1.
    pub(crate) line: usize,
    /// Trimmed text; never empty, never a comment.
    pub(crate) text: Cow<'a, str>,
}

impl Statement<'_> {
    /// The first word and what follows it, trimmed.
    pub(crate) fn split(&self) -> (&str, &str) {
        let (key, rest) = self.text.split_once(char::is_whitespace).unwrap_or((&self.text, ""));
        (key, rest.trim())
    }
}

/// The statements of an OBJ or MTL file, blank lines and whole-line comments left out.
pub(crate) fn statements(text: &str) -> impl Iterator<Item = Statement<'_>> {
    let mut lines = physical_lines(text).enumerate();
    std::iter::from_fn(move || {
        loop {
            let (index, first) = lines.next()?;
            let mut text = clean(first);
            if text.starts_with('#') {
                continue; // also where it ends in a backslash, as Windows paths in comments do
            }
            if text.ends_with('\\') {
                text = Cow::Owned(continued(text.into_owned(), &mut lines));
            }
            if !text.is_empty() {
                return Some(Statement { line: index + 1, text });
            }
        }
    })
}

/// A statement whose text ends in a backslash, with the lines that continue it. Each is appended in place: a statement of
/// many lines costs what it is long.
fn continued<'a>(mut text: String, lines: &mut impl Iterator<Item = (usize, &'a str)>) -> String {
    while text.ends_with('\\') {
        text.pop();
        if let Some((_, next)) = lines.next() {
            if !text.is_empty() {
                text.push(' ');
            }
            text.push_str(&clean(next));
        }
        text.truncate(text.trim_end().len());
    }
    text
}

/// Lines that end in LF, CRLF or CR.
fn physical_lines(text: &str) -> impl Iterator<Item = &str> {
    let mut rest = Some(text);
    std::iter::from_fn(move || {
        let current = rest?;
        let Some(end) = current.find(['\n', '\r']) else {
            rest = None;
            return Some(current);
        };
        let width = if current[end..].starts_with("\r\n") { 2 } else { 1 };
        rest = Some(&current[end + width..]);
        Some(&current[..end])
    })
}

/// Trims a line and turns control characters (NUL, Ctrl-Z at the end of old files) into blanks.
fn clean(line: &str) -> Cow<'_, str> {
    let is_garbage = |c: char| c.is_control() && c != '\t';
    if line.contains(is_garbage) {
        Cow::Owned(line.replace(is_garbage, " ").trim().to_owned())
    } else {
        Cow::Borrowed(line.trim())
    }
}

/// Line, from 1, of a byte offset.
pub(crate) fn line_at(text: &str, offset: usize) -> usize {
    1 + text.as_bytes()[..offset.min(text.len())].iter().filter(|&&b| b == b'\n').count()
}

/// Where the lines of a text begin: tells the line of any offset without counting again.
pub(crate) struct Lines {
    /// Offsets of the line feeds, rising.
    ends: Vec<usize>,
}

impl Lines {
    /// Looks for the lines of a text.
    pub(crate) fn of(text: &str) -> Self {
        Self { ends: text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i).collect() }
    }

    /// Line, from 1, of a byte offset.
    pub(crate) fn at(&self, offset: usize) -> usize {
        1 + self.ends.partition_point(|&end| end < offset)
    }
}

/// `; did you mean "…"?` for the candidate that is nearest in spelling, or nothing.
pub(crate) fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Below this Jaro–Winkler similarity two words are not taken for a slip of the keyboard.
    const LEAST_SIMILARITY: f64 = 0.75;
    /// Longer words, in bytes, are not compared: that takes the product of both lengths.
    const LONGEST: usize = 128;
    candidates
        .into_iter()
        .filter(|c| word.len().max(c.len()) <= LONGEST)
        .map(|c| (strsim::jaro_winkler(&word.to_lowercase(), &c.to_lowercase()), c))
        .filter(|(similarity, _)| *similarity >= LEAST_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbered(text: &str) -> Vec<(usize, String)> {
        statements(text).map(|s| (s.line, s.text.into_owned())).collect()
    }

    /// LF, CRLF and CR end one line each, and comments and blanks count as lines.
    #[test]
    fn every_line_end_counts_once() {
        let expected = [(1, "a".into()), (3, "b".into()), (5, "c".into())];
        for end in ["\n", "\r\n", "\r"] {
            assert_eq!(numbered(&["a", "", "b", "# x\\", "c"].join(end)), expected, "{end:?}");
        }
    }

    /// A continued statement carries the number of its first line.
    #[test]
    fn continuation_keeps_first_line() {
        assert_eq!(numbered("f 1 \\\n2 3\nv\n"), [(1, "f 1  2 3".into()), (3, "v".into())]);
        assert_eq!(numbered("f 1 \\"), [(1, "f 1".into())]);
        assert_eq!(numbered("\\\n \\\nf 1 \\ \n\\\n\n2"), [(1, "f 1".into()), (6, "2".into())]);
    }

    /// The line of an offset is found as by counting.
    #[test]
    fn lines_are_counted_once() {
        let text = "a\n\nbc\nd";
        let lines = Lines::of(text);
        for offset in 0..=text.len() {
            assert_eq!(lines.at(offset), line_at(text, offset), "{offset}");
        }
    }

    /// Latin-1 and UTF-16 give the same text as UTF-8.
    #[test]
    fn encodings_agree() {
        let text = "usemtl grün";
        let latin1: Vec<u8> = text.chars().map(|c| c as u8).collect();
        let mut le = vec![0xFF, 0xFE];
        let mut be = vec![0xFE, 0xFF];
        for unit in text.encode_utf16() {
            le.extend(unit.to_le_bytes());
            be.extend(unit.to_be_bytes());
        }
        for bytes in [text.as_bytes(), &latin1, &le, &be] {
            assert_eq!(decode(bytes), text);
        }
    }
}
