// Fixtures of the tests in Chromium: servers of the site, pages at it that are watched for errors, and pages with the package alone.
// Its default export runs once before all tests: it writes the site of what is built, which each worker serves.

import { mkdtempSync, readFileSync, readdirSync, renameSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { expect, test as base } from '@playwright/test';
import { mounts, serve, serviceWorker } from '../../scripts/serve.mjs';
import { siteList, writeSite } from '../../scripts/site.mjs';
import { root } from '../../scripts/tools.mjs';

export { expect };

/** Sample clips that the served page opens with: the page's own takes five times as long as the small one. */
export const SMALL = { width: 192, height: 108, frames: 16, seed: 4 };
const TINY = { width: 64, height: 36, frames: 4, seed: 1 };
const SAMPLES = { small: SMALL, brief: { width: 128, height: 72, frames: 8, seed: 4 }, tiny: TINY };

/** The sample in the scripts of the site as they are built. */
const BUILT_SAMPLE = '{width:480,height:270,frames:24,seed:0}';
const STRICT_POLICY = "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'";

/**
 * @typedef {'package' | 'whole' | SampleName} SiteKind the package and the page as they are written; the built site; the built
 *   site with another sample
 * @typedef {'small' | 'brief' | 'tiny'} SampleName
 */

/** A fixture that all tests of a worker share. */
const perWorker = (fixture) => [fixture, { scope: 'worker' }];

export const test = base.extend({
  /**
   * Errors and warnings of all pages of this worker, failed requests, and requests to other hosts. A test adds patterns of those that it expects
   * to `faults.expected`; they may come until its pages are closed.
   */
  faults: perWorker(async ({}, use) => use(Object.assign([], { expected: [] }))),

  /**
   * Opens an empty page in a context of its own: `newPage(options)`, with options of a browser context. It is closed after the
   * test that opened it; one opened in `beforeAll` stays.
   */
  newPage: perWorker(async ({ browser, faults }, use) => {
    await use(async (options) => {
      const page = await (await browser.newContext(options)).newPage();
      openPages.add(page);
      page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
      return page;
    });
  }),

  /** Addresses of the site, by `SiteKind`; each server starts when it is first asked for. */
  sites: perWorker(async ({}, use) => {
    const servers = new Map();
    await use(async (kind) => {
      if (!servers.has(kind)) servers.set(kind, serveSite(kind));
      return (await servers.get(kind)).url;
    });
    for (const server of servers.values()) await (await server).close();
  }),

  /** Opens a page of the studio: `openStudio({ sample, query, url, ...options of a browser context })`. */
  openStudio: perWorker(async ({ newPage, sites, faults }, use) => {
    await use(async ({ sample = 'small', query = '', url, ...options } = {}) => {
      const viewport = { width: 1280, height: 800 };
      const page = await newPage({ viewport, reducedMotion: 'reduce', serviceWorkers: 'block', ...options });
      // Nobody answers a dialog of the browser here: files come as downloads.
      await page.addInitScript(() => (globalThis.showSaveFilePicker = undefined));
      const address = url ?? (await sites(sample));
      watchStudio(page, address, faults);
      await page.goto(address + query);
      return page;
    });
  }),

  /**
   * Opens a page that has the package under `tracecut`, and the functions of `page-helpers.mjs`: `openLibrary(prepare)`, where
   * `prepare(page)` runs at the end.
   */
  openLibrary: perWorker(async ({ newPage, sites, faults }, use) => {
    await use(async (prepare = async () => {}) => {
      const page = await newPage();
      // The console also has the demuxer's complaints about frames that nobody closed.
      page.on('console', (message) => {
        if (['error', 'warning'].includes(message.type()) && !/404|net::ERR/.test(message.text()))
          faults.push(message.text());
      });
      // A file of the site: a page that a test makes up may not request from other servers of this machine.
      await page.goto(`${await sites('package')}empty.js`);
      await page.evaluate(async () => {
        document.body.innerHTML = '<input type="file" id="file" multiple>';
        globalThis.tracecut = await import('/model/library.js');
      });
      await addHelpers(page);
      await prepare(page);
      return page;
    });
  }),

  /** Collects actions after the test, as a context of `node:test`: `cleanup.after(action)`. The latest runs first. */
  cleanup: async ({}, use) => {
    const actions = [];
    await use({ after: (action) => actions.push(action) });
    for (const action of actions.reverse()) await action();
  },

  /**
   * Opens a page at any address: `openPage(url, prepare)`, where `prepare(page)` runs before. Its errors and failed requests
   * are faults.
   */
  openPage: perWorker(async ({ newPage, faults }, use) => {
    await use(async (url, prepare = async () => {}) => {
      const page = await newPage();
      page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
      page.on('response', (response) => response.ok() || faults.push(`${response.status()} ${response.url()}`));
      await prepare(page);
      await page.goto(url);
      return page;
    });
  }),

  /**
   * Opens an empty page of the site with a content security policy, the strictest that the package works with if none is
   * given: `openEmptyPage({ policy, prepare })`, where `prepare(page)` runs at the end.
   */
  openEmptyPage: perWorker(async ({ newPage, sites }, use) => {
    await use(async ({ policy = STRICT_POLICY, prepare = async () => {} } = {}) => {
      const [url, page] = [`${await sites('package')}empty`, await newPage()];
      const body = '<!doctype html><title>empty</title>';
      await page.route(url, (route) =>
        route.fulfill({ contentType: 'text/html', headers: { 'Content-Security-Policy': policy }, body }),
      );
      await page.goto(url);
      await prepare(page);
      return page;
    });
  }),

  /**
   * The built site with the tiny sample, as on a host: with all its files, and not at the root. A test may change files in
   * `folder`, restores them, and calls `publish` for a service worker with their list.
   */
  ownSite: perWorker(async ({}, use) => {
    const folder = mkdtempSync(join(tmpdir(), 'tracecut-own-site-'));
    await writeSite(folder);
    for (const [path, script] of scriptsWithSample(folder, JSON.stringify(TINY)))
      writeFileSync(join(folder, path), script);
    // The browser may be reading the file, as it looks for updates by itself: another takes its place.
    const publish = () => {
      writeFileSync(join(folder, 'service-worker.new'), serviceWorker(siteList(folder)));
      renameSync(join(folder, 'service-worker.new'), join(folder, 'service-worker.js'));
    };
    publish();
    const server = await serve({ places: [{ prefix: '/some/where/', folder }] });
    await use({ url: `${server.url}some/where/`, folder, publish });
    await server.close();
    rmSync(folder, { recursive: true, force: true });
  }),

  checkPages: [
    async ({ faults }, use) => {
      // Pages of `beforeAll` stay.
      openPages.clear();
      await use();
      for (const page of openPages) await page.context().close();
      const expected = faults.expected.splice(0);
      expect(faults.splice(0).filter((fault) => !expected.some((pattern) => pattern.test(fault)))).toEqual([]);
    },
    { auto: true },
  ],
});

/** Pages that this worker opened and that no file keeps. */
const openPages = new Set();

/** Waits until a run of the studio has ended and returns `done` or `error`. */
export function runEnd(page) {
  return page.evaluate(() => {
    const { body } = document;
    return new Promise((resolve) => {
      const resolveAtEnd = () => ['done', 'error'].includes(body.dataset.state) && resolve(body.dataset.state);
      new MutationObserver(resolveAtEnd).observe(body, { attributeFilter: ['data-state'] });
      resolveAtEnd();
    });
  });
}

/**
 * Returns a page that all tests of the enclosing file or `test.describe` share: read `page` inside tests.
 *
 * @param {(fixtures: object) => Promise<import('@playwright/test').Page>} open opens the page
 */
function usePage(open) {
  const holder = { /** @type {import('@playwright/test').Page} */ page: null };
  test.beforeAll(async ({ openStudio, openLibrary, openEmptyPage }) => {
    holder.page = await open({ openStudio, openLibrary, openEmptyPage });
  });
  test.afterAll(() => holder.page?.context().close());
  return holder;
}

/** Shares a studio page with a segmented sample. @param {object} [options] of `openStudio` */
export const useSample = (options) => usePage(({ openStudio }) => openSample(openStudio, options));

/** Opens a studio page with the functions of `page-helpers.mjs`, and waits until its sample is segmented. */
export async function openSample(openStudio, options = {}) {
  const page = await openStudio(options);
  expect(await runEnd(page), await page.locator('#error').innerText()).toBe('done');
  if (!options.url) await addHelpers(page);
  return page;
}

/** Makes the functions of `page-helpers.mjs` global in a page. */
const addHelpers = (page) =>
  page.evaluate(async () => void Object.assign(globalThis, await import('/tests/browser/page-helpers.mjs')));

/** Shares a page with the package; `prepare(page)` runs first. */
export const useLibrary = (prepare) => usePage(({ openLibrary }) => openLibrary(prepare));

/** Shares an empty page; `prepare(page)` runs first. */
export const useEmptyPage = (prepare) => usePage(({ openEmptyPage }) => openEmptyPage({ prepare }));

/** Starts a server of another origin, which all tests of the enclosing file or `test.describe` share: read `origin` inside tests. */
export function useServer(answer) {
  const server = createServer(answer);
  test.beforeAll(() => new Promise((resolve) => server.listen(0, '127.0.0.1', resolve)));
  test.afterAll(() => {
    server.closeAllConnections();
    server.close();
  });
  return {
    get origin() {
      return `http://127.0.0.1:${server.address().port}`;
    },
  };
}

/** Gives a file to a page of `openLibrary`, where it is `globalThis.file` from then on. */
export async function giveFile(page, path) {
  await page.setInputFiles('#file', path);
  await page.evaluate(() => (globalThis.file = document.querySelector('#file').files[0]));
}

/** Returns the bytes of a download. @param {import('@playwright/test').Download} download */
export async function downloadBytes(download) {
  return readFileSync(await download.path());
}

function watchStudio(page, url, faults) {
  page.on('console', (message) => {
    const isExpected = message.text().includes('Service Worker registration blocked by Playwright');
    if (['error', 'warning'].includes(message.type()) && !isExpected)
      faults.push(`${message.type()}: ${message.text()}`);
  });
  page.on('request', (request) => {
    if (!request.url().startsWith(url) && !/^(blob|data):/.test(request.url()))
      faults.push(`request to ${request.url()}`);
  });
  page.on('requestfailed', (request) => {
    // A page that is left, reloaded or closed stops loading, and a player that releases its file stops reading it.
    const isStopped = request.failure()?.errorText === 'net::ERR_ABORTED' || request.url().startsWith('blob:');
    if (!isStopped) faults.push(`failed: ${request.url()}`);
  });
}

/** The package's entries, which the site has in one file. */
const ENTRIES = Object.fromEntries(
  ['draw', 'edit', 'export', 'stages'].map((name) => [`/dist/${name}.js`, "export * from './index.js';"]),
);

/** Files of `tests/`, which pages may import. */
const TEST_FILES = { prefix: '/tests/', folder: join(root, 'tests') };

/** Serves a kind of site. @param {SiteKind} kind */
async function serveSite(kind) {
  const folder = process.env.TRACECUT_TEST_SITE;
  if (kind === 'package') return serve({ places: [TEST_FILES, ...mounts], instead: { '/empty.js': '' } });
  const scripts = kind === 'whole' ? [] : scriptsWithSample(folder, JSON.stringify(SAMPLES[kind]));
  // The page is one file with its start script, and has nothing to fetch ahead.
  const instead = { ...Object.fromEntries(scripts), ...ENTRIES, '/view/page.js': '' };
  const places = [TEST_FILES, { prefix: '/', folder }, ...mounts];
  return serve({ places, instead, list: () => siteList(folder, instead) });
}

/** Returns the scripts of the site that name its sample, with another sample, as pairs of path and text. */
function scriptsWithSample(folder, sample) {
  const names = readdirSync(folder, { recursive: true }).filter((name) => /^(view|dist).*\.js$/.test(name));
  const scripts = names
    .map((name) => [`/${name.replaceAll('\\', '/')}`, readFileSync(join(folder, name), 'utf8')])
    .filter(([, script]) => script.includes(BUILT_SAMPLE));
  if (scripts.length < 2) throw new Error('The scripts of page and lab do not name the sample.');
  return scripts.map(([path, script]) => [path, script.replace(BUILT_SAMPLE, sample)]);
}

export default async function setUp() {
  const folder = mkdtempSync(join(tmpdir(), 'tracecut-site-'));
  await writeSite(folder, { splits: false });
  process.env.TRACECUT_TEST_SITE = folder;
  return () => rmSync(folder, { recursive: true, force: true });
}
