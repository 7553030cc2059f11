//! How the program ends before it is done: signals, and memory that there is not.

use crate::failure::{Failure, Result, tell};
use crate::output::Place;
use std::io;
use std::process::ExitCode;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Exit codes, for `--help`.
pub(crate) const CODES: &str = "\
Exit codes, of several inputs that failed the lowest:
  0    all is done
  1    may succeed later: an input is missing or cannot be opened, there is no ffmpeg, results cannot be
       written, or a fault of the program
  2    wrong use: an option, a parameter, a folder that exists already
  3    bad input, now and later: no images or video, frames of different sizes, fewer than two frames;
       damaged: results hold the frames before
  4    out of memory, or frames too large
  130  interrupted (SIGINT), 143 ended (SIGTERM): what --resume needs stays in DIR.partial";

/// Does the `work` of a program: a signal ends it in order, and what fails is told on standard error, with `events` as one
/// of them.
pub fn conclude(events: bool, work: impl FnOnce() -> Result<()>) -> ExitCode {
    let listening = listen().map_err(|e| Failure::new(format!("signals: {e}")));
    let Err(failure) = listening.and_then(|()| work()) else { return ExitCode::SUCCESS };
    let code = failure.kind as u8;
    if events {
        tell(serde_json::json!({ "event": "error", "code": code, "message": failure.reason }));
    } else {
        tell(format_args!("error: {}", failure.reason));
    }
    ExitCode::from(code)
}

/// The results that are being written.
static OPEN: Mutex<Option<Place>> = Mutex::new(None);

fn lock() -> MutexGuard<'static, Option<Place>> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// What a signal leaves in order until this is dropped.
#[derive(Debug)]
pub(crate) struct Watched;

/// From here on a signal puts these results in order before the program ends.
pub(crate) fn watch(place: &Place) -> Watched {
    *lock() = Some(place.clone());
    Watched
}

impl Drop for Watched {
    fn drop(&mut self) {
        *lock() = None;
    }
}

/// Does `work`, which no signal ends half way.
pub(crate) fn whole<T>(work: impl FnOnce() -> T) -> T {
    let _guard = lock();
    work()
}

/// Has SIGINT and SIGTERM end the program in order, and memory that runs out with a code of its own.
#[cfg(unix)]
fn listen() -> io::Result<()> {
    use signal_hook::consts::{SIGABRT, SIGINT, SIGTERM};
    use std::sync::Arc;
    use std::sync::atomic::{AtomicBool, Ordering};
    // The standard library aborts where memory runs out, after saying so. A panic aborts too, and is a fault of ours.
    let out_of_memory = Arc::new(AtomicBool::new(true));
    signal_hook::flag::register_conditional_shutdown(SIGABRT, 4, Arc::clone(&out_of_memory))?;
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        out_of_memory.store(false, Ordering::SeqCst);
        hook(panic);
    }));
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    std::thread::spawn(move || signals.forever().for_each(end));
    Ok(())
}

#[cfg(not(unix))]
fn listen() -> io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn end(signal: i32) {
    // Held to the end: nothing more is written.
    let open = lock();
    if open.as_ref().is_some_and(Place::give_up) {
        tell("interrupted: --resume goes on after the last window that was finished");
    }
    std::process::exit(128 + signal);
}
