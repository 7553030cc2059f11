// What the page and its worker say to each other. Every request carries an id; its answers carry the same one.
//
//   page                                     worker
//   {id, type: 'create', data}        ->
//                                     <-     {id, type: 'done', data}
//   {id, type: 'run'}                 ->
//                                     <-     {id, type: 'progress', data}   (any number)
//   {id, type: 'abort'}               ->                                    (id of the run; has no answer of its own)
//                                     <-     {id, type: 'done', data: null}
//   {id, type: 'push', data}          ->
//                                     <-     {id, type: 'failed', data: {code, message}}

/**
 * @typedef {'create' | 'push' | 'pushInShot' | 'advance' | 'setTrajectories' | 'correct' | 'run' | 'abort' | 'flow' | 'boundaries'
 *   | 'superpixels' | 'saliencyMap' | 'boundariesOf' | 'superpixelsOf' | 'discontinuitiesOf' | 'clear'} RequestType
 */
/** @typedef {{id: number, type: RequestType, data?: any}} Request */
/** @typedef {{id: number, type: 'done' | 'progress' | 'failed', data: any}} Reply */

/**
 * The part of a `MessagePort`, a `Worker` or a worker's global scope that the protocol uses.
 * @typedef {object} Port
 * @property {(message: any, transfer: Transferable[]) => void} postMessage
 * @property {(type: 'message', listener: (event: MessageEvent) => void) => void} addEventListener
 */

/**
 * The buffers of all typed arrays in a tree of plain objects: what to transfer rather than copy.
 * @param {unknown} value
 * @returns {ArrayBuffer[]}
 */
export function transferables(value) {
  if (ArrayBuffer.isView(value)) return value.buffer instanceof ArrayBuffer ? [value.buffer] : [];
  if (typeof value !== 'object' || value === null || value instanceof WebAssembly.Module) return [];
  return Object.values(value).flatMap(transferables);
}
