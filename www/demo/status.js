/** The heading, the bar of the whole run, the card for errors, and what screen readers are told. @module */

import { byId } from './dom.js';
import { explain } from './words.js';

/**
 * What the page is doing. Several phases share one of the four public states in `document.body.dataset.state`:
 * opening, setup and stopped are all `loading`, as no result is on screen.
 *
 * @typedef {'opening' | 'setup' | 'running' | 'stopped' | 'done' | 'error'} Phase
 */

/** @type {Record<Phase, 'loading' | 'running' | 'done' | 'error'>} */
const STATE = { opening: 'loading', setup: 'loading', running: 'running', stopped: 'loading', done: 'done', error: 'error' };

/**
 * @param {Phase} phase
 * @param {string} headline
 * @param {string} subline
 * @param {string} [summary] what is seen
 */
export function showPhase(phase, headline, subline, summary = '') {
  byId('headline').textContent = headline;
  showSubline(subline);
  byId('summary').textContent = summary;
  byId('summary').hidden = summary === '';
  say(phase === 'error' ? '' : [headline, subline, summary].filter(Boolean).join('. '));
  document.body.dataset.phase = phase;
  keepFocus();
  // Last, so that whoever waits for the state finds everything else in place.
  document.body.dataset.state = STATE[phase];
}

/** Buttons of the heading come and go with the phase; the keyboard's place stays among them. */
function keepFocus() {
  const buttons = [...document.querySelectorAll('.heading-actions button')];
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  if (!focused || !buttons.includes(focused) || focused.offsetParent) return;
  const shown = /** @type {HTMLElement | undefined} */ (buttons.find((button) => /** @type {HTMLElement} */ (button).offsetParent));
  shown?.focus();
}

/** @returns {Phase} */
export function phase() {
  return /** @type {Phase} */ (document.body.dataset.phase ?? 'opening');
}

/** @param {string} text */
export function showSubline(text) {
  byId('subline').textContent = text;
}

/** @param {string} text read aloud by screen readers when they are idle */
export function say(text) {
  byId('live').textContent = text;
}

/** @param {number} share of the run, in 0..1 */
export function showProgress(share) {
  const bar = byId('progress');
  bar.style.setProperty('--share', String(share));
  bar.setAttribute('aria-valuenow', String(Math.round(share * 100)));
}

/** @param {string} text shown above the picture, empty for none */
export function showNotice(text) {
  byId('notice').hidden = text === '';
  byId('notice').textContent = text;
}

/** @param {unknown} error */
export function showError(error) {
  const { code, title, advice, detail } = explain(error);
  byId('error-title').textContent = title;
  byId('error-advice').textContent = advice;
  byId('error-detail').textContent = detail;
  byId('error-detail').hidden = detail === '';
  byId('error').dataset.code = code;
  showPhase('error', 'Nothing to show', '');
  byId('error').focus();
}
