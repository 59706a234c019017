//! The disc: what output asks of the file system to write, call by call. Nothing else in `output` does, but for removing files.
//!
//! In tests of the library each call of a thread has a number, and the one that a test names fails; in the program they are those of
//! the standard library.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

/// What is asked of the disc.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Call {
    Open,
    Permissions,
    Write,
    Sync,
    Link,
    Copy,
    Rename,
}

/// A file that is written.
pub(super) struct Written(File);

impl Written {
    /// The file, to ask what changes nothing.
    pub(super) fn file(&self) -> &File {
        &self.0
    }

    /// Give it these permissions.
    #[cfg(unix)]
    pub(super) fn permit(&self, permissions: fs::Permissions) -> io::Result<()> {
        fault(Call::Permissions)?;
        self.0.set_permissions(permissions)
    }

    /// Bring it to the disc.
    pub(super) fn sync(&self) -> io::Result<()> {
        fault(Call::Sync)?;
        self.0.sync_all()
    }
}

impl Write for Written {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        fault(Call::Write)?;
        self.0.write(short(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

impl Seek for Written {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.0.seek(to)
    }
}

/// Open a file to write it.
pub(super) fn open(path: &Path, options: &OpenOptions) -> io::Result<Written> {
    fault(Call::Open)?;
    options.open(path).map(Written)
}

/// Give a file a name that another one may have.
pub(super) fn rename(from: &Path, to: &Path) -> io::Result<()> {
    fault(Call::Rename)?;
    fs::rename(from, to)
}

/// Give a file a second name.
pub(super) fn link(file: &Path, name: &Path) -> io::Result<()> {
    fault(Call::Link)?;
    fs::hard_link(file, name)
}

/// Copy a file.
pub(super) fn copy(from: &Path, to: &Path) -> io::Result<()> {
    fs::metadata(from)?;
    if let Err(e) = fault(Call::Copy) {
        // what a disc leaves that fills up meanwhile
        fs::write(to, "half").ok();
        return Err(e);
    }
    fs::copy(from, to).map(|_| ())
}

#[cfg(not(test))]
#[inline]
fn fault(_: Call) -> io::Result<()> {
    Ok(())
}

#[cfg(not(test))]
#[inline]
fn short(bytes: &[u8]) -> &[u8] {
    bytes
}

#[cfg(test)]
use faults::{fault, short};

/// Faults that tests ask for.
#[cfg(test)]
pub(super) mod faults {
    use super::Call;
    use std::cell::RefCell;
    use std::io::{self, ErrorKind};

    /// What goes wrong on a thread.
    #[derive(Debug, Clone, Copy, PartialEq, Eq)]
    pub(in crate::output) enum Fault {
        /// Nothing.
        None,
        /// The call of this number fails, in this way.
        One(usize, ErrorKind),
        /// Likewise, and no file can have a second name.
        WithoutLinks(usize, ErrorKind),
        /// The disc is full from this call on: only renaming takes no room.
        Full(usize),
        /// A write takes half of what it is given, and every other call is interrupted.
        Short,
    }

    /// What was asked for, and the calls so far.
    struct Plan {
        fault: Fault,
        calls: Vec<Call>,
    }

    thread_local! {
        static PLAN: RefCell<Plan> = const { RefCell::new(Plan { fault: Fault::None, calls: Vec::new() }) };
    }

    /// Do something with a fault; what it gives, and the calls that it made.
    pub(in crate::output) fn with<T>(fault: Fault, work: impl FnOnce() -> T) -> (T, Vec<Call>) {
        PLAN.with_borrow_mut(|plan| (plan.fault, plan.calls) = (fault, Vec::new()));
        let done = work();
        (
            done,
            PLAN.with_borrow_mut(|plan| {
                plan.fault = Fault::None;
                std::mem::take(&mut plan.calls)
            }),
        )
    }

    pub(super) fn fault(call: Call) -> io::Result<()> {
        PLAN.with_borrow_mut(|plan| {
            let number = plan.calls.len();
            plan.calls.push(call);
            match plan.fault {
                Fault::One(k, e) | Fault::WithoutLinks(k, e) if number == k => Err(e.into()),
                Fault::WithoutLinks(..) if call == Call::Link => Err(ErrorKind::Unsupported.into()),
                Fault::Full(k) if number >= k && call != Call::Rename => Err(ErrorKind::StorageFull.into()),
                Fault::Short if call == Call::Write && number % 2 == 1 => Err(ErrorKind::Interrupted.into()),
                _ => Ok(()),
            }
        })
    }

    pub(super) fn short(bytes: &[u8]) -> &[u8] {
        let is_short = PLAN.with_borrow(|plan| plan.fault == Fault::Short);
        if is_short { &bytes[..bytes.len().div_ceil(2)] } else { bytes }
    }
}
