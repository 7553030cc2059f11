// Corrections by the user: checked here, applied by the engine.

import { illegal } from './errors.js';
import { wholeNumber } from './options.js';

/**
 * A place in the clip: frame `t`, and input pixels, pixel centres at whole numbers.
 * @typedef {{t: number, x: number, y: number}} Place
 */

/**
 * A correction as the engine takes it.
 * @typedef {{kind: 'merge', into: number, from: number}
 *   | {kind: 'split', label: number, at: Place | null}
 *   | {kind: 'undo'}} RawCorrection
 */

/**
 * The clip that a correction is made for.
 * @typedef {{numFrames: number, width: number, height: number}} Clip
 */

/**
 * @param {number} into
 * @param {number} from
 * @returns {RawCorrection}
 */
export function mergeOf(into, from) {
  wholeNumber('param', 'a', into, 0, 255);
  if (from === 0) throw illegal('param', 'b', from, 'an object, 1..255: the background cannot be merged into one');
  wholeNumber('param', 'b', from, 1, 255);
  if (into === from) throw illegal('param', 'b', from, 'another label than a');
  return { kind: 'merge', into, from };
}

/**
 * @param {number} label
 * @param {Place | undefined} at
 * @param {Clip} clip
 * @returns {RawCorrection}
 */
export function splitOf(label, at, clip) {
  wholeNumber('param', 'label', label, 0, 255);
  if (at === undefined) {
    if (label === 0) throw illegal('param', 'label', label, 'an object, or the background with a place {t, x, y} of what is none');
    return { kind: 'split', label, at: null };
  }
  if (typeof at !== 'object' || at === null) throw illegal('param', 'at', at, '{t, x, y}');
  const { t, x, y } = at;
  wholeNumber('param', 'at.t', t, 0, Math.max(0, clip.numFrames - 1));
  coordinate('at.x', x, clip.width);
  coordinate('at.y', y, clip.height);
  return { kind: 'split', label, at: { t, x, y } };
}

/**
 * @param {import('./tracecut.js').Session} session
 * @param {RawCorrection} correction
 */
export function applyCorrection(session, correction) {
  switch (correction.kind) {
    case 'merge':
      return session.merge(correction.into, correction.from);
    case 'split': {
      const { t, x, y } = correction.at ?? { t: 0, x: 0, y: 0 };
      return session.split(correction.label, correction.at !== null, t, x, y);
    }
    case 'undo':
      return session.undoCorrection();
  }
}

/**
 * @param {string} name
 * @param {unknown} value
 * @param {number} side
 */
function coordinate(name, value, side) {
  if (typeof value !== 'number' || !(value >= -0.5 && value <= side - 0.5)) {
    throw illegal('param', name, value, `a number of pixels, -0.5..${side - 0.5}`);
  }
}
