// Messages between the page and its worker. Every request carries an id; its answers carry the same one. Further workers
// help the first: they are introduced once, and then talk with it over a channel of their own (`helpers.ts`).
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

import { type ErrorCode, typeTag } from '../check/errors.js';
import type { StageStep } from '../session/engine.js';
import type { Arguments, RequestName } from '../session/requests.js';
import type { EnlargeTask } from './instance.js';

/** A message of the page, except `abort`. The arguments of a request are on its line in `session/requests.ts`. */
export type Message =
  | { type: 'create'; data: { module: WebAssembly.Module; parameters: Record<string, unknown> } }
  | { type: 'enlarge'; data: EnlargeTask }
  | { type: 'help'; data: { module: WebAssembly.Module; parameters: Record<string, unknown>; port: MessagePort } }
  | { type: 'helper'; data: { number: number; port: MessagePort } }
  | { type: 'lost'; data: { number: number } }
  | { type: 'run'; data?: undefined }
  | { type: 'track'; data?: undefined }
  | { type: RequestName; data: Arguments<RequestName> };
export type Request = { id: number } & (Message | { type: 'abort' });
export type Reply =
  | { id: number; type: 'done'; data: unknown }
  | { id: number; type: 'progress'; data: StageStep }
  | { id: number; type: 'failed'; data: { code: ErrorCode; message: string } };

/** The part of a `MessagePort`, a `Worker` or a worker's global scope that the protocol uses. */
export interface Port {
  postMessage: (message: unknown, transfer: Transferable[]) => void;
  addEventListener: (type: 'message', listener: (event: MessageEvent<Request>) => void) => void;
}

/** Collects the buffers of all typed arrays, images and ports in a tree of plain objects: they are transferred, not copied. */
export function findTransferables(value: unknown): Transferable[] {
  if (value instanceof MessagePort) return [value];
  if (['ImageBitmap', 'VideoFrame'].includes(typeTag(value))) return [value as ImageBitmap];
  if (ArrayBuffer.isView(value)) return value.buffer instanceof ArrayBuffer ? [value.buffer] : [];
  if (typeof value !== 'object' || value === null || value instanceof WebAssembly.Module) return [];
  return Object.values(value).flatMap(findTransferables);
}
