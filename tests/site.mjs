// The project's server and a browser, for the tests of a file: those that `npm test` shares between all files, or its own.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before } from 'node:test';
import { launchBrowser } from '../scripts/browser.mjs';
import { serve } from '../scripts/serve.mjs';
import { root } from '../scripts/tools.mjs';

/** The sample of most tests: the page's own takes five times as long. */
export const SMALL = { width: 224, height: 126, frames: 16, seed: 4 };

/** Serves the project, with a page whose sample is a small one or, with 'whole', its own. */
export function serveSite(sample) {
  if (sample === 'whole') return serve();
  const source = readFileSync(join(root, 'www', 'demo', 'source.js'), 'utf8');
  const text = source.replace(/(?<=export const SAMPLE = ){[^}]*}/, JSON.stringify(SMALL));
  if (text === source) throw new Error('demo/source.js does not say what the sample is');
  return serve({ instead: { '/demo/source.js': text } });
}

/** Servers that `npm test` shares between all files, by their samples. */
const SHARED = { whole: process.env.TRACECUT_SITE, small: process.env.TRACECUT_SMALL_SITE };

/**
 * Has both ready before the tests of a file or suite, and ends after them what it started.
 *
 * @param {{args?: string[], sample?: 'whole' | 'small'}} [options] further arguments of the browser; the page's sample
 * @returns {{url: string, browser: import('playwright-core').Browser}} to be read in the tests
 */
export function useServerAndBrowser({ sample = 'whole', ...launch } = {}) {
  const site = { url: '', browser: null };
  let server;
  before(async () => {
    if (!SHARED[sample]) server = await serveSite(sample);
    Object.assign(site, { url: SHARED[sample] ?? server.url, browser: await launchBrowser(launch) });
  });
  after(async () => {
    await site.browser?.close();
    await server?.close();
  });
  return site;
}

/** The bytes of a download, wherever the browser runs. @param {import('playwright-core').Download} download */
export async function bytesOf(download) {
  const pieces = [];
  for await (const piece of await download.createReadStream()) pieces.push(piece);
  return Buffer.concat(pieces);
}
