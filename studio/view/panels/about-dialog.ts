// What this page is, and whether this browser computes what every other does; fetched when it is first opened.

import { version } from '../../model/library.js';
import { h, connectDialog } from '../dom.js';
import { explain } from '../../model/words.js';
import type { Selftest, SelftestCheck } from 'tracecut/selftest';

export class AboutDialog {
  abort: AbortController | null = null;
  list = h('dl', { class: 'keys about-hashes' });
  status = h('p', { class: 'export-status', id: 'about-status', role: 'status' });
  start = h('button', { type: 'button', id: 'about-check', click: () => this.check() }, 'Check this browser');
  dialog: HTMLDialogElement;

  constructor() {
    this.dialog = h('dialog', { class: 'dialog', id: 'about', 'aria-labelledby': 'about-title' }, ...this.content());
    this.dialog.addEventListener('close', () => this.abort?.abort());
    document.body.append(this.dialog);
    connectDialog(this.dialog);
  }

  content() {
    const close = { type: 'button', class: 'icon-button', id: 'about-close', 'aria-label': 'Close' };
    const page = 'https://github.com/tracecut/tracecut/blob/HEAD/docs/determinism.md';
    const more = { href: page, target: '_blank', rel: 'noopener' };
    return [
      h(
        'div',
        { class: 'dialog-head' },
        h('h2', { id: 'about-title' }, 'About'),
        h('button', { ...close, click: () => this.dialog.close() }, '✕'),
      ),
      h('p', { class: 'about' }, `TraceCut ${version}, free software under the MIT or Apache licence.`),
      h(
        'p',
        { class: 'about' },
        'The same clip gives the same result in every browser, to the last bit. This browser is checked by computing made clips, which takes some seconds; each line below is then a part of the program and what it came to.',
        ' ',
        h('a', more, 'What is promised'),
      ),
      h('div', { class: 'saves' }, this.start),
      this.status,
      this.list,
    ];
  }

  open() {
    if (!this.dialog.open) this.dialog.showModal();
  }

  async check() {
    this.abort?.abort();
    const { signal } = (this.abort = new AbortController());
    this.list.replaceChildren();
    this.start.disabled = true;
    this.status.textContent = 'Checking…';
    try {
      const { selftest } = await import('tracecut/selftest');
      const found = await selftest({ signal, onCheck: (check) => this.add(check) });
      this.status.textContent = verdict(found);
    } catch (error) {
      const { title, detail } = explain(error);
      this.status.textContent = signal.aborted ? '' : `${title}: ${detail}`;
    }
    this.start.disabled = false;
  }

  add({ name, what, hash, expected, same }: SelftestCheck) {
    const words = same ? 'the same' : `differs from ${expected}`;
    // Names and meanings are those that the programs print, in English everywhere.
    const term = h('dt');
    const title = h('code');
    title.textContent = name;
    title.title = what;
    term.append(title);
    const meaning = h('dd', { class: same ? 'hash' : 'hash hash-differs' });
    meaning.textContent = `${hash} · ${words}`;
    this.list.append(term, meaning);
  }
}

function verdict({ same, checks }: Selftest) {
  if (same) return `All ${checks.length} parts came to what they come to everywhere.`;
  const different = checks.filter((check) => !check.same).length;
  return `${different} of ${checks.length} parts came to something else: please report this browser, its version and this list.`;
}
