//! Guard: a panic in another's code comes out as an error.

use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};

thread_local! {
    static GUARDED: Cell<bool> = const { Cell::new(false) };
}

/// Do what panics where a device is lost: wgpu waits for a device, and lets go of one, without a way to report that. Or what panics of a
/// damaged file, in a decoder of another's. The words of the panic, in one line, where it does.
///
/// # Errors
/// The words of the panic.
pub fn guarded<T>(work: impl FnOnce() -> T) -> std::result::Result<T, String> {
    let before = GUARDED.replace(true);
    let done = catch_unwind(AssertUnwindSafe(work));
    GUARDED.set(before);
    done.map_err(|panic| {
        let words = panic.downcast_ref::<String>().map(String::as_str);
        let words = words.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("it panicked");
        words.split_whitespace().collect::<Vec<_>>().join(" ")
    })
}

/// Whether a panic of this thread is caught and comes out as an error: then a hook has nothing to print.
pub fn is_guarded() -> bool {
    GUARDED.get()
}
