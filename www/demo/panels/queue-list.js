/**
 * Several clips that were opened together: segmented one after the other, each with its progress; their masks are saved
 * as one archive. A clip that fails is a line and stops nothing. The clip on screen stays as it is.
 * Fetched when several are first opened.
 * @module
 */

import { clipsZip, masksAtSize, segmentEach, videoFrames } from '../library.js';
import { byId, h } from '../dom.js';
import { optionsOf } from '../settings.js';
import { DEFAULT_TAKE } from '../store.js';
import { bytes, damageWords, explain, plural } from '../words.js';
import { edgesOf } from '../saved/look.js';
import { download } from '../result/save-file.js';
import { say } from '../language.js';

/** @typedef {import('../library.js').MaskSource} MaskSource */

/** Of a clip's bar: masks as found; the rest brings them to the size of the source. */
const FOUND = 0.85;

export class Queue {
  /**
   * @param {import('../store.js').Store} store
   */
  constructor(store) {
    this.store = store;
    /** @type {Line[]} */
    this.lines = [];
    this.working = false;
    /** What is saved at the moment. @type {AbortController | null} */
    this.saving = null;
    byId('queue-cancel').addEventListener('click', () => this.cancel());
    byId('queue-save').addEventListener('click', () => this.save());
    byId('queue-close').addEventListener('click', () => this.close());
    addEventListener('beforeunload', (event) => this.working && event.preventDefault());
  }

  /** @param {readonly File[]} files */
  add(files) {
    if (files.length === 0) return;
    const added = files.map((file) => new Line(file));
    this.lines.push(...added);
    byId('queue-list').append(...added.map(({ element }) => element));
    byId('queue').hidden = false;
    this.show();
    if (!this.working) this.work();
  }

  async work() {
    this.working = true;
    this.tell('');
    this.show();
    const { store } = this;
    const clips = segmentEach(this.waiting(), {
      ...optionsOf({ changed: store.state.changed, source: null }),
      size: store.state.source?.kind === 'sample' ? DEFAULT_TAKE.side : store.state.take.side,
      onProgress: ({ frames, window }) => this.now?.progress(frames, window),
    });
    for await (const clip of clips) {
      const line = /** @type {Line} */ (this.now);
      await this.finish(line, clip);
      this.show();
    }
    this.working = false;
    this.show();
    if (this.lines.some(({ masks }) => masks)) await this.save();
  }

  /** The clips in order, those too that are added on the way. */
  async *waiting() {
    for (;;) {
      const next = this.lines.find(({ state }) => state === 'waiting');
      if (!next) return;
      this.now = next;
      next.begin();
      yield { name: next.file.name, source: next.file, signal: next.stop.signal };
    }
  }

  /**
   * @param {Line} line
   * @param {import('../library.js').SegmentedClip} clip
   */
  async finish(line, { result, error, damage }) {
    try {
      if (!result) throw error;
      const { signal } = line.stop;
      const { store } = this;
      const onDamage = () => {};
      const frames = videoFrames(line.file, { maxFrames: result.numFrames, signal, onDamage });
      const masks = await masksAtSize(result, frames, {
        edges: edgesOf(store.state.edges, result),
        signal,
        onProgress: ({ done, total }) =>
          line.show(FOUND + ((1 - FOUND) * done) / total, say('Bringing masks to full size')),
      });
      line.done(masks, result.objects.length, damage);
    } catch (caught) {
      if (line.stop.signal.aborted) line.end('cancelled', say('Cancelled'));
      else line.fail(caught);
    }
  }

  cancel() {
    this.saving?.abort();
    for (const line of this.lines) line.cancel();
    this.show();
  }

  close() {
    this.lines = [];
    byId('queue-list').replaceChildren();
    byId('queue').hidden = true;
    this.store.set({ queued: [] });
  }

  async save() {
    if (this.saving) return;
    const saving = (this.saving = new AbortController());
    this.show();
    const file = 'clips-masks.zip';
    this.tell(say`Making ${file}…`);
    const clips = this.lines.map(({ file: { name }, masks, words, damage }) => ({
      name,
      masks,
      error: masks ? undefined : words,
      about: { result: words, ...(damage ? { damage: damageWords(damage) } : {}) },
    }));
    try {
      const zip = await clipsZip(clips, { signal: saving.signal });
      const blob = new Blob([zip], { type: 'application/zip' });
      download(blob, file);
      this.tell(say`Saved ${file}, ${bytes(blob.size)}.`);
    } catch (error) {
      this.tell(saving.signal.aborted ? say('Cancelled; nothing was saved.') : explain(error).title);
    } finally {
      this.saving = null;
      this.show();
    }
  }

  /** @param {string} text */
  tell(text) {
    byId('queue-status').textContent = text;
  }

  show() {
    const through = this.lines.filter(({ state }) => !['waiting', 'running'].includes(state)).length;
    byId('queue-count').textContent = say`${through} of ${plural(this.lines.length, 'clip')} done`;
    const button = (/** @type {string} */ id) => /** @type {HTMLButtonElement} */ (byId(id));
    button('queue-save').disabled = this.working || this.saving !== null || !this.lines.some(({ masks }) => masks);
    button('queue-cancel').hidden = !this.working;
    button('queue-close').hidden = this.working || this.saving !== null;
  }
}

/** One clip. */
class Line {
  /** @param {File} file */
  constructor(file) {
    this.file = file;
    /** @type {'waiting' | 'running' | 'done' | 'failed' | 'cancelled'} */
    this.state = 'waiting';
    this.stop = new AbortController();
    /** @type {MaskSource | null} */
    this.masks = null;
    /** @type {import('../library.js').Damage | null} */
    this.damage = null;
    this.words = say('Waiting');
    this.bar = h('span', {
      class: 'bar',
      role: 'progressbar',
      'aria-label': file.name,
      'aria-valuemin': 0,
      'aria-valuemax': 100,
      'aria-valuenow': 0,
    });
    this.text = h('span', { class: 'queued-words' }, this.words);
    this.button = h(
      'button',
      { type: 'button', class: 'link', 'aria-label': say`Cancel ${file.name}`, click: () => this.cancel() },
      'Cancel',
    );
    const name = h('span', { class: 'queued-name', title: file.name }, file.name);
    this.element = h('li', { class: 'queued', 'data-queued': this.state }, name, this.bar, this.text, this.button);
  }

  begin() {
    this.state = 'running';
    this.show(0, say('Reading frames'));
  }

  /**
   * @param {{done: number, total: number | null}} frames
   * @param {number} window
   */
  progress({ done, total }, window) {
    if (this.state !== 'running') return;
    const share = total ? done / total : 0;
    const frame = total ? say`Frame ${done} of ${total}` : say`Frame ${done}`;
    this.show(FOUND * share, say`${frame}, window ${window + 1}`);
  }

  /**
   * @param {number} share
   * @param {string} words
   */
  show(share, words) {
    this.words = words;
    this.text.textContent = words;
    this.bar.style.setProperty('--share', String(share));
    this.bar.setAttribute('aria-valuenow', String(Math.round(100 * share)));
    this.element.dataset.queued = this.state;
  }

  /**
   * @param {MaskSource} masks
   * @param {number} objects
   * @param {import('../library.js').Damage | null} damage
   */
  done(masks, objects, damage) {
    this.masks = masks;
    this.damage = damage;
    const frames = plural(masks.numFrames, 'frame');
    const taken = damage ? say`${frames}, up to the damage` : frames;
    this.end('done', `${taken}, ${plural(objects, 'object')}`, 1);
  }

  /** @param {unknown} error */
  fail(error) {
    this.element.classList.add('is-wrong');
    this.end('failed', explain(error).title);
  }

  /** Takes the clip out, whether it has begun or not. */
  cancel() {
    if (this.state !== 'waiting' && this.state !== 'running') return;
    this.stop.abort(new DOMException('cancelled', 'AbortError'));
    // One under way ends when the queue hears of it.
    if (this.state === 'waiting') this.end('cancelled', say('Cancelled'));
  }

  /**
   * @param {Line['state']} state
   * @param {string} words
   * @param {number} [share]
   */
  end(state, words, share = 0) {
    this.state = state;
    // The keyboard's place stays in the queue.
    if (document.activeElement === this.button) byId('queue-cancel').focus();
    this.button.remove();
    this.show(share, words);
  }
}
