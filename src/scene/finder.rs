//! Finder: finds the files that meshes and material libraries name, as exporters write names.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Looks for files beside another; each folder is listed once.
#[derive(Debug)]
pub(crate) struct Finder {
    directory: PathBuf,
    /// For each folder its files by their names in small letters, the first by name where several agree.
    listings: HashMap<PathBuf, HashMap<String, PathBuf>>,
}

impl Finder {
    /// Looks in `directory` and below.
    pub(crate) fn new(directory: PathBuf) -> Self {
        Self { directory, listings: HashMap::new() }
    }

    /// The libraries that an `mtllib` statement names: the whole rest of the line as one name where such a file
    /// exists, otherwise each of its words.
    pub(crate) fn locate(&mut self, names: &str) -> Vec<Result<PathBuf, String>> {
        if let Some(path) = self.find(names) {
            return vec![Ok(path)];
        }
        if names.split_whitespace().count() < 2 {
            return vec![Err(names.to_owned())];
        }
        names.split_whitespace().map(|name| self.find(name).ok_or_else(|| name.to_owned())).collect()
    }

    /// Finds a file by name: as written, with `\` as `/`, in any case, or by its last part in the same folder.
    pub(crate) fn find(&mut self, name: &str) -> Option<PathBuf> {
        let name = name.trim().trim_matches('"').replace('\\', "/");
        if name.is_empty() || name.contains('\0') {
            return None;
        }
        let last_part = name.rsplit('/').next().unwrap_or(&name).to_owned();
        [name, last_part].iter().find_map(|candidate| {
            let path = self.directory.join(candidate);
            if path.is_file() {
                return Some(path);
            }
            let wanted = path.file_name()?.to_str()?.to_lowercase();
            let folder = path.parent()?;
            if !self.listings.contains_key(folder) {
                self.listings.insert(folder.to_owned(), listing(folder));
            }
            self.listings.get(folder)?.get(&wanted).cloned()
        })
    }
}

/// The files of a folder by their names in small letters.
fn listing(folder: &Path) -> HashMap<String, PathBuf> {
    let mut entries: Vec<_> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().map(|e| e.path()).collect();
    entries.sort();
    let mut files = HashMap::new();
    for entry in entries.into_iter().filter(|e| e.is_file()) {
        if let Some(name) = entry.file_name().and_then(|n| n.to_str()).map(str::to_lowercase) {
            files.entry(name).or_insert(entry);
        }
    }
    files
}
