// What every export and drawing helper takes, and the checks that they share.

import { TraceCutError, checkSides, illegal, wholeNumber } from './errors.js';

/**
 * Masks of a clip: a `Result`, a window or the whole of a segmented video, or an object of the caller's. `labels(t)`
 * holds a label for each pixel of frame `t`, row by row, 0 for the background and 1 to 255 for objects; `times` the
 * frames' times in seconds, ascending.
 */
export interface MaskSource {
  /** In pixels. */
  width: number;
  /** In pixels. */
  height: number;
  /** How many there are. */
  numFrames: number;
  /** Of frame `t`: a label for each pixel, row by row. */
  labels: (t: number) => Uint8Array;
  /** Stretches of frames without a cut. */
  shots?: readonly { first: number; last: number }[];
  /** One for each frame, in seconds; null or absent where none are known. */
  times?: ArrayLike<number> | null;
  /**
   * Which of the clip's frames the first is, where the masks are a window of it; 0 if not given. Files and numbers of
   * frames run on from there.
   */
  firstFrame?: number;
  /** When the last frame ends, in seconds; null or absent where that is not known. */
  end?: number | null;
}

/** Which labels are meant: a list of them, or a function that says so of each. */
export type ObjectChoice = Iterable<number> | ((label: number) => boolean);

/** The highest label there can be. */
export const MAX_LABEL = 255;

const MAX_FRAMES = 10_000_000;

/** Refuses what is no {@link MaskSource}. */
export function checkMasks(masks: MaskSource) {
  if (typeof masks !== 'object' || masks === null || typeof masks.labels !== 'function') {
    throw illegal('data', 'masks', masks, 'a result, or an object {width, height, numFrames, labels(t)}');
  }
  checkSides('data', 'masks.', masks);
  wholeNumber('data', 'masks.numFrames', masks.numFrames, 1, MAX_FRAMES);
}

/** Which of the clip's frames the first one is. */
export function firstOf({ firstFrame = 0 }: MaskSource): number {
  return wholeNumber('data', 'masks.firstFrame', firstFrame, 0, MAX_FRAMES);
}

/**
 * The labels of frame `t`, checked.
 * @param masks already checked
 */
export function labelsOf(masks: MaskSource, t: number): Uint8Array {
  wholeNumber('param', 't', t, 0, masks.numFrames - 1);
  const labels = masks.labels(t);
  const expected = `${masks.width} × ${masks.height} labels, 0..=${MAX_LABEL}`;
  if (!ArrayBuffer.isView(labels) && !Array.isArray(labels))
    throw illegal('data', `masks.labels(${t})`, labels, expected);
  const size = masks.width * masks.height;
  if (labels.length !== size)
    throw new TraceCutError('data', `masks.labels(${t}) has ${labels.length} labels (expected ${size})`);
  if (labels instanceof Uint8Array) return labels;
  return Uint8Array.from(labels, (label, p) => wholeNumber('data', `masks.labels(${t})[${p}]`, label, 0, MAX_LABEL));
}

/**
 * The times of all frames in seconds: those of the masks, else those of a frame rate; null where neither is known.
 * @param masks already checked
 * @param frameRate frames per second
 */
export function timesOf(masks: MaskSource, frameRate?: number): Float64Array<ArrayBuffer> | null {
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
  const wrong = seconds.findIndex((time, t) => !Number.isFinite(time) || (t > 0 && time <= Number(seconds[t - 1])));
  if (wrong >= 0) throw illegal('data', `masks.times[${wrong}]`, seconds[wrong], 'seconds, ascending');
  return seconds;
}

/**
 * When the last frame ends: as the masks say, else it lasts as long as the one before; a single one as long as a frame
 * of the frame rate.
 * @param masks already checked
 * @param times as `timesOf` gives them
 * @param frameRate frames per second
 * @returns in seconds
 */
export function endOf({ end, times: own }: MaskSource, times: Float64Array, frameRate: number): number {
  const last = Number(times[times.length - 1]);
  // A frame rate in the place of times says it all.
  if (own && end !== undefined && end !== null) {
    if (!(Number.isFinite(end) && end > last)) throw illegal('data', 'masks.end', end, `seconds, above ${last}`);
    return end;
  }
  return last + (times.length > 1 ? last - Number(times[times.length - 2]) : 1 / frameRate);
}

/**
 * Returns the average number of frames a second to a millionth, as times are sums of fractions; NaN for a single frame.
 * @param duration seconds
 */
export function averageRate(numFrames: number, duration: number) {
  return numFrames > 1 ? Math.round((1e6 * numFrames) / duration) / 1e6 : NaN;
}

/** Returns for how long each frame is shown, in seconds: until the next one, the last until the end. */
export function durationsOf(times: Float64Array, end: number): number[] {
  return Array.from(times, (time, t) => (times[t + 1] ?? end) - time);
}

/**
 * Which labels are meant; all objects and not the background where nothing is said.
 * @returns 1 for each label that is
 */
export function chosenLabels(objects: ObjectChoice | undefined): Uint8Array {
  const chosen = new Uint8Array(MAX_LABEL + 1);
  if (objects === undefined) return chosen.fill(1, 1);
  if (typeof objects === 'function') return chosen.map((_, label) => Number(Boolean(objects(label))));
  if (typeof objects !== 'object' || objects === null || !(Symbol.iterator in objects)) {
    throw illegal('param', 'objects', objects, 'a list of labels, or a function of one');
  }
  for (const label of objects) chosen[wholeNumber('param', 'objects', label, 0, MAX_LABEL)] = 1;
  return chosen;
}
