/** Keeps the page on the device, where the browser can; a page without service workers works all the same. @module */

import { byId } from './dom.js';
import { say } from './language.js';

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
