// Loads dialogs and panels when they are first opened.

import * as storage from '../storage.js';
import { searchReport } from '../../model/library.js';
import { TOUCH, byId, h } from '../dom.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';
import type { Projects } from './projects.js';

/** Fetched to test the network; the service worker caches it too. */
const PROBE = './favicon.svg';

/** Shortest time between two warm-ups, in milliseconds: shorter than idle workers live. */
const WARM_UP_INTERVAL_MS = 4000;

const OFFLINE = 'You’re offline. Try again when you’re connected.';
const NOT_LOADED = 'A part of the page didn’t load. Reload the page to try again.';

/**
 * Returns a function that loads a dialog and opens it. Without a network it shows a notice, and the next call tries
 * again. The network is tested before the import, as some browsers never repeat a failed import until the page is reloaded.
 * @param isWanted returns true if the user waits for it
 * @returns `prepare` loads it without opening; resolves to undefined on failure
 */
function onDemand(
  store: Store,
  importDialog: () => Promise<{ open: () => void }>,
  isWanted: () => boolean = () => true,
): (() => Promise<void>) & { prepare: () => Promise<unknown> } {
  let loading: Promise<{ open: () => void }> | undefined;
  let isOffline = false;
  const load = async () => {
    markLoading(1);
    try {
      isOffline = true;
      await fetch(PROBE, { cache: 'no-store' });
      isOffline = false;
      return await importDialog();
    } finally {
      markLoading(-1);
    }
  };
  const prepare = () => (loading ??= load());
  const open = async () => {
    try {
      await prepare();
    } catch {
      loading = undefined;
      if (!isWanted()) return;
      store.set({ notice: isOffline ? OFFLINE : NOT_LOADED });
    }
    (await loading)?.open();
  };
  return Object.assign(open, { prepare: () => prepare().catch(() => void (loading = undefined)) });
}

/** Number of parts that are loading. */
let loadingCount = 0;

/** The body has `data-loading` while a part of the page loads, as the part may change the layout. */
function markLoading(change: 1 | -1) {
  loadingCount += change;
  document.body.toggleAttribute('data-loading', loadingCount > 0);
}

export function correctPanel(page: Pick<Page, 'app' | 'store' | 'viewer' | 'keys' | 'selection'>) {
  const { store } = page;
  let [isLoaded, isOpening] = [false, false];
  const importFix = async () => {
    const [{ Correction }, { JoinBar }] = await Promise.all([import('./correction.js'), import('./join.js')]);
    const correction = new Correction(page);
    new JoinBar(page, correction);
    isLoaded = true;
    return {
      open: () => {
        if (isOpening) correction.open();
        isOpening = false;
      },
    };
  };
  const fetching = onDemand(store, importFix, () => isOpening || store.state.selected.size > 0);
  const open = () => {
    isOpening = true;
    return fetching();
  };
  byId('correct-open').addEventListener('click', open);
  page.keys.on('m', () => {
    // It has the focus then.
    page.keys.tabbed = true;
    void open();
  });
  store.watch(['selected', 'phase', 'analysis'], ({ selected, phase, source, job }) => {
    // A user's clip may have similar objects to propose; a repaired one has something to undo.
    if (!isLoaded && (selected.size > 0 || job?.isCorrected || (phase === 'done' && source?.files))) void fetching();
  });
}

export function helpPanel(page: Pick<Page, 'store' | 'keys'>) {
  const open = onDemand(page.store, async () => new (await import('./help.js')).Help());
  const about = onDemand(page.store, async () => new (await import('./help.js')).AboutDialog());
  byId('help-open').addEventListener('click', open);
  byId('about-open').addEventListener('click', about);
  page.keys.on('?', open);
}

export function exportPanel(page: Pick<Page, 'store' | 'selection' | 'keys' | 'viewer'>) {
  const open = onDemand(page.store, async () => new (await import('./export-dialog.js')).ExportDialog(page));
  byId('export-open').addEventListener('click', open);
  // Starts workers and codecs before the dialog opens.
  let warmed = -Infinity;
  const warmUpSoon = async () => {
    if (performance.now() - warmed < WARM_UP_INTERVAL_MS) return;
    warmed = performance.now();
    if (await open.prepare()) await (await import('./save-preview.js')).warmUp();
  };
  for (const kind of ['pointerenter', 'focus'])
    byId('export-open').addEventListener(kind, () => void warmUpSoon().catch(() => {}));
  page.keys.on('e', open);
}

export function doubtsPanel(page: Pick<Page, 'store' | 'keys'>) {
  const { store } = page;
  const load = onDemand(
    store,
    async () => {
      const { DoubtsPanel } = await import('./doubts.js');
      new DoubtsPanel(page);
      return { open() {} };
    },
    () => false,
  );
  store.watch(['phase', 'doubts', 'agreement'], ({ phase, doubts, agreement }) => {
    if (phase === 'done' && (doubts.length > 0 || agreement)) void load();
  });
}

export function nothingPanel(page: Pick<Page, 'app' | 'store'>) {
  const { store } = page;
  const isNothing = () => foundNothing(store.state);
  const show = onDemand(
    store,
    async () => {
      const suggestions = await import('../../model/suggestions.js');
      return { open: () => isNothing() && showSuggestions(page, suggestions) };
    },
    isNothing,
  );
  store.watch(['phase', 'analysis', 'isCorrecting'], () => {
    byId('suggestions').hidden = !isNothing();
    if (isNothing()) void show();
  });
}

/** Returns whether a finished run has no objects and none is being added. */
function foundNothing({ phase, analysis, job, isCorrecting }: State): boolean {
  if (phase !== 'done' || isCorrecting || !analysis || !job || job.isPartial) return false;
  return !analysis.facts.some(({ object, first }) => object > 0 && first >= 0);
}

export function savedPanel(page: Pick<Page, 'store' | 'app'>) {
  let loading: Promise<Projects> | undefined;
  const loadProjects = () => (loading ??= import('./projects.js').then(({ startAutosave }) => startAutosave(page)));
  page.store.watch(['source'], ({ source }) => {
    if (source?.files) loadProjects().catch(() => (loading = undefined));
  });
  storage.list().then(async (records) => records.length > 0 && (await loadProjects()).offer());
}

/** Shows what a run without objects tracked, and buttons with suggestions. */
function showSuggestions(
  { store, app }: Pick<Page, 'store' | 'app'>,
  { suggestChanges, describeSearch }: typeof import('../../model/suggestions.js'),
) {
  const { state } = store;
  const result = state.analysis?.segmentation.result;
  if (!result) return;
  const report = searchReport(result);
  byId('suggestions-report').textContent = describeSearch(report);
  const buttons = suggestChanges(state, report).map(({ id, label, patch }) =>
    h('button', { type: 'button', 'data-suggestion': id, click: () => (store.set(patch), app.rerun()) }, label),
  );
  const adds = TOUCH ? 'Tap the object to add it' : 'Click the object to add it';
  buttons.push(h('button', { type: 'button', 'data-suggestion': 'add', click: addByClick }, adds));
  byId('suggestions-list').replaceChildren(...buttons);
}

/** Opens the tool that adds an object by a click. */
function addByClick() {
  document.querySelector<HTMLInputElement>('#correct-tools [value="add"]')?.click();
  byId('correct-open').click();
}
