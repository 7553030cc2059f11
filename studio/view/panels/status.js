/**
 * The heading, the bar of the whole run, notices, the card for errors, what screen readers are told, and the attributes
 * of the body that the style sheets go by.
 * @module
 */

import { PLAYS_MP4, byId } from '../dom.js';
import { explain } from '../../model/words.js';

/** @typedef {import('../../model/store.js').State} State */
/** @typedef {import('../../model/store.js').Store} Store */

/**
 * The public state of each phase: opening and stopped are both `loading`, as no result is on screen.
 *
 * @type {Record<import('../../model/store.js').Phase, 'loading' | 'running' | 'done' | 'error'>}
 */
const STATE = {
  opening: 'loading',
  running: 'running',
  stopped: 'loading',
  done: 'done',
  error: 'error',
};

/** @param {{store: Store}} page */
export function statusPanel({ store }) {
  store.watch(['name'], ({ name }) => write('clip-name', name));
  store.watch(['headline'], ({ headline }) => write('headline', headline));
  for (const id of ['subline', 'facts']) store.watch(['subline'], ({ subline }) => write(id, subline));
  store.watch(['summary'], ({ summary }) => writeOrHide('summary', summary));
  store.watch(['notice'], ({ notice }) => writeOrHide('notice', notice));
  // Read aloud by screen readers when they are idle.
  store.watch(['live'], ({ live }) => write('live', live));
  store.watch(['share'], ({ share }) => showShare(share));
  store.watch(['phase', 'error'], ({ phase, error }) => phase === 'error' && showError(error));
  store.watch(['preview'], ({ preview }) => document.body.toggleAttribute('data-preview', preview !== null));
  store.watch(['source', 'found', 'streaming', 'job', 'phase'], showFacts);
  store.watch(['phase', 'source', 'found', 'job', 'correcting', 'pending'], showPrimary);
  store.watch(['phase', 'source', 'found'], endWelcome);
  // Last, so that whoever waits for the state finds everything else in place.
  store.watch(['phase', 'error'], showPhase, { last: true });
}

/**
 * @param {string} id
 * @param {string} text
 */
function write(id, text) {
  byId(id).textContent = text;
}

/**
 * @param {string} id
 * @param {string} text
 */
function writeOrHide(id, text) {
  write(id, text);
  byId(id).hidden = text === '';
}

/** @param {number} share of the run, in 0..1 */
function showShare(share) {
  const bar = byId('progress');
  bar.style.setProperty('--share', String(share));
  bar.setAttribute('aria-valuenow', String(Math.round(share * 100)));
}

/** @param {unknown} error */
function showError(error) {
  const { code, title, advice, detail } = explain(error, PLAYS_MP4);
  write('error-title', title);
  write('error-advice', advice);
  writeOrHide('error-detail', detail);
  byId('error').dataset.code = code;
}

/** @param {Readonly<State>} state */
function showFacts({ source, found, streaming, job }) {
  const { body } = document;
  if (source) body.dataset.source = source.kind;
  else delete body.dataset.source;
  body.toggleAttribute('data-masks', Boolean(found?.points));
  body.toggleAttribute('data-streaming', streaming);
  body.toggleAttribute('data-partial', job?.partial ?? false);
}

/**
 * One button is the next step, and looks like it.
 *
 * @param {Readonly<State>} state
 */
function showPrimary({ phase, source, found, job, correcting, pending }) {
  const hasOwn = source !== null && source.kind !== 'sample';
  let next = hasOwn && phase === 'running' ? '' : 'open';
  if (phase === 'done' && hasOwn && found?.points) next = 'export-open';
  if (phase === 'stopped' || job?.partial) next = 'resume';
  if (pending) next = 'again';
  if (correcting) next = 'correct-done';
  for (const id of ['open', 'export-open', 'resume', 'again', 'correct-done'])
    byId(id).classList.toggle('primary', id === next);
}

/**
 * What shows what the page does has done so when there is something of one's own, or the sample's objects.
 *
 * @param {Readonly<State>} state
 */
function endWelcome({ phase, source, found }) {
  const isFirst = (phase === 'opening' || phase === 'running') && !found && (source?.kind ?? 'sample') === 'sample';
  if (!isFirst) document.getElementById('welcome')?.remove();
}

/** @param {Readonly<State>} state */
function showPhase({ phase }) {
  document.body.dataset.phase = phase;
  keepFocus();
  document.body.dataset.state = STATE[phase];
  if (phase === 'error') byId('error').focus();
}

/** Buttons of the heading come and go with the phase; the keyboard's place stays among them. */
function keepFocus() {
  const buttons = /** @type {HTMLElement[]} */ ([...document.querySelectorAll('.heading-actions button')]);
  const focused = buttons.find((button) => button === document.activeElement);
  if (!focused || focused.offsetParent) return;
  buttons.find((button) => button.offsetParent)?.focus();
}
