// Compiles the wasm file, from wherever it is.

import { TraceCutError, illegal, typeTag } from './errors.js';

/** The smallest module with a SIMD instruction in it. */
const SIMD_PROBE = [
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
];

/**
 * Compiles the wasm module from wherever it is.
 * @param {import('./options.js').WasmSource} source
 * @param {string} [hint] what to do where it is not found
 * @returns {Promise<WebAssembly.Module>}
 */
export async function loadModule(source, hint = '') {
  if (typeof WebAssembly === 'undefined')
    throw new TraceCutError('unsupported', 'this JavaScript engine has no WebAssembly');
  if (source instanceof WebAssembly.Module || typeTag(source) === 'WebAssembly.Module')
    return /** @type {WebAssembly.Module} */ (source);
  if (typeof source === 'string' || source instanceof URL)
    return fromResponse(await fetched(source, hint), String(source), hint);
  if (typeTag(source) === 'Response') return fromResponse(/** @type {Response} */ (source), 'the response');
  if (typeTag(source) === 'ArrayBuffer' || ArrayBuffer.isView(source))
    return compile(/** @type {BufferSource} */ (source), 'the bytes given');
  throw illegal('param', 'wasm', source, 'a URL, a Response, bytes or a WebAssembly.Module');
}

/**
 * @param {string | URL} url
 * @param {string} hint
 */
async function fetched(url, hint) {
  try {
    return await fetch(url);
  } catch (cause) {
    throw new TraceCutError('wasm-load', advised(`${url} could not be fetched: ${words(cause)}`, hint), { cause });
  }
}

/**
 * @param {Response} response
 * @param {string} name
 * @param {string} [hint]
 */
async function fromResponse(response, name, hint = '') {
  if (!response.ok) {
    const words = `${name} could not be fetched: the server answered ${response.status}`;
    throw new TraceCutError('wasm-load', advised(words, hint));
  }
  /** @type {Response | undefined} */
  let spare;
  if (response.headers.get('Content-Type') === 'application/wasm' && !response.bodyUsed) {
    spare = response.clone();
    try {
      return await WebAssembly.compileStreaming(response);
    } catch {
      // Compiled from its bytes, which says what is wrong.
    }
  }
  return compile(await bodyOf(spare ?? response, name, hint), name, hint);
}

/**
 * The bytes of an answer, unless the network goes while they come.
 * @param {Response} response
 * @param {string} name
 * @param {string} hint
 */
async function bodyOf(response, name, hint) {
  try {
    return await response.arrayBuffer();
  } catch (cause) {
    const said = `${name} came only in part: ${words(cause)}. Try again`;
    throw new TraceCutError('wasm-load', advised(said, hint), { cause });
  }
}

/**
 * @param {BufferSource} bytes
 * @param {string} name
 * @param {string} [hint]
 */
async function compile(bytes, name, hint = '') {
  const view = ArrayBuffer.isView(bytes)
    ? new Uint8Array(bytes.buffer, bytes.byteOffset, bytes.byteLength)
    : new Uint8Array(bytes);
  if (view[0] === 0x3c) {
    const check =
      "check that the .wasm file is where the URL says (with Vite before 8, set optimizeDeps.exclude to ['tracecut'])";
    throw new TraceCutError('wasm-load', advised(`${name} is a page of HTML, not WebAssembly: ${check}`, hint));
  }
  if (!WebAssembly.validate(new Uint8Array(SIMD_PROBE))) {
    throw new TraceCutError(
      'unsupported',
      'this JavaScript engine has no WebAssembly SIMD (needs Chrome 91, Firefox 89, Safari 16.4 or Node 18)',
    );
  }
  try {
    return await WebAssembly.compile(bytes);
  } catch (cause) {
    throw new TraceCutError('wasm-load', `${name} could not be compiled: ${words(cause)}`, { cause });
  }
}

/**
 * @param {string} words
 * @param {string} hint
 */
function advised(words, hint) {
  return hint ? `${words}. ${hint}` : words;
}

/** @param {unknown} error */
function words(error) {
  return error instanceof Error ? error.message : String(error);
}
