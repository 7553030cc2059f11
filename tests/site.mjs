// The project's server and a browser, for the tests of a file: those that `npm test` shares between all files, or its own.

import { mkdtempSync, readFileSync, readdirSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before } from 'node:test';
import { launchBrowser } from '../scripts/browser.mjs';
import { mounts, serve } from '../scripts/serve.mjs';
import { siteList, writeSite } from '../scripts/site.mjs';

/** The sample of most tests: the page's own takes five times as long. */
export const SMALL = { width: 192, height: 108, frames: 16, seed: 4 };

/** What the page begins with in tests of something else: through at once. */
const TINY = { width: 96, height: 54, frames: 4, seed: 1 };
const SAMPLES = { small: SMALL, tiny: TINY };

/** The site of the sample that it is built with, as its scripts write it. */
const OWN_SAMPLE = '{width:480,height:270,frames:24,seed:0}';

/** The package's entries, which the site has in one file. */
const ENTRIES = Object.fromEntries(
  ['draw', 'edit', 'export', 'stages'].map((name) => [`/dist/${name}.js`, "export * from './index.js';"]),
);
/** What the page would fetch ahead, where it is in one file with what starts it. */
const WITHIN = { '/view/page.js': '' };

/**
 * Serves the package and the page as they are written, or ('whole', 'small', 'tiny') the site as it is built, with this
 * sample: it opens with a tenth of the requests.
 * @param {'package' | 'whole' | 'small' | 'tiny'} kind
 * @param {{folder?: string, splits?: boolean}} [options] a folder of the site that was written before; whether it has as many
 *   files as on a host
 */
export async function serveSite(kind, { folder, splits = false } = {}) {
  if (kind === 'package') return serve();
  const target = folder ?? (await writeTestSite({ splits }));
  const texts = kind === 'whole' ? [] : withSample(target, JSON.stringify(SAMPLES[kind]));
  const instead = { ...Object.fromEntries(texts), ...ENTRIES, ...(splits ? {} : WITHIN) };
  const places = [{ prefix: '/', folder: target }, ...mounts];
  const server = await serve({ places, instead, list: () => siteList(target, instead) });
  const close = () => server.close().finally(() => folder ?? rmSync(target, { recursive: true, force: true }));
  return { url: server.url, folder: target, close };
}

/** The built site in a folder of its own. */
async function writeTestSite(options) {
  const target = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
  await writeSite(target, options);
  return target;
}

/** Scripts of the site with another sample, by their paths. */
function withSample(target, sample) {
  const names = readdirSync(target, { recursive: true }).filter((name) => /^(view|dist).*\.js$/.test(name));
  const texts = names
    .map((name) => [`/${name.replaceAll('\\', '/')}`, readFileSync(join(target, name), 'utf8')])
    .filter(([, text]) => text.includes(OWN_SAMPLE));
  if (texts.length < 2) throw new Error('The scripts of page and lab do not say what the sample is');
  return texts.map(([path, text]) => [path, text.replace(OWN_SAMPLE, sample)]);
}

/** Servers that `npm test` shares between all files, by their samples. */
const shared = JSON.parse(process.env.TRACECUT_SITES ?? '{}');

/** Starts a server of each kind, for all processes that are started from here. @returns {Promise<() => Promise<void>>} */
export async function shareSites() {
  const folder = await writeTestSite({ splits: false });
  const kinds = ['package', 'whole', ...Object.keys(SAMPLES)];
  const servers = await Promise.all(kinds.map((kind) => serveSite(kind, { folder })));
  process.env.TRACECUT_SITES = JSON.stringify(Object.fromEntries(kinds.map((kind, k) => [kind, servers[k].url])));
  return async () => {
    await Promise.all(servers.map((server) => server.close()));
    rmSync(folder, { recursive: true, force: true });
  };
}

/**
 * Has both ready before the tests of a file or suite, and ends after them what it started.
 *
 * @param {{sample?: 'package' | 'whole' | 'small' | 'tiny', isOwn?: boolean}} [options] the page's sample; without one the files of the package are as
 *   they are written; a server of its own has the site as hosts have it, in a `folder` whose files may be
 *   changed
 * @returns {{url: string, folder: string, browser: import('playwright-core').Browser, ready: () => Promise<unknown>}} to be read in the tests; what
 *   else is made before them, outside of a suite, waits for `ready()`: Node starts all that at once
 */
export function useServerAndBrowser({ sample = 'package', isOwn = false } = {}) {
  const url = isOwn ? undefined : shared[sample];
  const site = { url: '', folder: '', browser: null, ready: () => (starting ??= start()) };
  let server, starting;
  const start = async () => {
    if (!url) server = await serveSite(sample, { splits: isOwn });
    Object.assign(site, { url, ...server, browser: await launchBrowser() });
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
