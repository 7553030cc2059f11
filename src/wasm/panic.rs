//! Keeps the words of a panic, so that JavaScript can say more than "unreachable executed", and shows them in the
//! console.

use std::sync::Mutex;

static MESSAGE: Mutex<Option<String>> = Mutex::new(None);

/// From now on a panic leaves its text and place in [`message`].
pub(super) fn install_hook() {
    std::panic::set_hook(Box::new(|info| {
        let words = info.to_string();
        web_sys::console::error_1(&words.as_str().into());
        if let Ok(mut message) = MESSAGE.lock() {
            *message = Some(words);
        }
    }));
}

/// The text of the last panic.
pub(super) fn message() -> Option<String> {
    MESSAGE.lock().ok().and_then(|message| message.clone())
}
