//! The end of the program: exit codes, signals and lack of memory.

use crate::failure::{Failure, Result, print_error};
use crate::output::OutputFolder;
use std::io;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Exit codes, for `--help`.
pub(crate) const CODES: &str = "\
Exit codes, of several inputs that failed the lowest:
  0    success
  1    may succeed later: an input is missing or cannot be opened, there is no ffmpeg, results cannot be
       written, or a fault of the program
  2    wrong use: an option, a parameter, a folder that exists already
  3    bad input, now and later: no images or video, frames of different sizes, fewer than two frames;
       damaged: results end before the damage
  4    out of memory, or frames too large
  130  interrupted (SIGINT), 143 ended (SIGTERM): what --resume needs stays in DIR.partial";

/// Runs the program until it ends or a signal cleanly ends it. Prints a failure on standard error, as an event if `events` is set.
pub fn conclude(events: bool, work: impl FnOnce() -> Result<()>) -> u8 {
    let handlers = install_handlers().map_err(|e| Failure::new(format!("signals: {e}")));
    let Err(failure) = handlers.and_then(|()| work()) else { return 0 };
    let code = failure.kind as u8;
    if events {
        print_error(serde_json::json!({ "event": "error", "code": code, "message": failure.reason }));
    } else {
        print_error(format_args!("error: {}", failure.reason));
    }
    code
}

/// The folder whose results are being written.
static OPEN: Mutex<Option<OutputFolder>> = Mutex::new(None);

fn lock() -> MutexGuard<'static, Option<OutputFolder>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Until this is dropped, a signal cleans up the results first.
#[derive(Debug)]
pub(crate) struct CleanupGuard;

/// Makes signals clean up these results before the program ends.
pub(crate) fn clean_up_on_signal(place: &OutputFolder) -> CleanupGuard {
    *lock() = Some(place.clone());
    CleanupGuard
}

impl Drop for CleanupGuard {
    fn drop(&mut self) {
        *lock() = None;
    }
}

/// Runs `work` without interruption by a signal.
pub(crate) fn uninterrupted<T>(work: impl FnOnce() -> T) -> T {
    let _guard = lock();
    work()
}

/// Installs handlers: SIGINT and SIGTERM end the program cleanly, and lack of memory has an exit code of its own.
#[cfg(unix)]
fn install_handlers() -> io::Result<()> {
    use signal_hook::consts::{SIGABRT, SIGINT, SIGTERM};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    // The standard library aborts with a message if memory runs out. A panic also aborts, but is a fault of the program.
    let out_of_memory = Arc::new(AtomicBool::new(true));
    signal_hook::flag::register_conditional_shutdown(SIGABRT, 4, Arc::clone(&out_of_memory))?;
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        out_of_memory.store(false, Ordering::SeqCst);
        hook(panic);
    }));
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    std::thread::spawn(move || signals.forever().for_each(end_on_signal));
    Ok(())
}

#[cfg(not(unix))]
fn install_handlers() -> io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn end_on_signal(signal: i32) {
    // Held until exit, so that nothing more is written.
    let open = lock();
    if open.as_ref().is_some_and(OutputFolder::give_up) {
        print_error("interrupted: --resume continues after the last finished window");
    }
    std::process::exit(128 + signal);
}
