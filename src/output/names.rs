//! Names: which file a name stands for, and whether two stand for the same one.

use crate::error::{Error, Result};
use std::collections::HashSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Links that are followed one after the other, as many as Linux does.
const LINKS_MAX: u32 = 40;

/// The folder of a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// The file that a name stands for, whether it exists or not: links are followed, also where nothing is at their end yet.
pub fn resolve(path: &Path) -> PathBuf {
    let mut at = path.to_owned();
    for _ in 0..LINKS_MAX {
        let Ok(next) = fs::read_link(&at) else { break };
        at = folder_of(&at).join(next);
    }
    match (folder_of(&at).canonicalize(), at.file_name()) {
        (Ok(folder), Some(name)) => folder.join(name),
        _ => at,
    }
}

/// What tells files apart that exist, whatever their names: device and number on it.
#[cfg(unix)]
fn identity(path: &Path) -> Option<(u64, u64)> {
    use std::os::unix::fs::MetadataExt;
    fs::metadata(path).ok().map(|meta| (meta.dev(), meta.ino()))
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// Refuse to write over what was read, by whichever name.
///
/// # Errors
/// [`Error::Usage`] with the first of `outputs` that is one of `inputs`.
pub fn check_not_read<'a>(
    outputs: impl IntoIterator<Item = &'a (impl AsRef<Path> + ?Sized + 'a)>,
    inputs: &[PathBuf],
) -> Result<()> {
    let names: HashSet<PathBuf> = inputs.iter().map(|input| resolve(input)).collect();
    let identities: HashSet<_> = inputs.iter().filter_map(|input| identity(input)).collect();
    for output in outputs {
        let output = output.as_ref();
        let is_read =
            names.contains(&resolve(output)) || identity(output).is_some_and(|id| identities.contains(&id));
        if is_read {
            let what = format!(
                "{}: is read here as scene, mesh, material library or picture, and must not be written over",
                output.display()
            );
            return Err(Error::usage(what, "give what is written another name"));
        }
    }
    Ok(())
}
