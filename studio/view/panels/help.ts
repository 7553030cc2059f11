// The help dialog, with keys and gestures, and the about dialog, with a check that this browser computes the reference
// results. Loaded when first opened.

import { byId, connectDialog, h, TOUCH } from '../dom.js';
import { version } from '../../model/library.js';
import { explain } from '../../model/messages.js';
import type { Selftest, SelftestCheck } from 'tracecut/selftest';

const KEYS: [keys: string[], what: string][] = [
  [['Space'], 'play or pause'],
  [['←', '→'], 'one frame back or forward'],
  [['Home', 'End'], 'first or last frame'],
  [['N'], 'next place to check'],
  [['V'], 'overlay, side by side, slider, cut-out'],
  [['1', '9'], 'masks, source image'],
  [['+', '−', '0'], 'zoom in, zoom out, fit; or use the wheel'],
  [['Shift', '←', '→', '↑', '↓'], 'pan; or drag'],
  [['W'], 'full screen'],
  [['P'], 'play the original clip'],
  [['O'], 'open a file'],
  [['M'], 'fix the result'],
  [['←', '→', '↑', '↓', 'Enter'], 'on the picture, in Fix: move, and use the tool'],
  [['+', '−', 'Alt'], 'with Add in Fix: larger, smaller, take away'],
  [['Shift', 'Enter'], 'on a listed object: select several; or Shift-click'],
  [['Ctrl', 'Z'], 'undo'],
  [['Ctrl', 'Y'], 'redo'],
  [['E'], 'save'],
  [['Esc'], 'cancel a run, leave Fix, close a dialog'],
  [['Tab'], 'next control'],
  [['?'], 'this list'],
];

const GESTURES: [touches: string, what: string][] = [
  ['Tap an object', 'show only it; tap again to show all'],
  ['Two fingers', 'zoom and pan'],
  ['One finger, when zoomed in', 'pan'],
  ['Fix, then one finger', 'pick, paint, erase, draw strokes; drag from object to object to join them'],
  ['Drag below the picture', 'scrub; the handles of the filmstrip trim the clip'],
];

export class Help {
  dialog = byId<HTMLDialogElement>('help');

  constructor() {
    const entries = KEYS.flatMap(([names, description]) => [
      h('dt', {}, ...names.flatMap((name) => [h('kbd', {}, name), ' '])),
      h('dd', {}, description),
    ]);
    byId('help-keys').replaceChildren(...entries);
    byId('help-touch').replaceChildren(
      ...GESTURES.flatMap(([touch, description]) => [h('dt', {}, touch), h('dd', {}, description)]),
    );
    for (const id of ['help-touch', 'help-touch-title', 'help-keys-title']) byId(id).hidden = !TOUCH;
    byId('help-pick').hidden = TOUCH;
    byId('help-close').addEventListener('click', () => this.dialog.close());
    connectDialog(this.dialog);
  }

  open() {
    if (!this.dialog.open) this.dialog.showModal();
  }
}

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
        'The same clip gives the same result in every browser, bit for bit. The check computes test clips for a few seconds and compares the hash of each part.',
        ' ',
        h('a', more, 'Learn more'),
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
      const result = await selftest({ signal, onCheck: (check) => this.add(check) });
      this.status.textContent = describeResult(result);
    } catch (error) {
      const { title, detail } = explain(error);
      this.status.textContent = signal.aborted ? '' : `${title}: ${detail}`;
    }
    this.start.disabled = false;
  }

  add({ name, what, hash, expected, same }: SelftestCheck) {
    const comparison = same ? 'same' : `differs from ${expected}`;
    // The command line prints the same names and descriptions.
    const term = h('dt');
    const title = h('code');
    title.textContent = name;
    title.title = what;
    term.append(title);
    const meaning = h('dd', { class: same ? 'hash' : 'hash hash-differs' });
    meaning.textContent = `${hash} · ${comparison}`;
    this.list.append(term, meaning);
  }
}

function describeResult({ same, checks }: Selftest) {
  if (same) return `All ${checks.length} parts match.`;
  const different = checks.filter((check) => !check.same).length;
  return `${different} of ${checks.length} parts differ. Please report this browser, its version and this list.`;
}
