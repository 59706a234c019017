//! Interrupt: what Ctrl-C, a hang-up and a request to terminate do.

use super::INTERRUPTED;
use crate::system;
use joton::output;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// From now on the first signal raises the flag, for the command to stop and save; a second one does not wait, and leaves no
/// half-written file. Signals that were ignored stay so.
pub(super) fn watch() -> Arc<AtomicBool> {
    let raised = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&raised);
    system::keep_ignored(|| {
        // where no handler can be set, a signal ends the program as it always does
        ctrlc::set_handler(move || {
            if flag.swap(true, Ordering::SeqCst) {
                output::discard_unfinished();
                std::process::exit(INTERRUPTED.into());
            }
        })
        .ok();
    });
    raised
}
