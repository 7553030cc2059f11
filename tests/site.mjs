// The project's server and a browser, for the tests of a file: those that `npm test` shares between all files, or its own.

import { readFileSync } from 'node:fs';
import { join } from 'node:path';
import { after, before } from 'node:test';
import { launchBrowser } from '../scripts/browser.mjs';
import { serve } from '../scripts/serve.mjs';
import { root } from '../scripts/tools.mjs';

/** The sample of most tests: the page's own takes five times as long. */
export const SMALL = { width: 192, height: 108, frames: 16, seed: 4 };

/** What the page begins with in tests of something else: through at once. */
const TINY = { width: 96, height: 54, frames: 4, seed: 1 };
const SAMPLES = { small: SMALL, tiny: TINY };

/** Files that say what the sample is, by their paths on the server: the page's and the lab's. */
const SAMPLE_FILES = { '/view/source.js': 'studio/view/source.js', '/lab/clip.js': 'www/clip.js' };

/** Serves the project, with pages whose sample is another or, with 'whole', their own. */
export function serveSite(sample) {
  if (sample === 'whole') return serve();
  const instead = Object.fromEntries(
    Object.entries(SAMPLE_FILES).map(([path, file]) => {
      const source = readFileSync(join(root, file), 'utf8');
      const text = source.replace(/(?<=export const SAMPLE = ){[^}]*}/, JSON.stringify(SAMPLES[sample]));
      if (text === source) throw new Error(`${file} does not say what the sample is`);
      return [path, text];
    }),
  );
  return serve({ instead });
}

/** Servers that `npm test` shares between all files, by their samples. */
const shared = JSON.parse(process.env.TRACECUT_SITES ?? '{}');

/** Starts a server for each sample, for all processes that are started from here. @returns {Promise<() => Promise<void>>} */
export async function shareSites() {
  const kinds = ['whole', ...Object.keys(SAMPLES)];
  const servers = await Promise.all(kinds.map(serveSite));
  process.env.TRACECUT_SITES = JSON.stringify(Object.fromEntries(kinds.map((kind, k) => [kind, servers[k].url])));
  return async () => void (await Promise.all(servers.map((server) => server.close())));
}

/**
 * Has both ready before the tests of a file or suite, and ends after them what it started.
 *
 * @param {{sample?: 'whole' | 'small' | 'tiny'}} [options] the page's sample
 * @returns {{url: string, browser: import('playwright-core').Browser, ready: () => Promise<unknown>}} to be read in the tests; what
 *   else is made before them, outside of a suite, waits for `ready()`: Node starts all that at once
 */
export function useServerAndBrowser({ sample = 'whole' } = {}) {
  const site = { url: '', browser: null, ready: () => (starting ??= start()) };
  let server, starting;
  const start = async () => {
    if (!shared[sample]) server = await serveSite(sample);
    Object.assign(site, { url: shared[sample] ?? server.url, browser: await launchBrowser() });
  };
  before(site.ready);
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
