/**
 * The kinds of runs. To add one, write its file, a subclass of `Job`, and list it here; the page asks a job what it can
 * do and never of which kind it is.
 * @module
 */

import { ClipJob } from './clip-job.js';
import { LongJob } from './long-job.js';
import { SavedJob } from './saved-job.js';
import { StillJob } from './still-job.js';

/** The first that fits is taken. */
export const KINDS = [StillJob, LongJob, ClipJob];

/** @typedef {(typeof KINDS)[number]} Kind */

/** @typedef {InstanceType<Kind> | SavedJob} AnyJob */

/**
 * @param {import('../source.js').Source} source
 * @param {import('../source.js').Take} take
 * @returns {Kind}
 */
export function kindFor(source, take) {
  return KINDS.find((kind) => kind.fits(source, take)) ?? ClipJob;
}
