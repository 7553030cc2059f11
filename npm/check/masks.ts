// The interface of masks that all exports and drawing helpers accept, and the checks that they share.

import { TraceCutError, checkSides, checkWholeNumber, illegal } from './errors.js';

/**
 * Masks of a clip: a `Result`, a window or the whole of a segmented video, or your own object. `labels(t)` returns a
 * label for each pixel of frame `t`, row by row, 0 for the background and 1 to 255 for objects.
 */
export interface MaskSource {
  /** Pixels in a row. */
  width: number;
  /** Number of rows. */
  height: number;
  /** Number of frames. */
  numFrames: number;
  /** Returns the label of each pixel of frame `t`, row by row. */
  labels: (t: number) => Uint8Array;
  /** Ranges of frames without a cut. */
  shots?: readonly { first: number; last: number }[];
  /** Frame times in seconds, ascending; null or absent if unknown. */
  times?: ArrayLike<number> | null;
  /** Number of the first frame in the clip, for masks of a window; 0 if not given. Files and frames are numbered from it. */
  firstFrame?: number;
  /** Time at which the last frame ends, in seconds; null or absent if unknown. */
  end?: number | null;
  /** The frames, `from <= t < to`, whose masks should be looked at; null or absent if unknown. */
  doubts?: readonly { from: number; to: number }[] | null;
}

/** Labels to include: a list of them, or a predicate. */
export type ObjectChoice = Iterable<number> | ((label: number) => boolean);

/** Highest label. */
export const MAX_LABEL = 255;

/** Most frames of masks: longer clips are mistakes. */
export const MAX_FRAMES = 10_000_000;

/** Throws unless `masks` is a {@link MaskSource}. */
export function checkMasks(masks: MaskSource) {
  if (typeof masks !== 'object' || masks === null || typeof masks.labels !== 'function') {
    throw illegal('data', 'masks', masks, 'a result, or an object {width, height, numFrames, labels(t)}');
  }
  checkSides('data', 'masks.', masks);
  checkWholeNumber('data', 'masks.numFrames', masks.numFrames, 1, MAX_FRAMES);
}

/** Returns the first and the last frame of the shot of frame `t`; of the clip, if its shots are unknown. */
export function findShot({ shots, numFrames }: MaskSource, t: number): { first: number; last: number } {
  return shots?.find(({ first, last }) => first <= t && t <= last) ?? { first: 0, last: numFrames - 1 };
}

/** Returns the number of the first frame in the clip. */
export function getFirstFrame({ firstFrame = 0 }: MaskSource): number {
  return checkWholeNumber('data', 'masks.firstFrame', firstFrame, 0, MAX_FRAMES);
}

/**
 * Returns the labels of frame `t`, checked.
 * @param masks already checked
 */
export function readLabels(masks: MaskSource, t: number): Uint8Array {
  checkWholeNumber('param', 't', t, 0, masks.numFrames - 1);
  const labels = masks.labels(t);
  const expected = `${masks.width} × ${masks.height} labels, 0..=${MAX_LABEL}`;
  if (!ArrayBuffer.isView(labels) && !Array.isArray(labels))
    throw illegal('data', `masks.labels(${t})`, labels, expected);
  const size = masks.width * masks.height;
  if (labels.length !== size)
    throw new TraceCutError('data', `masks.labels(${t}) has ${labels.length} labels (expected ${size})`);
  if (labels instanceof Uint8Array) return labels;
  return Uint8Array.from(labels, (label, p) =>
    checkWholeNumber('data', `masks.labels(${t})[${p}]`, label, 0, MAX_LABEL),
  );
}

/**
 * Returns the times of all frames in seconds: the times of the masks, or else those given by a frame rate; null if
 * neither is known.
 * @param masks already checked
 * @param frameRate frames per second
 */
export function getTimes(masks: MaskSource, frameRate?: number): Float64Array<ArrayBuffer> | null {
  if (frameRate !== undefined && !(typeof frameRate === 'number' && frameRate > 0 && frameRate <= 1000)) {
    throw illegal('param', 'frameRate', frameRate, 'frames per second, above 0, up to 1000');
  }
  const { times, numFrames } = masks;
  if (times === undefined || times === null) {
    return frameRate === undefined ? null : Float64Array.from({ length: numFrames }, (_, t) => t / frameRate);
  }
  if (times.length !== numFrames)
    throw new TraceCutError('data', `masks.times has ${times.length} times (expected ${numFrames}, one a frame)`);
  const seconds = Float64Array.from(times);
  const badIndex = seconds.findIndex((time, t) => !Number.isFinite(time) || (t > 0 && time <= Number(seconds[t - 1])));
  if (badIndex >= 0) throw illegal('data', `masks.times[${badIndex}]`, seconds[badIndex], 'seconds, ascending');
  return seconds;
}

/**
 * Returns when the last frame ends, in seconds. If the masks do not say, it lasts as long as the frame before, and a
 * single frame as long as a frame of the frame rate.
 * @param masks already checked
 * @param times as returned by `getTimes`
 * @param frameRate frames per second
 */
export function getEnd({ end, times: maskTimes }: MaskSource, times: Float64Array, frameRate: number): number {
  const last = Number(times[times.length - 1]);
  // Where the times come from a frame rate, `end` does not apply.
  if (maskTimes && end !== undefined && end !== null) {
    if (!(Number.isFinite(end) && end > last)) throw illegal('data', 'masks.end', end, `seconds, above ${last}`);
    return end;
  }
  return last + (times.length > 1 ? last - Number(times[times.length - 2]) : 1 / frameRate);
}

/**
 * Computes the average frame rate, rounded to a millionth as times are sums of fractions; NaN for a single frame.
 * @param duration seconds
 */
export function computeFrameRate(numFrames: number, duration: number) {
  return numFrames > 1 ? Math.round((1e6 * numFrames) / duration) / 1e6 : NaN;
}

/** Computes how long each frame is shown, in seconds: until the next one, the last until the end. */
export function computeDurations(times: Float64Array, end: number): number[] {
  return Array.from(times, (time, t) => (times[t + 1] ?? end) - time);
}

/**
 * Converts a choice of objects to flags; all objects but not the background if not given.
 * @returns 1 for each selected label
 */
export function selectLabels(objects: ObjectChoice | undefined): Uint8Array {
  const selected = new Uint8Array(MAX_LABEL + 1);
  if (objects === undefined) return selected.fill(1, 1);
  if (typeof objects === 'function') return selected.map((_, label) => Number(Boolean(objects(label))));
  if (typeof objects !== 'object' || objects === null || !(Symbol.iterator in objects)) {
    throw illegal('param', 'objects', objects, 'a list of labels, or a function of one');
  }
  for (const label of objects) selected[checkWholeNumber('param', 'objects', label, 0, MAX_LABEL)] = 1;
  return selected;
}
