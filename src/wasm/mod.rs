//! The JavaScript interface: a thin newtype over [`Session`](crate::Session).
//!
//! Every method converts, makes one call of the core, and converts back; defaults, stepping, cancelling and the choice
//! of worker or main thread belong to `npm`. Arrays come out as copies, never as views of wasm memory: memory that
//! grows detaches views. Nothing here decodes image files, so that the decoders stay out of this wasm file; the package in
//! `decoder/` makes another one of them.

mod convert;
mod image;
mod session;

pub use image::JsScene;
pub use session::JsSession;

use crate::Params;
use crate::session::Window;
use serde::Serialize;
use std::sync::Mutex;
use wasm_bindgen::prelude::*;

/// Runs once when the module is instantiated.
#[wasm_bindgen(start)]
fn start() {
    install_panic_hook();
}

/// Returns the version of the crate and of the package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// Returns the message of the last panic; `undefined` if there was none.
#[wasm_bindgen(js_name = panicMessage)]
pub fn panic_message() -> Option<String> {
    PANIC_MESSAGE.lock().ok().and_then(|message| message.clone())
}

/// Returns the default and the largest number of frames of a window, and the default overlap.
#[wasm_bindgen]
pub fn windows() -> Vec<usize> {
    vec![Window::FRAMES, Window::MAX_FRAMES, Window::overlap(Window::FRAMES)]
}

/// One parameter, without its description, which the build reads from the declaration.
#[derive(Serialize)]
struct Parameter {
    name: String,
    kind: &'static str,
    min: f64,
    max: f64,
    default: f64,
    expert: bool,
    choices: &'static [&'static str],
}

/// Returns all parameters in their order of declaration: `{name, kind, min, max, default, expert, choices}`; truth values
/// read as 0 or 1, choices as their place among `choices`.
#[wasm_bindgen]
pub fn parameters() -> Result<JsValue, JsValue> {
    let mut list = Vec::new();
    Params::default().for_each(&mut |field| {
        let (min, max, expert) = (field.min, field.max, field.expert);
        let (kind, default, choices) = (field.kind(), field.get(), field.choices());
        list.push(Parameter { name: field.name, kind, min, max, default, expert, choices });
    });
    convert::to_js(&list)
}

/// The message of the last panic, which JavaScript reports instead of "unreachable executed".
static PANIC_MESSAGE: Mutex<Option<String>> = Mutex::new(None);

/// Installs a hook that stores the message of a panic, and logs it to the console.
fn install_panic_hook() {
    std::panic::set_hook(Box::new(|info| {
        let message = info.to_string();
        web_sys::console::error_1(&message.as_str().into());
        if let Ok(mut last_message) = PANIC_MESSAGE.lock() {
            *last_message = Some(message);
        }
    }));
}
