// Text to UTF-8 and back. Engines have classes for it, but for some that tests run in, such as jsdom.

/** What the modules that wasm-bindgen made, and exports, ask of both. */
class Plain {
  decode(bytes: Iterable<number> = []) {
    return decodeURIComponent(escape(String.fromCharCode(...bytes)));
  }

  encode(text: string) {
    return Uint8Array.from(unescape(encodeURIComponent(text)), (letter) => letter.charCodeAt(0));
  }
}

export const Decoder = globalThis.TextDecoder ?? Plain;
export const Encoder = globalThis.TextEncoder ?? Plain;
