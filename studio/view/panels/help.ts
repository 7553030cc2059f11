// Help: the keys that the page has.

import { TOUCH, byId, connectDialog, h } from '../dom.js';

const KEYS: [keys: string[], what: string][] = [
  [['Space'], 'play or pause'],
  [['←', '→'], 'one frame back or forward'],
  [['Home', 'End'], 'first or last frame'],
  [['V'], 'overlay, side by side, slider, cut-out'],
  [['1', '9'], 'masks, source image'],
  [['+', '−', '0'], 'closer, farther, all; the wheel does it too'],
  [['Shift', '←', '→', '↑', '↓'], 'move about; dragging does it too'],
  [['W'], 'fill the screen'],
  [['P'], 'play the clip as it is'],
  [['O'], 'open a file'],
  [['M'], 'fix the result'],
  [['Shift', 'Enter'], 'on an object of the list: choose it with others; Shift and a click does it too'],
  [['Ctrl', 'Z'], 'undo'],
  [['Ctrl', 'Y'], 'do it again'],
  [['E'], 'save'],
  [['Esc'], 'cancel a run, close a dialog'],
  [['Tab'], 'next control'],
  [['?'], 'this list'],
];

/** What fingers do. */
const TOUCHES: [touches: string, what: string][] = [
  ['Tap an object', 'it alone; again, or the background, for all'],
  ['Two fingers', 'closer, farther, move about'],
  ['One finger, when closer', 'move about'],
  ['Fix, then one finger', 'pick, paint, wipe away, draw strokes'],
  ['Drag below the picture', 'go through the clip; the handles of the filmstrip choose a part'],
];

export class Help {
  dialog = byId<HTMLDialogElement>('help');

  constructor() {
    const entries = KEYS.flatMap(([names, what]) => [
      h('dt', {}, ...names.flatMap((name) => [h('kbd', {}, name), ' '])),
      h('dd', {}, what),
    ]);
    byId('help-keys').replaceChildren(...entries);
    byId('help-touch').replaceChildren(...TOUCHES.flatMap(([touch, what]) => [h('dt', {}, touch), h('dd', {}, what)]));
    for (const id of ['help-touch', 'help-touch-title', 'help-keys-title']) byId(id).hidden = !TOUCH;
    byId('help-pick').hidden = TOUCH;
    byId('help-close').addEventListener('click', () => this.dialog.close());
    connectDialog(this.dialog);
  }

  open() {
    if (!this.dialog.open) this.dialog.showModal();
  }
}
