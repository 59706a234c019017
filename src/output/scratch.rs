//! Scratch files: what is written beside a target until it is whole. They are removed when writing fails or is broken off;
//! those that a killed process left are removed by the next one that writes into their folder.
//!
//! `.NAME.joton-PID-N.part`: the name tells whose it is. While it is written it is locked, too: where several machines share a
//! folder, the number alone would not tell whether its process lives.

use super::disc::{self, Written};
use std::ffi::OsString;
use std::fs::{self, File, Metadata, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};

const MARK: &str = ".joton-";
const ENDING: &str = ".part";
/// Extension of what was at a target before, until all of a set have their places.
const BEFORE: &str = "before.part";
/// Until the bits of the target are taken over, nobody else may read what may be meant for few.
#[cfg(unix)]
const PRIVATE: u32 = 0o600;

/// Scratch files of this process. Who holds the list may create, rename and remove.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Remove what is not whole yet, and let nothing more be written by this process, which is about to end: whoever tries
/// waits for ever.
pub fn discard_unfinished() {
    let list = unfinished();
    for path in list.iter() {
        // Nothing better can be done where even removing fails.
        let _ = fs::remove_file(path);
    }
    std::mem::forget(list);
}

/// A file that is removed unless it is renamed.
pub(super) struct Scratch(PathBuf);

impl Scratch {
    /// A new file in the folder of `target`: renaming works only within one file system. It has the owner and the permissions
    /// of what is there now.
    pub(super) fn beside(target: &Path) -> std::io::Result<(Self, Written)> {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let mut name = OsString::from(".");
        name.push(target.file_name().ok_or_else(|| std::io::Error::other("it names no file"))?);
        let count = COUNT.fetch_add(1, Ordering::Relaxed);
        name.push(format!("{MARK}{}-{count}{ENDING}", std::process::id()));
        let path = target.with_file_name(name);
        let replaced = fs::metadata(target).ok();
        let mut options = OpenOptions::new();
        options.write(true).create_new(true);
        #[cfg(unix)]
        if replaced.is_some() {
            std::os::unix::fs::OpenOptionsExt::mode(&mut options, PRIVATE);
        }
        let mut list = unfinished();
        let file = disc::open(&path, &options)?;
        // some file systems have no locks; then what a killed process leaves stays
        file.file().try_lock().ok();
        list.push(path.clone());
        drop(list);
        let scratch = Self(path);
        if let Some(replaced) = replaced {
            take_over(&file, &replaced)?;
        }
        Ok((scratch, file))
    }

    /// Give several their places, all or none: where one cannot be had, those before it get back what was there.
    pub(super) fn rename_all(scratches: &[(Self, PathBuf)]) -> Result<(), (PathBuf, std::io::Error)> {
        let mut list = unfinished();
        let mut done: Vec<(&Path, Before)> = Vec::new();
        let mut failed = None;
        for (scratch, target) in scratches {
            // with one file there is nothing to go back to
            let before = if scratches.len() > 1 { scratch.keep(target) } else { Ok(Before::Nothing) };
            let renamed = before.and_then(|before| match disc::rename(&scratch.0, target) {
                Ok(()) => Ok(before),
                Err(e) => {
                    before.forget();
                    Err(e)
                }
            });
            match renamed {
                Ok(before) => {
                    list.retain(|p| *p != scratch.0);
                    done.push((target, before));
                }
                Err(e) => {
                    failed = Some((target.clone(), e));
                    break;
                }
            }
        }
        for (target, before) in done {
            // Nothing better can be done where that fails.
            let _ = match (before, &failed) {
                (Before::Kept(path), Some(_)) => disc::rename(&path, target),
                (Before::Nothing, Some(_)) => fs::remove_file(target),
                (before, None) => {
                    before.forget();
                    Ok(())
                }
            };
        }
        failed.map_or(Ok(()), Err)
    }

    /// Give what is at `target` a second name.
    fn keep(&self, target: &Path) -> std::io::Result<Before> {
        let path = self.0.with_extension(BEFORE);
        // some file systems have no second names
        match disc::link(target, &path).or_else(|_| disc::copy(target, &path)) {
            Ok(()) => Ok(Before::Kept(path)),
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(Before::Nothing),
            Err(e) => {
                Before::Kept(path).forget();
                Err(e)
            }
        }
    }
}

/// What was at a target.
enum Before {
    Nothing,
    /// It is here now, too.
    Kept(PathBuf),
}

impl Before {
    /// It is not needed any more.
    fn forget(self) {
        if let Self::Kept(path) = self {
            // Nothing better can be done where even removing fails.
            let _ = fs::remove_file(path);
        }
    }
}

impl Drop for Scratch {
    fn drop(&mut self) {
        let mut list = unfinished();
        // after a rename it is not in the list, and another may have its name
        if let Some(at) = list.iter().position(|p| *p == self.0) {
            list.swap_remove(at);
            // Nothing better can be done where even removing fails.
            let _ = fs::remove_file(&self.0);
        }
    }
}

/// Remove what killed processes left in a folder: their number is in use no more, nobody holds the lock, and the file is of the
/// owner of `own`.
pub(super) fn remove_stale(folder: &Path, own: &Metadata) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let Some(process) = name.to_str().and_then(process_of) else { continue };
        if is_alive(process)
            || !entry.metadata().is_ok_and(|meta| meta.is_file() && is_same_owner(&meta, own))
        {
            continue;
        }
        let is_free = |file: File| file.try_lock().is_ok();
        if OpenOptions::new().write(true).open(entry.path()).is_ok_and(is_free) {
            fs::remove_file(entry.path()).ok();
        }
    }
}

/// The process in the name of a scratch file.
fn process_of(name: &str) -> Option<u32> {
    let (_, rest) = name.strip_prefix('.')?.strip_suffix(ENDING)?.rsplit_once(MARK)?;
    rest.split_once('-')?.0.parse().ok()
}

/// Whether a process of this number runs; where the system does not tell, the lock alone does.
fn is_alive(process: u32) -> bool {
    process == std::process::id() || Path::new("/proc").join(process.to_string()).exists()
}

#[cfg(unix)]
fn is_same_owner(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    a.uid() == b.uid()
}

#[cfg(not(unix))]
fn is_same_owner(_: &Metadata, _: &Metadata) -> bool {
    true
}

/// Owner, where that is allowed, and permissions of what is replaced.
#[cfg(unix)]
fn take_over(file: &Written, replaced: &Metadata) -> std::io::Result<()> {
    use std::os::unix::fs::{MetadataExt, fchown};
    let own = file.file().metadata()?;
    if (own.uid(), own.gid()) != (replaced.uid(), replaced.gid()) {
        fchown(file.file(), Some(replaced.uid()), Some(replaced.gid())).ok();
    }
    file.permit(replaced.permissions())
}

#[cfg(not(unix))]
fn take_over(_: &Written, _: &Metadata) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).expect("a folder").map(|e| e.expect("an entry").file_name());
        let mut names: Vec<_> = entries.map(|name| name.into_string().expect("UTF-8")).collect();
        names.sort();
        names
    }

    /// Where one file of a set cannot have its place, those before it are what they were, and nothing is left beside them.
    #[test]
    fn a_set_is_replaced_whole_or_not_at_all() {
        for fails in [false, true] {
            let folder = tempfile::tempdir().expect("a folder");
            let [old, new, last] = ["old", "new", "last"].map(|name| folder.path().join(name));
            fs::write(&old, "precious").expect("written");
            let set: Vec<_> = [&old, &new, &last]
                .map(|target| {
                    let (scratch, _) = Scratch::beside(target).expect("a scratch file");
                    fs::write(&scratch.0, "whole").expect("written");
                    (scratch, target.clone())
                })
                .into();
            if fails {
                // a folder came in between
                fs::create_dir(&last).expect("a folder");
            }
            let renamed = Scratch::rename_all(&set);
            assert_eq!(renamed.as_ref().err().map(|(path, _)| path), fails.then_some(&last));
            drop(set);
            let text = fs::read_to_string(&old).expect("read");
            assert_eq!(text, if fails { "precious" } else { "whole" });
            let wanted: &[&str] = if fails { &["last", "old"] } else { &["last", "new", "old"] };
            assert_eq!(names(folder.path()), wanted);
        }
    }

    /// Scratch files of processes that are gone are removed, unless somebody holds their lock; those of living processes, and
    /// files that only look alike, stay.
    #[cfg(target_os = "linux")]
    #[test]
    fn what_dead_processes_left_is_removed() {
        let folder = tempfile::tempdir().expect("a folder");
        let mut child = std::process::Command::new("true").spawn().expect("a process");
        child.wait().expect("it ends");
        let (dead, alive) = (child.id(), std::os::unix::process::parent_id());
        let file = |name: String| File::create(folder.path().join(name)).expect("a file");
        file(format!(".a.exr.joton-{dead}-0.part"));
        file(format!(".b.joton-{dead}-12.before.part"));
        let locked = file(format!(".locked.joton-{dead}-0.part"));
        locked.lock().expect("locked");
        let mut stay = vec![format!(".locked.joton-{dead}-0.part"), format!(".alive.joton-{alive}-0.part")];
        for alike in
            ["a.exr.joton-PID-0.part", ".a.exr.PID-0.part", ".a.joton-PID-0.exr", ".a.joton-x-0.part"]
        {
            stay.push(alike.replace("PID", &dead.to_string()));
        }
        for name in &stay[1..] {
            file(name.clone());
        }
        remove_stale(folder.path(), &locked.metadata().expect("an owner"));
        stay.sort();
        assert_eq!(names(folder.path()), stay);
    }
}
