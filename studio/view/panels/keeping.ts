// Work on clips is kept in the browser as it goes. Fetched when the user opens a clip, or something was kept.

import { Autosave, rememberRuns } from '../../model/autosave.js';
import { Works, runMemory } from './works.js';
import type { Page } from '../page.js';

export function keepWork({ store, app }: Pick<Page, 'store' | 'app'>): Works {
  const works = new Works({ store, app }, () => autosave.keepSoon());
  const { body } = document;
  const autosave = new Autosave(
    store,
    async (state) => {
      const isKept = await works.keep(state);
      if (isKept) body.dataset.kept = String(Date.now());
      return isKept;
    },
    (isPending) => body.toggleAttribute('data-unkept', isPending),
  );
  addEventListener('beforeunload', (event) => autosave.loses && event.preventDefault());
  rememberRuns(store, runMemory);
  return works;
}
