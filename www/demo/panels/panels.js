/**
 * The list of panels: whatever shows a part of the store or changes it. To add one, write its file and list it here. A
 * panel is a function; it takes of the page what it needs, watches the store, and registers its keys.
 * @module
 */

import { clipPanel } from './clip.js';
import { comparePanel } from './compare.js';
import { correctPanel } from './correct.js';
import { edgesPanel } from './edges.js';
import { smoothPanel } from './smooth.js';
import { exportPanel } from './export.js';
import { galleryPanel } from './gallery.js';
import { groundPanel } from './ground.js';
import { guidePanel } from './guide.js';
import { helpPanel } from './help.js';
import { layersPanel } from './layers.js';
import { nothingPanel } from './nothing.js';
import { objectsPanel } from './objects.js';
import { queuePanel } from './queue.js';
import { readoutPanel } from './readout.js';
import { runPanel } from './run.js';
import { savedPanel } from './saved.js';
import { settingsPanel } from './settings.js';
import { stagesPanel } from './stages.js';
import { timelinePanel } from './timeline.js';
import { trimPanel } from './trim.js';
import { whyPanel } from './why.js';
import { webcamPanel } from './webcam.js';
import { zoomPanel } from './zoom.js';

/**
 * @typedef {object} Page
 * @property {import('../run/job.js').Library} library
 * @property {import('../store.js').Store} store
 * @property {import('../app.js').App} app what can be done
 * @property {import('../keyboard.js').Keys} keys
 * @property {import('../settings.js').Settings} settings
 * @property {import('../result/selection.js').Selection} selection
 * @property {import('../layers/layer.js').Layer[]} layers
 * @property {import('../viewer.js').Viewer} viewer
 */

/** @type {((page: Page) => void)[]} */
export const PANELS = [
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
