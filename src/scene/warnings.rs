//! Warnings: what was repaired or ignored on the way in, one line for each kind.

use crate::error::plain;
use std::collections::{BTreeSet, HashMap, HashSet};
use std::path::Path;

/// Names that a line gives; those beyond are counted.
const NAMES: usize = 3;

/// Collects warnings; those of one kind about one file become one line with a count.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    groups: Vec<Group>,
    group_of: HashMap<(String, String), usize>,
}

/// A kind of warning about things that have names, in the words for one of them and for several:
/// `material "a" is odd`, `materials "a", "b", "c" and 42 more are odd`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Named<'a> {
    /// What such a thing is called.
    pub(crate) noun: [&'a str; 2],
    /// What follows the names.
    pub(crate) what: [&'a str; 2],
}

/// Warnings of one kind.
#[derive(Debug)]
struct Group {
    /// Where the first is.
    place: String,
    /// Words after the place for one, and for several: before the names and after them.
    words: [[String; 2]; 2],
    /// The first names in quotes; none where the things have none.
    names: Vec<String>,
    /// All names so far.
    known: HashSet<String>,
    /// Names, or warnings where the things have none.
    count: usize,
}

impl Warnings {
    /// Notes `what` at a line of a file; the first line met stands for all of the same words.
    pub(crate) fn add(&mut self, file: &Path, line: Option<usize>, what: impl Into<String>) {
        let what = what.into();
        let words = || [[what.clone(), String::new()], [what.clone(), String::new()]];
        self.group(file, line, &what, words).count += 1;
    }

    /// Notes something about a thing with a name; the first ones met stand for all of the same kind in the file. A hint
    /// that follows the name is asked for only where the name will be told.
    pub(crate) fn add_named(
        &mut self,
        file: &Path,
        line: Option<usize>,
        kind: Named<'_>,
        name: &str,
        hint: impl FnOnce() -> String,
    ) {
        let words = || [0, 1].map(|i| [format!("{} ", kind.noun[i]), kind.what[i].to_owned()]);
        let group = self.group(file, line, kind.what[0], words);
        if !group.known.insert(name.to_owned()) {
            return;
        }
        group.count += 1;
        if group.names.len() < NAMES {
            group.names.push(format!("\"{name}\"{}", hint()));
        }
    }

    fn group(
        &mut self,
        file: &Path,
        line: Option<usize>,
        what: &str,
        words: impl FnOnce() -> [[String; 2]; 2],
    ) -> &mut Group {
        let file = file.display().to_string();
        let next = self.groups.len();
        let place = line.map_or(file.clone(), |l| format!("{file}:{l}"));
        let index = *self.group_of.entry((file, what.to_owned())).or_insert(next);
        if index == next {
            self.groups.push(Group {
                place,
                words: words(),
                names: Vec::new(),
                known: HashSet::new(),
                count: 0,
            });
        }
        &mut self.groups[index]
    }

    /// One line each, in the order in which they were first met.
    pub(crate) fn into_lines(self) -> Vec<String> {
        self.groups.into_iter().map(Group::into_line).collect()
    }
}

impl Group {
    /// One plain line, whatever the names.
    fn into_line(self) -> String {
        let several = usize::from(self.count > 1 && !self.names.is_empty());
        let [before, after] = &self.words[several];
        let text = format!("{}: {before}{}{after}", self.place, listed(&self.names, self.count));
        let text = plain(&text);
        match self.count {
            n if n > 1 && self.names.is_empty() => format!("{text} (… and {} more)", n - 1),
            _ => text.into_owned(),
        }
    }
}

/// Names in quotes that [`quoted`] gives.
const QUOTED: usize = 3;

/// Names in quotes, the first few and how many more.
pub(crate) fn quoted(all: &BTreeSet<&str>) -> String {
    let first: Vec<String> = all.iter().take(QUOTED).map(|name| format!("\"{name}\"")).collect();
    listed(&first, all.len())
}

/// `a, b and c`, or `a, b, c and 7 more` where `count` are more than the names.
pub(crate) fn listed(names: &[String], count: usize) -> String {
    match (names, count - names.len().min(count)) {
        ([], _) => String::new(),
        (names, 0) if names.len() > 1 => {
            let (last, first) = (&names[names.len() - 1], &names[..names.len() - 1]);
            format!("{} and {last}", first.join(", "))
        }
        (names, 0) => names.join(", "),
        (names, more) => format!("{} and {more} more", names.join(", ")),
    }
}
