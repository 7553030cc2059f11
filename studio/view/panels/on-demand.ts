// Dialogs and lists that are fetched when they are first opened, and what opens them.

import { byId } from '../dom.js';
import type { State, Store } from '../../model/store.js';
import type { Page } from '../page.js';

/** What is fetched to see whether the network answers; the service worker has it too. */
const PROBE = './favicon.svg';

/** A worker without work stays for longer than that, in milliseconds. */
const WARM_MS = 4000;

/**
 * What opens a dialog. Where the network does not answer the page says so, and the next call tries again. That is seen
 * before the dialog is imported: some browsers never fetch a module again that they could not import.
 * @param isWanted whether the user waits for it
 * @returns `prepare` fetches it and opens nothing; gives nothing where that fails
 */
function onDemand(
  store: Store,
  importDialog: () => Promise<{ open: () => void }>,
  isWanted: () => boolean = () => true,
): (() => Promise<void>) & { prepare: () => Promise<unknown> } {
  let fetched: Promise<{ open: () => void }> | undefined;
  const prepare = () => (fetched ??= fetch(PROBE, { cache: 'no-store' }).then(importDialog));
  const open = async () => {
    try {
      await prepare();
    } catch {
      fetched = undefined;
      if (!isWanted()) return;
      store.set({ notice: 'The network does not answer, so this could not be opened. Please try again.' });
    }
    (await fetched)?.open();
  };
  return Object.assign(open, { prepare: () => prepare().catch(() => void (fetched = undefined)) });
}

export function correctPanel(page: Pick<Page, 'app' | 'store' | 'viewer' | 'keys' | 'selection'>) {
  const { store } = page;
  let [fetched, opens] = [false, false];
  const importFix = async () => {
    const [{ Correction }, { JoinBar }] = await Promise.all([import('./correction.js'), import('./join.js')]);
    const correction = new Correction(page);
    new JoinBar(page, correction);
    fetched = true;
    return {
      open: () => {
        if (opens) correction.open();
        opens = false;
      },
    };
  };
  const fetching = onDemand(store, importFix, () => opens || store.state.chosen.size > 0);
  const open = () => {
    opens = true;
    return fetching();
  };
  byId('correct-open').addEventListener('click', open);
  page.keys.on('m', () => void open());
  store.watch(['chosen', 'phase'], ({ chosen, phase, source }) => {
    // Objects of one's own clip may look like one.
    if (!fetched && (chosen.size > 0 || (phase === 'done' && source?.files))) void fetching();
  });
}

export function helpPanel(page: Pick<Page, 'store' | 'keys'>) {
  const open = onDemand(page.store, async () => new (await import('./help.js')).Help());
  const about = onDemand(page.store, async () => new (await import('./about-dialog.js')).AboutDialog());
  byId('help-open').addEventListener('click', open);
  byId('about-open').addEventListener('click', about);
  page.keys.on('?', open);
}

export function exportPanel(page: Pick<Page, 'store' | 'selection' | 'keys' | 'viewer'>) {
  const open = onDemand(page.store, async () => new (await import('./export-dialog.js')).ExportDialog(page));
  byId('export-open').addEventListener('click', open);
  // Whoever is about to open it does not wait for workers and codecs.
  let warmed = -Infinity;
  const near = async () => {
    if (performance.now() - warmed < WARM_MS) return;
    warmed = performance.now();
    if (await open.prepare()) await (await import('./save-preview.js')).warmUp();
  };
  for (const kind of ['pointerenter', 'focus'])
    byId('export-open').addEventListener(kind, () => void near().catch(() => {}));
  page.keys.on('e', open);
}

export function nothingPanel(page: Pick<Page, 'app' | 'store'>) {
  const { store } = page;
  const isNothing = () => foundNothing(store.state);
  const show = onDemand(
    store,
    async () => {
      const { showNothing } = await import('./nothing.js');
      return { open: () => isNothing() && showNothing(page) };
    },
    isNothing,
  );
  store.watch(['phase', 'found', 'correcting'], () => {
    byId('nothing').hidden = !isNothing();
    if (isNothing()) void show();
  });
}

/** Returns whether a run has ended in which no object was found, nor made by hand, and nobody is at work on one. */
function foundNothing({ phase, found, job, correcting }: State): boolean {
  if (phase !== 'done' || correcting || !found?.points || !job || job.partial) return false;
  return !found.facts.some(({ object, first }) => object > 0 && first >= 0);
}
