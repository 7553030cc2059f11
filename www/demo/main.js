/** Starts the page: loads the package, connects buttons, keys, drag and drop, and runs the sample. @module */

import { byId } from './dom.js';
import { connectHelp } from './help.js';
import { connectKeys } from './keyboard.js';
import { stayOffline } from './offline.js';
import { showError } from './status.js';
import { PageError } from './words.js';

/** @typedef {import('./app.js').App} App */

/** The smallest module with a SIMD instruction: whether it is valid says whether this browser can run the package. */
const SIMD_PROBE = new Uint8Array([
  0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11,
]);

async function main() {
  try {
    if (typeof OffscreenCanvas === 'undefined' || !WebAssembly.validate(SIMD_PROBE)) throw new PageError('unsupported');
    const { library, App } = await load();
    const app = new App(library);
    connect(app);
    expose(app, library);
    await app.openSample();
    await stayOffline();
  } catch (error) {
    showError(error);
  }
}

/** The package, which the site serves beside the page, and the page, which is built on it: without the one the other cannot be loaded. */
async function load() {
  try {
    return { library: await import('../dist/index.js'), ...(await import('./app.js')) };
  } catch (error) {
    throw new PageError('wasm-load', error instanceof Error ? error.message : String(error));
  }
}

/** @param {App} app */
function connect(app) {
  const picker = /** @type {HTMLInputElement} */ (byId('file'));
  picker.addEventListener('change', () => {
    const files = [...(picker.files ?? [])];
    picker.value = '';
    if (files.length > 0) app.openFiles(files);
  });
  for (const id of ['open', 'error-open']) byId(id).addEventListener('click', () => picker.click());
  for (const id of ['sample', 'error-sample']) byId(id).addEventListener('click', () => app.openSample());
  byId('start').addEventListener('click', () => app.start());
  byId('again').addEventListener('click', () => app.start());
  byId('pending-run').addEventListener('click', () => app.start());
  byId('resume').addEventListener('click', () => app.resume());
  byId('cancel').addEventListener('click', () => app.cancel());
  byId('show-all').addEventListener('click', () => app.selection.reset(app.selection.count));
  connectDrop(app);
  connectHelp();
  connectKeys(app);
  addEventListener('paste', (event) => {
    const files = [...(event.clipboardData?.files ?? [])];
    if (files.length > 0) app.openFiles(files);
  });
}

/** @param {App} app */
function connectDrop(app) {
  let depth = 0;
  const hover = (/** @type {number} */ by) => {
    depth = Math.max(0, depth + by);
    document.body.classList.toggle('is-dropping', depth > 0);
  };
  addEventListener('dragenter', () => hover(1));
  addEventListener('dragleave', () => hover(-1));
  addEventListener('dragover', (event) => event.preventDefault());
  addEventListener('drop', (event) => {
    event.preventDefault();
    hover(-depth);
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length > 0) app.openFiles(files);
  });
}

/**
 * What tests and the curious may read: the result on screen and how it was made.
 *
 * @param {App} app
 * @param {typeof import('../dist/index.js')} library
 */
function expose(app, { objectColor }) {
  Object.defineProperty(globalThis, 'tracecutDemo', {
    value: {
      app,
      objectColor,
      get result() {
        return app.job?.result ?? null;
      },
      get take() {
        return app.job?.take ?? null;
      },
      get source() {
        return app.source;
      },
    },
  });
}

main();
