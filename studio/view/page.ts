// Assembles the page: store, canvas, keys and panels. A panel is a function that watches the store, shows or changes
// a part of it, and registers its keys. To add one, write its file and list it here.

import { objectColor, parameters } from '../model/library.js';
import { App } from '../model/app.js';
import { FrameStore } from './frame-store.js';
import { Keys } from './keyboard.js';
import { openFiles, sampleSource } from './source.js';
import { addsCanvasNoise } from './video.js';
import { createLayers } from './layers.js';
import { readLink } from '../model/recipe.js';
import { Selection } from '../model/selection.js';
import { Settings } from '../model/settings.js';
import { Smoothing } from '../model/smoothing.js';
import { type Store, clampFrame } from '../model/store.js';
import { Viewer } from './viewer.js';
import { clipPanel, labPanel, settingsPanel } from './panels/settings.js';
import { comparePanel, backdropPanel } from './panels/view-modes.js';
import { correctPanel, doubtsPanel, exportPanel, helpPanel, nothingPanel, savedPanel } from './panels/on-demand.js';
import { edgesPanel, layersPanel, readoutPanel } from './panels/layers.js';
import { objectsPanel } from './panels/objects.js';
import { runPanel } from './panels/run.js';
import { soundPanel } from './panels/sound.js';
import { timelinePanel } from './panels/timeline.js';
import { trimPanel } from './panels/trim.js';
import { zoomPanel } from './panels/zoom.js';
import type { Layer } from './layers.js';

export function openPage(store: Store): Page {
  const layers = createLayers();
  const settings = new Settings(store, parameters());
  readLink(settings, location.hash);
  store.set({ isReducedMotion: matchMedia('(prefers-reduced-motion: reduce)').matches, isNoisy: addsCanvasNoise() });
  const page = {
    store,
    settings,
    layers,
    app: new App(store, { openSample: sampleSource, openFiles, createImages: () => new FrameStore() }),
    keys: new Keys(),
    selection: new Selection(store),
    viewer: new Viewer(store, layers),
  };
  for (const connect of PANELS) connect(page);
  new Smoothing(store);
  expose(page);
  return page;
}

export interface Page {
  store: Store;
  app: App;
  keys: Keys;
  settings: Settings;
  selection: Selection;
  layers: Layer[];
  viewer: Viewer;
}

const PANELS: ((page: Page) => void)[] = [
  runPanel,
  zoomPanel,
  comparePanel,
  backdropPanel,
  timelinePanel,
  doubtsPanel,
  soundPanel,
  trimPanel,
  readoutPanel,
  nothingPanel,
  objectsPanel,
  edgesPanel,
  layersPanel,
  labPanel,
  clipPanel,
  settingsPanel,
  correctPanel,
  exportPanel,
  helpPanel,
  savedPanel,
];

/** Exposes the result on screen to tests. */
function expose({ store, layers, viewer }: Page) {
  const timeline = {
    seek: (frame: number) => store.set({ frame: clampFrame(store.state, frame) }),
    get frame() {
      return store.state.frame;
    },
    get playing() {
      return store.state.isPlaying;
    },
  };
  const app = {
    layers,
    viewer,
    timeline,
    get job() {
      return store.state.job;
    },
    get segmentation() {
      return store.state.analysis?.segmentation ?? null;
    },
  };
  const value = {
    app,
    objectColor,
    get result() {
      const { job } = store.state;
      return job && 'result' in job ? job.result : null;
    },
    get trim() {
      return store.state.job?.trim ?? null;
    },
    get source() {
      return store.state.source;
    },
  };
  Object.defineProperty(globalThis, 'tracecutStudio', { value });
}
