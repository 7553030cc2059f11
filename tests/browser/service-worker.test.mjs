// What the page's service worker keeps, and what it does not: a small site with this very worker, on a host that answers
// as badly as hosts, networks and neighbours do.

import assert from 'node:assert/strict';
import { mkdirSync, mkdtempSync, rmSync, writeFileSync } from 'node:fs';
import { createServer } from 'node:http';
import { tmpdir } from 'node:os';
import { dirname, join } from 'node:path';
import { after, before, beforeEach, describe, test } from 'node:test';
import { launchBrowser } from '../../scripts/browser.mjs';
import { listed, serviceWorker } from '../../scripts/precache.mjs';

const PAGE = '<!doctype html><title>page</title><link rel="icon" href="data:,">';
const TYPES = { html: 'text/html', js: 'text/javascript', json: 'application/json' };
const folder = mkdtempSync(join(tmpdir(), 'tracecut-worker-'));
/** What the host says in place of a file, by its path: `{status, headers, body}`. */
const strange = new Map();
let server, browser, origin;
/** Whether the host is out of reach: a browser's own switch reaches a worker that is being woken too late. */
let down = false;

/** Writes a version of the site at `/{site}/` and gives its service worker's text. */
function publish(site, code) {
  const place = join(folder, site);
  const files = { 'index.html': PAGE, 'a.js': code };
  for (const [name, text] of Object.entries(files)) {
    mkdirSync(dirname(join(place, name)), { recursive: true });
    writeFileSync(join(place, name), text);
  }
  const kept = listed([{ folder: place, at: './', wanted: (name) => /^(index\.html|a\.js)$/.test(name) }]);
  contents.set(`/${site}/service-worker.js`, serviceWorker(kept));
  for (const [name, text] of Object.entries(files)) contents.set(`/${site}/${name}`, text);
}
const contents = new Map();

function answer(request, response) {
  if (down) return void request.socket.destroy();
  const { pathname } = new URL(request.url, origin);
  const name = pathname.replace(/\/$/, '/index.html');
  const plain = { status: contents.has(name) ? 200 : 404, headers: {}, body: contents.get(name) ?? 'nothing' };
  const { status, headers, body } = { ...plain, ...strange.get(pathname) };
  const type = { 'content-type': TYPES[name.split('.').pop()] ?? 'text/plain', 'cache-control': 'no-store' };
  response.writeHead(status, { ...type, ...headers }).end(body);
}

/** A tab at the site of this name; `install` waits until its worker is in force, or gives why there is none. */
async function open(context, site) {
  const page = await context.newPage();
  await page.goto(`${origin}/${site}/`);
  const install = () =>
    page.evaluate(async () => {
      const registration = await navigator.serviceWorker.register('service-worker.js', { updateViaCache: 'none' });
      const worker = registration.installing ?? registration.waiting ?? registration.active;
      return new Promise((done) => {
        const tell = () => ['activated', 'redundant'].includes(worker.state) && done(worker.state);
        worker.addEventListener('statechange', tell);
        tell();
      });
    });
  const read = (path) =>
    page.evaluate(async (at) => (await fetch(at)).text().catch(() => 'unreadable'), path).catch(() => 'failed');
  return { page, install, read };
}

before(async () => {
  server = createServer(answer);
  await new Promise((done) => server.listen(0, '127.0.0.1', done));
  origin = `http://127.0.0.1:${server.address().port}`;
  browser = await launchBrowser();
});
after(async () => {
  await browser?.close();
  server?.closeAllConnections();
  server?.close();
  rmSync(folder, { recursive: true, force: true });
});

describe('the service worker', { timeout: 120_000 }, () => {
  beforeEach(() => (down = false));

  test('keeps the very files of its version or none: no login page, no part, no file of the next version', async (t) => {
    publish('site', 'first');
    const context = await browser.newContext();
    t.after(() => context.close());
    const { page, install, read } = await open(context, 'site');
    for (const wrong of [
      { body: PAGE, headers: { 'content-type': 'text/html' } },
      { body: 'second' },
      { status: 206, headers: { 'content-range': 'bytes 0-4/9' } },
      { status: 302, headers: { location: '/site/elsewhere.js' } },
      { status: 503 },
    ]) {
      contents.set('/site/elsewhere.js', 'first');
      strange.set('/site/a.js', wrong);
      assert.equal(await install(), 'redundant', JSON.stringify(wrong));
      strange.delete('/site/a.js');
      assert.equal(await read('a.js'), 'first', 'the page works from the network');
      assert.equal(await page.evaluate(async () => !!(await caches.match('a.js'))), false);
    }
    assert.equal(await install(), 'activated');
    contents.set('/site/a.js', 'from the network');
    await page.reload();
    assert.equal(await read('a.js'), 'first');
    assert.equal(await read('a.js?version=9'), 'first');
    await page.goto(`${origin}/site/index.html`);
    assert.equal(await page.title(), 'page');
  });

  test('asks nothing for other origins, other methods and pages beside its folder', async (t) => {
    publish('scope', 'code');
    contents.set('/outside.js', 'outside');
    const context = await browser.newContext();
    t.after(() => context.close());
    const { page, install, read } = await open(context, 'scope');
    await install();
    await page.reload();
    assert.equal(await read('/outside.js'), 'outside');
    assert.equal(await page.evaluate(async () => (await fetch('a.js', { method: 'POST' })).status), 200);
    const kept = await page.evaluate(async () => {
      const [name] = await caches.keys();
      return (await (await caches.open(name)).keys()).map(({ url }) => new URL(url).pathname).sort();
    });
    assert.deepEqual(kept, ['/scope/', '/scope/a.js']);
  });

  test('a new version at one address leaves alone what another address of the host keeps', async (t) => {
    publish('one', 'first');
    publish('one/within', 'within');
    const context = await browser.newContext();
    t.after(() => context.close());
    const [one, within] = [await open(context, 'one'), await open(context, 'one/within')];
    assert.deepEqual([await one.install(), await within.install()], ['activated', 'activated']);
    publish('one', 'second');
    await one.page.evaluate(async () => (await navigator.serviceWorker.getRegistration()).update());
    await one.page.close();
    const again = await open(context, 'one');
    await again.page.waitForFunction(async () => (await caches.keys()).length === 2);
    contents.delete('/one/within/a.js');
    await within.page.reload();
    assert.equal(await within.read('a.js'), 'within');
    assert.equal(await again.read('a.js'), 'second');
  });

  test('where there is no room nothing is kept, the page works, and an old version stays whole', async (t) => {
    publish('full', 'first');
    const context = await browser.newContext();
    t.after(() => context.close());
    const { page, install, read } = await open(context, 'full');
    const storage = await context.newCDPSession(page);
    const room = (quotaSize) => storage.send('Storage.overrideQuotaForOrigin', { origin, quotaSize });
    await room(1);
    assert.equal(await install(), 'redundant');
    assert.equal(await read('a.js'), 'first');
    await room();
    assert.equal(await install(), 'activated');
    await page.reload();
    await room(1);
    publish('full', 'second');
    await page.evaluate(async () => (await navigator.serviceWorker.getRegistration()).update().catch(() => {}));
    await page.waitForFunction(async () => !(await navigator.serviceWorker.getRegistration()).installing);
    await page.reload();
    assert.equal(await read('a.js'), 'first', 'the old version, whole');
  });
});
