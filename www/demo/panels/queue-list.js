/**
 * Several clips that were opened together: segmented one after the other, each with its progress. One that is through
 * is kept as work, opens with a click, and is corrected while the others go on; at the end all are saved: as masks in
 * one archive, or as a video each. A clip that fails is a line and stops nothing.
 * Fetched when several are first opened.
 * @module
 */

import { clipsZip, saveProject, segmentEach } from '../library.js';
import { byId, h, toPicture } from '../dom.js';
import { optionsOf } from '../settings.js';
import { DEFAULT_TAKE } from '../store.js';
import { bytes, count, damageWords, explain, plural, remaining } from '../words.js';
import { masksOf, stemOf } from '../result/export.js';
import { FIRST } from '../result/exports.js';
import { keptSubject } from '../result/kept-subject.js';
import { download } from '../result/save-file.js';
import { TimeLeft } from '../result/time-left.js';
import { lookOf } from '../saved/look.js';
import { smallPicture } from '../saved/picture.js';
import { keep } from '../saved/slots.js';
import { clipId, reopened } from '../saved/work.js';
import { openVideo } from '../video.js';

/** @typedef {import('../saved/storage.js').Saved} Saved */

/** What all are saved as when nobody chooses. */
const MASKS = 'zip';

export class Queue {
  /**
   * @param {Pick<import('../page.js').Page, 'store' | 'app'>} page
   */
  constructor({ store, app }) {
    this.store = store;
    this.app = app;
    /** @type {Line[]} */
    this.lines = [];
    this.working = false;
    /** What is saved at the moment. @type {AbortController | null} */
    this.saving = null;
    this.kind = /** @type {HTMLSelectElement} */ (byId('queue-kind'));
    const kinds = FIRST.map(({ title, choices: [{ id }] }) => h('option', { value: id }, title));
    this.kind.replaceChildren(...kinds);
    this.kind.value = MASKS;
    byId('queue-cancel').addEventListener('click', () => this.cancel());
    byId('queue-save').addEventListener('click', () => this.save());
    byId('queue-close').addEventListener('click', () => this.close());
    addEventListener('beforeunload', (event) => this.working && event.preventDefault());
    // What is corrected of a clip is saved so.
    store.watch(['kept'], ({ kept }) => {
      for (const line of this.lines) if (kept && line.saved?.id === kept.id) line.keep(kept);
    });
    store.watch(['source'], ({ source }) => {
      for (const line of this.lines) line.mark(source?.files?.[0] === line.file);
    });
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
    const side = store.state.source?.kind === 'sample' ? DEFAULT_TAKE.side : store.state.take.side;
    const { changed } = store.state;
    const clips = segmentEach(this.waiting(), {
      ...optionsOf({ changed, source: null }),
      size: side,
      onProgress: ({ frames, window }) => this.now?.progress(frames, window),
    });
    for await (const clip of clips) {
      const line = /** @type {Line} */ (this.now);
      await this.finish(line, clip, { side, changed: [...changed] });
      this.show();
    }
    this.working = false;
    this.show();
    if (this.lines.some(({ saved }) => saved)) await this.save();
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
   * What was found is packed: results of many clips would fill the memory.
   *
   * @param {Line} line
   * @param {import('../library.js').SegmentedClip} clip
   * @param {{side: number, changed: Saved['about']['changed']}} settings
   */
  async finish(line, { result, error, damage }, { side, changed }) {
    try {
      if (!result) throw error;
      const { file } = line;
      const take = { start: 0, frames: result.numFrames, step: 1, side };
      const look = lookOf({ ...this.store.state, hidden: new Set() });
      /** @type {Saved} */
      const saved = {
        ...{ id: await clipId([file]), name: file.name, at: Date.now(), files: [file], edits: null },
        ...{ corrected: false, earlier: [], picture: await pictureOf(file, result, side) },
        project: await saveProject(result),
        about: { name: file.name, take, changed, look, run: `queue-${Date.now()}` },
      };
      line.done(saved, result.objects.length, damage, () => this.open(line));
      // Without storage, or room in it, this page still has it.
      await keep(saved).catch(() => false);
      this.store.set({ kept: saved });
    } catch (caught) {
      if (line.stop.signal.aborted) line.end('cancelled', 'Cancelled');
      else line.fail(caught);
    }
  }

  /**
   * Shows a clip that is through; the queue goes on.
   *
   * @param {Line} line
   */
  async open({ saved }) {
    if (!saved) return;
    toPicture();
    await this.app.openWork(saved.name, () => reopened(saved));
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
    const { signal } = (this.saving = new AbortController());
    this.show();
    try {
      const choice = FIRST.flatMap(({ choices }) => choices).find(({ id }) => id === this.kind.value);
      const words = choice && choice.id !== MASKS ? await this.saveEach(choice, signal) : await this.saveMasks(signal);
      this.tell(words);
    } catch (error) {
      this.tell(signal.aborted ? 'Cancelled; nothing was saved.' : explain(error).title);
    } finally {
      this.saving = null;
      this.show();
    }
  }

  /**
   * All masks, at the size of the sources.
   *
   * @param {AbortSignal} signal
   */
  async saveMasks(signal) {
    const file = 'clips-masks.zip';
    /** @type {Parameters<typeof clipsZip>[0]} */
    const clips = [];
    for (const {
      file: { name },
      saved,
      words,
      damage,
    } of this.lines) {
      const about = { result: words, ...(damage ? { damage: damageWords(damage) } : {}) };
      try {
        const masks = saved && (await this.making(saved, file, signal, masksOf));
        clips.push({ name, masks, error: masks ? undefined : words, about });
      } catch (error) {
        signal.throwIfAborted();
        clips.push({ name, masks: null, error, about });
      }
    }
    this.tell(`Making ${file}…`);
    const zip = await clipsZip(clips, { signal });
    const blob = new Blob([zip], { type: 'application/zip' });
    download(blob, file);
    return `Saved ${file}, ${bytes(blob.size)}.`;
  }

  /**
   * A file for each clip, one after the other; one that cannot be made stops no other.
   *
   * @param {import('../result/export.js').Choice} choice
   * @param {AbortSignal} signal
   */
  async saveEach(choice, signal) {
    let [files, size] = [0, 0];
    /** @type {string[]} */
    const failed = [];
    for (const { saved } of this.lines) {
      if (!saved) continue;
      try {
        const stem = stemOf(saved.name);
        const blob = await this.making(saved, stem, signal, async (subject, work) => {
          const made = await choice.make(subject, work);
          const whole = made instanceof Blob ? made : await new Response(made).blob();
          download(whole, `${stem}-${choice.file(subject)}`);
          return whole;
        });
        files += 1;
        size += blob.size;
      } catch (error) {
        if (signal.aborted) break;
        failed.push(`${saved.name}: ${explain(error).title}`);
      }
    }
    const words = files > 0 ? `Saved ${plural(files, 'file')}, ${bytes(size)}.` : 'Nothing was saved.';
    return [words, ...failed].join(' ');
  }

  /**
   * @template T
   * @param {Saved} saved
   * @param {string} file that is made
   * @param {AbortSignal} signal
   * @param {(subject: import('../result/export.js').Subject, work: import('../result/export.js').Work) => Promise<T>} make
   * @returns {Promise<T>}
   */
  async making(saved, file, signal, make) {
    signal.throwIfAborted();
    const timeLeft = new TimeLeft(performance.now());
    const begun = `Making ${file}…`;
    this.tell(begun);
    const { subject, close } = await keptSubject(saved, this.store.state, signal);
    try {
      return await make(subject, {
        signal,
        onProgress: ({ done, total }) => {
          const left = timeLeft.after({ done, total }, performance.now());
          const words = `${saved.name}: ${done} of ${count(total)} frames`;
          byId('queue-progress').textContent = left === null ? words : `${words}, ${remaining(left)}`;
        },
      });
    } finally {
      byId('queue-progress').textContent = '';
      close();
    }
  }

  /** @param {string} text */
  tell(text) {
    byId('queue-status').textContent = text;
  }

  show() {
    const through = this.lines.filter(({ state }) => !['waiting', 'running'].includes(state)).length;
    byId('queue-count').textContent = `${through} of ${plural(this.lines.length, 'clip')} done`;
    const button = (/** @type {string} */ id) => /** @type {HTMLButtonElement} */ (byId(id));
    button('queue-save').disabled = this.working || this.saving !== null || !this.lines.some(({ saved }) => saved);
    this.kind.disabled = this.saving !== null;
    button('queue-cancel').hidden = !this.working && this.saving === null;
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
    /** The clip's work, when it is through. @type {Saved | null} */
    this.saved = null;
    /** @type {import('../library.js').Damage | null} */
    this.damage = null;
    this.words = 'Waiting';
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
      { type: 'button', class: 'link', 'aria-label': `Cancel ${file.name}`, click: () => this.cancel() },
      'Cancel',
    );
    this.picture = h('span', { class: 'work-picture' });
    const name = h('span', { class: 'queued-name', title: file.name }, file.name);
    const parts = [this.picture, name, this.bar, this.text, this.button];
    this.element = h('li', { class: 'queued', 'data-queued': this.state }, ...parts);
  }

  begin() {
    this.state = 'running';
    this.show(0, 'Reading frames');
  }

  /**
   * @param {{done: number, total: number | null}} frames
   * @param {number} window
   */
  progress({ done, total }, window) {
    if (this.state !== 'running') return;
    const share = total ? done / total : 0;
    const frame = total ? `Frame ${done} of ${total}` : `Frame ${done}`;
    this.show(share, `${frame}, window ${window + 1}`);
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
   * @param {Saved} saved
   * @param {number} objects
   * @param {import('../library.js').Damage | null} damage
   * @param {() => void} open
   */
  done(saved, objects, damage, open) {
    this.damage = damage;
    const frames = plural(saved.about.take.frames, 'frame');
    const taken = damage ? `${frames}, up to the damage` : frames;
    const { file, button } = this;
    const opener = h(
      'button',
      { type: 'button', class: 'link', 'aria-label': `Open ${file.name}`, 'data-open': saved.id, click: open },
      'Open',
    );
    const held = document.activeElement === button;
    this.element.append(opener);
    this.end('done', `${taken}, ${plural(objects, 'object')}`, 1);
    if (held) opener.focus();
    this.keep(saved);
  }

  /**
   * @param {Saved} saved as it is now
   */
  keep(saved) {
    if (saved.picture && saved.picture !== this.saved?.picture) {
      const url = URL.createObjectURL(saved.picture);
      const picture = h('img', { class: 'work-picture', src: url, alt: '', load: () => URL.revokeObjectURL(url) });
      this.picture.replaceWith(picture);
      this.picture = picture;
    }
    this.saved = saved;
    const words = this.text.textContent?.replace(/ · .*$/, '') ?? '';
    if (saved.corrected) this.words = this.text.textContent = `${words} · corrected`;
  }

  /** @param {boolean} shown whether it is the clip on screen */
  mark(shown) {
    if (shown) this.element.setAttribute('aria-current', 'true');
    else this.element.removeAttribute('aria-current');
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
    if (this.state === 'waiting') this.end('cancelled', 'Cancelled');
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

/**
 * @param {File} file
 * @param {import('../library.js').VideoResult} result
 * @param {number} side
 */
async function pictureOf(file, result, side) {
  const source = await openVideo(file).catch(() => null);
  if (!source) return null;
  const picture = await smallPicture(result, (t) => source.preview(t, side, result.times[t]));
  source.close();
  return picture;
}
