// What was kept of work on clips, and a run that was cut off, are offered; what the user opens is kept from then on.

import * as storage from '../storage.js';
import type { Page } from '../page.js';
import type { Projects } from './projects.js';

export function savedPanel(page: Pick<Page, 'store' | 'app'>) {
  let fetched: Promise<Projects> | undefined;
  const works = () => (fetched ??= import('./start-autosave.js').then(({ startAutosave }) => startAutosave(page)));
  page.store.watch(['source'], ({ source }) => {
    if (source?.files) works().catch(() => (fetched = undefined));
  });
  storage.list().then(async (records) => records.length > 0 && (await works()).offer());
}
