// The project's server and one browser, for the tests of a file.

import { after, before } from 'node:test';
import { launchBrowser } from '../scripts/browser.mjs';
import { serve } from '../scripts/serve.mjs';

/**
 * Starts both before the tests of a file or suite and ends them after.
 *
 * @returns {{url: string, browser: import('playwright-core').Browser}} to be read in the tests
 */
export function useServerAndBrowser(launch = {}) {
  const site = { url: '', browser: null };
  let server;
  before(async () => {
    server = await serve();
    Object.assign(site, { url: server.url, browser: await launchBrowser(launch) });
  });
  after(async () => {
    await site.browser?.close();
    await server?.close();
  });
  return site;
}
