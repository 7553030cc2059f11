/** The dialog in which results are saved: files, a link with the settings, and what it takes to get the same result again. @module */

import { byId, h } from './dom.js';
import { EXPORTS, stemOf } from './exports.js';
import { connectDialog } from './help.js';
import { explain, plural } from './words.js';

/** @typedef {import('./exports.js').Subject} Subject */

/** How long a file that was saved stays in memory for the browser to read, in milliseconds. */
const KEPT_MS = 60_000;

export class ExportPanel {
  /**
   * @param {object} parts
   * @param {() => Omit<Subject, 'objects'> | null} parts.subject what there is to save; null without a result
   * @param {(object: number) => boolean} parts.visible
   * @param {() => string} parts.link an address that opens the page with these settings
   * @param {() => Promise<string>} parts.recipe what it takes to get the same result again
   */
  constructor({ subject, visible, link, recipe }) {
    this.subject = subject;
    this.visible = visible;
    this.recipe = recipe;
    this.dialog = /** @type {HTMLDialogElement} */ (byId('export'));
    this.shownOnly = /** @type {HTMLInputElement} */ (byId('export-shown'));
    /** @type {AbortController | null} */
    this.abort = null;
    byId('export-list').replaceChildren(...EXPORTS.map((one) => this.row(one)));
    byId('export-open').addEventListener('click', () => this.open());
    byId('export-close').addEventListener('click', () => this.dialog.close());
    byId('export-cancel').addEventListener('click', () => this.abort?.abort());
    byId('copy-link').addEventListener('click', () => this.copy(link(), 'The link'));
    byId('copy-recipe').addEventListener('click', () => this.copy(byId('recipe').textContent ?? '', 'The recipe'));
    byId('recipe-box').addEventListener('toggle', () => this.showRecipe());
    this.dialog.addEventListener('close', () => this.abort?.abort());
    connectDialog(this.dialog);
  }

  open() {
    if (!this.subject() || this.dialog.open) return;
    this.tell('');
    this.setBusy(false);
    /** @type {HTMLDetailsElement} */ (byId('recipe-box')).open = false;
    this.dialog.showModal();
  }

  /** @param {import('./exports.js').Export} one */
  row({ title, about, choices }) {
    const buttons = choices.map((choice) =>
      h(
        'button',
        { type: 'button', class: 'save', 'data-export': choice.id, 'aria-label': choice.says ?? `${title}: ${choice.label}`, click: () => this.save(choice) },
        choice.label,
      ),
    );
    return h('li', { class: 'export' }, h('h3', {}, title), h('p', { class: 'about' }, about), h('div', { class: 'saves' }, ...buttons));
  }

  /** @param {import('./exports.js').Choice} choice */
  async save(choice) {
    const found = this.subject();
    if (!found || this.abort) return;
    const subject = { ...found, objects: (/** @type {number} */ object) => object > 0 && (!this.shownOnly.checked || this.visible(object)) };
    const file = `${stemOf(subject.name)}-${choice.file(subject)}`;
    this.abort = new AbortController();
    const { signal } = this.abort;
    this.setBusy(true);
    this.tell(`Making ${file}…`);
    const onProgress = (/** @type {{done: number, total: number}} */ { done, total }) => {
      byId('export-bar').style.setProperty('--share', String(done / total));
      byId('export-bar').setAttribute('aria-valuenow', String(Math.round((100 * done) / total)));
      byId('export-count').textContent = `${done} of ${plural(total, 'frame')}`;
    };
    try {
      const blob = await choice.make(subject, { signal, onProgress });
      signal.throwIfAborted();
      download(blob, file);
      this.tell(`Saved ${file}, ${sizeOf(blob)}.`);
    } catch (error) {
      if (signal.aborted) this.tell('Cancelled; nothing was saved.');
      else this.tell(wordsOf(error), true);
    } finally {
      this.abort = null;
      this.setBusy(false);
    }
  }

  /** @param {boolean} busy */
  setBusy(busy) {
    for (const button of this.dialog.querySelectorAll('.save')) /** @type {HTMLButtonElement} */ (button).disabled = busy;
    byId('export-progress').hidden = !busy;
    byId('export-bar').style.setProperty('--share', '0');
    byId('export-bar').setAttribute('aria-valuenow', '0');
    byId('export-count').textContent = '';
  }

  /**
   * @param {string} text
   * @param {boolean} [wrong]
   */
  tell(text, wrong = false) {
    byId('export-status').textContent = text;
    byId('export-status').classList.toggle('is-wrong', wrong);
  }

  async showRecipe() {
    if (!(/** @type {HTMLDetailsElement} */ (byId('recipe-box')).open)) return;
    byId('recipe').textContent = await this.recipe();
  }

  /**
   * @param {string} text
   * @param {string} what
   */
  async copy(text, what) {
    try {
      await navigator.clipboard.writeText(text);
      this.tell(`${what} is on the clipboard.`);
    } catch {
      this.tell(`The browser does not let the page write to the clipboard. Copy it yourself: ${text}`, true);
    }
  }
}

/**
 * @param {Blob} blob
 * @param {string} file
 */
function download(blob, file) {
  const url = URL.createObjectURL(blob);
  h('a', { href: url, download: file }).click();
  setTimeout(() => URL.revokeObjectURL(url), KEPT_MS);
}

/** @param {unknown} error */
function wordsOf(error) {
  const { title, advice, detail } = explain(error);
  return [title, advice, detail].filter(Boolean).join('. ');
}

/** @param {Blob} blob */
function sizeOf({ size }) {
  return size < 1e6 ? `${Math.max(1, Math.round(size / 1e3))}\u00a0KB` : `${(size / 1e6).toFixed(1)}\u00a0MB`;
}
