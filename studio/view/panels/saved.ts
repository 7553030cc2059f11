// What was kept of work on clips, and a run that was cut off, are offered; what the user opens is kept from then on.

import { stored } from '../storage.js';
import type { Page } from '../page.js';
import type { Works } from './works.js';

export function savedPanel(page: Pick<Page, 'store' | 'app'>) {
  let fetched: Promise<Works> | undefined;
  const works = () => (fetched ??= import('./keeping.js').then(({ keepWork }) => keepWork(page)));
  page.store.watch(['source'], ({ source }) => {
    if (source?.files) works().catch(() => (fetched = undefined));
  });
  stored().then(async (all) => all.length > 0 && (await works()).offer());
}
