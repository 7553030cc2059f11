// What can be asked of a session. The engine in this thread, the engine in a worker, the worker and what results ask later
// are built from one table: a new question is a line in `Requests` and in `REQUESTS`, a method of the wasm session, and one
// of `Session` (and of `Result`) with its description.
//
// A worker gets arguments and gives answers by transfer: their typed arrays must be nobody else's.

import { TraceCutError } from '../check/errors.js';
import { type Pixels, toPixels } from '../worker/decode.js';
import { type RawCorrection, type RawTrajectories, applyCorrection } from './inputs.js';
import type { ImageDiscontinuities } from '../stages/image.js';
import type { Session as WasmSession } from '../tracecut.js';
import type { WindowFacts } from '../video/window.js';
import type { RawFrame } from '../worker/frames.js';
import type {
  FlowField,
  Info,
  RawBackground,
  RawBoundaryMap,
  RawConfidenceMap,
  RawSaliencyMap,
  RawSuperpixels,
} from './engine.js';
import type { Explanation } from './result.js';

/** Where a window lies in its clip. */
export type Place = Pick<WindowFacts, 'index' | 'shot' | 'firstFrame' | 'settled'>;

/** What is done with the wasm module's session. */
export type Work<R> = (session: WasmSession) => R;

/**
 * A request with arguments `A` and answer `R`; `work` says what its arguments mean to the session. With `restarts` the
 * seconds of the stages are counted from here on.
 */
export type Line<A extends unknown[], R> = { work: (...args: A) => Work<R> | Promise<Work<R>>; restarts?: true };

/**
 * A request that results make too: `called` is what they call the answer when they cannot, `from` what must be there,
 * which is also when a session can answer first. `ofLabels` where it speaks of the labels in force, which a correction
 * changes.
 */
export type ResultLine<A extends unknown[], R> = Line<A, R> & {
  called: string;
  from: 'frames' | 'saliency' | 'masks';
  ofLabels?: true;
};

/** Such a request for a map of frame `t`, at the size that frames are processed at. */
export type MapLine<R extends { width: number; height: number }> = ResultLine<[t: number], R>;

export interface Requests {
  push: Line<[frame: RawFrame], Info>;
  /** For clips taken window by window. */
  pushInShot: Line<[frame: RawFrame], Info & { held: boolean }>;
  /** Goes on to the next window. */
  advance: Line<[overlap: number], Info>;
  /** The windows' size, and what neighbours share. */
  planWindows: Line<[window: number, overlap: number | undefined], Info>;
  /** How many frames the next window shares; `left` are still to come. */
  shared: Line<[left: number | undefined], number>;
  /** `kept` are shared with the next of its shot. */
  closeWindow: Line<[frames: number, kept: number | undefined], Place>;
  setTrajectories: Line<[trajectories: RawTrajectories], Info>;
  /** Decides; `run` then does what follows. */
  correct: Line<[correction: RawCorrection], Info>;
  clear: Line<[], Info>;

  flow: Line<[t: number], FlowField>;
  boundaries: MapLine<RawBoundaryMap>;
  superpixels: MapLine<RawSuperpixels>;
  background: MapLine<RawBackground>;
  explain: ResultLine<[t: number, x: number, y: number], Explanation>;
  confidence: MapLine<RawConfidenceMap>;
  objectConfidence: ResultLine<[], Float32Array<ArrayBuffer>>;
  saliencyMap: MapLine<RawSaliencyMap>;

  /** Of an image of its own, as those below. */
  boundariesOf: Line<[image: RawFrame], RawBoundaryMap>;
  superpixelsOf: Line<[image: RawFrame, count?: number], RawSuperpixels>;
  flowOf: Line<[from: RawFrame, to: RawFrame], FlowField>;
  discontinuitiesOf: Line<[image: RawFrame], ImageDiscontinuities>;
}

export const REQUESTS: Requests = {
  push: {
    work: withPixels((frame) => order((session) => session.pushRgba(frame.data, frame.width, frame.height))),
  },
  pushInShot: {
    work: withPixels((frame) => (session) => {
      const held = session.pushInShot(frame.data, frame.width, frame.height);
      return { ...session.info(), held };
    }),
  },
  advance: { restarts: true, work: (overlap) => order((session) => session.advance(overlap)) },
  planWindows: { work: (window, overlap) => order((session) => session.planWindows(window, overlap)) },
  shared: { work: (left) => (session) => session.shared(left) },
  closeWindow: {
    work: (frames, kept) => (session) => {
      const place = session.closeWindow(frames, kept);
      const [index, shot, firstFrame, from, to] = [...place] as [number, number, number, number, number];
      return { index, shot, firstFrame, settled: { from, to } };
    },
  },
  setTrajectories: {
    work: ({ numFrames, width, height, startFrame, offset, x, y }) =>
      order((session) => session.setTrajectories(numFrames, width, height, startFrame, offset, x, y)),
  },
  correct: { work: (correction) => order((session) => applyCorrection(session, correction)) },
  clear: { restarts: true, work: () => order((session) => session.clear()) },

  flow: { work: (t) => (session) => session.flow(t) },
  boundaries: { called: 'boundaries', from: 'frames', work: (t) => (session) => session.boundaries(t) },
  superpixels: { called: 'superpixels', from: 'masks', work: (t) => (session) => session.superpixels(t) },
  background: { called: 'backgrounds', from: 'masks', work: (t) => (session) => session.background(t) },
  explain: {
    called: 'explanations',
    from: 'masks',
    ofLabels: true,
    work: (t, x, y) => (session) => session.explain(t, x, y),
  },
  confidence: { called: 'confidences', from: 'masks', ofLabels: true, work: (t) => (session) => session.confidence(t) },
  objectConfidence: {
    called: 'confidences',
    from: 'masks',
    ofLabels: true,
    work: () => (session) => session.objectConfidence() as Float32Array<ArrayBuffer>,
  },
  saliencyMap: { called: 'saliency maps', from: 'saliency', work: (t) => (session) => session.saliencyMap(t) },

  boundariesOf: {
    work: withPixels((image) => (session) => session.boundariesOf(image.data, image.width, image.height)),
  },
  superpixelsOf: {
    work: withPixels(
      (image, count?: number) => (session) => session.superpixelsOf(image.data, image.width, image.height, count),
    ),
  },
  flowOf: {
    work: async (from, to) => {
      const [first, second] = [await toPixels(from), await toPixels(to)];
      const [{ width, height }, size] = [first, `${second.width} × ${second.height}`];
      if (size !== `${width} × ${height}`)
        throw new TraceCutError('frame-size-changed', `the second image is ${size} (expected ${width} × ${height})`);
      return (session) => session.flowOf(first.data, second.data, width, height);
    },
  },
  discontinuitiesOf: {
    work: withPixels((image) => (session) => session.discontinuitiesOf(image.data, image.width, image.height)),
  },
};

/** The work of a request whose first argument is a frame: files are decoded before the session sees them. */
function withPixels<A extends unknown[], R>(
  work: (pixels: Pixels, ...rest: A) => Work<R>,
): (frame: RawFrame, ...rest: A) => Promise<Work<R>> {
  return async (frame, ...rest) => work(await toPixels(frame), ...rest);
}

/** Work that changes the session; the answer is what it holds then. */
function order(change: Work<void>): Work<Info> {
  return (session) => {
    change(session);
    return session.info();
  };
}

export type RequestName = keyof Requests;
export type ResultName = { [N in RequestName]: Requests[N] extends { called: string } ? N : never }[RequestName];
export type MapName = { [N in ResultName]: Requests[N] extends MapLine<infer _> ? N : never }[ResultName];
export type Arguments<N extends RequestName> = Parameters<Requests[N]['work']>;
export type Answer<N extends RequestName> = ReturnType<Awaited<ReturnType<Requests[N]['work']>>>;

/** How results ask. */
export type Ask = <N extends ResultName>(name: N, ...args: Arguments<N>) => Promise<Answer<N>>;

/** The line of a request. */
export function lineOf<N extends RequestName>(name: N): Line<Arguments<N>, Answer<N>> {
  return REQUESTS[name] as Line<Arguments<N>, Answer<N>>;
}
