// The site on a host and without a network: the size of a first visit, the service worker, updates, and faults of networks
// and storage (docs/reliability.md).

import { mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { gzipSync } from 'node:zlib';
import { listed, serviceWorker } from '../../scripts/serve.mjs';
import { siteList } from '../../scripts/site.mjs';
import { movingFrames } from '../moving.mjs';
import { expect, openSample, runEnd, test, useServer } from './fixtures.mjs';
import { openSave, pngFiles, saveExport, stillFiles } from './studio-page.mjs';

/** Largest transfer size of a visit until the sample is segmented, in bytes. */
const MAX_VISIT_BYTES = { '': 556e3, 'lab/': 457e3 };

const labels = (page) => page.evaluate(() => [...globalThis.tracecutStudio.result.labels(3)].join(''));

for (const [place, maxBytes] of Object.entries(MAX_VISIT_BYTES))
  // The limits are of the optimised wasm files, which the slow tests build.
  test(
    `a first visit to /${place} loads less than ${maxBytes / 1000} kB`,
    { tag: '@long' },
    async ({ ownSite, browser }) => {
      const page = await (await browser.newContext({ serviceWorkers: 'block' })).newPage();
      const names = new Set();
      const failures = [];
      page.on('pageerror', ({ message }) => failures.push(message));
      page.on('response', (response) => {
        if (response.ok()) names.add(decodeURIComponent(response.url().slice(ownSite.url.length)));
        else failures.push(response.url());
      });
      await page.goto(ownSite.url + place);
      expect(await runEnd(page)).toBe('done');
      const sizes = [...names].map((name) => {
        const bytes = readFileSync(join(ownSite.folder, name.replace(/(^|\/)$/, '$1index.html')));
        return gzipSync(bytes, { level: 9 }).length;
      });
      const total = sizes.reduce((sum, size) => sum + size, 0);
      console.log(`a first visit to /${place}: ${total} bytes, compressed, in ${sizes.length} files`);
      expect(total).toBeLessThan(maxBytes);
      expect(failures).toEqual([]);
      await page.context().close();
    },
  );

test('works offline after the first visit, with all its parts', async ({ openStudio, ownSite }) => {
  const page = await openSample(openStudio, { url: ownSite.url, serviceWorkers: 'allow' });
  await page.evaluate(() => navigator.serviceWorker.ready.then(() => true));
  const before = await labels(page);
  // Otherwise parts that are fetched ahead are cut off.
  await page.waitForLoadState('networkidle');
  await page.context().setOffline(true);
  const names = [];
  page.on('request', (request) => {
    if (request.url().startsWith('http'))
      names.push(`./${new URL(request.url().slice(ownSite.url.length), 'http://host').pathname.slice(1)}`);
  });
  await page.goto(`${ownSite.url}?from=a-link`);
  expect(await runEnd(page)).toBe('done');
  expect(await labels(page)).toBe(before);
  await page.setInputFiles('#file', pngFiles(movingFrames(3, [48, 32])));
  await expect(page.locator('#clip-name')).toHaveText('frame0.png … frame2.png');
  expect(await runEnd(page)).toBe('done');
  await openSave(page);
  expect(JSON.parse((await saveExport(page, 'coco')).bytes).images).toHaveLength(3);
  const files = siteList(ownSite.folder).files.map(([name]) => name);
  expect(names.length).toBeGreaterThan(40);
  expect(names.filter((name) => !files.includes(name))).toEqual([]);
});

test('offers a new version, and changes to it once it is the only tab', async ({ openStudio, ownSite, faults }) => {
  const NAME = 'view/of-another-version.js';
  const path = join(ownSite.folder, NAME);
  const addFile = () => writeFileSync(path, '// Another version of the site.\n');
  /** Returns whether the version in force has the file, also when the host has not. */
  const hasFile = (page) => page.evaluate(async (name) => (await fetch(name)).ok, `./${NAME}`);
  const page = await openSample(openStudio, { url: ownSite.url, serviceWorkers: 'allow' });
  const update = page.locator('#update');
  await page.evaluate(() => navigator.serviceWorker.ready.then(() => true));
  const [firstCache] = await page.evaluate(() => caches.keys());
  await page.reload();
  expect(await runEnd(page)).toBe('done');
  await expect(update).toBeHidden();
  addFile();
  ownSite.publish();
  await page.evaluate(async () => (await navigator.serviceWorker.getRegistration()).update());
  await expect(update).toBeVisible();
  // Open tabs and new ones stay with the first version.
  const secondTab = await page.context().newPage();
  await secondTab.goto(page.url());
  expect(await runEnd(secondTab)).toBe('done');
  rmSync(path);
  expect(await Promise.all([page, secondTab].map(hasFile))).toEqual([false, false]);
  await update.click();
  await expect(page.getByText('Close other tabs first')).toBeVisible();
  await expect(page.locator('body')).toHaveAttribute('data-state', 'done');
  expect(await Promise.all([page, secondTab].map(hasFile))).toEqual([false, false]);
  await secondTab.close();
  addFile();
  await Promise.all([page.waitForEvent('load'), update.click()]);
  expect(await runEnd(page)).toBe('done');
  await expect(update).toBeHidden();
  const cacheNames = await page.evaluate(() => caches.keys());
  expect(cacheNames).toHaveLength(1);
  expect(cacheNames).not.toContain(firstCache);
  rmSync(path);
  expect(await hasFile(page)).toBe(true);
  ownSite.publish();
  // The files that the first version did not have.
  faults.expected.push(/./);
});

test.describe('the service worker', () => {
  const PAGE = '<!doctype html><title>page</title><link rel="icon" href="data:,">';
  const TYPES = { html: 'text/html', js: 'text/javascript' };
  /** Texts of the host, by their paths. */
  const contents = new Map();
  /** Answers of the host that replace texts of `contents`: `{ status, headers, body }`. */
  const wrongAnswers = new Map();
  const host = useServer((request, response) => {
    const { pathname } = new URL(request.url, host.origin);
    const name = pathname.replace(/\/$/, '/index.html');
    const answer = { status: contents.has(name) ? 200 : 404, body: contents.get(name) ?? 'nothing' };
    const { status, headers, body } = { ...answer, ...wrongAnswers.get(pathname) };
    const type = TYPES[name.split('.').pop()] ?? 'text/plain';
    response.writeHead(status, { 'content-type': type, 'cache-control': 'no-store', ...headers }).end(body);
  });

  /** Puts a version of a site at `/{site}/`. */
  function publish(site, code) {
    const folder = test.info().outputPath(site);
    const files = { 'index.html': PAGE, 'a.js': code };
    for (const [name, text] of Object.entries(files)) {
      mkdirSync(dirname(join(folder, name)), { recursive: true });
      writeFileSync(join(folder, name), text);
      contents.set(`/${site}/${name}`, text);
    }
    const list = listed([{ folder, at: './', wanted: (name) => /^(index\.html|a\.js)$/.test(name) }]);
    contents.set(`/${site}/service-worker.js`, serviceWorker(list));
  }

  /** Opens a tab at a site. */
  async function openTab(context, site) {
    const page = await context.newPage();
    await page.goto(`${host.origin}/${site}/`);
    return page;
  }

  /** Registers the worker and returns `activated`, or `redundant` if it could not be installed. */
  const install = (page) =>
    page.evaluate(async () => {
      const registration = await navigator.serviceWorker.register('service-worker.js', { updateViaCache: 'none' });
      const worker = registration.installing ?? registration.waiting ?? registration.active;
      return new Promise((resolve) => {
        const resolveAtEnd = () => ['activated', 'redundant'].includes(worker.state) && resolve(worker.state);
        worker.addEventListener('statechange', resolveAtEnd);
        resolveAtEnd();
      });
    });

  const read = (page, path) => page.evaluate(async (url) => (await fetch(url)).text(), path);

  test('keeps all files of its version or none', async ({ context }) => {
    publish('site', 'first');
    contents.set('/site/elsewhere.js', 'first');
    const page = await openTab(context, 'site');
    for (const answer of [
      // A login page, a file of the next version, a part of a file, a redirect, an error.
      { body: PAGE, headers: { 'content-type': 'text/html' } },
      { body: 'second' },
      { status: 206, headers: { 'content-range': 'bytes 0-4/9' } },
      { status: 302, headers: { location: '/site/elsewhere.js' } },
      { status: 503 },
    ]) {
      wrongAnswers.set('/site/a.js', answer);
      expect(await install(page), JSON.stringify(answer)).toBe('redundant');
      wrongAnswers.delete('/site/a.js');
      expect(await read(page, 'a.js'), 'from the network').toBe('first');
      expect(await page.evaluate(async () => Boolean(await caches.match('a.js')))).toBe(false);
    }
    expect(await install(page)).toBe('activated');
    contents.set('/site/a.js', 'from the network');
    await page.reload();
    expect(await read(page, 'a.js')).toBe('first');
    expect(await read(page, 'a.js?version=9')).toBe('first');
    await page.goto(`${host.origin}/site/index.html`);
    expect(await page.title()).toBe('page');
  });

  test('answers only GET requests in its folder, and leaves where the host no longer has it', async ({ context }) => {
    publish('scope', 'code');
    contents.set('/outside.js', 'outside');
    const page = await openTab(context, 'scope');
    await install(page);
    await page.reload();
    expect(await read(page, '/outside.js')).toBe('outside');
    expect(await page.evaluate(async () => (await fetch('a.js', { method: 'POST' })).status)).toBe(200);
    const cached = await page.evaluate(async () => {
      const [name] = await caches.keys();
      return (await (await caches.open(name)).keys()).map(({ url }) => new URL(url).pathname).sort();
    });
    expect(cached).toEqual(['/scope/', '/scope/a.js']);
    contents.delete('/scope/service-worker.js');
    await page.reload();
    await page.waitForFunction(async () => !(await navigator.serviceWorker.getRegistration()));
    expect(await page.evaluate(() => caches.keys())).toEqual([]);
  });

  test('a new version leaves the files of other sites of the host', async ({ context }) => {
    publish('one', 'first');
    publish('one/within', 'within');
    const [outerTab, innerTab] = [await openTab(context, 'one'), await openTab(context, 'one/within')];
    expect([await install(outerTab), await install(innerTab)]).toEqual(['activated', 'activated']);
    publish('one', 'second');
    await outerTab.evaluate(async () => {
      const registration = await navigator.serviceWorker.getRegistration();
      await registration.update();
      const worker = registration.installing ?? registration.waiting;
      await new Promise((resolve) => {
        const resolveAtEnd = () => worker.state === 'installed' && resolve();
        worker.addEventListener('statechange', resolveAtEnd);
        resolveAtEnd();
      });
    });
    await outerTab.close();
    // The version takes over once the tab is gone, and removes the files of the first one.
    await innerTab.waitForFunction(async () => (await caches.keys()).length === 2);
    const again = await openTab(context, 'one');
    contents.delete('/one/within/a.js');
    await innerTab.reload();
    expect(await read(innerTab, 'a.js')).toBe('within');
    expect(await read(again, 'a.js')).toBe('second');
  });

  test('keeps nothing without space, and an old version stays whole', async ({ context }) => {
    publish('full', 'first');
    const page = await openTab(context, 'full');
    const session = await context.newCDPSession(page);
    const setQuota = (quotaSize) => session.send('Storage.overrideQuotaForOrigin', { origin: host.origin, quotaSize });
    await setQuota(1);
    expect(await install(page)).toBe('redundant');
    expect(await read(page, 'a.js')).toBe('first');
    await setQuota();
    expect(await install(page)).toBe('activated');
    await page.reload();
    await setQuota(1);
    publish('full', 'second');
    await page.evaluate(async () => (await navigator.serviceWorker.getRegistration()).update().catch(() => {}));
    await page.waitForFunction(async () => !(await navigator.serviceWorker.getRegistration()).installing);
    await page.reload();
    expect(await read(page, 'a.js')).toBe('first');
  });
});

test.describe('faults', () => {
  /** Opens a clip and waits for its result. */
  async function open(page, name) {
    await page.setInputFiles('#file', stillFiles(name));
    await expect(page.locator('#clip-name')).toContainText(name);
    expect(await runEnd(page)).toBe('done');
  }

  /** Returns the names of the saved projects, and whether each has masks. */
  const savedProjects = (page) =>
    page.evaluate(
      () =>
        new Promise((resolve) => {
          const opening = indexedDB.open('tracecut');
          opening.onsuccess = () => {
            const request = opening.result.transaction('work').objectStore('work').getAll();
            request.onsuccess = () => resolve(request.result.map(({ name, project }) => [name, project.length > 0]));
          };
        }),
    );

  test('a full storage leaves saved projects, and the page asks before a result is lost', async ({ openStudio }) => {
    const page = await openSample(openStudio, { sample: 'tiny' });
    await open(page, 'first');
    await expect(page.locator('body')).toHaveAttribute('data-saved', /./);
    const before = await savedProjects(page);
    expect(before).toEqual([['first0.png … first2.png', true]]);
    // Aborts transactions, as a browser does without space; quotas of browsers are checked too rarely for a test.
    await page.evaluate(() => {
      const { put } = IDBObjectStore.prototype;
      IDBObjectStore.prototype.put = function (...args) {
        const request = put.apply(this, args);
        this.transaction.abort();
        return request;
      };
    });
    await open(page, 'second');
    await openSave(page);
    expect((await saveExport(page, 'coco')).bytes.length).toBeGreaterThan(0);
    const secondTab = await page.context().newPage();
    await secondTab.goto(page.url());
    const dialogShown = page.waitForEvent('dialog');
    await page.close({ runBeforeUnload: true });
    const dialog = await dialogShown;
    expect(dialog.type()).toBe('beforeunload');
    await dialog.accept();
    expect(await savedProjects(secondTab)).toEqual(before);
  });

  test('reports a wasm file that does not load, and loads it for the next clip', async ({ openStudio, faults }) => {
    const page = await openSample(openStudio, { sample: 'tiny' });
    await page.context().route('**/tracecut_bg.wasm', (route) => route.abort('connectionreset'));
    await page.reload();
    expect(await runEnd(page)).toBe('error');
    await expect(page.locator('#error')).toHaveText(/tracecut_bg\.wasm/);
    await page.context().unroute('**/tracecut_bg.wasm');
    await open(page, 'again');
    faults.expected.push(/./);
  });

  for (const [name, stop, restore, notice] of [
    [
      'without a network',
      (context) => context.setOffline(true),
      (context) => context.setOffline(false),
      /^You’re offline/,
    ],
    [
      'that the host lacks',
      (context) => context.route('**/view/*.js', (route) => route.abort()),
      (context) => context.unroute('**/view/*.js'),
      /^A part of the page didn’t load\. Reload/,
    ],
  ])
    test(`reports a part ${name} on first use, and keeps the result`, async ({ openStudio, ownSite, faults }) => {
      const page = await openSample(openStudio, { url: ownSite.url });
      // Parts that the result needs are loaded by then.
      await expect(page.locator('#certainty')).toBeVisible();
      const before = await labels(page);
      await stop(page.context());
      await page.keyboard.press('e');
      await expect(page.locator('#notice')).toHaveText(notice);
      await restore(page.context());
      await expect(page.locator('body')).toHaveAttribute('data-state', 'done');
      expect(await labels(page)).toBe(before);
      // Chromium never repeats a failed import. Without a network there was none.
      if (name === 'that the host lacks') {
        await page.reload();
        expect(await runEnd(page)).toBe('done');
      }
      await openSave(page);
      faults.expected.push(/./);
    });
});
