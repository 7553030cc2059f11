/**
 * Starts the page: loads the package, connects buttons, keys, drag and drop, runs the sample, and keeps the page on
 * the device.
 * @module
 */

import { chooseLanguage, wantedLanguage, say } from './language.js';
import { statusPanel } from './panels/status.js';
import { Store, errorPatch, withinFilm } from './store.js';
import { PageError } from './words.js';
import { byId } from './dom.js';

/** The smallest module with a SIMD instruction: whether it is valid says whether this browser can run the package. */
const SIMD_PROBE = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

async function main() {
  // Whoever cannot fetch the words reads English.
  await chooseLanguage(wantedLanguage()).catch(() => {});
  const store = new Store();
  statusPanel({ store });
  try {
    if (typeof OffscreenCanvas === 'undefined' || !WebAssembly.validate(SIMD_PROBE)) throw new PageError('unsupported');
    const { library, openPage } = await load();
    const page = openPage(library, store);
    expose(page);
    await page.app.openSample();
    await stayOffline();
  } catch (error) {
    store.set(errorPatch(error));
  }
}

/**
 * The package, which the site serves beside the page, and the page, which is built on it: without the one the other
 * cannot be loaded.
 */
async function load() {
  try {
    return { library: await import('tracecut'), ...(await import('./page.js')) };
  } catch (error) {
    throw new PageError('wasm-load', error instanceof Error ? error.message : String(error));
  }
}

/**
 * What tests and the curious may read: the result on screen and how it was made.
 *
 * @param {import('./page.js').Page} page
 */
function expose({ store, layers, viewer, library }) {
  const timeline = {
    seek: (/** @type {number} */ frame) => store.set({ frame: withinFilm(store.state, frame) }),
    get frame() {
      return store.state.frame;
    },
    get playing() {
      return store.state.playing;
    },
  };
  const app = {
    layers,
    viewer,
    timeline,
    compare: { choose: (/** @type {import('./store.js').State['view']} */ view) => store.set({ view }) },
    get job() {
      return store.state.job;
    },
    get points() {
      return store.state.found?.points ?? null;
    },
  };
  const value = {
    app,
    objectColor: library.objectColor,
    get result() {
      return resultOf(store.state.job);
    },
    get take() {
      return store.state.job?.take ?? null;
    },
    get source() {
      return store.state.source;
    },
  };
  Object.defineProperty(globalThis, 'tracecutDemo', { value });
}

/** @param {object | null} job of a still image has none */
function resultOf(job) {
  return job && 'result' in job ? job.result : null;
}

/** Asked for when the first result is on screen, so that nothing gets slower by it. */
async function stayOffline() {
  const workers = navigator.serviceWorker;
  if (!workers || !isSecureContext) return;
  try {
    const registration = await workers.register(new URL('../service-worker.js', import.meta.url), {
      updateViaCache: 'none',
    });
    // Private windows and test drivers may answer with nothing.
    if (!registration) return;
    offer(registration);
    registration.addEventListener('updatefound', () => {
      registration.installing?.addEventListener('statechange', () => offer(registration));
    });
  } catch (error) {
    console.info('This page is not kept for use without a network.', error);
  }
}

/**
 * A new version waits until the user wants it: a reload would throw away the result, and it does not take over while
 * other tabs are open, which would get files of two versions.
 *
 * @param {ServiceWorkerRegistration} registration
 */
function offer(registration) {
  const { waiting } = registration;
  const workers = navigator.serviceWorker;
  if (!waiting || !workers.controller) return;
  const button = byId('update');
  button.hidden = false;
  workers.onmessage = ({ data }) => {
    if (data !== 'other-pages') return;
    button.textContent = say`Close other tabs first`;
    button.title = say`TraceCut is open in another tab, whose result would be lost. Close it, then click here again.`;
  };
  button.onclick = () => {
    workers.oncontrollerchange = () => location.reload();
    waiting.postMessage('take-over');
  };
}

main();
