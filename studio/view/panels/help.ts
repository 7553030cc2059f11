// The help dialog: keys and gestures.

import { TOUCH, byId, connectDialog, h } from '../dom.js';

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
