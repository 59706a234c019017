// Warnings: what was repaired or ignored on the way in, repeated ones counted instead of listed.

use std::collections::HashMap;
use std::path::Path;

/// Collects warnings; the same words about the same file become one line with a count.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    groups: Vec<(String, usize)>,
    group_of: HashMap<(String, String), usize>,
}

impl Warnings {
    /// Notes `what` at a line of a file; the first line met stands for all of the same words.
    pub(crate) fn add(&mut self, file: &Path, line: Option<usize>, what: impl Into<String>) {
        let (file, what) = (file.display().to_string(), what.into());
        let place = line.map_or(file.clone(), |l| format!("{file}:{l}"));
        let text = format!("{place}: {what}");
        let group = *self.group_of.entry((file, what)).or_insert(self.groups.len());
        match self.groups.get_mut(group) {
            Some((_, repeats)) => *repeats += 1,
            None => self.groups.push((text, 0)),
        }
    }

    /// One line each, in the order in which they were first met.
    pub(crate) fn into_lines(self) -> Vec<String> {
        let line = |(text, repeats)| match repeats {
            0 => text,
            n => format!("{text} (… and {n} more)"),
        };
        self.groups.into_iter().map(line).collect()
    }
}
