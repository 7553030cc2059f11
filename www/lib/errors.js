// The one error of the package, and what its messages are put together from.

/**
 * What a {@link TraceCutError} is about. From Rust: `frame-size`, `frame-bytes`, `frame-size-changed`,
 * `too-few-frames`, `too-large` (more than a parameter such as `clip.maxPixels` allows), `decode`, `param`, `data`,
 * `state`. From this layer: `unsupported` (the engine lacks something), `wasm-load` (the wasm file cannot be fetched or
 * compiled), `memory` (there is not enough of it; the session has given back its own), `poisoned` (the engine stopped on
 * an internal error), `closed`, `busy`. Of videos: `no-video` (nothing in it that could be shown), `codec` (it cannot be decoded here),
 * `truncated` (cut off or damaged), `no-frames` (none in the range), `fetch` (the address cannot be fetched).
 * @typedef {'frame-size' | 'frame-bytes' | 'frame-size-changed' | 'too-few-frames' | 'too-large' | 'decode' | 'param'
 *   | 'data' | 'state' | 'unsupported' | 'wasm-load' | 'memory' | 'poisoned' | 'closed' | 'busy' | 'no-video' | 'codec' | 'truncated'
 *   | 'no-frames' | 'fetch'} ErrorCode
 */

/** An error with a stable `code` and a message that names the value and what is legal. */
export class TraceCutError extends Error {
  /**
   * @param {ErrorCode} code
   * @param {string} message
   * @param {{cause?: unknown}} [options]
   */
  constructor(code, message, options) {
    super(message, options);
    this.name = 'TraceCutError';
    /**
     * What it is about; the message may change, this does not.
     * @type {ErrorCode}
     */
    this.code = code;
  }
}

/**
 * The error of a value that is not legal.
 * @param {ErrorCode} code
 * @param {string} name
 * @param {unknown} value
 * @param {string} expected
 */
export function illegal(code, name, value, expected) {
  return new TraceCutError(code, `${name} = ${describe(value)} (expected ${expected})`);
}

/**
 * The error of what is larger than a parameter allows, in the words that Rust has for it.
 * @param {number} actual
 * @param {string} what
 * @param {number} limit
 * @param {string} name
 */
export function tooLarge(actual, what, limit, name) {
  return new TraceCutError(
    'too-large',
    `${actual} ${what} (expected at most ${limit}; the parameter ${name} sets this limit)`,
  );
}

/**
 * A value in a few words.
 * @param {unknown} value
 * @returns {string}
 */
export function describe(value) {
  if (typeof value === 'string') return value.length > 40 ? `"${value.slice(0, 40)}..."` : `"${value}"`;
  if (typeof value === 'function') return 'a function';
  if (Array.isArray(value)) return `a list of ${value.length}`;
  if (ArrayBuffer.isView(value)) return `${typeTag(value)} of ${value.byteLength} bytes`;
  if (typeof value === 'object' && value !== null) {
    const tag = typeTag(value);
    return `${/^[AEIOU]/.test(tag) ? 'an' : 'a'} ${tag}`;
  }
  return String(value);
}

/**
 * The built-in type's name, also for objects of another realm: `Uint8Array`, `VideoFrame`, `Object`...
 * @param {unknown} value
 */
export function typeTag(value) {
  return Object.prototype.toString.call(value).slice(8, -1);
}

/**
 * An error that says which frame it is about, where that is known.
 * @param {unknown} error
 * @param {{kind?: string, index?: number, name?: string}} frame
 */
export function inFrame(error, { index, name }) {
  if (!(error instanceof TraceCutError) || (index ?? name) === undefined) return error;
  const words = index === undefined ? name : `frame ${index}${name ? ` (${name})` : ''}`;
  return new TraceCutError(error.code, `${words}: ${error.message}`, { cause: error });
}
