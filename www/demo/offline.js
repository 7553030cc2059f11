/** Keeps the page on the device, where the browser can; a page without service workers works all the same. @module */

import { byId } from './dom.js';

/** Asked for when the first result is on screen, so that nothing gets slower by it. */
export async function stayOffline() {
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
 * A new version waits until the user wants it: a reload would throw away the result.
 *
 * @param {ServiceWorkerRegistration} registration
 */
function offer(registration) {
  const { waiting } = registration;
  if (!waiting || !navigator.serviceWorker.controller) return;
  byId('update').hidden = false;
  byId('update').onclick = () => {
    navigator.serviceWorker.addEventListener('controllerchange', () => location.reload());
    waiting.postMessage('take-over');
  };
}
