/**
 * Puts the page together: store, canvas, keys, and panels. A panel shows a part of the store or changes it: a function
 * that takes of the page what it needs, watches the store, and registers its keys. To add one, write its file and list
 * it here.
 * @module
 */

import { App } from './app.js';
import { Keys } from './keyboard.js';
import { createLayers } from './layers/layers.js';
import { readLink } from './result/recipe.js';
import { Selection } from './result/selection.js';
import { Settings } from './settings.js';
import { Viewer } from './viewer.js';
import { clipPanel } from './panels/clip.js';
import { comparePanel, groundPanel } from './panels/views.js';
import { correctPanel, exportPanel, galleryPanel, queuePanel, whyPanel, webcamPanel } from './panels/on-demand.js';
import { edgesPanel, smoothPanel } from './panels/edges.js';
import { guidePanel, helpPanel } from './panels/help.js';
import { layersPanel } from './panels/layers.js';
import { nothingPanel } from './panels/nothing.js';
import { objectsPanel } from './panels/objects.js';
import { readoutPanel } from './panels/readout.js';
import { runPanel, stagesPanel } from './panels/run.js';
import { savedPanel } from './panels/saved.js';
import { settingsPanel } from './panels/settings.js';
import { timelinePanel } from './panels/timeline.js';
import { trimPanel } from './panels/trim.js';
import { zoomPanel } from './panels/zoom.js';

/**
 * @param {import('./run/job.js').Library} library
 * @param {import('./store.js').Store} store
 * @returns {Page}
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

/**
 * @typedef {object} Page
 * @property {import('./run/job.js').Library} library
 * @property {import('./store.js').Store} store
 * @property {import('./app.js').App} app what can be done
 * @property {import('./keyboard.js').Keys} keys
 * @property {import('./settings.js').Settings} settings
 * @property {import('./result/selection.js').Selection} selection
 * @property {import('./layers/layer.js').Layer[]} layers
 * @property {import('./viewer.js').Viewer} viewer
 */

/** @type {((page: Page) => void)[]} */
const PANELS = [
  runPanel,
  zoomPanel,
  comparePanel,
  groundPanel,
  timelinePanel,
  trimPanel,
  readoutPanel,
  nothingPanel,
  objectsPanel,
  edgesPanel,
  smoothPanel,
  layersPanel,
  clipPanel,
  settingsPanel,
  stagesPanel,
  correctPanel,
  whyPanel,
  exportPanel,
  helpPanel,
  guidePanel,
  webcamPanel,
  savedPanel,
  queuePanel,
  galleryPanel,
];
