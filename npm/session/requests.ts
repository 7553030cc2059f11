// The requests of a session. The engine in this thread, the engine in a worker, the worker and later requests of results
// are built from one table: a new request is a line in `Requests` and in `REQUESTS`, a method of the wasm session, and one
// of `Session` (and of `Result`) with its description.
//
// Arguments and answers are transferred to and from a worker, so their typed arrays must not be shared.

import { TraceCutError, checkSides, checkWholeNumber, describe, illegal, isPlainObject } from '../check/errors.js';
import { type Pixels, toPixels } from '../worker/instance.js';
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

/**
 * Trajectories of any tracker. Trajectory `i` has the points `offset[i]` to `offset[i + 1]` of `x` and `y`, one for each of
 * the consecutive frames from `startFrame[i]` on.
 */
export interface TrajectoryInput {
  numFrames: number;
  /** Width of the frames in pixels. */
  width: number;
  /** Height of the frames in pixels. */
  height: number;
  /** The first frame of each trajectory. */
  startFrame: Uint32Array | readonly number[];
  /** Index of the first point of each trajectory; one longer than `startFrame`. */
  offset: Uint32Array | readonly number[];
  /** Coordinates of all points to the right, in input pixels. */
  x: Float32Array | Float64Array | readonly number[];
  /** Coordinates of all points downwards, in input pixels. */
  y: Float32Array | Float64Array | readonly number[];
}

/** Trajectories for the engine. */
export type RawTrajectories = {
  numFrames: number;
  width: number;
  height: number;
  startFrame: Uint32Array<ArrayBuffer>;
  offset: Uint32Array<ArrayBuffer>;
  x: Float32Array<ArrayBuffer>;
  y: Float32Array<ArrayBuffer>;
};

/** Most frames of trajectories. */
const MAX_FRAMES = 1000000;
const MAX_U32 = 4294967295;

/** Checks types and copies the arrays; Rust checks their contents. */
export function toRawTrajectories(input: TrajectoryInput): RawTrajectories {
  if (!isPlainObject(input)) {
    throw illegal('data', 'trajectories', input, 'an object {numFrames, width, height, startFrame, offset, x, y}');
  }
  checkWholeNumber('data', 'numFrames', input.numFrames, 1, MAX_FRAMES);
  checkSides('frame-size', '', input);
  const { numFrames, width, height } = input;
  return {
    numFrames,
    width,
    height,
    startFrame: toUint32Array('startFrame', input.startFrame),
    offset: toUint32Array('offset', input.offset),
    x: toFloat32Array('x', input.x),
    y: toFloat32Array('y', input.y),
  };
}

function toUint32Array(name: string, values: unknown) {
  if (values instanceof Uint32Array) return new Uint32Array(values);
  if (!Array.isArray(values)) throw illegal('data', name, values, 'a Uint32Array');
  values.forEach((value, i) => checkWholeNumber('data', `${name}[${i}]`, value, 0, MAX_U32));
  return new Uint32Array(values);
}

function toFloat32Array(name: string, values: unknown) {
  if (values instanceof Float32Array || values instanceof Float64Array) return new Float32Array(values);
  if (!Array.isArray(values)) throw illegal('data', name, values, 'a Float32Array');
  const badIndex = values.findIndex((value) => typeof value !== 'number');
  if (badIndex >= 0) throw illegal('data', `${name}[${badIndex}]`, describe(values[badIndex]), 'a number of pixels');
  return new Float32Array(values);
}

/** A place in a clip. */
export interface Place {
  /** Frame number, from 0. */
  t: number;
  /** Distance from the left in input pixels, pixel centres at whole numbers. */
  x: number;
  /** Distance from the top in input pixels. */
  y: number;
}

/** A line painted in a frame. Points may lie outside of the frame, but not all of them. */
export interface Stroke {
  /** Frame number, from 0. */
  t: number;
  /** X0, y0, x1, y1 and so on along its middle, in input pixels, pixel centres at whole numbers; one point is a dot. */
  points: ArrayLike<number>;
  /** Half the width of the brush, in input pixels. */
  radius: number;
}

/** A correction for the engine. Stroke `k` has the points `offset[k]` to `offset[k + 1]`. */
export type RawCorrection =
  | { kind: 'merge'; into: number; from: number }
  | { kind: 'split'; label: number; at: Place | null }
  | { kind: 'together' | 'apart'; t: Uint32Array; radius: Float32Array; offset: Uint32Array; points: Float32Array }
  | { kind: 'undo' };

/** The part of a clip that checks of corrections need. */
export type Clip = { numFrames: number };

export function toMerge(into: number, from: number): RawCorrection {
  checkWholeNumber('param', 'a', into, 0, 255);
  if (from === 0) throw illegal('param', 'b', from, 'an object, 1..255: the background cannot be merged into one');
  checkWholeNumber('param', 'b', from, 1, 255);
  if (into === from) throw illegal('param', 'b', from, 'another label than a');
  return { kind: 'merge', into, from };
}

export function toSplit(label: number, at: Place | undefined, clip: Clip): RawCorrection {
  checkWholeNumber('param', 'label', label, 0, 255);
  if (at === undefined) {
    if (label === 0)
      throw illegal('param', 'label', label, 'an object, or the background with a place {t, x, y} of what is none');
    return { kind: 'split', label, at: null };
  }
  if (typeof at !== 'object' || at === null) throw illegal('param', 'at', at, '{t, x, y}');
  const { t, x, y } = at;
  checkWholeNumber('param', 'at.t', t, 0, Math.max(0, clip.numFrames - 1));
  if (typeof x !== 'number' || typeof y !== 'number')
    throw illegal('param', 'at', at, '{t, x, y}, all of them numbers');
  return { kind: 'split', label, at: { t, x, y } };
}

/** Most strokes of a correction. The engine has the same limit. */
const MAX_STROKES = 255;

export function toStrokes(kind: 'together' | 'apart', strokes: readonly Stroke[], clip: Clip): RawCorrection {
  const least = kind === 'apart' ? 2 : 1;
  if (!Array.isArray(strokes) || strokes.length < least || strokes.length > MAX_STROKES) {
    throw illegal('param', 'strokes', strokes, `a list of ${least}..${MAX_STROKES} strokes {t, points, radius}`);
  }
  const lists = strokes.map((stroke, k) => checkStroke(stroke, `strokes[${k}]`, clip.numFrames));
  const offset = [0];
  for (const points of lists) offset.push(offset.at(-1)! + points.length / 2);
  return {
    kind,
    t: Uint32Array.from(strokes, (stroke) => stroke.t),
    radius: Float32Array.from(strokes, (stroke) => stroke.radius),
    offset: Uint32Array.from(offset),
    points: Float32Array.from(lists.flat()),
  };
}

/** Returns the points of a stroke. Throws for values that typed arrays would change; Rust checks the rest. */
export function checkStroke(stroke: Stroke, name: string, numFrames: number) {
  if (typeof stroke !== 'object' || stroke === null)
    throw illegal('param', name, stroke, 'a stroke {t, points, radius}');
  const { t, points, radius } = stroke;
  checkWholeNumber('param', `${name}.t`, t, 0, Math.max(0, numFrames - 1));
  const coordinates = Array.from(typeof points === 'object' && points !== null ? points : []);
  if (coordinates.length % 2 > 0 || ![radius, ...coordinates].every((v) => typeof v === 'number')) {
    throw illegal('param', name, stroke, 'a radius and points x0, y0, x1, y1, ..., all of them numbers');
  }
  return coordinates;
}

export function applyCorrection(session: WasmSession, correction: RawCorrection) {
  switch (correction.kind) {
    case 'merge':
      return session.merge(correction.into, correction.from);
    case 'split': {
      const { t, x, y } = correction.at ?? { t: 0, x: 0, y: 0 };
      return session.split(correction.label, correction.at !== null, t, x, y);
    }
    case 'together':
    case 'apart': {
      const { kind, t, radius, offset, points } = correction;
      return session.strokes(kind === 'apart', t, radius, offset, points);
    }
    case 'undo':
      return session.undoCorrection();
  }
}
