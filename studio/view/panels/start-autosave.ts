// Starts saving projects automatically. Loaded when a clip is opened or projects exist.

import { Autosave, rememberRuns } from '../../model/autosave.js';
import { Projects, runMemory } from './projects.js';
import type { Page } from '../page.js';

export function startAutosave({ store, app }: Pick<Page, 'store' | 'app'>): Projects {
  const projects = new Projects({ store, app }, () => autosave.saveSoon());
  const { body } = document;
  const autosave = new Autosave(
    store,
    async (state) => {
      const isSaved = await projects.save(state);
      if (isSaved) body.dataset.saved = String(Date.now());
      return isSaved;
    },
    (isPending) => body.toggleAttribute('data-unsaved', isPending),
  );
  addEventListener('beforeunload', (event) => autosave.hasUnsaved && event.preventDefault());
  rememberRuns(store, runMemory);
  return projects;
}
