//! Keeps the message of a panic, so that JavaScript can report more than "unreachable executed", and logs it to the console.

use std::sync::Mutex;

static MESSAGE: Mutex<Option<String>> = Mutex::new(None);

/// Installs a hook that stores the message of a panic for [`message`].
pub(super) fn install_hook() {
    std::panic::set_hook(Box::new(|info| {
        let message = info.to_string();
        web_sys::console::error_1(&message.as_str().into());
        if let Ok(mut last_message) = MESSAGE.lock() {
            *last_message = Some(message);
        }
    }));
}

/// Returns the message of the last panic.
pub(super) fn message() -> Option<String> {
    MESSAGE.lock().ok().and_then(|message| message.clone())
}
