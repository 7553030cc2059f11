/**
 * What the page knows, in one place. Everyone may read it, change it with `set`, and watch the keys that they show:
 * the document is written from it and never read back. What only one panel looks at stays with that panel.
 * @module
 */

import { DEFAULT_TAKE } from './source.js';
import { Times } from './presence.js';

/**
 * What the page is doing. Several phases share one of the four public states in `document.body.dataset.state`, see
 * panels/status.js.
 *
 * @typedef {'opening' | 'running' | 'stopped' | 'done' | 'error'} Phase
 */

/**
 * Frames to show: `get` gives null for one that is still on its way; then `onReady` is called. `more` frames after it are
 * made ready too.
 *
 * @typedef {{get: (frame: number, more?: number) => CanvasImageSource | null, has: (frame: number) => boolean, onReady: () => void}}
 *   Frames
 */

/** @typedef {{width: number, height: number, images: Frames}} Picture What the viewer shows, size in pixels. */

/**
 * @typedef {{numFrames: number, fps: number, times: Times, cuts: number[]}} Film What the timeline goes over: `fps`
 *   frames a second, and the frames with which new shots begin.
 */

/**
 * @typedef {object} Found What is known of the clip by now.
 * @property {import('./points.js').Points | null} points null for a still image
 * @property {import('./presence.js').Facts[]} facts of each object, the background among them
 * @property {Partial<import('./answers.js').Answers>} answers
 */

/** @typedef {{name: import('./look.js').GroundName, colour: string, picture: ImageBitmap | null}} Ground */

/**
 * @typedef {object} State
 * @property {number} visit grows whenever something else begins: what was awaited before that is void
 * @property {Phase} phase
 * @property {string} headline
 * @property {string} subline
 * @property {string} summary what is seen, empty for nothing
 * @property {string} notice shown above the picture, empty for none
 * @property {string} live what screen readers are told
 * @property {unknown} error of the phase `error`
 * @property {string} name of the clip
 * @property {import('./source.js').Source | null} source
 * @property {import('./source.js').Take} take
 * @property {Record<'clip' | 'still', number>} pace milliseconds that the last run took per pixel and frame
 * @property {ReadonlyMap<string, number | boolean | string>} changed parameters that differ from their defaults
 * @property {import('./job.js').AnyJob | null} job
 * @property {import('./job.js').AnyJob | null} before corrected, until it was run again
 * @property {number} share of the run that is through, in 0..1
 * @property {import('./preview.js').Preview | null} preview shown until there are masks
 * @property {boolean} streaming whether windows of a run under way are shown already
 * @property {Picture} picture
 * @property {Found | null} found
 * @property {ReadonlySet<number>} hidden objects
 * @property {ReadonlySet<number>} chosen objects that are to be joined, into the first
 * @property {Film} film
 * @property {number} frame on screen
 * @property {boolean} playing
 * @property {boolean} loop
 * @property {boolean} calm whether nothing is to move by itself
 * @property {boolean} isNoisy whether the browser alters pixels that a page reads
 * @property {import('./look.js').View} view
 * @property {Ground} ground what cut-out objects lie on
 * @property {import('./look.js').EdgeChoice} edges
 * @property {import('./smoothing.js').Smoothed | null} smoothed masks as far as they are smoothed over time; null where they are not
 * @property {number} split where the original ends under the slider, in percent
 * @property {import('./answers.js').Spot} spot under the pointer
 * @property {boolean} correcting
 * @property {boolean} pending whether the result was made with other settings than those chosen now
 */

/** @type {Frames} */
const NO_FRAMES = { get: () => null, has: () => false, onReady() {} };

/** Specks are nobody's wish. @type {import('./look.js').EdgeChoice} */
export const DEFAULT_EDGES = { smallest: 0.02, grow: 0, feather: 0, smooth: 0 };

/** @type {import('./answers.js').Spot} */
export const NOWHERE = { x: -1, y: -1, object: -1 };

/** The state of a page with no clip. */
export const BLANK = {
  notice: '',
  job: null,
  before: null,
  preview: null,
  streaming: false,
  picture: { width: 16, height: 9, images: NO_FRAMES },
  found: null,
  hidden: new Set(),
  chosen: new Set(),
  film: { numFrames: 0, fps: 25, times: new Times(null), cuts: [] },
  frame: 0,
  playing: false,
  spot: NOWHERE,
  correcting: false,
};

/** @type {State} */
const INITIAL = {
  ...BLANK,
  visit: 0,
  phase: 'opening',
  headline: 'Loading…',
  subline: '\u00a0',
  summary: '',
  live: '',
  error: null,
  name: '\u00a0',
  source: null,
  take: DEFAULT_TAKE,
  pace: { clip: 0, still: 0 },
  changed: new Map(),
  share: 0,
  loop: true,
  calm: false,
  isNoisy: false,
  view: 'overlay',
  edges: DEFAULT_EDGES,
  smoothed: null,
  ground: { name: 'transparent', colour: '#f4f1ea', picture: null },
  split: 50,
  pending: false,
};

export class Store {
  constructor() {
    /** @type {Readonly<State>} */
    this.state = { ...INITIAL };
    /** @type {{keys: (keyof State)[], show: (state: Readonly<State>) => void, last: boolean}[]} */
    this.watchers = [];
  }

  /**
   * Changes state and tells everyone whom it concerns, once each, before it returns.
   *
   * @param {Partial<State>} patch
   */
  set(patch) {
    const keys = /** @type {(keyof State)[]} */ (Object.keys(patch));
    const changed = keys.filter((key) => !Object.is(patch[key], this.state[key]));
    this.state = { ...this.state, ...patch };
    for (const watcher of this.watchers)
      if (watcher.keys.some((key) => changed.includes(key))) watcher.show(this.state);
  }

  /**
   * Shows what there is, and again whenever one of these keys changes.
   *
   * @param {(keyof State)[]} keys
   * @param {(state: Readonly<State>) => void} show
   * @param {{last?: boolean}} [order] `last` for whoever is to find everything else in place
   */
  watch(keys, show, { last = false } = {}) {
    this.watchers.push({ keys, show, last });
    this.watchers.sort((a, b) => Number(a.last) - Number(b.last));
    show(this.state);
  }
}

/**
 * Enters a phase.
 *
 * @param {Phase} phase
 * @param {string} headline
 * @param {string} subline
 * @param {string} [summary]
 * @returns {Partial<State>}
 */
export function phasePatch(phase, headline, subline, summary = '') {
  const live = [headline, subline, summary].filter(Boolean).join('. ');
  return { phase, headline, subline, summary, live, error: null };
}

/**
 * @param {unknown} error
 * @returns {Partial<State>}
 */
export function errorPatch(error) {
  return { ...phasePatch('error', 'Nothing to show', ''), live: '', error };
}

/**
 * @param {Pick<State, 'film'>} state
 * @param {number} frame
 * @returns {number} within the film
 */
export function withinFilm({ film }, frame) {
  return Math.max(0, Math.min(film.numFrames - 1, frame));
}
