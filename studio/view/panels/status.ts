// The heading, the bar of the whole run, notices, the card for errors, what screen readers are told, and the attributes
// of the body that the style sheets go by.

import { PLAYS_MP4, byId } from '../dom.js';
import { explain } from '../../model/words.js';
import type { Phase, State, Store } from '../../model/store.js';

/** The public state of each phase: opening and stopped are both `loading`, as no result is on screen. */
const STATE: Record<Phase, 'loading' | 'running' | 'done' | 'error'> = {
  opening: 'loading',
  running: 'running',
  stopped: 'loading',
  done: 'done',
  error: 'error',
};

export function statusPanel({ store }: { store: Store }) {
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

function write(id: string, text: string) {
  byId(id).textContent = text;
}

function writeOrHide(id: string, text: string) {
  write(id, text);
  byId(id).hidden = text === '';
}

/** @param share of the run, in 0..1 */
function showShare(share: number) {
  const bar = byId('progress');
  bar.style.setProperty('--share', String(share));
  bar.setAttribute('aria-valuenow', String(Math.round(share * 100)));
}

function showError(error: unknown) {
  const { code, title, advice, detail } = explain(error, PLAYS_MP4);
  write('error-title', title);
  write('error-advice', advice);
  writeOrHide('error-detail', detail);
  byId('error').dataset.code = code;
}

function showFacts({ source, found, streaming, job }: Readonly<State>) {
  const { body } = document;
  if (source) body.dataset.source = source.kind;
  else delete body.dataset.source;
  body.toggleAttribute('data-masks', Boolean(found?.points));
  body.toggleAttribute('data-streaming', streaming);
  body.toggleAttribute('data-partial', job?.partial ?? false);
}

/** One button is the next step, and looks like it. */
function showPrimary({ phase, source, found, job, correcting, pending }: Readonly<State>) {
  const hasOwn = source !== null && source.kind !== 'sample';
  let next = hasOwn && phase === 'running' ? '' : 'open';
  if (phase === 'done' && hasOwn && found?.points) next = 'export-open';
  if (phase === 'stopped' || job?.partial) next = 'resume';
  if (pending) next = 'again';
  if (correcting) next = 'correct-done';
  for (const id of ['open', 'export-open', 'resume', 'again', 'correct-done'])
    byId(id).classList.toggle('primary', id === next);
}

/** What shows what the page does has done so when there is something of one's own, or the sample's objects. */
function endWelcome({ phase, source, found }: Readonly<State>) {
  const isFirst = (phase === 'opening' || phase === 'running') && !found && (source?.kind ?? 'sample') === 'sample';
  if (!isFirst) document.getElementById('welcome')?.remove();
}

function showPhase({ phase }: Readonly<State>) {
  document.body.dataset.phase = phase;
  keepFocus();
  document.body.dataset.state = STATE[phase];
  if (phase === 'error') byId('error').focus();
}

/** Buttons of the heading come and go with the phase; the keyboard's place stays among them. */
function keepFocus() {
  const buttons = [...document.querySelectorAll('.heading-actions button')] as HTMLElement[];
  const focused = buttons.find((button) => button === document.activeElement);
  if (!focused || focused.offsetParent) return;
  buttons.find((button) => button.offsetParent)?.focus();
}
