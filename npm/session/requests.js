// What can be asked of a session, a line for each request. The engine in this thread, the engine in a worker, the worker
// and what results ask later are built from this table: a new question is a line here, a method of the wasm session, and
// one of `Session` (and of `Result`) with its description.
//
// A worker gets arguments and gives answers by transfer: their typed arrays must be nobody else's.

import { TraceCutError } from '../check/errors.js';
import { toPixels } from '../worker/decode.js';
import { applyCorrection } from './inputs.js';

/** @typedef {import('./engine.js').Info} Info */
/** @typedef {import('../worker/frames.js').RawFrame} RawFrame */
/** @typedef {import('../tracecut.js').Session} WasmSession */
/** Where a window lies in its clip. @typedef {Pick<import('../video/window.js').WindowFacts, 'index' | 'shot' | 'firstFrame' | 'settled'>} Place */

/**
 * What is done with the wasm module's session.
 * @template R
 * @typedef {(session: WasmSession) => R} Work
 */

/**
 * A request with arguments `A` and answer `R`; `work` says what its arguments mean to the session. With `restarts` the
 * seconds of the stages are counted from here on.
 * @template {unknown[]} A
 * @template R
 * @typedef {{work: (...args: A) => Work<R> | Promise<Work<R>>, restarts?: true}} Line
 */

/**
 * A request that results make too: `called` is what they call the answer when they cannot, `from` what must be there,
 * which is also when a session can answer first. `ofLabels` where it speaks of the labels in force, which a correction
 * changes.
 * @template {unknown[]} A
 * @template R
 * @typedef {Line<A, R> & {called: string, from: 'frames' | 'saliency' | 'masks', ofLabels?: true}} ResultLine
 */

/**
 * Such a request for a map of frame `t`, at the size that frames are processed at.
 * @template {{width: number, height: number}} R
 * @typedef {ResultLine<[t: number], R>} MapLine
 */

export const REQUESTS = {
  /** @type {Line<[frame: RawFrame], Info>} */
  push: {
    work: withPixels((frame) => order((session) => session.pushRgba(frame.data, frame.width, frame.height))),
  },
  /** @type {Line<[frame: RawFrame], Info & {held: boolean}>} for clips taken window by window */
  pushInShot: {
    work: withPixels((frame) => (session) => {
      const held = session.pushInShot(frame.data, frame.width, frame.height);
      return { ...session.info(), held };
    }),
  },
  /** @type {Line<[overlap: number], Info>} goes on to the next window */
  advance: { restarts: true, work: (overlap) => order((session) => session.advance(overlap)) },
  /** @type {Line<[window: number, overlap: number | undefined], Info>} the windows' size, and what neighbours share */
  planWindows: { work: (window, overlap) => order((session) => session.planWindows(window, overlap)) },
  /** @type {Line<[left: number | undefined], number>} how many frames the next window shares; `left` are still to come */
  shared: { work: (left) => (session) => session.shared(left) },
  /** @type {Line<[frames: number, kept: number | undefined], Place>} `kept` are shared with the next of its shot */
  closeWindow: {
    work: (frames, kept) => (session) => {
      const place = session.closeWindow(frames, kept);
      const [index, shot, firstFrame, from, to] = /** @type {[number, number, number, number, number]} */ ([...place]);
      return { index, shot, firstFrame, settled: { from, to } };
    },
  },
  /** @type {Line<[trajectories: import('./inputs.js').RawTrajectories], Info>} */
  setTrajectories: {
    work: ({ numFrames, width, height, startFrame, offset, x, y }) =>
      order((session) => session.setTrajectories(numFrames, width, height, startFrame, offset, x, y)),
  },
  /** @type {Line<[correction: import('./inputs.js').RawCorrection], Info>} decides; `run` then does what follows */
  correct: { work: (correction) => order((session) => applyCorrection(session, correction)) },
  /** @type {Line<[], Info>} */
  clear: { restarts: true, work: () => order((session) => session.clear()) },

  /** @type {Line<[t: number], import('./engine.js').FlowField>} */
  flow: { work: (t) => (session) => session.flow(t) },
  /** @type {MapLine<import('./engine.js').RawBoundaryMap>} */
  boundaries: { called: 'boundaries', from: 'frames', work: (t) => (session) => session.boundaries(t) },
  /** @type {MapLine<import('./engine.js').RawSuperpixels>} */
  superpixels: { called: 'superpixels', from: 'masks', work: (t) => (session) => session.superpixels(t) },
  /** @type {MapLine<import('./engine.js').RawBackground>} */
  background: { called: 'backgrounds', from: 'masks', work: (t) => (session) => session.background(t) },
  /** @type {ResultLine<[t: number, x: number, y: number], import('./result.js').Explanation>} */
  explain: {
    called: 'explanations',
    from: 'masks',
    ofLabels: true,
    work: (t, x, y) => (session) => session.explain(t, x, y),
  },
  /** @type {MapLine<import('./engine.js').RawConfidenceMap>} */
  confidence: { called: 'confidences', from: 'masks', ofLabels: true, work: (t) => (session) => session.confidence(t) },
  /** @type {ResultLine<[], Float32Array<ArrayBuffer>>} */
  objectConfidence: {
    called: 'confidences',
    from: 'masks',
    ofLabels: true,
    work: () => (session) => /** @type {Float32Array<ArrayBuffer>} */ (session.objectConfidence()),
  },
  /** @type {MapLine<import('./engine.js').RawSaliencyMap>} */
  saliencyMap: { called: 'saliency maps', from: 'saliency', work: (t) => (session) => session.saliencyMap(t) },

  /** @type {Line<[image: RawFrame], import('./engine.js').RawBoundaryMap>} of an image of its own, as those below */
  boundariesOf: {
    work: withPixels((image) => (session) => session.boundariesOf(image.data, image.width, image.height)),
  },
  /** @type {Line<[image: RawFrame, count?: number], import('./engine.js').RawSuperpixels>} */
  superpixelsOf: {
    work: withPixels(
      (image, /** @type {number | undefined} */ count) => (session) =>
        session.superpixelsOf(image.data, image.width, image.height, count),
    ),
  },
  /** @type {Line<[from: RawFrame, to: RawFrame], import('./engine.js').FlowField>} */
  flowOf: {
    work: async (from, to) => {
      const [first, second] = [await toPixels(from), await toPixels(to)];
      const [{ width, height }, size] = [first, `${second.width} × ${second.height}`];
      if (size !== `${width} × ${height}`)
        throw new TraceCutError('frame-size-changed', `the second image is ${size} (expected ${width} × ${height})`);
      return (session) => session.flowOf(first.data, second.data, width, height);
    },
  },
  /** @type {Line<[image: RawFrame], import('../stages/image.js').ImageDiscontinuities>} */
  discontinuitiesOf: {
    work: withPixels((image) => (session) => session.discontinuitiesOf(image.data, image.width, image.height)),
  },
};

/**
 * The work of a request whose first argument is a frame: files are decoded before the session sees them.
 * @template {unknown[]} A
 * @template R
 * @param {(pixels: import('../worker/decode.js').Pixels, ...rest: A) => Work<R>} work
 * @returns {(frame: RawFrame, ...rest: A) => Promise<Work<R>>}
 */
function withPixels(work) {
  return async (frame, ...rest) => work(await toPixels(frame), ...rest);
}

/**
 * Work that changes the session; the answer is what it holds then.
 * @param {Work<void>} change
 * @returns {Work<Info>}
 */
function order(change) {
  return (session) => {
    change(session);
    return session.info();
  };
}

/** @typedef {typeof REQUESTS} Requests */
/** @typedef {keyof Requests} RequestName */
/** @typedef {{[N in RequestName]: Requests[N] extends {called: string} ? N : never}[RequestName]} ResultName */
/** @typedef {{[N in ResultName]: Requests[N] extends MapLine<infer _> ? N : never}[ResultName]} MapName */
/**
 * @template {RequestName} N
 * @typedef {Parameters<Requests[N]['work']>} Arguments
 */
/**
 * @template {RequestName} N
 * @typedef {ReturnType<Awaited<ReturnType<Requests[N]['work']>>>} Answer
 */

/**
 * How results ask.
 * @typedef {<N extends ResultName>(name: N, ...args: Arguments<N>) => Promise<Answer<N>>} Ask
 */

/**
 * The line of a request.
 * @template {RequestName} N
 * @param {N} name
 * @returns {Line<Arguments<N>, Answer<N>>}
 */
export function lineOf(name) {
  return /** @type {Line<Arguments<N>, Answer<N>>} */ (/** @type {unknown} */ (REQUESTS[name]));
}
