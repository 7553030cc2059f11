// The requests of a session. The engine in this thread, the engine in a worker, the worker and later requests of results
// are built from one table: a new request is a line in `Requests` and in `REQUESTS`, a method of the wasm session, and one
// of `Session` (and of `Result`) with its description.
//
// Arguments and answers are transferred to and from a worker, so their typed arrays must not be shared.

import { TraceCutError } from '../check/errors.js';
import { type Pixels, toPixels } from '../worker/decode.js';
import { type RawCorrection, type RawTrajectories, applyCorrection } from './inputs.js';
import type { ImageDiscontinuities } from '../stages/image.js';
import type { Session as WasmSession } from '../tracecut.js';
import type { WindowFacts } from '../video/window.js';
import type { RawFrame } from '../worker/frames.js';
import type {
  FlowField,
  RawBackground,
  RawBoundaryMap,
  RawSaliencyMap,
  RawSuperpixels,
  SessionInfo,
} from './engine.js';
import type { Agreement, Explanation } from './result.js';

/** Place of a window in its clip. */
export type WindowPlace = Pick<WindowFacts, 'index' | 'shot' | 'firstFrame' | 'settled'>;

/** A call of the wasm module's session. */
export type SessionCall<R> = (session: WasmSession) => R;

/**
 * A request with arguments `A` and answer `R`; `work` converts the arguments to a call of the session. `restarts` resets
 * the seconds of the stages.
 */
export type RequestSpec<A extends unknown[], R> = {
  work: (...args: A) => SessionCall<R> | Promise<SessionCall<R>>;
  restarts?: true;
};

/**
 * A request that results make too: `noun` names the answer in errors, `needs` is the output that it needs, and the
 * earliest time at which a session can answer. `byLabels` marks answers about the present labels, which a correction
 * changes.
 */
export type ResultRequestSpec<A extends unknown[], R> = RequestSpec<A, R> & {
  noun: string;
  needs: 'frames' | 'saliency' | 'masks';
  byLabels?: true;
};

/** A request of results for a map of frame `t`, at the working size. */
export type MapRequestSpec<R extends { width: number; height: number }> = ResultRequestSpec<[t: number], R>;

export interface Requests {
  push: RequestSpec<[frame: RawFrame], SessionInfo>;
  /** Adds a frame of a clip that is processed window by window. */
  pushInShot: RequestSpec<[frame: RawFrame], SessionInfo & { held: boolean }>;
  /** Continues with the next window. */
  advance: RequestSpec<[overlap: number], SessionInfo>;
  /** Sets the size of windows, and the number of frames that neighbours share. */
  planWindows: RequestSpec<[window: number, overlap: number | undefined], SessionInfo>;
  /** Returns the number of frames that the next window shares; `remaining` are still to come. */
  shared: RequestSpec<[remaining: number | undefined], number>;
  /** Ends a window, of which `overlap` frames are shared with the next one of its shot. */
  closeWindow: RequestSpec<[frames: number, overlap: number | undefined], WindowPlace>;
  setTrajectories: RequestSpec<[trajectories: RawTrajectories], SessionInfo>;
  /** Registers a correction; `run` then applies it. */
  correct: RequestSpec<[correction: RawCorrection], SessionInfo>;
  clear: RequestSpec<[], SessionInfo>;

  flow: RequestSpec<[t: number], FlowField>;
  boundaries: MapRequestSpec<RawBoundaryMap>;
  superpixels: MapRequestSpec<RawSuperpixels>;
  background: MapRequestSpec<RawBackground>;
  explain: ResultRequestSpec<[t: number, x: number, y: number], Explanation>;
  agreement: ResultRequestSpec<[], Agreement>;
  saliencyMap: MapRequestSpec<RawSaliencyMap>;

  /** For a single image, as the following. */
  boundariesOf: RequestSpec<[image: RawFrame], RawBoundaryMap>;
  superpixelsOf: RequestSpec<[image: RawFrame, count?: number], RawSuperpixels>;
  flowOf: RequestSpec<[from: RawFrame, to: RawFrame], FlowField>;
  discontinuitiesOf: RequestSpec<[image: RawFrame], ImageDiscontinuities>;
}

export const REQUESTS: Requests = {
  push: {
    work: withPixels((frame) => change((session) => session.pushRgba(frame.data, frame.width, frame.height))),
  },
  pushInShot: {
    work: withPixels((frame) => (session) => {
      const held = session.pushInShot(frame.data, frame.width, frame.height);
      return { ...session.info(), held: held };
    }),
  },
  advance: { restarts: true, work: (overlap) => change((session) => session.advance(overlap)) },
  planWindows: { work: (window, overlap) => change((session) => session.planWindows(window, overlap)) },
  shared: { work: (remaining) => (session) => session.shared(remaining) },
  closeWindow: {
    work: (frames, overlap) => (session) => {
      const place = session.closeWindow(frames, overlap);
      const [index, shot, firstFrame, from, to] = [...place] as [number, number, number, number, number];
      return { index, shot, firstFrame, settled: { from, to } };
    },
  },
  setTrajectories: {
    work: ({ numFrames, width, height, startFrame, offset, x, y }) =>
      change((session) => session.setTrajectories(numFrames, width, height, startFrame, offset, x, y)),
  },
  correct: { work: (correction) => change((session) => applyCorrection(session, correction)) },
  clear: { restarts: true, work: () => change((session) => session.clear()) },

  flow: { work: (t) => (session) => session.flow(t) },
  boundaries: { noun: 'boundaries', needs: 'frames', work: (t) => (session) => session.boundaries(t) },
  superpixels: { noun: 'superpixels', needs: 'masks', work: (t) => (session) => session.superpixels(t) },
  background: { noun: 'backgrounds', needs: 'masks', work: (t) => (session) => session.background(t) },
  explain: {
    noun: 'explanations',
    needs: 'masks',
    byLabels: true,
    work: (t, x, y) => (session) => session.explain(t, x, y),
  },
  agreement: {
    noun: 'agreements',
    needs: 'masks',
    byLabels: true,
    work: () => (session) => session.agreement() as Agreement,
  },
  saliencyMap: { noun: 'saliency maps', needs: 'saliency', work: (t) => (session) => session.saliencyMap(t) },

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

/** Creates the call for a request whose first argument is a frame: files are decoded before the session gets them. */
function withPixels<A extends unknown[], R>(
  work: (pixels: Pixels, ...rest: A) => SessionCall<R>,
): (frame: RawFrame, ...rest: A) => Promise<SessionCall<R>> {
  return async (frame, ...rest) => work(await toPixels(frame), ...rest);
}

/** Creates a call that changes the session; the answer is its new state. */
function change(modify: SessionCall<void>): SessionCall<SessionInfo> {
  return (session) => {
    modify(session);
    return session.info();
  };
}

export type RequestName = keyof Requests;
export type ResultName = { [N in RequestName]: Requests[N] extends { noun: string } ? N : never }[RequestName];
export type MapName = { [N in ResultName]: Requests[N] extends MapRequestSpec<infer _> ? N : never }[ResultName];
export type Arguments<N extends RequestName> = Parameters<Requests[N]['work']>;
export type Answer<N extends RequestName> = ReturnType<Awaited<ReturnType<Requests[N]['work']>>>;

/** Sends a request of a result. */
export type Ask = <N extends ResultName>(name: N, ...args: Arguments<N>) => Promise<Answer<N>>;

/** Returns the specification of a request. */
export function getRequestSpec<N extends RequestName>(name: N): RequestSpec<Arguments<N>, Answer<N>> {
  return REQUESTS[name] as RequestSpec<Arguments<N>, Answer<N>>;
}
