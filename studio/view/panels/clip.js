/** What to take from the clip: first frame, number of frames, step and working size. @module */

import { endOf, timeOf } from '../clip-player.js';
import { byId } from '../dom.js';
import { workingSize } from '../video.js';
import { WINDOW } from '../run/clip-job.js';
import { fitTake, kindOf } from '../source.js';
import { DEFAULT_TAKE } from '../store.js';
import { plural } from '../words.js';

/** @typedef {import('../source.js').Source} Source */
/** @typedef {import('../source.js').Take} Take */
/** @typedef {import('../store.js').State} State */

/** @param {Pick<import('../page.js').Page, 'store'>} page */
export function clipPanel({ store }) {
  new ClipPanel(store);
}

class ClipPanel {
  /** @param {import('../store.js').Store} store */
  constructor(store) {
    this.store = store;
    this.start = /** @type {HTMLInputElement} */ (byId('take-start'));
    this.frames = /** @type {HTMLInputElement} */ (byId('take-frames'));
    this.step = /** @type {HTMLSelectElement} */ (byId('take-step'));
    this.side = /** @type {HTMLSelectElement} */ (byId('take-side'));
    for (const field of [this.start, this.frames, this.step, this.side])
      field.addEventListener('input', (event) => this.take(this.wanted(event.target)));
    byId('take-all').addEventListener('click', () =>
      this.take({ ...store.state.take, start: 0, frames: store.state.source?.count ?? 0 }),
    );
    // While a number is typed it is left as it is; afterwards it shows what is really taken.
    this.frames.addEventListener('blur', () => this.show(store.state));
    store.watch(['source'], ({ source }) => source && this.showSource(source));
    store.watch(['source', 'take', 'pace'], (state) => this.show(state));
  }

  /**
   * What the user has put in. A take that went to the clip's end still does when its start or step is changed.
   *
   * @param {EventTarget | null} changed
   * @returns {Take}
   */
  wanted(changed) {
    const { take, source } = this.store.state;
    const typed = Math.round(Number(this.frames.value));
    const toEnd = changed !== this.frames && source !== null && take.start + take.frames * take.step >= source.count;
    return {
      start: Number(this.start.value),
      frames: toEnd ? source.count : Number.isFinite(typed) ? Math.max(2, typed) : DEFAULT_TAKE.frames,
      step: Number(this.step.value),
      side: Number(this.side.value),
    };
  }

  /** @param {Take} take as far as the source has it */
  take(take) {
    const { source } = this.store.state;
    if (source) this.store.set({ take: fitTake(take, source) });
  }

  /** @param {Source} source */
  showSource(source) {
    const isSample = source.kind === 'sample';
    byId('clip-form').hidden = isSample;
    byId('clip-sample').hidden = !isSample;
    byId('clip-title').textContent = kindOf(source) === 'still' ? 'Image' : 'Clip';
    byId('clip-facts').textContent = facts(source);
    this.start.max = String(Math.max(0, source.count - 2));
  }

  /** @param {Readonly<State>} state */
  show({ source, take, pace }) {
    if (!source) return;
    const at = placeIn(source);
    this.start.value = String(take.start);
    this.start.style.setProperty('--share', String(take.start / Math.max(1, source.count - 2)));
    this.start.setAttribute('aria-valuetext', at(take.start));
    byId('take-start-text').textContent = at(take.start);
    this.step.value = String(take.step);
    this.side.value = String(take.side);
    if (document.activeElement !== this.frames) this.frames.value = String(take.frames);
    byId('take-all').hidden = take.start === 0 && 1 + (take.frames - 1) * take.step > source.count - take.step;
    byId('take-text').textContent = takeText(source, take, pace[kindOf(source)]);
  }
}

/**
 * @param {Source} source
 * @returns {(frame: number) => string} `1.2 s`, `image 13`
 */
function placeIn(source) {
  return (frame) => (source.kind === 'video' ? `${timeOf(source, frame).toFixed(1)}\u00a0s` : `image ${frame + 1}`);
}

/**
 * @param {Source} source
 * @param {Take} take
 * @param {number} pace milliseconds per pixel and frame, 0 if not known
 * @returns {string} what is taken, and how long that may last
 */
function takeText(source, take, pace) {
  const { width, height } = workingSize(source, take.side);
  const size = `${width} × ${height}`;
  const at = placeIn(source);
  const last = take.start + (take.frames - 1) * take.step;
  const what =
    kindOf(source) === 'still'
      ? `Seen at ${size}`
      : `${plural(take.frames, 'frame')} of ${size}, ${at(take.start)} to ${at(last)}`;
  const ms = pace * width * height * take.frames;
  const time = ms > 0 ? `About ${Math.max(1, Math.round(ms / 1000))}\u00a0s on this computer` : '';
  const windows =
    take.frames > WINDOW
      ? `More than ${WINDOW} frames are taken in windows; the first are shown while the others are computed`
      : '';
  return `${[what, time, windows].filter(Boolean).join('. ')}.`;
}

/**
 * @param {Source} source
 * @returns {string}
 */
function facts(source) {
  const size = `${source.width} × ${source.height}`;
  if (source.kind === 'still') return size;
  if (source.kind === 'video')
    return `${size}, ${(endOf(source) - timeOf(source, 0)).toFixed(1)} s at ${Number(source.fps.toFixed(2))} fps`;
  return `${size}, ${plural(source.count, source.kind === 'images' ? 'image' : 'frame')}`;
}
