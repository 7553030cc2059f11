// Starts the page: loads the package, connects buttons, keys, drag and drop, runs the sample, and keeps the page on
// the device.

import { statusPanel } from './panels/status.js';
import { Store, errorPatch } from '../model/store.js';
import { PageError } from '../model/words.js';
import { byId } from './dom.js';

async function main() {
  const store = new Store();
  statusPanel({ store });
  try {
    if (typeof OffscreenCanvas === 'undefined') throw new PageError('unsupported');
    const { openPage } = await load();
    await openPage(store).app.openSample();
    await stayOffline();
  } catch (error) {
    store.set(errorPatch(error));
  }
}

/** The page, which is built on the package that the site serves beside it: without that it cannot be loaded. */
async function load() {
  try {
    return await import('./page.js');
  } catch (error) {
    throw new PageError('wasm-load', error instanceof Error ? error.message : String(error));
  }
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
 */
function offer(registration: ServiceWorkerRegistration) {
  const { waiting } = registration;
  const workers = navigator.serviceWorker;
  if (!waiting || !workers.controller) return;
  const button = byId('update');
  button.hidden = false;
  workers.onmessage = ({ data }) => {
    if (data !== 'other-pages') return;
    button.textContent = 'Close other tabs first';
    button.title = 'TraceCut is open in another tab, whose result would be lost. Close it, then click here again.';
  };
  button.onclick = () => {
    workers.oncontrollerchange = () => location.reload();
    waiting.postMessage('take-over');
  };
}

main();
