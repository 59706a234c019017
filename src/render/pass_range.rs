//! Pass range: the passes of a part of a render.

use crate::backend::{BATCH_PASSES_MAX, PASSES_MAX};
use crate::error::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Passes `first` to `end` - 1 of a render, written `first..end`.
///
/// `first` is a multiple of [`PassRange::HEAD`]: devices sum up to so many passes in f32, the same ones whatever the range, and no part decides
/// anything after the first so many.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct PassRange {
    first: u64,
    end: u64,
}

impl PassRange {
    /// Passes at the begin of a render in which it is decided where paths are split most; every part knows what they saw.
    pub const HEAD: u64 = BATCH_PASSES_MAX as u64;

    /// Of at least one pass.
    ///
    /// # Errors
    /// [`Error::Usage`] where there is none, where there are more than [`PASSES_MAX`], and where `first` is no multiple of
    /// [`PassRange::HEAD`].
    pub fn new(first: u64, end: u64) -> Result<Self> {
        let refuse =
            |what: &str, remedy: String| Err(Error::usage(format!("{first}..{end}: {what}"), remedy));
        if end <= first {
            return refuse(
                "has no passes",
                "give the first pass and the one after the last, like 64..128".into(),
            );
        }
        if end > PASSES_MAX {
            return refuse("has too many passes", format!("random numbers last for {PASSES_MAX}"));
        }
        if !first.is_multiple_of(Self::HEAD) {
            let near = first.next_multiple_of(Self::HEAD);
            let remedy = format!("begin at a multiple of {}, like {near}", Self::HEAD);
            return refuse("parts of a render cannot begin there", remedy);
        }
        Ok(Self { first, end })
    }

    /// The first pass.
    pub fn first(self) -> u64 {
        self.first
    }

    /// The pass after the last.
    pub fn end(self) -> u64 {
        self.end
    }

    /// How many passes it has.
    pub fn passes(self) -> u64 {
        self.end - self.first
    }
}

impl fmt::Display for PassRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}..{}", self.first, self.end)
    }
}

impl FromStr for PassRange {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let parse = |word: &str| word.trim().parse().ok();
        let parsed = text.split_once("..").and_then(|(first, end)| Some((parse(first)?, parse(end)?)));
        let (first, end) = parsed.ok_or_else(|| {
            Error::usage(
                format!("{text}: is no range of passes"),
                "give the first pass and the one after the last, like 64..128",
            )
        })?;
        Self::new(first, end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Ranges are read as they are written; what no part can be is refused.
    #[test]
    fn ranges_are_read() {
        for (text, first, end) in
            [("0..1", 0, 1), ("64..100", 64, 100), (" 16 .. 4294967295 ", 16, PASSES_MAX)]
        {
            let range: PassRange = text.parse().expect("a range");
            assert_eq!((range.first(), range.end(), range.passes()), (first, end, end - first));
            assert_eq!(range.to_string().parse::<PassRange>().expect("the same"), range);
        }
        for (text, what) in [
            ("64", "is no range"),
            ("a..b", "is no range"),
            ("-1..4", "is no range"),
            ("64..64", "has no passes"),
            ("64..32", "has no passes"),
            ("60..128", "like 64"),
            ("0..4294967296", "too many"),
        ] {
            let told = text.parse::<PassRange>().expect_err("it is refused").to_string();
            assert!(told.contains(what), "{text}: {told}");
        }
    }
}
