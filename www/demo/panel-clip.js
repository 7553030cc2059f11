/** What to take from the clip: first frame, number of frames, step and working size. @module */

import { byId } from './dom.js';
import { WINDOW } from './long-job.js';
import { workingSize } from './grabber.js';
import { DEFAULT_TAKE, fitTake } from './source.js';
import { plural } from './words.js';

/** @typedef {import('./source.js').Source} Source */
/** @typedef {import('./source.js').Take} Take */

export class ClipPanel {
  /** @param {(take: Take) => void} onChange called after each change by the user */
  constructor(onChange) {
    this.start = /** @type {HTMLInputElement} */ (byId('take-start'));
    this.frames = /** @type {HTMLInputElement} */ (byId('take-frames'));
    this.step = /** @type {HTMLSelectElement} */ (byId('take-step'));
    this.side = /** @type {HTMLSelectElement} */ (byId('take-side'));
    /** @type {Source | null} */
    this.source = null;
    /** @type {Record<string, number>} Time that the last run took per pixel and frame, of clips and of still images. */
    this.pace = { clip: 0, still: 0 };
    /** @type {Take} */
    this.take = { ...DEFAULT_TAKE };
    for (const field of [this.start, this.frames, this.step, this.side]) {
      field.addEventListener('input', () => {
        this.read();
        onChange(this.take);
      });
    }
    byId('take-all').addEventListener('click', () => {
      if (!this.source) return;
      this.start.value = '0';
      this.frames.value = String(this.source.count);
      this.read();
      this.show();
      onChange(this.take);
    });
    // While a number is typed it is left as it is; afterwards it shows what is really taken.
    this.frames.addEventListener('blur', () => this.show());
  }

  /** @param {Source} source the form starts from the usual values */
  setSource(source) {
    this.source = source;
    const sample = source.kind === 'sample';
    this.take = fitTake(sample ? { start: 0, frames: source.count, step: 1, side: source.width } : { ...DEFAULT_TAKE }, source);
    byId('clip-form').hidden = sample;
    byId('clip-sample').hidden = !sample;
    byId('clip-title').textContent = source.kind === 'still' ? 'Image' : 'Clip';
    byId('clip-name').textContent = source.name;
    byId('clip-facts').textContent = facts(source);
    this.start.max = String(Math.max(0, source.count - 2));
    this.start.value = '0';
    this.step.value = '1';
    this.side.value = String(DEFAULT_TAKE.side);
    this.show();
  }

  /** @param {number} msPerPixel time that the last run took per pixel and frame, for an estimate of the next */
  setPace(msPerPixel) {
    this.pace[paceOf(this.source)] = msPerPixel;
    this.show();
  }

  read() {
    if (!this.source) return;
    const wanted = Math.round(Number(this.frames.value));
    this.take = fitTake(
      {
        start: Number(this.start.value),
        frames: Number.isFinite(wanted) ? Math.max(2, wanted) : DEFAULT_TAKE.frames,
        step: Number(this.step.value),
        side: Number(this.side.value),
      },
      this.source,
    );
    this.show();
  }

  show() {
    const { source, take } = this;
    if (!source) return;
    const last = take.start + (take.frames - 1) * take.step;
    const inSeconds = source.kind === 'video';
    const at = (/** @type {number} */ frame) => (inSeconds ? `${(frame / source.fps).toFixed(1)}\u00a0s` : `image ${frame + 1}`);
    byId('take-start-text').textContent = at(take.start);
    this.start.style.setProperty('--share', String(take.start / Math.max(1, Number(this.start.max))));
    this.start.setAttribute('aria-valuetext', at(take.start));
    if (document.activeElement !== this.frames) this.frames.value = String(take.frames);
    const { width, height } = workingSize(source, take.side);
    const size = `${width} × ${height}`;
    const what = source.kind === 'still' ? `Seen at ${size}` : `${plural(take.frames, 'frame')} of ${size}, ${at(take.start)} to ${at(last)}`;
    const ms = this.pace[paceOf(source)] * width * height * take.frames;
    const time = ms > 0 ? `. About ${Math.max(1, Math.round(ms / 1000))}\u00a0s on this computer` : '';
    const windows = take.frames > WINDOW ? `. More than ${WINDOW} frames are taken in windows; the first are shown while the others are computed` : '';
    byId('take-text').textContent = `${what}${time}${windows}.`;
  }
}

/** @param {Source | null} source */
function paceOf(source) {
  return source?.kind === 'still' ? 'still' : 'clip';
}

/**
 * @param {Source} source
 * @returns {string}
 */
function facts(source) {
  const size = `${source.width} × ${source.height}`;
  if (source.kind === 'still') return size;
  if (source.kind === 'video') return `${size}, ${(source.count / source.fps).toFixed(1)} s at ${Number(source.fps.toFixed(2))} fps`;
  return `${size}, ${plural(source.count, source.kind === 'images' ? 'image' : 'frame')}`;
}
