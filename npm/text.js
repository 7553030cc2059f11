// Text to UTF-8 and back. Engines have classes for it, but for some that tests run in, such as jsdom.

/** What the modules that wasm-bindgen made, and exports, ask of both. */
class Plain {
  /** @param {Iterable<number>} [bytes] */
  decode(bytes = []) {
    return decodeURIComponent(escape(String.fromCharCode(...bytes)));
  }

  /** @param {string} text */
  encode(text) {
    return Uint8Array.from(unescape(encodeURIComponent(text)), (letter) => letter.charCodeAt(0));
  }
}

export const Decoder = /** @type {typeof TextDecoder} */ (globalThis.TextDecoder ?? Plain);
export const Encoder = /** @type {typeof TextEncoder} */ (globalThis.TextEncoder ?? Plain);
