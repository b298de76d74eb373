//! Ctrl-C and SIGTERM: during the rendering they end it and keep what there is; otherwise they end the program.

use std::sync::atomic::{AtomicBool, Ordering};

use crate::failure::Failure;
use crate::progress::say;

/// There is something worth keeping: the rendering has begun.
static KEEPING: AtomicBool = AtomicBool::new(false);
static ASKED: AtomicBool = AtomicBool::new(false);

/// Starts to listen.
pub fn listen() -> Result<(), Failure> {
    ctrlc::set_handler(|| {
        let again = ASKED.swap(true, Ordering::SeqCst);
        let keeping = KEEPING.load(Ordering::SeqCst);
        if !again && !keeping {
            say(format_args!("pelage: interrupted: nothing has been written"));
        }
        if again || !keeping {
            std::process::exit(130);
        }
    })
    .map_err(|e| Failure::Usage(format!("cannot listen for interruptions: {e}")))
}

/// From now on, a first interruption is only remembered.
pub fn keep_partial_result() {
    KEEPING.store(true, Ordering::SeqCst);
}

/// Whether there was one.
pub fn asked() -> bool {
    ASKED.load(Ordering::Relaxed)
}
