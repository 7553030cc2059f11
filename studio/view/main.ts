// Starts the page: loads the package, connects buttons, keys, drag and drop, runs the sample, and keeps the page on
// the device.

import { statusPanel } from './panels/status.js';
import { Store, errorPatch } from '../model/store.js';
import { PageError } from '../model/messages.js';
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

/** Imports the page. Fails if the site lacks the package. */
async function load() {
  try {
    return await import('./page.js');
  } catch (error) {
    throw new PageError('wasm-load', error instanceof Error ? error.message : String(error));
  }
}

/** Registers the service worker after the first result, so that it slows nothing down. */
async function stayOffline() {
  const workers = navigator.serviceWorker;
  if (!workers || !isSecureContext) return;
  try {
    const registration = await workers.register(new URL('../service-worker.js', import.meta.url), {
      updateViaCache: 'none',
    });
    // Private windows and test drivers may return nothing.
    if (!registration) return;
    offer(registration);
    registration.addEventListener('updatefound', () => {
      registration.installing?.addEventListener('statechange', () => offer(registration));
    });
  } catch (error) {
    console.info('This page is not available offline.', error);
  }
}

/**
 * Offers an update. It waits for the user, as a reload loses the result, and for other tabs to close, as they would
 * mix files of two versions.
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
    button.title = 'TraceCut is open in another tab. Close it, then click again.';
  };
  button.onclick = () => {
    workers.oncontrollerchange = () => location.reload();
    waiting.postMessage('take-over');
  };
}

main();
