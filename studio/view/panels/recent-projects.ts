// Loads saving of projects when a clip is opened, or when there are saved projects to offer.

import * as storage from '../storage.js';
import type { Page } from '../page.js';
import type { Projects } from './projects.js';

export function savedPanel(page: Pick<Page, 'store' | 'app'>) {
  let loading: Promise<Projects> | undefined;
  const loadProjects = () =>
    (loading ??= import('./start-autosave.js').then(({ startAutosave }) => startAutosave(page)));
  page.store.watch(['source'], ({ source }) => {
    if (source?.files) loadProjects().catch(() => (loading = undefined));
  });
  storage.list().then(async (records) => records.length > 0 && (await loadProjects()).offer());
}
