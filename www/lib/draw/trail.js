// The trail of a moving object: copies of it where it was a few frames before, the oldest the faintest.

import { checkNumber, checkedOptions, illegal, wholeNumber } from '../errors.js';

/**
 * A trail behind the objects: copies of them where they were some frames before. None comes from before a cut.
 * @typedef {object} TrailOptions
 * @property {number} [copies] how many, 0 (none) to 16; 4 if not given
 * @property {number} [spacing] frames from one copy to the next, 1 to 16; 3 if not given
 * @property {number} [opacity] how opaque the newest is, 0 to 1, and each before it fainter by the same step; 0.6 if not
 *   given
 */

/** A frame that a trail is made of, and how opaque its objects are in it. @typedef {{t: number, opacity: number}} TrailFrame */

const MOST = 16;

/**
 * @param {TrailOptions | undefined} trail
 * @returns {Required<TrailOptions> | null} null for none
 */
export function checkedTrail(trail) {
  if (trail === undefined) return null;
  const { copies = 4, spacing = 3, opacity = 0.6 } = checkedOptions(trail, ['copies', 'spacing', 'opacity']);
  wholeNumber('param', 'trail.copies', copies, 0, MOST);
  wholeNumber('param', 'trail.spacing', spacing, 1, MOST);
  checkNumber('trail.opacity', opacity, 0, 1);
  return copies > 0 && opacity > 0 ? { copies, spacing, opacity } : null;
}

/**
 * The frames whose objects make the trail in frame `t`, the oldest and faintest first: none at the beginning of a clip
 * or a shot.
 * @param {number} t
 * @param {TrailOptions} trail
 * @param {readonly {first: number, last: number}[]} [shots] stretches of frames without a cut; one if not given
 * @returns {TrailFrame[]}
 */
export function trailFrames(t, trail, shots) {
  wholeNumber('param', 't', t, 0, Number.MAX_SAFE_INTEGER);
  if (trail === undefined) throw illegal('param', 'trail', trail, 'an object with copies, spacing, opacity');
  const checked = checkedTrail(trail);
  return checked ? framesOf(t, checked, firstOf(t, shots)) : [];
}

/**
 * @param {number} t
 * @param {Required<TrailOptions>} trail
 * @param {number} first frame that may be seen
 * @returns {TrailFrame[]}
 */
export function framesOf(t, { copies, spacing, opacity }, first) {
  const count = Math.min(copies, Math.floor((t - first) / spacing));
  return Array.from({ length: count }, (_, k) => {
    const back = count - k;
    return { t: t - back * spacing, opacity: (opacity * (copies + 1 - back)) / copies };
  });
}

/**
 * @param {number} t
 * @param {readonly {first: number, last: number}[] | undefined} shots
 */
export function firstOf(t, shots) {
  return shots?.find(({ first, last }) => t >= first && t <= last)?.first ?? 0;
}
