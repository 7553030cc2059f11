// Fixtures of the tests in Chromium: servers of the site, pages at it that are watched for errors, and pages with the package alone.

import { mkdtempSync, readFileSync, readdirSync, rmSync, writeFileSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { expect, test as base } from '@playwright/test';
import { mounts, serve, serviceWorker } from '../../scripts/serve.mjs';
import { siteList, writeSite } from '../../scripts/site.mjs';

export { expect };

/** Sample clips that the served page opens with: the page's own takes five times as long as the small one. */
export const SMALL = { width: 192, height: 108, frames: 16, seed: 4 };
const TINY = { width: 96, height: 54, frames: 4, seed: 1 };
const SAMPLES = { small: SMALL, tiny: TINY };

/** The sample in the scripts of the site as they are built. */
const BUILT_SAMPLE = '{width:480,height:270,frames:24,seed:0}';
const STRICT_POLICY = "script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'";

/**
 * @typedef {'package' | 'whole' | SampleName} SiteKind the package and the page as they are written; the built site; the built
 *   site with another sample
 * @typedef {'small' | 'tiny'} SampleName
 */

export const test = base.extend({
  /** Errors and warnings of all pages of this worker, failed requests, and requests to other hosts. A test that expects some empties it. */
  faults: [async ({}, use) => use([]), { scope: 'worker' }],

  /** Pages opened during the current test. */
  ownPages: [async ({}, use) => use(new Set()), { scope: 'worker' }],

  /** Addresses of the site, by `SiteKind`; each server starts when it is first asked for. */
  sites: [
    async ({}, use) => {
      const servers = new Map();
      await use(async (kind) => {
        if (!servers.has(kind)) servers.set(kind, serveSite(kind));
        return (await servers.get(kind)).url;
      });
      for (const server of servers.values()) await (await server).close();
    },
    { scope: 'worker' },
  ],

  /**
   * Opens a page of the studio: `openStudio({ sample, query, url, ...options of a browser context })`. A page opened in a
   * test is closed after it; one opened in `beforeAll` stays.
   */
  openStudio: [
    async ({ browser, sites, faults, ownPages }, use) => {
      await use(async ({ sample = 'small', query = '', url, ...options } = {}) => {
        const context = await browser.newContext({
          viewport: { width: 1280, height: 800 },
          reducedMotion: 'reduce',
          serviceWorkers: 'block',
          ...options,
        });
        // Nobody answers a dialog of the browser here: files come as downloads.
        await context.addInitScript(() => (globalThis.showSaveFilePicker = undefined));
        const page = await context.newPage();
        ownPages.add(page);
        const address = url ?? (await sites(sample));
        watchStudio(page, address, faults);
        await page.goto(address + query);
        return page;
      });
    },
    { scope: 'worker' },
  ],

  /**
   * Opens a page that has the package under `tracecut`, and the functions of `page-helpers.mjs`: `openLibrary({ modules })`,
   * where `modules` are more files of `tests/` that the page may import.
   */
  openLibrary: [
    async ({ browser, sites, faults, ownPages }, use) => {
      await use(async ({ modules = [] } = {}) => {
        const page = await (await browser.newContext()).newPage();
        ownPages.add(page);
        page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
        // The console also has the demuxer's complaints about frames that nobody closed.
        page.on('console', (message) => {
          if (['error', 'warning'].includes(message.type()) && !/404|net::ERR/.test(message.text()))
            faults.push(message.text());
        });
        // A script of the site, shown as a page: a page that a test makes up may not request from other servers of this machine.
        const url = await sites('package');
        await serveModules(page, url, ['browser/page-helpers.mjs', ...modules]);
        await page.goto(`${url}dist/index.js`);
        await page.evaluate(async () => {
          document.body.innerHTML = '<input type="file" id="file" multiple>';
          globalThis.tracecut = await import('/model/library.js');
          Object.assign(globalThis, await import('/browser/page-helpers.mjs'));
        });
        return page;
      });
    },
    { scope: 'worker' },
  ],

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
  openPage: [
    async ({ browser, faults, ownPages }, use) => {
      await use(async (url, prepare = async () => {}) => {
        const page = await (await browser.newContext()).newPage();
        ownPages.add(page);
        page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
        page.on('console', (message) => message.type() === 'error' && faults.push(message.text()));
        page.on('response', (response) => response.ok() || faults.push(`${response.status()} ${response.url()}`));
        await prepare(page);
        await page.goto(url);
        return page;
      });
    },
    { scope: 'worker' },
  ],

  /**
   * Opens an empty page of the site with a content security policy, the strictest that the package works with if none is
   * given: `openEmptyPage({ policy, modules })`, where `modules` are files of `tests/` that the page may import.
   */
  openEmptyPage: [
    async ({ browser, sites, ownPages }, use) => {
      await use(async ({ policy = STRICT_POLICY, modules = [] } = {}) => {
        const url = await sites('package');
        const page = await (await browser.newContext()).newPage();
        ownPages.add(page);
        const body = '<!doctype html><title>empty</title>';
        await page.route(`${url}empty`, (route) =>
          route.fulfill({ contentType: 'text/html', headers: { 'Content-Security-Policy': policy }, body }),
        );
        await serveModules(page, url, modules);
        await page.goto(`${url}empty`);
        return page;
      });
    },
    { scope: 'worker' },
  ],

  /**
   * The built site with the tiny sample, as on a host: with all its files, and not at the root. A test may change files in
   * `folder`, restores them, and calls `publish` for a service worker with their list.
   */
  ownSite: [
    async ({}, use) => {
      const folder = mkdtempSync(join(tmpdir(), 'tracecut-own-site-'));
      await writeSite(folder);
      for (const [path, script] of scriptsWithSample(folder, JSON.stringify(TINY)))
        writeFileSync(join(folder, path), script);
      const publish = () => writeFileSync(join(folder, 'service-worker.js'), serviceWorker(siteList(folder)));
      publish();
      const server = await serve({ places: [{ prefix: '/some/where/', folder }] });
      await use({ url: `${server.url}some/where/`, folder, publish });
      await server.close();
      rmSync(folder, { recursive: true, force: true });
    },
    { scope: 'worker' },
  ],

  checkPages: [
    async ({ faults, ownPages }, use) => {
      // Pages of `beforeAll` stay.
      ownPages.clear();
      await use();
      for (const page of ownPages) await page.context().close();
      const found = faults.splice(0);
      expect(found).toEqual([]);
    },
    { auto: true },
  ],
});

/** Waits until a run of the studio has ended and returns `done` or `error`. */
export async function runEnd(page) {
  await page.waitForFunction(() => ['done', 'error'].includes(document.body.dataset.state));
  return page.evaluate(() => document.body.dataset.state);
}

/**
 * A studio page with a segmented sample, shared by all tests of the enclosing file or `test.describe`. Read `page` inside tests.
 *
 * @param {Parameters<typeof openStudio>[0]} [options]
 */
export function useSample(options) {
  const shared = { /** @type {import('@playwright/test').Page} */ page: null };
  test.beforeAll(async ({ openStudio }) => {
    shared.page = await openStudio(options);
    expect(await runEnd(shared.page), await shared.page.locator('#error').innerText()).toBe('done');
  });
  test.afterAll(() => shared.page?.context().close());
  return shared;
}

/** A page with the package, shared by all tests of a file; `prepare(page)` runs first. Read `page` inside tests. */
export function useLibrary(prepare = async () => {}, options) {
  const shared = { /** @type {import('@playwright/test').Page} */ page: null };
  test.beforeAll(async ({ openLibrary }) => {
    shared.page = await openLibrary(options);
    await prepare(shared.page);
  });
  test.afterAll(() => shared.page?.context().close());
  return shared;
}

/** An empty page, shared by all tests of a file; `prepare(page)` runs first. Read `page` inside tests. */
export function useEmptyPage(prepare, options) {
  const shared = { /** @type {import('@playwright/test').Page} */ page: null };
  test.beforeAll(async ({ openEmptyPage }) => {
    shared.page = await openEmptyPage(options);
    await prepare(shared.page);
  });
  test.afterAll(() => shared.page?.context().close());
  return shared;
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

/** Serves files of `tests/` to a page. */
async function serveModules(page, url, names) {
  for (const name of names) {
    const path = fileURLToPath(new URL(`../${name}`, import.meta.url));
    await page.route(url + name, (route) => route.fulfill({ path, contentType: 'text/javascript' }));
  }
}

function watchStudio(page, url, faults) {
  page.on('console', (message) => {
    const isExpected = message.text().includes('Service Worker registration blocked by Playwright');
    if (['error', 'warning'].includes(message.type()) && !isExpected)
      faults.push(`${message.type()}: ${message.text()}`);
  });
  page.on('pageerror', (error) => faults.push(`page error: ${error.message}`));
  page.on('request', (request) => {
    if (!request.url().startsWith(url) && !/^(blob|data):/.test(request.url()))
      faults.push(`request to ${request.url()}`);
  });
  page.on('requestfailed', (request) => {
    // A player that releases its file stops reading it.
    if (!request.url().startsWith('blob:')) faults.push(`failed: ${request.url()}`);
  });
}

/** The package's entries, which the site has in one file. */
const ENTRIES = Object.fromEntries(
  ['draw', 'edit', 'export', 'stages'].map((name) => [`/dist/${name}.js`, "export * from './index.js';"]),
);

/** Serves a kind of site. @param {SiteKind} kind */
async function serveSite(kind) {
  const folder = process.env.TRACECUT_TEST_SITE;
  if (kind === 'package') return serve();
  const scripts = kind === 'whole' ? [] : scriptsWithSample(folder, JSON.stringify(SAMPLES[kind]));
  // The page is one file with its start script, and has nothing to fetch ahead.
  const instead = { ...Object.fromEntries(scripts), ...ENTRIES, '/view/page.js': '' };
  const places = [{ prefix: '/', folder }, ...mounts];
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
