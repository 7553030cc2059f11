// The heading, progress, notices, errors, texts for screen readers, and the attributes of the body that style sheets
// use.

import { PLAYS_MP4, byId } from '../dom.js';
import { explain } from '../../model/messages.js';
import type { Phase, State, Store } from '../../model/store.js';

/**
 * Public state of each phase; opening and stopped are both `loading`, as no result is on screen. So is a finished result
 * while another file is opened.
 */
const STATE: Record<Phase, 'loading' | 'running' | 'done' | 'error'> = {
  opening: 'loading',
  running: 'running',
  stopped: 'loading',
  done: 'done',
  error: 'error',
};

export function statusPanel({ store }: { store: Store }) {
  store.watch(['name'], ({ name }) => write('clip-name', name));
  store.watch(['headline', 'isOpening'], ({ headline, isOpening }) => {
    write('headline', isOpening ? 'Opening…' : headline);
  });
  for (const id of ['subline', 'facts']) store.watch(['subline'], ({ subline }) => write(id, subline));
  store.watch(['summary'], ({ summary }) => writeOrHide('summary', summary));
  store.watch(['notice'], ({ notice }) => writeOrHide('notice', notice));
  // A file could not be opened: the notice is at the top of the panel.
  store.watch(['isOpening'], ({ isOpening, notice }) => {
    if (!isOpening && notice) byId('notice').scrollIntoView({ block: 'nearest' });
  });
  // Read aloud by screen readers when they are idle.
  store.watch(['announcement'], ({ announcement }) => write('live', announcement));
  store.watch(['share'], ({ share }) => showShare(share));
  store.watch(['phase', 'error'], ({ phase, error }) => phase === 'error' && showError(error));
  store.watch(['preview'], ({ preview }) => document.body.toggleAttribute('data-preview', preview !== null));
  store.watch(['source', 'isStreaming', 'job', 'phase'], showFacts);
  store.watch(['phase', 'source', 'analysis', 'job', 'isCorrecting', 'isOutdated'], showPrimary);
  store.watch(['phase', 'source', 'analysis'], endWelcome);
  // Last, so that everything else is up to date when the state changes.
  store.watch(['phase', 'error', 'isOpening'], showPhase, { last: true });
}

function write(id: string, text: string) {
  byId(id).textContent = text;
}

function writeOrHide(id: string, text: string) {
  write(id, text);
  byId(id).hidden = text === '';
}

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

function showFacts({ source, isStreaming, job }: Readonly<State>) {
  const { body } = document;
  if (source) body.dataset.source = source.kind;
  else delete body.dataset.source;
  body.toggleAttribute('data-streaming', isStreaming);
  body.toggleAttribute('data-partial', job?.isPartial ?? false);
}

/** Highlights the button of the next step. */
function showPrimary({ phase, source, analysis, job, isCorrecting, isOutdated }: Readonly<State>) {
  const hasOwn = source !== null && source.kind !== 'sample';
  let next = hasOwn && phase === 'running' ? '' : 'open';
  if (phase === 'done' && hasOwn && analysis) next = 'export-open';
  if (phase === 'stopped' || job?.isPartial) next = 'resume';
  if (isOutdated) next = 'again';
  if (isCorrecting) next = 'correct-done';
  for (const id of ['open', 'export-open', 'resume', 'again', 'correct-done'])
    byId(id).classList.toggle('primary', id === next);
}

/** Removes the welcome picture once there is a user's clip or a result. */
function endWelcome({ phase, source, analysis }: Readonly<State>) {
  const isFirst = (phase === 'opening' || phase === 'running') && !analysis && (source?.kind ?? 'sample') === 'sample';
  if (!isFirst) document.getElementById('welcome')?.remove();
}

function showPhase({ phase, isOpening }: Readonly<State>) {
  document.body.dataset.phase = phase;
  keepFocus();
  document.body.dataset.state = isOpening ? 'loading' : STATE[phase];
  if (phase === 'error') byId('error').focus();
}

/** Moves the focus if the focused button of the heading was hidden. */
function keepFocus() {
  const buttons = [...document.querySelectorAll('.heading-actions button')] as HTMLElement[];
  const focused = buttons.find((button) => button === document.activeElement);
  if (!focused || focused.offsetParent) return;
  buttons.find((button) => button.offsetParent)?.focus();
}
