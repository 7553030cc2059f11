/** Keys of the page; help.js lists them. @module */

import { byId } from './dom.js';
import { openHelp } from './help.js';
import { phase } from './status.js';

/** @param {import('./app.js').App} app */
export function connectKeys(app) {
  /** @type {Record<string, () => unknown>} */
  const actions = {
    ' ': () => app.timeline.toggle(),
    ArrowLeft: () => app.timeline.step(-1),
    ArrowRight: () => app.timeline.step(1),
    Home: () => app.timeline.jump(0),
    End: () => app.timeline.jump(app.timeline.numFrames - 1),
    Escape: () => app.cancel(),
    '?': openHelp,
    v: () => app.compare.next(),
    m: () => app.correction.toggle(),
    e: () => app.exports.open(),
    o: () => byId('open').click(),
    r: () => ['done', 'stopped'].includes(phase()) && app.start(),
  };
  // Whether the focus got where it is by the keyboard: then the space bar belongs to the button that has it.
  let tabbed = false;
  addEventListener('pointerdown', () => (tabbed = false), true);
  addEventListener('keydown', (event) => {
    if (event.key === 'Tab') tabbed = true;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'z' && app.correction.on) {
      event.preventDefault();
      app.correction.undo();
    }
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (document.querySelector('dialog[open]')) return;
    const action = actions[event.key] ?? actions[event.key.toLowerCase()] ?? app.panel.action(event.key);
    if (!action || keepsKey(event, tabbed)) return;
    event.preventDefault();
    // A button that was clicked with the mouse would still answer to the space bar.
    if (event.key === ' ') /** @type {HTMLElement} */ (event.target).blur();
    action();
  });
}

/**
 * Form fields keep the keys that they use themselves, and so do buttons that were reached with the keyboard.
 *
 * @param {KeyboardEvent} event
 * @param {boolean} tabbed
 * @returns {boolean}
 */
function keepsKey(event, tabbed) {
  if (event.key === 'Escape') return false;
  const target = /** @type {HTMLElement} */ (event.target);
  if (target.matches('select, textarea, input[type="number"]')) return true;
  if (target.matches('input[type="range"]')) return /^(Arrow|Home|End|Page)/.test(event.key);
  return event.key === ' ' && tabbed && target.matches('button, input, a');
}
