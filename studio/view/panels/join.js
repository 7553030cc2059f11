/**
 * Joining: objects that are one thing become one, in one step. The user chooses them; those that look like one are
 * proposed. Fetched with what corrects.
 * @module
 */

import { byId, h } from '../dom.js';
import { alikeObjects } from '../../model/alike.js';
import { objectColor, objectName, objectShape } from '../../model/palette.js';
import { plural } from '../../model/words.js';
import { boxOf, drawFrame } from './correction.js';

/** A result that stays for so long is looked at, in milliseconds. */
const WAIT_MS = 200;

export class JoinBar {
  /**
   * @param {Pick<import('../page.js').Page, 'store' | 'viewer'>} page
   * @param {import('./correction.js').Correction} correction
   */
  constructor({ store, viewer }, correction) {
    this.store = store;
    this.viewer = viewer;
    this.correction = correction;
    /** @type {number[][]} Groups that look like one thing. */
    this.alike = [];
    /** @type {Set<string>} Groups that the user does not want. */
    this.refused = new Set();
    /** @type {{found: unknown, count: number} | null} What was joined last, and the result of it. */
    this.joined = null;
    this.pointed = false;
    this.timer = 0;
    byId('join-do').addEventListener('click', () => this.join());
    byId('join-no').addEventListener('click', () => this.refuse());
    byId('join-undo').addEventListener('click', () => correction.undo());
    for (const name of ['pointerenter', 'focusin', 'pointerleave', 'focusout'])
      byId('join').addEventListener(name, () => this.point(/enter|in$/.test(name)));
    viewer.painters.push((ctx, view) => {
      for (const object of this.marked) drawFrame(ctx, view, boxOf(view, object));
    });
    store.watch(['visit'], () => this.refused.clear());
    store.watch(['found', 'phase'], () => this.look());
    store.watch(['found', 'phase', 'chosen'], () => this.show());
  }

  /** @returns {number[]} the objects that would be joined */
  get meant() {
    const { chosen } = this.store.state;
    return chosen.size > 0 ? [...chosen] : (this.proposal ?? []);
  }

  /** @returns {number[]} those that are marked in the picture */
  get marked() {
    return this.store.state.chosen.size > 0 || this.pointed ? this.meant : [];
  }

  get proposal() {
    return this.alike.find((group) => !this.refused.has(String(group)));
  }

  /** Looks which objects are alike, when there is time. */
  look() {
    this.alike = [];
    clearTimeout(this.timer);
    const { found, phase } = this.store.state;
    const points = found?.points;
    if (phase !== 'done' || !points || !this.correction.corrector) return;
    this.timer = window.setTimeout(() => {
      const { width, height, numFrames, trajectories } = points.result;
      const labels = (/** @type {number} */ t) => /** @type {Uint8Array} */ (points.mask(t));
      this.alike = alikeObjects({ width, height, numFrames, trajectories, labels, scene: points.scene });
      this.show();
    }, WAIT_MS);
  }

  show() {
    const { chosen, found, phase } = this.store.state;
    const { meant, joined } = this;
    const isDone = joined?.found === found && chosen.size === 0;
    const shows = phase === 'done' && (isDone || meant.length > 0);
    byId('join').hidden = !shows;
    for (const row of document.querySelectorAll('.object')) {
      const object = Number(/** @type {HTMLElement} */ (row).dataset.object);
      row.classList.toggle('is-meant', shows && !isDone && meant.includes(object));
    }
    this.viewer.redraw();
    if (!shows) return;
    byId('join-words').replaceChildren(...(isDone ? [] : meant.map(swatchOf)), this.words(isDone));
    const button = /** @type {HTMLButtonElement} */ (byId('join-do'));
    button.hidden = byId('join-no').hidden = isDone;
    button.disabled = meant.length < 2;
    byId('join-no').textContent = chosen.size > 0 ? 'Choose none' : 'Dismiss';
    byId('join-undo').hidden = !isDone;
  }

  /** @param {boolean} isDone */
  words(isDone) {
    const { chosen } = this.store.state;
    if (isDone) return `${plural(this.joined?.count ?? 0, 'object')} joined.`;
    if (chosen.size === 0) return `These ${this.meant.length} look like one: join?`;
    return chosen.size > 1 ? `${plural(chosen.size, 'object')} chosen` : 'Choose another one too.';
  }

  async join() {
    const [into, ...others] = this.meant;
    if (others.length === 0) return;
    const held = byId('join').contains(document.activeElement);
    const { found } = this.store.state;
    await this.correction.apply((corrector) => corrector.join(into, others));
    if (this.store.state.found === found) return;
    this.joined = { found: this.store.state.found, count: others.length + 1 };
    this.show();
    // The button that had it is gone.
    if (held) byId('join-undo').focus();
  }

  refuse() {
    const { chosen } = this.store.state;
    if (chosen.size === 0) this.refused.add(String(this.proposal));
    this.store.set({ chosen: new Set() });
    this.show();
    if (byId('join').hidden) /** @type {HTMLElement} */ (document.querySelector('.object-main'))?.focus();
  }

  /** @param {boolean} pointed whether the pointer or the focus is here */
  point(pointed) {
    this.pointed = pointed;
    this.viewer.redraw();
  }
}

/** @param {number} object */
function swatchOf(object) {
  const swatch = h('span', { class: `swatch swatch-${objectShape(object)}`, 'aria-hidden': 'true' });
  swatch.style.setProperty('--mark', objectColor(object));
  return h('span', { title: objectName(object) }, swatch, h('span', { class: 'visually-hidden' }, objectName(object)));
}
