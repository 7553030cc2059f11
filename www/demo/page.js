/** Puts the page together: store, canvas, keys, panels. @module */

import { App } from './app.js';
import { Keys } from './keyboard.js';
import { createLayers } from './layers/layers.js';
import { PANELS } from './panels/panels.js';
import { readLink } from './result/recipe.js';
import { Selection } from './result/selection.js';
import { Settings } from './settings.js';
import { Viewer } from './viewer.js';

/**
 * @param {import('./run/job.js').Library} library
 * @param {import('./store.js').Store} store
 * @returns {import('./panels/panels.js').Page}
 */
export function openPage(library, store) {
  const layers = createLayers();
  const settings = new Settings(store, library.parameters());
  readLink(settings, location.hash);
  const page = {
    library,
    store,
    settings,
    layers,
    app: new App(library, store),
    keys: new Keys(),
    selection: new Selection(store),
    viewer: new Viewer(store, layers),
  };
  for (const connect of PANELS) connect(page);
  return page;
}
