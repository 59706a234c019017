// Table: typed access to a TOML table in which every fault names its line.

use super::mtl::At;
use super::spd;
use super::text::{self, Lines};
use crate::spectrum::{BANDS, Bands, from_rgb};
use crate::{Error, Result};
use glam::{DVec2, DVec3};
use std::cell::RefCell;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Parses TOML; a fault of syntax names its line.
pub(crate) fn parse<'a>(source: &'a str, path: &Path) -> Result<Spanned<DeTable<'a>>> {
    DeTable::parse(source).map_err(|e| {
        let line = e.span().map(|span| text::line_at(source, span.start));
        Error::scene(path, line, e.message().replace('\n', " "), "mend the TOML")
    })
}

/// What a key says by name, or itself.
pub(crate) enum TextOrTable<'a> {
    Text(At<String>),
    Table(Table<'a>),
}

/// The text of a scene file: its lines, and the other files that were read for what it says.
pub(crate) struct Source {
    lines: Lines,
    read: RefCell<Vec<PathBuf>>,
}

impl Source {
    /// Nothing is read yet.
    pub(crate) fn of(text: &str) -> Self {
        Self { lines: Lines::of(text), read: RefCell::default() }
    }

    /// Files that were read.
    pub(crate) fn into_read(self) -> Vec<PathBuf> {
        self.read.into_inner()
    }
}

/// A table of a scene file.
#[derive(Clone)]
pub(crate) struct Table<'a> {
    path: &'a Path,
    source: &'a Source,
    /// What the user calls it: `[camera]`.
    name: String,
    entries: &'a DeTable<'a>,
    span: Range<usize>,
}

impl<'a> Table<'a> {
    /// Wraps a parsed table.
    pub(crate) fn new(
        path: &'a Path,
        source: &'a Source,
        name: impl Into<String>,
        entries: &'a DeTable<'a>,
        span: Range<usize>,
    ) -> Self {
        Self { path, source, name: name.into(), entries, span }
    }

    /// Line of its header, from 1.
    pub(crate) fn line(&self) -> usize {
        self.source.lines.at(self.span.start)
    }

    /// A fault at a line of this file.
    pub(crate) fn fault(&self, line: usize, what: &str, remedy: &str) -> Error {
        Error::scene(self.path, Some(line), what, remedy)
    }

    /// A word that is none of those that are known.
    pub(crate) fn unknown(&self, line: usize, what: &str, word: &str, known: &[&str]) -> Error {
        let remedy = match text::did_you_mean(word, known.iter().copied()) {
            Some(near) => format!("did you mean \"{near}\"?"),
            None => format!("known are {}", known.join(", ")),
        };
        self.fault(line, &format!("unknown {what} \"{word}\""), &remedy)
    }

    /// A key that must be there and is not.
    pub(crate) fn missing(&self, key: &str) -> Error {
        self.fault(self.line(), &format!("{} has no {key}", self.name), &format!("add {key} = …"))
    }

    /// Refuses keys that are not known.
    pub(crate) fn allow(&self, known: &[&str]) -> Result<()> {
        let mut keys: Vec<_> = self.entries.keys().collect();
        keys.sort_by_key(|key| key.span().start);
        match keys.into_iter().find(|key| !known.contains(&key.get_ref().as_ref())) {
            Some(key) => {
                let line = self.source.lines.at(key.span().start);
                Err(self.unknown(line, &format!("key in {}:", self.name), key.get_ref(), known))
            }
            None => Ok(()),
        }
    }

    fn get(&self, key: &str) -> Option<(&'a DeValue<'a>, usize, Range<usize>)> {
        let value = self.entries.get(key)?;
        Some((value.get_ref(), self.source.lines.at(value.span().start), value.span()))
    }

    fn wrong(&self, key: &str, line: usize, expected: &str) -> Error {
        self.fault(line, &format!("{key} has a wrong value"), &format!("give {expected}"))
    }

    /// A table within this one.
    pub(crate) fn table(&self, key: &str) -> Result<Option<Table<'a>>> {
        match self.get(key) {
            None => Ok(None),
            Some((DeValue::Table(entries), _, span)) => {
                Ok(Some(Table::new(self.path, self.source, format!("[{key}]"), entries, span)))
            }
            Some((_, line, _)) => Err(self.wrong(key, line, &format!("a table: [{key}]"))),
        }
    }

    /// A text, or a table within this one.
    pub(crate) fn text_or_table(&self, key: &str) -> Result<Option<TextOrTable<'a>>> {
        match self.get(key) {
            None => Ok(None),
            Some((DeValue::String(value), line, _)) => {
                Ok(Some(TextOrTable::Text(At { value: value.clone().into_owned(), line })))
            }
            Some((DeValue::Table(entries), _, span)) => {
                Ok(Some(TextOrTable::Table(Table::new(self.path, self.source, key, entries, span))))
            }
            Some((_, line, _)) => Err(self.wrong(key, line, "a name in quotes, or a table: { … }")),
        }
    }

    /// The tables of an array of tables.
    pub(crate) fn tables(&self, key: &str) -> Result<Vec<Table<'a>>> {
        let expected = format!("an array of tables: [[{key}]]");
        let Some((value, line, _)) = self.get(key) else { return Ok(Vec::new()) };
        let DeValue::Array(items) = value else { return Err(self.wrong(key, line, &expected)) };
        let table = |item: &'a Spanned<DeValue<'a>>| match item.get_ref() {
            DeValue::Table(entries) => {
                Ok(Table::new(self.path, self.source, format!("[[{key}]]"), entries, item.span()))
            }
            _ => Err(self.wrong(key, self.source.lines.at(item.span().start), &expected)),
        };
        items.iter().map(table).collect()
    }

    /// A text that must be there.
    pub(crate) fn string(&self, key: &str) -> Result<At<String>> {
        self.optional_string(key)?.ok_or_else(|| self.missing(key))
    }

    /// A text.
    pub(crate) fn optional_string(&self, key: &str) -> Result<Option<At<String>>> {
        match self.get(key) {
            None => Ok(None),
            Some((DeValue::String(value), line, _)) => {
                Ok(Some(At { value: value.clone().into_owned(), line }))
            }
            Some((_, line, _)) => Err(self.wrong(key, line, "a text in quotes")),
        }
    }

    /// True or false.
    pub(crate) fn boolean(&self, key: &str) -> Result<Option<At<bool>>> {
        match self.get(key) {
            None => Ok(None),
            Some((DeValue::Boolean(value), line, _)) => Ok(Some(At { value: *value, line })),
            Some((_, line, _)) => Err(self.wrong(key, line, "true or false")),
        }
    }

    /// A whole number.
    pub(crate) fn integer(&self, key: &str) -> Result<Option<At<i64>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        let whole = match value {
            DeValue::Integer(i) => i64::from_str_radix(&i.as_str().replace('_', ""), i.radix()).ok(),
            _ => None,
        };
        whole.map(|value| Some(At { value, line })).ok_or_else(|| self.wrong(key, line, "a whole number"))
    }

    /// A finite number.
    pub(crate) fn number(&self, key: &str) -> Result<Option<At<f64>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        finite(value)
            .map(|value| Some(At { value, line }))
            .ok_or_else(|| self.wrong(key, line, "a finite number"))
    }

    fn numbers<const N: usize>(&self, key: &str) -> Option<(Option<[f64; N]>, usize)> {
        let (value, line, _) = self.get(key)?;
        Some((all_finite(value).and_then(|v| v.try_into().ok()), line))
    }

    /// Any number of finite numbers.
    pub(crate) fn list(&self, key: &str) -> Result<Option<At<Vec<f64>>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        let values = all_finite(value).map(|value| Some(At { value, line }));
        values.ok_or_else(|| self.wrong(key, line, "finite numbers: [a, b, …]"))
    }

    /// Any number of pairs of finite numbers.
    pub(crate) fn pairs(&self, key: &str) -> Result<Option<At<Vec<[f64; 2]>>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        let values = rows::<2>(value).map(|value| Some(At { value, line }));
        values.ok_or_else(|| self.wrong(key, line, "pairs of finite numbers: [[nm, value], …]"))
    }

    /// A spectrum: pairs of wavelength, nm, and value, or the name of a file of them ([`spd`]), whose values are at most `most`.
    pub(crate) fn spectrum(&self, key: &str, most: f64) -> Result<Option<At<Vec<[f64; 2]>>>> {
        let Some((DeValue::String(name), line, _)) = self.get(key) else { return self.pairs(key) };
        let name = name.trim();
        if name.is_empty() || name.contains('\0') {
            return Err(self.wrong(key, line, "a file, or pairs: [[nm, value], …]"));
        }
        let path = self.path.parent().unwrap_or(Path::new("")).join(name);
        let value = spd::read(&path, most).map_err(|error| match error {
            // where it is named tells more than why the system has none
            Error::Io { .. } => self.fault(line, &error.to_string(), "name a file beside the scene"),
            other => other,
        })?;
        self.source.read.borrow_mut().push(path);
        Ok(Some(At { value, line }))
    }

    /// Two colours.
    pub(crate) fn colours(&self, key: &str) -> Result<Option<At<[[f64; 3]; 2]>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        match rows::<3>(value).as_deref() {
            Some([a, b]) => Ok(Some(At { value: [*a, *b], line })),
            _ => Err(self.wrong(key, line, "two colours: [[r, g, b], [r, g, b]]")),
        }
    }

    /// A text or a table within this one, where the value is one of these.
    pub(crate) fn named_or_table(&self, key: &str) -> Result<Option<TextOrTable<'a>>> {
        match self.get(key) {
            Some((DeValue::String(_) | DeValue::Table(_), ..)) => self.text_or_table(key),
            _ => Ok(None),
        }
    }

    /// Line of a key, where it is there.
    pub(crate) fn line_of(&self, key: &str) -> Option<usize> {
        self.get(key).map(|(_, line, _)| line)
    }

    /// Whether it says anything of a key.
    pub(crate) fn has(&self, key: &str) -> bool {
        self.entries.contains_key(key)
    }

    /// Three finite numbers that must be there.
    pub(crate) fn vector(&self, key: &str) -> Result<At<DVec3>> {
        let (values, line) = self.numbers::<3>(key).ok_or_else(|| self.missing(key))?;
        let value = values.ok_or_else(|| self.wrong(key, line, "three finite numbers: [x, y, z]"))?;
        Ok(At { value: DVec3::from(value), line })
    }

    /// Three finite numbers, and their line.
    pub(crate) fn at_vector(&self, key: &str) -> Result<Option<At<DVec3>>> {
        if self.get(key).is_none() { Ok(None) } else { self.vector(key).map(Some) }
    }

    /// Finite numbers, or one that stands for all of them.
    fn repeated<const N: usize>(&self, key: &str, expected: &str) -> Result<Option<At<[f64; N]>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        let values = match finite(value) {
            Some(all) => Some([all; N]),
            None => self.numbers(key).and_then(|(values, _)| values),
        };
        values.map(|value| Some(At { value, line })).ok_or_else(|| self.wrong(key, line, expected))
    }

    /// Three finite numbers, or one for all.
    pub(crate) fn factors(&self, key: &str) -> Result<Option<At<DVec3>>> {
        let found = self.repeated::<3>(key, "three finite numbers: [x, y, z], or one for all")?;
        Ok(found.map(|At { value, line }| At { value: value.into(), line }))
    }

    /// Two finite numbers, or one for both.
    pub(crate) fn sides(&self, key: &str) -> Result<Option<At<DVec2>>> {
        let found = self.repeated::<2>(key, "two finite numbers: [across, along], or one for both")?;
        Ok(found.map(|At { value, line }| At { value: value.into(), line }))
    }

    /// Three rows of four finite numbers; a fourth row may follow, which is that of every affine map.
    pub(crate) fn matrix(&self, key: &str) -> Result<Option<At<[[f64; 4]; 3]>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        let rows = rows::<4>(value);
        match rows.as_deref() {
            Some([a, b, c] | [a, b, c, [0.0, 0.0, 0.0, 1.0]]) => Ok(Some(At { value: [*a, *b, *c], line })),
            _ => Err(self.wrong(key, line, "three rows of four finite numbers: [[…, x], […, y], […, z]]")),
        }
    }

    /// Three finite numbers.
    pub(crate) fn optional_vector(&self, key: &str) -> Result<Option<DVec3>> {
        Ok(self.at_vector(key)?.map(|v| v.value))
    }

    /// One number per band, or one for all; none negative.
    pub(crate) fn bands(&self, key: &str) -> Result<Option<At<Bands>>> {
        let Some((value, line, _)) = self.get(key) else { return Ok(None) };
        let values = match finite(value) {
            Some(all) => Some([all as f32; BANDS]),
            None => self.numbers(key).and_then(|(values, _)| values).map(|v| from_rgb(v.map(|x| x as f32))),
        };
        match values {
            Some(values) if values.iter().all(|v| v.is_finite() && *v >= 0.0) => {
                Ok(Some(At { value: values, line }))
            }
            _ => Err(self.wrong(key, line, "three finite numbers of at least 0: [r, g, b], or one for all")),
        }
    }
}

/// An array of finite numbers.
fn all_finite(value: &DeValue) -> Option<Vec<f64>> {
    let DeValue::Array(items) = value else { return None };
    items.iter().map(|item| finite(item.get_ref())).collect()
}

/// An array of arrays of so many finite numbers.
fn rows<const N: usize>(value: &DeValue) -> Option<Vec<[f64; N]>> {
    let DeValue::Array(items) = value else { return None };
    items.iter().map(|item| all_finite(item.get_ref())?.try_into().ok()).collect()
}

fn finite(value: &DeValue) -> Option<f64> {
    let text = match value {
        DeValue::Float(f) => f.as_str().replace('_', ""),
        DeValue::Integer(i) => {
            let digits = i.as_str().replace('_', "");
            return i64::from_str_radix(&digits, i.radix()).ok().map(|i| i as f64);
        }
        _ => return None,
    };
    text.parse().ok().filter(|v: &f64| v.is_finite())
}
