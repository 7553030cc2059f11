// Further workers help the first: they are told once, and then talk with it over a channel of their own (`helpers.js`).
//
// What the page and its worker say to each other. Every request carries an id; its answers carry the same one.
//
//   page                                     worker
//   {id, type: 'create', data}        ->
//                                     <-     {id, type: 'done', data}
//   {id, type: 'run'}                 ->                                    (or 'track': no further than trajectories)
//                                     <-     {id, type: 'progress', data}   (any number)
//   {id, type: 'abort'}               ->                                    (id of the run; has no answer of its own)
//                                     <-     {id, type: 'done', data: null}
//   {id, type: 'push', data: [frame]} ->
//                                     <-     {id, type: 'failed', data: {code, message}}

import { typeTag } from '../check/errors.js';

/** @typedef {import('../session/requests.js').RequestName} RequestName */

/**
 * What the page asks, beside `abort`. The arguments of a request are those of its line in `session/requests.js`.
 * @typedef {{type: 'create', data: {module: WebAssembly.Module, parameters: Record<string, unknown>}}
 *   | {type: 'enlarge', data: import('./decode.js').EnlargeTask}
 *   | {type: 'help', data: {module: WebAssembly.Module, parameters: Record<string, unknown>, port: MessagePort}}
 *   | {type: 'helper', data: {number: number, port: MessagePort}}
 *   | {type: 'lost', data: {number: number}}
 *   | {type: 'run', data?: undefined}
 *   | {type: 'track', data?: undefined}
 *   | {type: RequestName, data: import('../session/requests.js').Arguments<RequestName>}} Message
 */
/** @typedef {{id: number} & (Message | {type: 'abort'})} Request */
/**
 * @typedef {{id: number, type: 'done', data: unknown}
 *   | {id: number, type: 'progress', data: import('../session/engine.js').Progress}
 *   | {id: number, type: 'failed', data: {code: import('../check/errors.js').ErrorCode, message: string}}} Reply
 */

/**
 * The part of a `MessagePort`, a `Worker` or a worker's global scope that the protocol uses.
 * @typedef {object} Port
 * @property {(message: unknown, transfer: Transferable[]) => void} postMessage
 * @property {(type: 'message', listener: (event: MessageEvent<Request>) => void) => void} addEventListener
 */

/**
 * The buffers of all typed arrays in a tree of plain objects, images and ports: what to transfer rather than copy.
 * @param {unknown} value
 * @returns {Transferable[]}
 */
export function transferables(value) {
  if (value instanceof MessagePort) return [value];
  if (['ImageBitmap', 'VideoFrame'].includes(typeTag(value))) return [/** @type {ImageBitmap} */ (value)];
  if (ArrayBuffer.isView(value)) return value.buffer instanceof ArrayBuffer ? [value.buffer] : [];
  if (typeof value !== 'object' || value === null || value instanceof WebAssembly.Module) return [];
  return Object.values(value).flatMap(transferables);
}
