// UTF-8 encoding and decoding. Most engines have classes for it, but not some that tests run in, such as jsdom.

/** The methods that wasm-bindgen's modules and exports use. */
class Utf8Codec {
  decode(bytes: Iterable<number> = []) {
    return decodeURIComponent(escape(String.fromCharCode(...bytes)));
  }

  encode(text: string) {
    return Uint8Array.from(unescape(encodeURIComponent(text)), (letter) => letter.charCodeAt(0));
  }
}

export const Decoder = globalThis.TextDecoder ?? Utf8Codec;
export const Encoder = globalThis.TextEncoder ?? Utf8Codec;
