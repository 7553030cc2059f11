// Trajectories of a clip's points and nothing else: flow and tracking, without the stages that look at them.

import { TraceCutError, illegal, isPlainObject } from '../check/errors.js';
import { splitOptions } from '../check/options.js';
import { atSize } from '../video/pixels.js';
import { asOptions, nothingTaken, splitTake, taken } from '../video/reader.js';
import { openReader } from '../video/source.js';
import { untilAborted } from '../worker/pause.js';
import { decoderLoader, openEngine } from '../worker/remote.js';

/**
 * What is told of tracking.
 * @typedef {object} TrackingProgress
 * @property {(progress: import('../session/engine.js').Progress) => void} [onProgress] hears of the stages `flow` and
 *   `trajectories`
 */

/**
 * Options of `trajectories`: what to take of the source, and the options of a session, of which flow and tracking are
 * used.
 * @typedef {import('../video/reader.js').TakeOptions & import('../check/options.js').SessionOptions & TrackingProgress}
 *   TrajectoryOptions
 */

/**
 * Trajectories with the clip that they are of: what `setTrajectories` and `tracksDat` take. `width` and `height` are
 * those of the frames in pixels; `times` those of the frames in seconds.
 * @typedef {import('../session/result.js').TrajectoryList & {numFrames: number, width: number, height: number, times:
 *   Float64Array}} TrackedClip
 */

/**
 * Follows points through a clip, and no more: flow and tracking of a session, in the time that these take. Memory grows
 * with the clip, as all of it is one window.
 *
 * ```js
 * const { count, startFrame, offset, x, y } = await trajectories(frames, { trajectory: { gridStep: 6 } });
 * ```
 * @param {import('../video/source.js').VideoSource} source
 * @param {TrajectoryOptions} [options]
 * @returns {Promise<TrackedClip>}
 */
export async function trajectories(source, options) {
  const { take, onProgress, engine: split } = checked(options);
  take.signal?.throwIfAborted();
  const reader = await openReader(source, take, decoderLoader(split.decoder));
  const engine = await openEngine(split).catch((error) => {
    reader.close();
    throw error;
  });
  try {
    const { info, times } = await pushed(engine, reader, take);
    const signal = take.signal ?? new AbortController().signal;
    const list = await untilAborted(engine.track(onProgress, signal), take.signal);
    if (!list) throw new TraceCutError('closed', 'the tracking was ended');
    return { ...list, numFrames: info.numFrames, width: info.width, height: info.height, times };
  } finally {
    reader.close();
    engine.close();
  }
}

/** @param {unknown} options */
function checked(options) {
  const { take, others } = splitTake(asOptions(options));
  const { onProgress = () => {}, ...session } = others;
  if (typeof onProgress !== 'function') throw illegal('param', 'onProgress', onProgress, 'a function');
  const split = splitOptions(session);
  const clip = isPlainObject(split.parameters.clip) ? split.parameters.clip : {};
  // Without masks nobody needs the denser trajectories that they are made from.
  const engine = { ...split, parameters: { ...split.parameters, clip: { ...clip, dense: false } } };
  return { take, onProgress: /** @type {NonNullable<TrajectoryOptions['onProgress']>} */ (onProgress), engine };
}

/**
 * Gives all frames to the engine.
 * @param {import('../session/engine.js').Engine} engine
 * @param {import('../video/reader.js').Reader} reader
 * @param {import('../video/reader.js').Take} take
 */
async function pushed(engine, reader, take) {
  const times = [];
  let info;
  for await (const { raw, time } of taken(reader, take)) {
    info = await engine.request('push', await atSize(raw, take.size));
    times.push(time);
  }
  if (!info) throw await nothingTaken(take, reader);
  return { info, times: Float64Array.from(times) };
}
